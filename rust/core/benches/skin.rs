//! Times of a bind and of a frame on a body of 30,000 vertices with 75 muscles, and of a frame of elastic skin on bodies of
//! 13,000 to 100,000 vertices and on 1 to all threads.
#![allow(clippy::unwrap_used, missing_docs)]

use std::f64::consts::TAU;
use std::sync::Arc;

use divan::Bencher;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use sinew_core::{
    ColumnMajor, Elasticity, MotionSource, Musculature, RestMesh, Segments, Skeleton, Skin, SkinOptions,
    Skinning, Tissue, TissueDescription, TissueKind,
};

const LIMBS: usize = 5;
const BONES: usize = 5;
const MUSCLES: usize = 15;
/// Vertices around a limb and along it, for a body of 30,000 vertices.
const AROUND: usize = 60;
const ALONG: usize = 100;
const TENSION: [f32; LIMBS * MUSCLES] = [0.0; LIMBS * MUSCLES];
const BONE_M: f64 = 0.25;
const RADIUS_M: f64 = 0.08;

/// Five limbs side by side, each of five bones.
struct Body {
    rest: Vec<DAffine3>,
    musculature: Arc<Musculature>,
    points: Vec<[f32; 3]>,
    edges: Vec<[i32; 2]>,
    triangles: Vec<[i32; 3]>,
    offsets: Vec<i32>,
    bones: Vec<i32>,
    weights: Vec<f32>,
}

fn columns(map: DAffine3) -> ColumnMajor {
    DMat4::from(map).as_mat4().to_cols_array()
}

fn foot(limb: usize) -> DVec3 {
    DVec3::new(0.4 * limb as f64, 0.0, 0.0)
}

fn muscle(limb: usize, index: usize) -> Tissue {
    let (joint, side) = (index % (BONES - 1), TAU * index as f64 / MUSCLES as f64);
    let around = DVec3::new(side.cos(), side.sin(), 0.0) * (0.6 * RADIUS_M);
    let centre = foot(limb) + around + DVec3::Z * (BONE_M * (joint + 1) as f64);
    Tissue::new(TissueDescription {
        name: format!("{limb}.{index}"),
        kind: TissueKind::Muscle,
        origin_bone: (limb * BONES + joint) as i64,
        insertion_bone: (limb * BONES + joint + 1) as i64,
        centre: centre.to_array(),
        rotation: [1.0, 0.0, 0.0, 0.0],
        semi_axes: [0.02, 0.025, 0.1],
        origin_tendon_m: 0.02,
        insertion_tendon_m: 0.02,
        volume_keeping: 1.0,
        via_points: vec![],
        wraps: vec![],
    })
    .unwrap()
}

impl Body {
    fn new() -> Self {
        Self::of_size(LIMBS * AROUND * ALONG)
    }

    /// A body of about so many vertices.
    fn of_size(vertices: usize) -> Self {
        let finer = (vertices as f64 / (LIMBS * AROUND * ALONG) as f64).sqrt();
        let grid = [AROUND, ALONG].map(|count| (count as f64 * finer).round() as usize);
        let joints = (0..LIMBS).flat_map(|limb| (0..BONES).map(move |bone| (limb, bone)));
        let rest: Vec<_> = joints
            .clone()
            .map(|(limb, bone)| DAffine3::from_translation(foot(limb) + DVec3::Z * (BONE_M * bone as f64)))
            .collect();
        let parents: Vec<i32> = joints
            .map(|(limb, bone)| {
                if bone == 0 {
                    -1
                } else {
                    (limb * BONES + bone - 1) as i32
                }
            })
            .collect();
        let names = (0..rest.len()).map(|bone| bone.to_string()).collect();
        let matrices: Vec<_> = rest.iter().copied().map(columns).collect();
        let skeleton = Skeleton::new(names, &parents, &matrices).unwrap();
        let tissues = (0..LIMBS)
            .flat_map(|limb| (0..MUSCLES).map(move |index| muscle(limb, index)))
            .collect();
        let musculature = Arc::new(Musculature::new(skeleton, tissues).unwrap());
        let (points, edges) = (vec![], vec![]);
        let mut body = Self {
            rest,
            musculature,
            points,
            edges,
            triangles: vec![],
            offsets: vec![0],
            bones: vec![],
            weights: vec![],
        };
        (0..LIMBS).for_each(|limb| body.add_skin(limb, grid));
        body
    }

    fn add_skin(&mut self, limb: usize, [around, along]: [usize; 2]) {
        let first = self.points.len();
        for ring in 0..along {
            let height = ring as f64 / along as f64 * BONES as f64;
            for step in 0..around {
                let angle = TAU * step as f64 / around as f64;
                let on_ring =
                    DVec3::new(angle.cos(), angle.sin(), 0.0) * RADIUS_M + DVec3::Z * (height * BONE_M);
                self.points.push((foot(limb) + on_ring).as_vec3().to_array());
                for bone in 0..BONES {
                    let weight = 1.0 - (height - bone as f64 - 0.5).abs();
                    if weight > 0.0 {
                        self.bones.push((limb * BONES + bone) as i32);
                        self.weights.push(weight as f32);
                    }
                }
                self.offsets.push(self.bones.len() as i32);
                let at = |ring: usize, step: usize| (first + ring * around + step % around) as i32;
                self.edges.push([at(ring, step), at(ring, step + 1)]);
                if ring + 1 < along {
                    self.edges.push([at(ring, step), at(ring + 1, step)]);
                    let (here, beside) = (at(ring, step), at(ring, step + 1));
                    let (above, across) = (at(ring + 1, step), at(ring + 1, step + 1));
                    self.triangles
                        .extend([[here, beside, across], [here, across, above]]);
                }
            }
        }
    }

    fn skin(&self, options: &SkinOptions) -> Skin {
        let whole = columns(DAffine3::IDENTITY);
        Skin::new(self.musculature.clone(), &self.mesh(&whole), options).unwrap()
    }

    fn elastic(&self, safeguards: bool) -> Skin {
        let whole = columns(DAffine3::IDENTITY);
        let of_bone: Vec<i32> = (0..self.rest.len() as i32).collect();
        let lengths_m = vec![BONE_M as f32; self.rest.len()];
        let segments = Segments {
            of_bone: &of_bone,
            lengths_m: &lengths_m,
        };
        let elasticity = Elasticity {
            safeguards,
            ..Elasticity::new(&self.edges, &self.triangles, segments, 10)
        };
        let skin = self.skin(&SkinOptions::default());
        skin.with_elasticity(&self.mesh(&whole), &elasticity).unwrap()
    }

    fn mesh<'a>(&'a self, mesh_to_armature: &'a ColumnMajor) -> RestMesh<'a> {
        RestMesh {
            points: &self.points,
            edges: &self.edges,
            mesh_to_armature,
            weight_offsets: &self.offsets,
            weight_bones: &self.bones,
            weights: &self.weights,
        }
    }

    /// Every joint bent by so many radians.
    fn pose(&self, bend: f64) -> Vec<ColumnMajor> {
        let mut posed = DAffine3::IDENTITY;
        let rotation = DAffine3::from_quat(DQuat::from_rotation_x(bend));
        let mut pose = vec![];
        for (index, rest) in self.rest.iter().enumerate() {
            let to_joint = DAffine3::from_translation(rest.translation);
            let rotated = to_joint * rotation * to_joint.inverse();
            posed = if index % BONES == 0 {
                rotated
            } else {
                posed * rotated
            };
            pose.push(columns(posed * *rest));
        }
        pose
    }
}

const MODES: [(Skinning, MotionSource); 4] = [
    (Skinning::Linear, MotionSource::Swelling),
    (Skinning::Linear, MotionSource::Full),
    (Skinning::PreserveVolume, MotionSource::Swelling),
    (Skinning::PreserveVolume, MotionSource::Full),
];

fn options(mode: usize) -> SkinOptions<'static> {
    let (skinning, motion_source) = MODES[mode];
    SkinOptions {
        skinning,
        motion_source,
        ..SkinOptions::default()
    }
}

fn main() {
    for (mode, (skinning, motion_source)) in MODES.iter().enumerate() {
        let skin = Body::new().skin(&options(mode));
        eprintln!(
            "mode {mode}: {skinning:?} {motion_source:?}, {} of {} vertices anchored",
            skin.anchored(),
            skin.len()
        );
    }
    divan::main();
}

#[divan::bench(args = [0, 1])]
fn bind(bencher: Bencher, mode: usize) {
    let body = Body::new();
    bencher.bench(|| body.skin(&options(mode)));
}

/// Two poses in turn. In a repeated pose nothing is dirty, and a frame only copies.
fn poses(body: &Body) -> impl FnMut() -> Vec<ColumnMajor> + use<> {
    let mut both = [body.pose(0.5), body.pose(0.8)];
    move || {
        both.swap(0, 1);
        both[0].clone()
    }
}

#[divan::bench(args = [0, 1, 2, 3])]
fn correct(bencher: Bencher, mode: usize) {
    let body = Body::new();
    let skin = body.skin(&options(mode));
    let mut out = vec![[0.0; 3]; skin.len()];
    let poses = bencher.with_inputs(poses(&body));
    poses.bench_local_values(|pose| skin.correct(&pose, &TENSION, &mut out).unwrap());
}

#[divan::bench(args = [0, 1, 2, 3])]
fn deform(bencher: Bencher, mode: usize) {
    let body = Body::new();
    let skin = body.skin(&options(mode));
    let mut out = vec![[0.0; 3]; skin.len()];
    let poses = bencher.with_inputs(poses(&body));
    poses.bench_local_values(|pose| skin.deform(&pose, &TENSION, &mut out).unwrap());
}

/// A whole frame, elasticity and contact on, with the safeguard and without.
#[divan::bench(args = [true, false])]
fn correct_elastic(bencher: Bencher, safeguards: bool) {
    let body = Body::new();
    let skin = body.elastic(safeguards);
    let mut out = vec![[0.0; 3]; skin.len()];
    let poses = bencher.with_inputs(poses(&body));
    poses.bench_local_values(|pose| skin.correct(&pose, &TENSION, &mut out).unwrap());
}

/// 1, 2, 4, ... and all threads of this machine.
fn thread_counts() -> impl Iterator<Item = usize> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let powers = (0..)
        .map(|power| 1 << power)
        .take_while(move |&count| count < all);
    powers.chain([all])
}

/// What a frame of the extension does: elasticity, contact and the safeguard on, 10 iterations, every joint moves.
#[divan::bench(args = [13_000, 30_000, 100_000].into_iter().flat_map(|vertices| thread_counts().map(move |threads| Load { vertices, threads })))]
fn frame(bencher: Bencher, load: &Load) {
    let body = Body::of_size(load.vertices);
    let skin = body.elastic(true);
    let mut out = vec![[0.0; 3]; skin.len()];
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(load.threads)
        .build()
        .unwrap();
    let mut next = poses(&body);
    let mut correct = |pose: &[ColumnMajor]| {
        pool.install(|| skin.correct(pose, &TENSION, &mut out)).unwrap();
    };
    (0..2).for_each(|_| correct(&next())); // the safeguard samples each rotation once
    bencher
        .with_inputs(next)
        .bench_local_values(|pose| correct(&pose));
}

struct Load {
    vertices: usize,
    threads: usize,
}

impl std::fmt::Display for Load {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(formatter, "{} vertices, {} threads", self.vertices, self.threads)
    }
}
