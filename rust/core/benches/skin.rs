//! Times of a bind and of a frame on a body of 30,000 vertices with 75 muscles.
#![allow(clippy::unwrap_used, missing_docs)]

use std::f64::consts::TAU;
use std::sync::Arc;

use divan::Bencher;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use sinew_core::{
    ColumnMajor, MotionSource, Musculature, RestMesh, Skeleton, Skin, SkinOptions, Skinning, Tissue,
    TissueDescription, TissueKind,
};

const LIMBS: usize = 5;
const BONES: usize = 5;
const MUSCLES: usize = 15;
const AROUND: usize = 60;
const ALONG: usize = 100;
const BONE_M: f64 = 0.25;
const RADIUS_M: f64 = 0.08;

/// Five limbs side by side, each of five bones.
struct Body {
    rest: Vec<DAffine3>,
    musculature: Arc<Musculature>,
    points: Vec<[f32; 3]>,
    edges: Vec<[i32; 2]>,
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
            offsets: vec![0],
            bones: vec![],
            weights: vec![],
        };
        (0..LIMBS).for_each(|limb| body.add_skin(limb));
        body
    }

    fn add_skin(&mut self, limb: usize) {
        let first = self.points.len();
        for ring in 0..ALONG {
            let height = ring as f64 / ALONG as f64 * BONES as f64;
            for step in 0..AROUND {
                let angle = TAU * step as f64 / AROUND as f64;
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
                let at = |ring: usize, step: usize| (first + ring * AROUND + step % AROUND) as i32;
                self.edges.push([at(ring, step), at(ring, step + 1)]);
                if ring + 1 < ALONG {
                    self.edges.push([at(ring, step), at(ring + 1, step)]);
                }
            }
        }
    }

    fn skin(&self, options: &SkinOptions) -> Skin {
        let mesh = RestMesh {
            points: &self.points,
            edges: &self.edges,
            mesh_to_armature: &columns(DAffine3::IDENTITY),
            weight_offsets: &self.offsets,
            weight_bones: &self.bones,
            weights: &self.weights,
        };
        Skin::new(self.musculature.clone(), &mesh, options).unwrap()
    }

    fn pose(&self) -> Vec<ColumnMajor> {
        let mut posed = DAffine3::IDENTITY;
        let rotation = DAffine3::from_quat(DQuat::from_rotation_x(0.5));
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

#[divan::bench(args = [0, 1, 2, 3])]
fn correct(bencher: Bencher, mode: usize) {
    let body = Body::new();
    let (skin, pose, tension) = (body.skin(&options(mode)), body.pose(), [0.0; LIMBS * MUSCLES]);
    let mut out = vec![[0.0; 3]; skin.len()];
    bencher.bench_local(|| skin.correct(&pose, &tension, &mut out).unwrap());
}

#[divan::bench(args = [0, 1, 2, 3])]
fn deform(bencher: Bencher, mode: usize) {
    let body = Body::new();
    let (skin, pose, tension) = (body.skin(&options(mode)), body.pose(), [0.0; LIMBS * MUSCLES]);
    let mut out = vec![[0.0; 3]; skin.len()];
    bencher.bench_local(|| skin.deform(&pose, &tension, &mut out).unwrap());
}
