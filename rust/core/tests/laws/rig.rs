//! A limb for the laws: three bones, muscles across both joints, a bone, a sphere, a tube of skin.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{
    ColumnMajor, Elasticity, MotionSource, Musculature, RestMesh, Result, Segments, Skeleton, Skin,
    SkinOptions, Skinning, Tissue, TissueDescription, TissueKind,
};

pub const AROUND: usize = 24;
pub const ALONG: usize = 40;
pub const BONES: usize = 3;
pub const TISSUES: usize = 6;

/// The position and orientation of a limb and everything on it.
#[derive(Clone, Copy)]
pub struct Limb {
    /// A map from the plain limb to this one, which may mirror.
    pub placed: DAffine3,
}

pub const PLAIN: Limb = Limb {
    placed: DAffine3::IDENTITY,
};

pub fn columns(map: DAffine3) -> ColumnMajor {
    DMat4::from(map).as_mat4().to_cols_array()
}

pub fn rotation_about(point: DVec3, rotation: DQuat) -> DAffine3 {
    DAffine3::from_translation(point) * DAffine3::from_quat(rotation) * DAffine3::from_translation(-point)
}

impl Limb {
    /// Axes moved with the limb, and made right-handed.
    fn frame(&self, frame: DAffine3) -> DAffine3 {
        let mirror = if self.placed.matrix3.determinant() < 0.0 {
            DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0))
        } else {
            DMat3::IDENTITY
        };
        let placed = self.placed * frame;
        DAffine3 {
            matrix3: placed.matrix3 * mirror,
            translation: placed.translation,
        }
    }

    pub fn rest(&self) -> Vec<DAffine3> {
        let turned = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_x(1.1);
        let heads = [
            DVec3::ZERO,
            DVec3::new(0.0, 0.01, 0.3),
            DVec3::new(0.02, 0.0, 0.6),
        ];
        heads
            .map(|head| self.frame(DAffine3::from_rotation_translation(turned, head)))
            .to_vec()
    }

    pub fn rest_pose(&self) -> Vec<ColumnMajor> {
        self.rest().into_iter().map(columns).collect()
    }

    /// The rest pose with each bone rotated about its joint by all rotations up to it; then `after`.
    pub fn pose(&self, turns: &[DQuat; BONES], after: DAffine3) -> Vec<ColumnMajor> {
        let mut carried = DAffine3::IDENTITY;
        let plain = PLAIN.rest();
        let mut pose = vec![];
        for (rest, turn) in plain.iter().zip(turns) {
            carried *= rotation_about(rest.translation, *turn);
            let map = self.placed * carried * self.placed.inverse();
            let own = self.rest()[pose.len()];
            pose.push(columns(after * map * own));
        }
        pose
    }

    pub fn skeleton(&self) -> Skeleton {
        let names = ["upper", "lower", "hand"].map(str::to_owned).to_vec();
        Skeleton::new(names, &[-1, 0, 1], &self.rest_pose()).unwrap()
    }

    pub fn musculature(&self) -> Arc<Musculature> {
        let tissue = |name: &str, kind, bones: [i64; 2], centre, tilt, semi_axes| {
            let rotation = DQuat::from_rotation_x(tilt) * DQuat::from_rotation_z(0.4);
            let frame = self.frame(DAffine3::from_rotation_translation(
                rotation,
                DVec3::from_array(centre),
            ));
            let rotation = DQuat::from_mat3(&frame.matrix3);
            // One muscle wraps around the elbow, so that all laws of skin also cover a chain.
            let wraps = if name == "long" { &["elbow"][..] } else { &[] };
            let tendon_m = if kind == TissueKind::Muscle { 0.02 } else { 0.0 };
            Tissue::new(TissueDescription {
                name: name.to_owned(),
                kind,
                origin_bone: bones[0],
                insertion_bone: bones[1],
                centre: frame.translation.to_array(),
                rotation: [rotation.w, rotation.x, rotation.y, rotation.z],
                semi_axes,
                origin_tendon_m: tendon_m,
                insertion_tendon_m: 1.5 * tendon_m,
                volume_keeping: 1.0,
                via_points: vec![],
                wraps: wraps.iter().map(|&wrap| wrap.to_owned()).collect(),
            })
            .unwrap()
        };
        let tissues = vec![
            tissue(
                "front",
                TissueKind::Muscle,
                [0, 1],
                [0.03, 0.0, 0.2],
                0.1,
                [0.015, 0.02, 0.11],
            ),
            tissue(
                "back",
                TissueKind::Muscle,
                [0, 1],
                [-0.03, 0.0, 0.21],
                -0.1,
                [0.02, 0.015, 0.1],
            ),
            tissue(
                "far",
                TissueKind::Muscle,
                [1, 2],
                [0.0, 0.03, 0.5],
                0.0,
                [0.012, 0.017, 0.08],
            ),
            tissue(
                "long",
                TissueKind::Muscle,
                [0, 2],
                [0.0, -0.035, 0.35],
                0.05,
                [0.01, 0.02, 0.2],
            ),
            tissue(
                "bone",
                TissueKind::Bone,
                [0, 0],
                [0.0, 0.0, 0.15],
                0.0,
                [0.015, 0.015, 0.14],
            ),
            tissue(
                "elbow",
                TissueKind::Sphere,
                [1, 1],
                [0.0, 0.01, 0.3],
                0.0,
                [0.025, 0.025, 0.025],
            ),
        ];
        Arc::new(Musculature::new(self.skeleton(), tissues).unwrap())
    }

    pub fn points(&self) -> Vec<[f32; 3]> {
        let place = |vertex: usize| {
            let angle = TAU * (vertex % AROUND) as f64 / AROUND as f64;
            let along = (vertex / AROUND) as f64 / ALONG as f64;
            let plain = DVec3::new(0.055 * angle.cos(), 0.06 * angle.sin(), 0.9 * along - 0.05);
            self.placed.transform_point3(plain).as_vec3().to_array()
        };
        (0..AROUND * ALONG).map(place).collect()
    }

    pub fn skin(&self, options: &SkinOptions) -> Skin {
        self.skin_of(&self.points(), &DAffine3::IDENTITY, options)
    }

    /// The same skin, with elasticity.
    pub fn elastic_skin(&self, options: &SkinOptions) -> Skin {
        let (edges, triangles) = (edges(), triangles());
        self.skin_with(options, &Elasticity::new(&edges, &triangles, SEGMENTS, 8))
            .unwrap()
    }

    /// The same, without what lets it return to the modifier's skin.
    pub fn relaxed_skin(&self, options: &SkinOptions) -> Skin {
        let (edges, triangles) = (edges(), triangles());
        let elasticity = Elasticity {
            safeguards: false,
            ..Elasticity::new(&edges, &triangles, SEGMENTS, 8)
        };
        self.skin_with(options, &elasticity).unwrap()
    }

    pub fn skin_with(&self, options: &SkinOptions, elasticity: &Elasticity) -> Result<Skin> {
        let (offsets, bones, weights) = weights();
        let points = self.points();
        let mesh = RestMesh {
            points: &points,
            edges: &edges(),
            mesh_to_armature: &columns(DAffine3::IDENTITY),
            weight_offsets: &offsets,
            weight_bones: &bones,
            weights: &weights,
        };
        Skin::new(self.musculature(), &mesh, options).and_then(|skin| skin.with_elasticity(&mesh, elasticity))
    }

    /// A skin with other points, and the edges and weights of the limb.
    pub fn skin_of(&self, points: &[[f32; 3]], mesh_to_armature: &DAffine3, options: &SkinOptions) -> Skin {
        let (offsets, bones, weights) = weights();
        let mesh = RestMesh {
            points,
            edges: &edges(),
            mesh_to_armature: &columns(*mesh_to_armature),
            weight_offsets: &offsets,
            weight_bones: &bones,
            weights: &weights,
        };
        Skin::new(self.musculature(), &mesh, options).unwrap()
    }
}

/// Each bone is its own segment.
pub const SEGMENTS: Segments = Segments {
    of_bone: &[0, 1, 2],
    lengths_m: &[0.3, 0.3, 0.2],
};

pub fn edges() -> Vec<[i32; 2]> {
    let at = |around: usize, along: usize| (along * AROUND + around % AROUND) as i32;
    let grid = (0..ALONG).flat_map(|along| (0..AROUND).map(move |around| (around, along)));
    let mut edges = vec![];
    for (around, along) in grid {
        edges.push([at(around, along), at(around + 1, along)]);
        if along + 1 < ALONG {
            edges.push([at(around, along), at(around, along + 1)]);
        }
    }
    edges
}

pub fn triangles() -> Vec<[i32; 3]> {
    let at = |around: usize, along: usize| (along * AROUND + around % AROUND) as i32;
    let grid = (0..ALONG - 1).flat_map(|along| (0..AROUND).map(move |around| (around, along)));
    grid.flat_map(|(around, along)| {
        let (a, b) = (at(around, along), at(around + 1, along));
        let (c, d) = (at(around + 1, along + 1), at(around, along + 1));
        [[a, b, c], [a, c, d]]
    })
    .collect()
}

/// Two bones per vertex, except a ring of vertices without weights at either end.
pub fn weights() -> (Vec<i32>, Vec<i32>, Vec<f32>) {
    let (mut offsets, mut bones, mut weights) = (vec![0], vec![], vec![]);
    for vertex in 0..AROUND * ALONG {
        let ring = vertex / AROUND;
        if ring > 0 && ring + 1 < ALONG {
            let height = 0.9 * ring as f32 / ALONG as f32 - 0.05;
            let joint = if height < 0.45 { 0 } else { 1 };
            // Ring 16 has equal weights: a twist by 180 degrees flattens it.
            let at = if joint == 0 { 0.31 } else { 0.6 };
            let share = ((height - at + 0.08) / 0.16).clamp(0.0, 1.0);
            bones.extend([joint, joint + 1]);
            weights.extend([0.8 * (1.0 - share), 0.8 * share]);
        }
        offsets.push(bones.len() as i32);
    }
    (offsets, bones, weights)
}

/// The vertices of a limb that have weights, and so move with bones.
pub fn weighed(points: &[[f32; 3]]) -> &[[f32; 3]] {
    &points[AROUND..AROUND * (ALONG - 1)]
}

pub fn no_tension() -> Vec<f32> {
    vec![0.0; TISSUES]
}

pub fn deformed(skin: &Skin, pose: &[ColumnMajor], tension: &[f32]) -> Vec<[f32; 3]> {
    let mut out = vec![[f32::NAN; 3]; skin.len()];
    skin.deform(pose, tension, &mut out).unwrap();
    out
}

pub fn corrected(skin: &Skin, pose: &[ColumnMajor], tension: &[f32]) -> (Vec<[f32; 3]>, usize) {
    let mut out = vec![[f32::NAN; 3]; skin.len()];
    let report = skin.correct(pose, tension, &mut out).unwrap();
    (out, report.damped)
}

/// Largest distance between two lists of points, m.
pub fn gap(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let wide = |point: &[f32; 3]| DVec3::from_array(point.map(f64::from));
    let gaps = a.iter().zip(b).map(|(a, b)| wide(a).distance(wide(b)));
    gaps.fold(
        0.0,
        |worst, gap| if gap > worst || gap.is_nan() { gap } else { worst },
    )
}

pub fn mapped(points: &[[f32; 3]], map: DAffine3) -> Vec<[f32; 3]> {
    let place = |point: &[f32; 3]| {
        map.transform_point3(DVec3::from_array(point.map(f64::from)))
            .as_vec3()
            .to_array()
    };
    points.iter().map(place).collect()
}

prop_compose! {
    pub fn rotations(limit: f64)(axis in prop::array::uniform3(-1.0..1.0), angle in -limit..limit) -> DQuat {
        let axis = DVec3::from_array(axis).try_normalize().unwrap_or(DVec3::X);
        DQuat::from_axis_angle(axis, angle)
    }
}

pub fn turns(limit: f64) -> impl Strategy<Value = [DQuat; BONES]> {
    prop::array::uniform3(rotations(limit))
}

pub fn tensions() -> impl Strategy<Value = Vec<f32>> {
    prop::collection::vec(0.0f32..=1.0, TISSUES)
}

prop_compose! {
    pub fn motions()(rotation in rotations(3.1), shift in prop::array::uniform3(-3.0..3.0)) -> DAffine3 {
        DAffine3::from_rotation_translation(rotation, DVec3::from_array(shift))
    }
}

pub fn options() -> impl Strategy<Value = SkinOptions<'static>> {
    let skinning = prop_oneof![Just(Skinning::Linear), Just(Skinning::PreserveVolume)];
    let motion_source = prop_oneof![Just(MotionSource::Swelling), Just(MotionSource::Full)];
    (skinning, motion_source, any::<bool>()).prop_map(|(skinning, motion_source, scales_fat)| SkinOptions {
        skinning,
        motion_source,
        scales_fat,
        ..SkinOptions::default()
    })
}
