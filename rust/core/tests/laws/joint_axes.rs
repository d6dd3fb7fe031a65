//! Joints bend about the axis of their muscles' moments, in any position of the rig.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use sinew_core::{Musculature, Skeleton, Tissue, TissueDescription, TissueKind};

use super::fixtures::rig::{Limb, PLAIN, columns, motions};

/// Two bones along z with muscles beside their joint, each at an angle around it. The lower bone is bent at
/// rest.
fn hinge(around: &[f64], bent: f64) -> Musculature {
    let lower = DAffine3::from_translation(0.3 * DVec3::Z) * DAffine3::from_rotation_x(bent);
    // bones point along their y axis
    let along_y = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y));
    let rest = [along_y, lower * along_y].map(columns);
    let skeleton = Skeleton::new(["upper", "lower"].map(str::to_owned).to_vec(), &[-1, 0], &rest).unwrap();
    let muscle = |(index, &angle): (usize, &f64)| {
        Tissue::new(TissueDescription {
            name: index.to_string(),
            kind: TissueKind::Muscle,
            origin_bone: 0,
            insertion_bone: 1,
            centre: [0.04 * angle.cos(), 0.04 * angle.sin(), 0.3],
            rotation: [1.0, 0.0, 0.0, 0.0],
            semi_axes: [0.01, 0.01, 0.08],
            origin_tendon_m: 0.01,
            insertion_tendon_m: 0.01,
            volume_keeping: 1.0,
            via_points: vec![],
            wraps: vec![],
        })
        .unwrap()
    };
    Musculature::new(skeleton, around.iter().enumerate().map(muscle).collect()).unwrap()
}

#[test]
fn flexors_and_extensors_share_the_axis_of_their_hinge() {
    let [joint] = hinge(&[1.6, 1.5, -1.5, -1.6], 0.4).joints()[..] else {
        panic!("one joint is crossed")
    };
    assert_eq!((joint.child, joint.parent), (1, 0));
    // muscles in front and behind, along y, rotate it about x; the rest pose is bent about +x
    assert!(joint.axis.distance(DVec3::X) < 1e-6 && joint.bends_one_way);
    let other_way = hinge(&[1.6, 1.5, -1.5, -1.6], -0.4).joints()[0];
    assert!(other_way.axis.distance(-DVec3::X) < 1e-6 && other_way.bends_one_way);
}

#[test]
fn a_straight_hinge_and_a_ball_joint_bend_both_ways() {
    assert!(!hinge(&[1.6, 1.5, -1.5, -1.6], 0.0).joints()[0].bends_one_way);
    assert!(!hinge(&[0.0, FRAC_PI_2, PI, -FRAC_PI_2], 0.4).joints()[0].bends_one_way);
}

#[test]
fn only_joints_that_muscles_cross_are_found() {
    let joints = PLAIN.musculature().joints();
    assert_eq!(joints.iter().map(|joint| joint.child).collect::<Vec<_>>(), [1, 2]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn axes_move_with_the_rig(placed in motions()) {
        let (plain, moved): (_, Arc<Musculature>) = (PLAIN.musculature(), Limb { placed }.musculature());
        for (a, b) in plain.joints().iter().zip(moved.joints()) {
            let due = placed.transform_vector3(a.axis);
            // a line has two directions
            prop_assert!(due.dot(b.axis).abs() > 1.0 - 1e-5, "{:?} {:?}", due, b.axis);
            prop_assert_eq!((a.child, a.bends_one_way), (b.child, b.bends_one_way));
        }
    }
}
