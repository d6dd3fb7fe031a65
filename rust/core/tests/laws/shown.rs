//! An object with its own transform and a delta transform shows its posed tissue.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{AngleOrder, Delta, ShownTissue, Transform};

use crate::fixtures::rig::columns;

const ORDERS: [(AngleOrder, [usize; 3]); 6] = [
    (AngleOrder::Xyz, [0, 1, 2]),
    (AngleOrder::Xzy, [0, 2, 1]),
    (AngleOrder::Yxz, [1, 0, 2]),
    (AngleOrder::Yzx, [1, 2, 0]),
    (AngleOrder::Zxy, [2, 0, 1]),
    (AngleOrder::Zyx, [2, 1, 0]),
];

fn vectors(reach: f64) -> impl Strategy<Value = DVec3> {
    [-reach..reach, -reach..reach, -reach..reach].prop_map(DVec3::from)
}

fn rotations() -> impl Strategy<Value = DQuat> {
    (vectors(1.0), -3.1..3.1)
        .prop_map(|(axis, angle)| DQuat::from_axis_angle(axis.try_normalize().unwrap_or(DVec3::X), angle))
}

fn transforms() -> impl Strategy<Value = Transform> {
    (vectors(0.5), rotations(), [0.2..3.0, 0.2..3.0, 0.2..3.0]).prop_map(|(location, rotation, scale)| {
        Transform {
            location,
            rotation,
            scale: scale.into(),
        }
    })
}

fn map_of(transform: &Transform) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(transform.scale, transform.rotation, transform.location)
}

fn unscaled(transform: &Transform) -> DAffine3 {
    DAffine3::from_rotation_translation(transform.rotation, transform.location)
}

/// The transform of an object with a delta (Blender's BKE_object_to_mat4).
fn with(own: &Transform, delta: &Delta) -> DAffine3 {
    let turned = Transform {
        location: own.location + delta.location,
        rotation: delta.rotation * own.rotation,
        scale: own.scale * delta.scale,
    };
    map_of(&turned)
}

fn far_apart(a: DAffine3, b: DAffine3) -> f64 {
    let distance = |a: DVec3, b: DVec3| (a - b).abs().max_element();
    let columns = [
        distance(a.matrix3.x_axis, b.matrix3.x_axis),
        distance(a.matrix3.y_axis, b.matrix3.y_axis),
        distance(a.matrix3.z_axis, b.matrix3.z_axis),
        distance(a.translation, b.translation),
    ];
    columns.into_iter().fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn a_delta_shows_the_posed_tissue(
        own in transforms(), parent in transforms(), bone in transforms(), posed in transforms(), order in 0..6_usize,
    ) {
        // a non-uniform scale of the bone would shear the tissue, which an object cannot show
        let (parent, bone) = (unscaled(&parent), unscaled(&bone));
        let shown = ShownTissue::new(0, &columns(parent), own, ORDERS[order].0, "Biceps").unwrap();
        let delta = shown.delta(&columns(bone), &columns(map_of(&posed)));
        prop_assert!(far_apart(bone * parent * with(&own, &delta), map_of(&posed)) < 1e-5);
    }

    #[test]
    fn angles_turn_as_the_rotation_does(rotation in rotations(), order in 0..6_usize) {
        let (order, axes) = ORDERS[order];
        let angles = order.angles(rotation);
        let turn = axes.iter().fold(DQuat::IDENTITY, |turn, &axis| {
            DQuat::from_axis_angle(DVec3::AXES[axis], angles[axis]) * turn
        });
        let (a, b) = (DMat3::from_quat(turn), DMat3::from_quat(rotation));
        prop_assert!(far_apart(DAffine3::from_mat3(a), DAffine3::from_mat3(b)) < 1e-7);
    }

    #[test]
    fn a_mirrored_parent_is_compensated(own in transforms(), posed in transforms()) {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let shown = ShownTissue::new(0, &columns(mirror), own, AngleOrder::Xyz, "Biceps").unwrap();
        let delta = shown.delta(&columns(DAffine3::IDENTITY), &columns(map_of(&posed)));
        prop_assert!(far_apart(mirror * with(&own, &delta), map_of(&posed)) < 1e-5);
    }

    #[test]
    fn on_a_bone_without_size_it_does_not_change(own in transforms(), posed in transforms()) {
        let shown = ShownTissue::new(0, &columns(DAffine3::IDENTITY), own, AngleOrder::Zxy, "Biceps").unwrap();
        let flat = columns(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)));
        let delta = shown.delta(&flat, &columns(map_of(&posed)));
        prop_assert!(far_apart(with(&own, &delta), map_of(&own)) == 0.0);
    }
}

#[test]
fn a_parent_without_size_is_refused_by_name() {
    let own = Transform {
        location: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        scale: DVec3::ONE,
    };
    let flat = columns(DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0)));
    let error = ShownTissue::new(0, &flat, own, AngleOrder::Xyz, "Biceps").unwrap_err();
    assert!(error.to_string().contains("Biceps"), "{error}");
}
