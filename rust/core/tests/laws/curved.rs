//! A muscle that wraps around a joint or passes through via points keeps its volume, never jumps, never
//! enters the joint, and is straight where nothing is in its way.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{Error, Musculature, Tissue, TissueDescription, TissueKind};

use super::fixtures::curved_rig::{
    Hinge, RADIUS_M, STEP_DEGREES, chain, change, clearance, deep, degrees, extensor, flexor, guided, hinges,
    length_of, path, quadriceps, tense_chain, two_joints, two_joints_bent, volume,
};
use super::fixtures::rig::{motions, rotations};

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
        // A point at the largest distance moves this far in a step; no point of the muscle may move much
        // farther.
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
fn a_twist_pops_nothing() {
    // Beyond half a rotation the x axes are inverted. The ellipsoids are the same, so their shapes are
    // compared.
    let shape = |link: &DMat4| {
        let axes = DMat3::from_mat4(*link);
        let squared = axes * axes.transpose();
        (squared * squared.determinant().powf(-1.0 / 6.0), link.w_axis)
    };
    for (hinge, _) in hinges() {
        let musculature = hinge.musculature();
        let twisted = |angle: f64| {
            let turn = DQuat::from_rotation_y(-0.5) * DQuat::from_rotation_z(angle.to_radians());
            chain(
                &musculature,
                &hinge.turned(&musculature, turn, DAffine3::IDENTITY),
            )
        };
        for angle in degrees(-170.0, 170.0) {
            let links = twisted(angle);
            for (before, after) in links.iter().zip(twisted(angle + STEP_DEGREES)) {
                let ((shape_before, place_before), (shape_after, place_after)) =
                    (shape(before), shape(&after));
                let moved = place_before.distance(place_after);
                assert!(moved < 0.005, "{angle}: moved by {moved}");
                let changed = shape_after - shape_before;
                let changed = changed
                    .to_cols_array()
                    .into_iter()
                    .fold(0.0, |worst: f64, by| worst.max(by.abs()));
                assert!(changed < 0.005, "{angle}: changed by {changed}");
            }
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
fn without_an_obstacle_it_is_the_straight_muscle() {
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
        let ends = straight.paths(&palette).points().to_vec();
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
            let centre = palette.skinning_matrices()[ball].transform_point3(DVec3::new(0.0, 0.0, -0.3 * (ball as f64 - 1.0)));
            prop_assert!(clearance(&path, centre) > 0.03 - 1e-6);
        }
        let moved = change(&chain(&musculature, &palette), &chain(&musculature, &at(first + 1e-4, second - 1e-4)));
        prop_assert!(moved < 2e-3, "{moved}");
    }
}

#[test]
fn invalid_wraps_are_refused_by_name() {
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
