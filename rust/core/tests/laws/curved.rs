//! A muscle round a joint or through via points keeps its volume, never jumps, never enters the joint, and is the straight
//! muscle where nothing is in the way.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{Error, Musculature, Palette, Skeleton, Tissue, TissueDescription, TissueKind};

use super::rig::{columns, motions, rotation_about, rotations};

const RADIUS_M: f64 = 0.025;
const STEP_DEGREES: f64 = 0.25;

/// A muscle over a hinge at the origin of space, between a bone upward and one downward, and a ball in the hinge.
#[derive(Clone)]
struct Hinge {
    origin: DVec3,
    insertion: DVec3,
    widths_m: [f64; 2],
    tendons_m: [f64; 2],
    via_points: Vec<(i64, [f64; 3])>,
    wraps: bool,
    /// Maps all of it elsewhere; may mirror.
    placed: DAffine3,
}

/// A triceps.
fn extensor() -> Hinge {
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

/// A quadriceps over its kneecap: the hinge turns the other way.
fn quadriceps() -> Hinge {
    Hinge {
        origin: DVec3::new(-0.05, 0.0, 0.4),
        insertion: DVec3::new(-0.04, 0.0, -0.08),
        widths_m: [0.03, 0.04],
        tendons_m: [0.03, 0.12],
        ..extensor()
    }
}

/// A biceps: it shortens as the hinge bends, and leaves the ball behind.
fn flexor() -> Hinge {
    Hinge {
        origin: DVec3::new(0.04, 0.0, 0.25),
        insertion: DVec3::new(0.035, 0.0, -0.05),
        tendons_m: [0.01, 0.02],
        ..extensor()
    }
}

/// An extensor that ends inside its ball.
fn deep() -> Hinge {
    Hinge {
        insertion: DVec3::new(-0.02, 0.002, -0.01),
        ..extensor()
    }
}

/// An extensor through two via points, round the ball between them.
fn guided() -> Hinge {
    Hinge {
        via_points: vec![(0, [-0.05, 0.0, 0.12]), (1, [-0.04, 0.005, -0.06])],
        insertion: DVec3::new(-0.02, 0.0, -0.2),
        ..extensor()
    }
}

impl Hinge {
    fn musculature(&self) -> Musculature {
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

    /// A frame placed like everything else, kept right-handed.
    fn frame(&self, frame: DAffine3) -> DAffine3 {
        let hand = self.placed.matrix3.determinant().signum();
        let mirror = DMat3::from_diagonal(DVec3::new(hand, 1.0, 1.0));
        let placed = self.placed * frame;
        DAffine3 {
            matrix3: placed.matrix3 * mirror,
            translation: placed.translation,
        }
    }

    /// The lower bone turned about the hinge, then `after` on all.
    fn turned(&self, musculature: &Musculature, turn: DQuat, after: DAffine3) -> Palette {
        let carried = self.placed * DAffine3::from_quat(turn) * self.placed.inverse();
        let rest = musculature.skeleton().rest();
        let pose = [after * rest[0], after * carried * rest[1]].map(columns);
        Palette::new(musculature.skeleton(), &pose).unwrap()
    }

    fn bent(&self, musculature: &Musculature, degrees: f64) -> Palette {
        let turn = DQuat::from_rotation_y(-degrees.to_radians());
        self.turned(musculature, turn, DAffine3::IDENTITY)
    }

    /// How far the whole path keeps from the middle of the ball, m.
    fn clear_m(&self) -> f64 {
        RADIUS_M + 0.5 * self.widths_m[0].min(self.widths_m[1])
    }

    /// How long the last way is that an insertion inside makes the path go in, m.
    fn dive_m(&self) -> f64 {
        let inside = self.clear_m().powi(2) - self.insertion.length_squared();
        inside.max(0.0).sqrt() * 1.1
    }
}

fn wxyz(rotation: DQuat) -> [f64; 4] {
    [rotation.w, rotation.x, rotation.y, rotation.z]
}

/// The chain of the first tissue.
fn chain(musculature: &Musculature, palette: &Palette) -> Vec<DMat4> {
    tense_chain(musculature, palette, 0.0)
}

fn tense_chain(musculature: &Musculature, palette: &Palette, tension: f32) -> Vec<DMat4> {
    let all = musculature
        .pose_ellipsoids(palette, &vec![tension; musculature.len()])
        .unwrap();
    let owners = musculature.ellipsoid_tissues();
    let own = all.into_iter().zip(owners).filter(|(_, owner)| **owner == 0);
    own.map(|(matrix, _)| matrix).collect()
}

fn path(musculature: &Musculature, palette: &Palette) -> Vec<DVec3> {
    let paths = musculature.paths(palette);
    paths.points[paths.offsets[0]..paths.offsets[1]].to_vec()
}

fn length_of(path: &[DVec3]) -> f64 {
    path.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Distance of a point from the nearest segment of a polyline.
fn clearance(path: &[DVec3], point: DVec3) -> f64 {
    let from_segment = |pair: &[DVec3]| {
        let along = pair[1] - pair[0];
        let share = (point - pair[0]).dot(along) / along.length_squared().max(1e-30);
        pair[0].lerp(pair[1], share.clamp(0.0, 1.0)).distance(point)
    };
    path.windows(2).map(from_segment).fold(f64::INFINITY, f64::min)
}

fn volume(matrix: &DMat4) -> f64 {
    4.0 / 3.0 * PI * DMat3::from_mat4(*matrix).determinant().abs()
}

/// Largest distance between columns and centres of two lists of ellipsoids, m.
fn change(a: &[DMat4], b: &[DMat4]) -> f64 {
    let columns = |matrix: &DMat4| [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis];
    let pairs = a
        .iter()
        .zip(b)
        .flat_map(|(a, b)| columns(a).into_iter().zip(columns(b)));
    pairs.map(|(a, b)| a.distance(b)).fold(0.0, f64::max)
}

fn degrees(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..=((to - from) / STEP_DEGREES) as usize).map(move |step| from + step as f64 * STEP_DEGREES)
}

fn hinges() -> [(Hinge, f64); 5] {
    [
        (extensor(), 150.0),
        (quadriceps(), 140.0),
        (flexor(), 150.0),
        (deep(), 150.0),
        (guided(), 150.0),
    ]
}

#[test]
fn every_link_keeps_its_volume_over_elbow_and_knee() {
    for (hinge, limit) in hinges() {
        let musculature = hinge.musculature();
        let rest = chain(&musculature, &hinge.bent(&musculature, 0.0));
        let whole = musculature
            .pose(&hinge.bent(&musculature, 0.0), &[0.0; 2])
            .unwrap()
            .volume[0];
        assert!(rest.len() >= 3);
        for angle in degrees(0.0, limit) {
            let palette = hinge.bent(&musculature, angle);
            for (link, own) in chain(&musculature, &palette).iter().zip(&rest) {
                assert!((volume(link) / volume(own) - 1.0).abs() < 1e-6, "{angle}");
            }
            for tension in [0.0, 0.7] {
                let posed = musculature.pose(&palette, &[tension, 0.0]).unwrap();
                assert!((posed.volume[0] / whole - 1.0).abs() < 1e-6, "{angle}");
            }
        }
    }
}

#[test]
fn nothing_jumps_over_elbow_and_knee() {
    for (hinge, limit) in hinges() {
        let musculature = hinge.musculature();
        let reach = hinge.origin.length() + hinge.insertion.length();
        // A point farthest out moves this far in a step; nothing on the muscle may move much farther.
        let bound = 3.0 * reach * STEP_DEGREES.to_radians();
        let mut before: Option<Vec<DMat4>> = None;
        for angle in degrees(-40.0, limit + 20.0) {
            let palette = hinge.bent(&musculature, angle);
            let mut now = chain(&musculature, &palette);
            now.push(musculature.pose(&palette, &[0.0; 2]).unwrap().matrices[0]);
            if let Some(before) = before {
                let moved = change(&before, &now);
                assert!(moved < bound, "{angle}: {moved} over {bound}");
            }
            before = Some(now);
        }
    }
}

#[test]
fn it_never_enters_its_wrap_sphere() {
    for (hinge, limit) in hinges() {
        let musculature = hinge.musculature();
        for angle in degrees(0.0, limit) {
            let palette = hinge.bent(&musculature, angle);
            let path = path(&musculature, &palette);
            let insertion = path[path.len() - 1];
            let outside: Vec<_> = path
                .iter()
                .copied()
                .take_while(|point| point.distance(insertion) > hinge.dive_m())
                .collect();
            let found = clearance(&outside, DVec3::ZERO);
            assert!(found > hinge.clear_m() - 1e-6, "{angle}: {found}");
            for link in chain(&musculature, &palette) {
                let centre = link.w_axis.truncate();
                let is_last_way = centre.distance(insertion) < hinge.dive_m();
                assert!(centre.length() > RADIUS_M || is_last_way, "{angle}");
            }
        }
    }
}

#[test]
fn it_stays_on_its_side_and_does_not_turn_back() {
    for (hinge, limit) in [(extensor(), 170.0), (quadriceps(), 170.0), (deep(), 170.0)] {
        let musculature = hinge.musculature();
        let mut length = 0.0;
        for angle in degrees(0.0, limit) {
            let path = path(&musculature, &hinge.bent(&musculature, angle));
            assert!(length_of(&path) > length, "{angle}");
            length = length_of(&path);
        }
    }
}

#[test]
fn where_nothing_is_in_the_way_it_is_the_straight_muscle() {
    let straight = Hinge {
        wraps: false,
        ..flexor()
    };
    let curved = flexor();
    let (straight, musculature) = (straight.musculature(), curved.musculature());
    for angle in degrees(0.0, 150.0) {
        let palette = curved.bent(&musculature, angle);
        let due = straight.pose(&palette, &[0.4, 0.0]).unwrap();
        let got = musculature.pose(&palette, &[0.4, 0.0]).unwrap();
        assert!(due.matrices[0].abs_diff_eq(got.matrices[0], 1e-12), "{angle}");
        assert!((due.stretch[0] - got.stretch[0]).abs() < 1e-12);
        assert!((due.volume[0] / got.volume[0] - 1.0).abs() < 1e-9);
        let ends = straight.paths(&palette).points;
        assert!((length_of(&path(&musculature, &palette)) - ends[0].distance(ends[1])).abs() < 1e-12);
        // The chain fills that ellipsoid and stays within it.
        let links = tense_chain(&musculature, &palette, 0.4);
        for (along, around) in (-9..=9).flat_map(|along| (0..8).map(move |around| (along, around))) {
            let (along, (sin, cos)) = (0.1 * f64::from(along), (PI * f64::from(around) / 4.0).sin_cos());
            let rim = (1.0 - along * along).sqrt();
            let is_held = |share: f64| {
                let place = DVec3::new(share * rim * cos, share * rim * sin, along);
                let place = due.matrices[0].transform_point3(place);
                let mut depths = links
                    .iter()
                    .map(|link| link.inverse().transform_point3(place).length());
                depths.any(|depth| depth <= 1.0)
            };
            assert!(is_held(0.88) && !is_held(1.0001), "{along}");
        }
    }
}

#[test]
fn at_rest_it_is_the_tissues_own() {
    for (hinge, _) in hinges() {
        let musculature = hinge.musculature();
        let palette = hinge.bent(&musculature, 0.0);
        let posed = musculature.pose(&palette, &[0.0; 2]).unwrap();
        let own = musculature.tissues()[0].envelope();
        let due = own.axes * DMat3::from_diagonal(own.semi_axes);
        assert!(DMat3::from_mat4(posed.matrices[0]).abs_diff_eq(due, 1e-6));
        assert!(posed.matrices[0].w_axis.truncate().abs_diff_eq(own.centre, 1e-6));
        assert!((posed.stretch[0] - 1.0).abs() < 1e-6);
        for (link, rest) in chain(&musculature, &palette).iter().zip(musculature.ellipsoids()) {
            let due = rest.axes * DMat3::from_diagonal(rest.semi_axes);
            assert!(DMat3::from_mat4(*link).abs_diff_eq(due, 1e-6));
            assert!(link.w_axis.truncate().abs_diff_eq(rest.centre, 1e-6));
        }
    }
}

#[test]
fn it_goes_through_its_via_points() {
    let hinge = guided();
    let musculature = hinge.musculature();
    for angle in degrees(-30.0, 150.0) {
        let palette = hinge.bent(&musculature, angle);
        let path = path(&musculature, &palette);
        for via_point in musculature.tissues()[0].via_points() {
            assert!(clearance(&path, via_point.posed(&palette)) < 1e-9, "{angle}");
        }
        let corners = path
            .windows(3)
            .map(|three| (three[1] - three[0]).angle_between(three[2] - three[1]));
        let long = path
            .windows(3)
            .map(|three| three[0].distance(three[1]).min(three[1].distance(three[2])));
        for (corner, long) in corners.zip(long).filter(|(_, long)| *long > 1e-4) {
            assert!(corner < 0.6, "{angle}: a corner of {corner} by {long}");
        }
    }
}

proptest! {
    #[test]
    fn a_moved_rig_moves_its_chains(turn in rotations(2.0), motion in motions()) {
        for (hinge, _) in hinges() {
            let musculature = hinge.musculature();
            let here = chain(&musculature, &hinge.turned(&musculature, turn, DAffine3::IDENTITY));
            let there = chain(&musculature, &hinge.turned(&musculature, turn, motion));
            let due: Vec<_> = here.iter().map(|link| DMat4::from(motion) * *link).collect();
            prop_assert!(change(&due, &there) < 2e-5);
        }
    }

    #[test]
    fn a_mirrored_rig_is_the_mirror_image(turn in rotations(2.0)) {
        let mirror = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
        for (hinge, _) in hinges() {
            let musculature = hinge.musculature();
            let twin = Hinge { placed: mirror, ..hinge.clone() };
            let other = twin.musculature();
            let here = path(&musculature, &hinge.turned(&musculature, turn, DAffine3::IDENTITY));
            let there = path(&other, &twin.turned(&other, turn, DAffine3::IDENTITY));
            prop_assert_eq!(here.len(), there.len());
            for (a, b) in here.iter().zip(&there) {
                prop_assert!(mirror.transform_point3(*a).distance(*b) < 1e-5);
            }
        }
    }

    #[test]
    fn a_scaled_rig_scales_its_chains(turn in rotations(1.5), scale in 0.2..5.0f64) {
        let scaling = DAffine3::from_scale(DVec3::splat(scale));
        for (hinge, _) in hinges() {
            let musculature = hinge.musculature();
            let here = chain(&musculature, &hinge.turned(&musculature, turn, DAffine3::IDENTITY));
            let there = chain(&musculature, &hinge.turned(&musculature, turn, scaling));
            let due: Vec<_> = here.iter().map(|link| DMat4::from(scaling) * *link).collect();
            prop_assert!(change(&due, &there) < 2e-5 * scale.max(1.0));
        }
    }

    #[test]
    fn any_turn_of_a_ball_joint_is_finite_clear_and_continuous(turn in rotations(1.8), nudge in rotations(1e-4)) {
        for (hinge, _) in hinges() {
            let musculature = hinge.musculature();
            let at = |turn| hinge.turned(&musculature, turn, DAffine3::IDENTITY);
            let (here, there) = (chain(&musculature, &at(turn)), chain(&musculature, &at(nudge * turn)));
            prop_assert!(here.iter().all(DMat4::is_finite));
            prop_assert!(change(&here, &there) < 2e-3, "{}", change(&here, &there));
            if hinge.via_points.is_empty() && hinge.dive_m() == 0.0 {
                let found = clearance(&path(&musculature, &at(turn)), DVec3::ZERO);
                prop_assert!(found > hinge.clear_m() - 1e-6, "{found}");
            }
        }
    }

    #[test]
    fn two_balls_on_one_span_are_both_kept_out(first in -1.5..1.5f64, second in -1.5..1.5f64) {
        let musculature = two_joints();
        let at = |first: f64, second: f64| two_joints_bent(&musculature, first, second);
        let palette = at(first, second);
        let path = path(&musculature, &palette);
        for ball in [1, 2] {
            let centre = palette.carries()[ball].transform_point3(DVec3::new(0.0, 0.0, -0.3 * (ball as f64 - 1.0)));
            prop_assert!(clearance(&path, centre) > 0.03 - 1e-6);
        }
        let moved = change(&chain(&musculature, &palette), &chain(&musculature, &at(first + 1e-4, second - 1e-4)));
        prop_assert!(moved < 2e-3, "{moved}");
    }
}

/// A muscle down the back of three bones in a line along -z, round a ball at either joint.
fn two_joints() -> Musculature {
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

fn two_joints_bent(musculature: &Musculature, first: f64, second: f64) -> Palette {
    let rest = musculature.skeleton().rest();
    let hip = DAffine3::from_quat(DQuat::from_rotation_y(first));
    let knee = hip * rotation_about(DVec3::new(0.0, 0.0, -0.3), DQuat::from_rotation_y(second));
    let pose = [rest[0], hip * rest[1], knee * rest[2]].map(columns);
    Palette::new(musculature.skeleton(), &pose).unwrap()
}

#[test]
fn what_cannot_be_gone_round_is_refused_by_name() {
    let musculature = two_joints();
    let of = |kind, wraps: &[&str], via_points: Vec<(i64, [f64; 3])>| {
        Tissue::new(TissueDescription {
            name: "odd".into(),
            kind,
            origin_bone: 0,
            insertion_bone: 0,
            centre: [0.0; 3],
            rotation: [1.0, 0.0, 0.0, 0.0],
            semi_axes: [0.1; 3],
            origin_tendon_m: 0.0,
            insertion_tendon_m: 0.0,
            volume_keeping: 1.0,
            via_points,
            wraps: wraps.iter().map(|&wrap| wrap.to_owned()).collect(),
        })
    };
    let with = |tissue: Tissue| {
        let mut tissues = musculature.tissues().to_vec();
        tissues.push(tissue);
        Musculature::new(musculature.skeleton().clone(), tissues).map(|_| ())
    };
    assert!(matches!(
        of(TissueKind::Bone, &["hip"], vec![]),
        Err(Error::RigidAndCurved { .. })
    ));
    assert!(matches!(
        of(TissueKind::Sphere, &[], vec![(0, [0.0; 3])]),
        Err(Error::RigidAndCurved { .. })
    ));
    assert!(of(TissueKind::Muscle, &[], vec![(-1, [0.0; 3])]).is_err());
    assert!(of(TissueKind::Muscle, &[], vec![(0, [f64::NAN; 3])]).is_err());
    let unknown = with(of(TissueKind::Muscle, &["ankle"], vec![]).unwrap());
    assert!(matches!(unknown, Err(Error::UnknownWrap { .. })));
    let muscle = with(of(TissueKind::Muscle, &["long"], vec![]).unwrap());
    assert!(matches!(muscle, Err(Error::WrapOfOtherKind { .. })));
    let far = with(of(TissueKind::Muscle, &[], vec![(3, [0.0; 3])]).unwrap());
    assert!(matches!(far, Err(Error::UnknownBone { .. })));
    assert!(with(of(TissueKind::Muscle, &["hip"], vec![]).unwrap()).is_ok());
}
