//! Curved muscles over a hinge for the laws, and measurements of them.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use sinew_core::{Musculature, Palette, Skeleton, Tissue, TissueDescription, TissueKind};

use super::rig::{columns, rotation_about};

pub const RADIUS_M: f64 = 0.025;
pub const STEP_DEGREES: f64 = 0.25;

/// A muscle over a hinge at the origin, between a bone upwards and a bone downwards, with a sphere in the
/// hinge.
#[derive(Clone)]
pub struct Hinge {
    pub origin: DVec3,
    pub insertion: DVec3,
    pub widths_m: [f64; 2],
    pub tendons_m: [f64; 2],
    pub via_points: Vec<(i64, [f64; 3])>,
    pub wraps: bool,
    /// A map of the whole rig, which may mirror.
    pub placed: DAffine3,
}

/// A triceps.
pub fn extensor() -> Hinge {
    Hinge {
        origin: DVec3::new(-0.03, 0.005, 0.25),
        insertion: DVec3::new(-0.032, -0.004, -0.03),
        widths_m: [0.02, 0.015],
        tendons_m: [0.02, 0.05],
        via_points: vec![],
        wraps: true,
        placed: DAffine3::IDENTITY,
    }
}

/// A quadriceps over its kneecap: the hinge bends the other way.
pub fn quadriceps() -> Hinge {
    Hinge {
        origin: DVec3::new(-0.05, 0.0, 0.4),
        insertion: DVec3::new(-0.04, 0.0, -0.08),
        widths_m: [0.03, 0.04],
        tendons_m: [0.03, 0.12],
        ..extensor()
    }
}

/// A biceps: it shortens as the hinge bends, and does not touch the sphere.
pub fn flexor() -> Hinge {
    Hinge {
        origin: DVec3::new(0.04, 0.0, 0.25),
        insertion: DVec3::new(0.035, 0.0, -0.05),
        tendons_m: [0.01, 0.02],
        ..extensor()
    }
}

/// An extensor that ends inside its sphere.
pub fn deep() -> Hinge {
    Hinge {
        insertion: DVec3::new(-0.02, 0.002, -0.01),
        ..extensor()
    }
}

/// An extensor through two via points, wrapped around the sphere between them.
pub fn guided() -> Hinge {
    Hinge {
        via_points: vec![(0, [-0.05, 0.0, 0.12]), (1, [-0.04, 0.005, -0.06])],
        insertion: DVec3::new(-0.02, 0.0, -0.2),
        ..extensor()
    }
}

/// The same, with the last via point so near to the sphere that its straight end is nearer than the path over
/// the joint.
pub fn hooked() -> Hinge {
    Hinge {
        via_points: vec![(0, [-0.06, 0.0, 0.1]), (1, [-0.05, 0.01, -0.03])],
        insertion: DVec3::new(-0.035, 0.0, -0.02),
        ..extensor()
    }
}

impl Hinge {
    pub fn musculature(&self) -> Musculature {
        let frames = [DQuat::from_rotation_x(0.3), DQuat::from_rotation_z(1.0)].map(DAffine3::from_quat);
        let rest = frames.map(|frame| columns(self.frame(frame)));
        let skeleton = Skeleton::new(vec!["upper".into(), "lower".into()], &[-1, 0], &rest).unwrap();
        let along = self.insertion - self.origin;
        let half_m = 0.5 * (along.length() - self.tendons_m[0] - self.tendons_m[1]);
        let axes = DQuat::from_rotation_arc(DVec3::Z, along.normalize()) * DQuat::from_rotation_z(0.2);
        let centre = self.origin + along.normalize() * (self.tendons_m[0] + half_m);
        let frame = self.frame(DAffine3::from_rotation_translation(axes, centre));
        let ball = self.placed.transform_point3(DVec3::ZERO);
        let placed = |point: [f64; 3]| self.placed.transform_point3(point.into()).to_array();
        let [x, y] = self.widths_m;
        let via_points = self.via_points.iter().map(|&(bone, point)| (bone, placed(point)));
        let tissue = TissueDescription {
            name: "muscle".into(),
            kind: TissueKind::Muscle,
            origin_bone: 0,
            insertion_bone: 1,
            centre: frame.translation.to_array(),
            rotation: wxyz(DQuat::from_mat3(&frame.matrix3)),
            semi_axes: [x, y, half_m],
            origin_tendon_m: self.tendons_m[0],
            insertion_tendon_m: self.tendons_m[1],
            volume_keeping: 1.0,
            via_points: via_points.collect(),
            wraps: if self.wraps { vec!["ball".into()] } else { vec![] },
        };
        let sphere = TissueDescription {
            name: "ball".into(),
            kind: TissueKind::Sphere,
            origin_bone: 1,
            centre: ball.to_array(),
            semi_axes: [RADIUS_M; 3],
            origin_tendon_m: 0.0,
            insertion_tendon_m: 0.0,
            via_points: vec![],
            wraps: vec![],
            ..tissue.clone()
        };
        let tissues = [tissue, sphere].map(|description| Tissue::new(description).unwrap());
        Musculature::new(skeleton, tissues.to_vec()).unwrap()
    }

    /// Axes moved with the rig, and made right-handed.
    pub fn frame(&self, frame: DAffine3) -> DAffine3 {
        let hand = self.placed.matrix3.determinant().signum();
        let mirror = DMat3::from_diagonal(DVec3::new(hand, 1.0, 1.0));
        let placed = self.placed * frame;
        DAffine3 {
            matrix3: placed.matrix3 * mirror,
            translation: placed.translation,
        }
    }

    /// The lower bone rotated about the hinge, then `after`.
    pub fn turned(&self, musculature: &Musculature, turn: DQuat, after: DAffine3) -> Palette {
        let carried = self.placed * DAffine3::from_quat(turn) * self.placed.inverse();
        let rest = musculature.skeleton().rest();
        let pose = [after * rest[0], after * carried * rest[1]].map(columns);
        Palette::new(musculature.skeleton(), &pose).unwrap()
    }

    pub fn bent(&self, musculature: &Musculature, degrees: f64) -> Palette {
        let turn = DQuat::from_rotation_y(-degrees.to_radians());
        self.turned(musculature, turn, DAffine3::IDENTITY)
    }

    /// Distance of the whole path from the centre of the sphere, m.
    pub fn clear_m(&self) -> f64 {
        RADIUS_M + 0.5 * self.widths_m[0].min(self.widths_m[1])
    }

    /// Length of the last part of the path, inside the sphere if the insertion is, m.
    pub fn dive_m(&self) -> f64 {
        let inside = self.clear_m().powi(2) - self.insertion.length_squared();
        inside.max(0.0).sqrt() * 1.1
    }
}

pub fn wxyz(rotation: DQuat) -> [f64; 4] {
    [rotation.w, rotation.x, rotation.y, rotation.z]
}

/// The chain of the first tissue.
pub fn chain(musculature: &Musculature, palette: &Palette) -> Vec<DMat4> {
    tense_chain(musculature, palette, 0.0)
}

pub fn tense_chain(musculature: &Musculature, palette: &Palette, tension: f32) -> Vec<DMat4> {
    let all = musculature
        .pose_ellipsoids(palette, &vec![tension; musculature.len()])
        .unwrap();
    let owners = musculature.ellipsoid_tissues();
    let own = all.into_iter().zip(owners).filter(|(_, owner)| **owner == 0);
    own.map(|(matrix, _)| matrix).collect()
}

pub fn path(musculature: &Musculature, palette: &Palette) -> Vec<DVec3> {
    musculature.paths(palette).of(0).to_vec()
}

pub fn length_of(path: &[DVec3]) -> f64 {
    path.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Distance of a point from the nearest segment of a polyline, m.
pub fn clearance(path: &[DVec3], point: DVec3) -> f64 {
    let from_segment = |pair: &[DVec3]| {
        let along = pair[1] - pair[0];
        let share = (point - pair[0]).dot(along) / along.length_squared().max(1e-30);
        pair[0].lerp(pair[1], share.clamp(0.0, 1.0)).distance(point)
    };
    path.windows(2).map(from_segment).fold(f64::INFINITY, f64::min)
}

pub fn volume(matrix: &DMat4) -> f64 {
    4.0 / 3.0 * PI * DMat3::from_mat4(*matrix).determinant().abs()
}

/// Largest distance between columns and centres of two lists of ellipsoids, m.
pub fn change(a: &[DMat4], b: &[DMat4]) -> f64 {
    let columns = |matrix: &DMat4| [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis];
    let pairs = a
        .iter()
        .zip(b)
        .flat_map(|(a, b)| columns(a).into_iter().zip(columns(b)));
    pairs.map(|(a, b)| a.distance(b)).fold(0.0, f64::max)
}

pub fn degrees(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..=((to - from) / STEP_DEGREES) as usize).map(move |step| from + step as f64 * STEP_DEGREES)
}

pub fn hinges() -> [(Hinge, f64); 6] {
    [
        (extensor(), 150.0),
        (quadriceps(), 140.0),
        (flexor(), 150.0),
        (deep(), 150.0),
        (guided(), 150.0),
        (hooked(), 150.0),
    ]
}

/// A muscle along the back of three bones in a line along -z, wrapped around a sphere at each joint.
pub fn two_joints() -> Musculature {
    let heads = [0.3, 0.0, -0.3].map(|height| DAffine3::from_translation(DVec3::Z * height));
    let names = ["a", "b", "c"].map(str::to_owned).to_vec();
    let skeleton = Skeleton::new(names, &[-1, 0, 1], &heads.map(columns)).unwrap();
    let muscle = TissueDescription {
        name: "long".into(),
        kind: TissueKind::Muscle,
        origin_bone: 0,
        insertion_bone: 2,
        centre: [-0.05, 0.0, -0.15],
        rotation: [0.0, 1.0, 0.0, 0.0],
        semi_axes: [0.02, 0.02, 0.2],
        origin_tendon_m: 0.05,
        insertion_tendon_m: 0.05,
        volume_keeping: 1.0,
        via_points: vec![],
        wraps: vec!["knee".into(), "hip".into()],
    };
    let ball = |name: &str, bone: i64, height: f64| TissueDescription {
        name: name.into(),
        kind: TissueKind::Sphere,
        origin_bone: bone,
        insertion_bone: bone,
        centre: [0.0, 0.0, height],
        semi_axes: [0.03; 3],
        origin_tendon_m: 0.0,
        insertion_tendon_m: 0.0,
        wraps: vec![],
        ..muscle.clone()
    };
    let tissues = [muscle.clone(), ball("hip", 1, 0.0), ball("knee", 2, -0.3)];
    let tissues = tissues.map(|description| Tissue::new(description).unwrap());
    Musculature::new(skeleton, tissues.to_vec()).unwrap()
}

pub fn two_joints_bent(musculature: &Musculature, first: f64, second: f64) -> Palette {
    let rest = musculature.skeleton().rest();
    let hip = DAffine3::from_quat(DQuat::from_rotation_y(first));
    let knee = hip * rotation_about(DVec3::new(0.0, 0.0, -0.3), DQuat::from_rotation_y(second));
    let pose = [rest[0], hip * rest[1], knee * rest[2]].map(columns);
    Palette::new(musculature.skeleton(), &pose).unwrap()
}
