//! Laws of the correction: the modifier moves a corrected rest position onto the deformed skin; where it
//! cannot, the correction is bounded.

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{MotionSource, Regional, SkinOptions, Skinning};

use super::rig::{PLAIN, columns, corrected, deformed, gap, no_tension, options, tensions, turns};

/// The result of the modifier alone: a skin that no tissue moves.
fn modified(points: &[[f32; 3]], skinning: Skinning, pose: &[sinew_core::ColumnMajor]) -> Vec<[f32; 3]> {
    let still = SkinOptions {
        skinning,
        muscle_influence: Regional::of_body(0.0),
        ..SkinOptions::default()
    };
    deformed(
        &PLAIN.skin_of(points, &DAffine3::IDENTITY, &still),
        pose,
        &no_tension(),
    )
}

fn shifted(offsets: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let add = |(point, offset): ([f32; 3], &[f32; 3])| std::array::from_fn(|axis| point[axis] + offset[axis]);
    PLAIN.points().into_iter().zip(offsets).map(add).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn the_modifier_moves_the_corrected_point_onto_the_skin(
        options in options(), turns in turns(1.0), tension in tensions(),
        stretch in prop::array::uniform3(0.6..1.6f64),
    ) {
        let mut pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let posed = DAffine3::from_mat4(glam::Mat4::from_cols_array(&pose[2]).as_dmat4());
        pose[2] = columns(posed * DAffine3::from_scale(DVec3::from_array(stretch)));
        let skin = PLAIN.skin(&options);
        let (offsets, damped) = corrected(&skin, &pose, &tension);
        prop_assume!(damped == 0);
        let got = modified(&shifted(&offsets), options.skinning, &pose);
        prop_assert!(gap(&got, &deformed(&skin, &pose, &tension)) < 1e-5);
    }

    #[test]
    fn any_pose_gives_a_bounded_correction(
        options in options(), turns in turns(3.1), tension in tensions(),
        scales in prop::array::uniform3(prop::array::uniform3(-1.0..2.0f64)), flat in 0..4usize,
    ) {
        let mut pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        for (matrix, scale) in pose.iter_mut().zip(scales) {
            let mut scale = DVec3::from_array(scale);
            if flat < 3 {
                scale[flat] = 0.0;
            }
            let posed = DAffine3::from_mat4(glam::Mat4::from_cols_array(matrix).as_dmat4());
            *matrix = columns(posed * DAffine3::from_scale(scale));
        }
        let skin = PLAIN.skin(&options);
        let (offsets, _) = corrected(&skin, &pose, &tension);
        prop_assert!(gap(&offsets, &vec![[0.0; 3]; skin.len()]) < 1e4);
        prop_assert!(deformed(&skin, &pose, &tension).iter().flatten().all(|number| number.is_finite()));
    }
}

#[test]
fn a_twist_through_180_degrees_is_damped_bounded_and_continuous() {
    let skin = PLAIN.skin(&SkinOptions::default());
    let tension = vec![0.5; no_tension().len()];
    let mut before: Option<Vec<[f32; 3]>> = None;
    let mut damped_most = 0;
    for step in 0..=8000 {
        let twist = DQuat::from_rotation_z((140.0 + f64::from(step) * 0.01).to_radians());
        let pose = PLAIN.pose(&[DQuat::IDENTITY, twist, DQuat::IDENTITY], DAffine3::IDENTITY);
        let (offsets, damped) = corrected(&skin, &pose, &tension);
        damped_most = damped_most.max(damped);
        assert!(gap(&offsets, &vec![[0.0; 3]; skin.len()]) < 0.2);
        if let Some(before) = before {
            assert!(
                gap(&before, &offsets) < 2e-3,
                "a jump at step {step}: {}",
                gap(&before, &offsets)
            );
        }
        before = Some(offsets);
    }
    assert!(damped_most > 0);
}

#[test]
fn a_bone_scaled_to_nothing_is_damped_and_finite() {
    for motion_source in [MotionSource::Swelling, MotionSource::Full] {
        for skinning in [Skinning::Linear, Skinning::PreserveVolume] {
            let skin = PLAIN.skin(&SkinOptions {
                motion_source,
                skinning,
                ..SkinOptions::default()
            });
            for scale in [0.0, 1e-20, 1e-6, 1e-3] {
                let scaling = DAffine3::from_scale(DVec3::splat(scale));
                let pose: Vec<_> = PLAIN
                    .rest()
                    .into_iter()
                    .map(|rest| columns(rest * scaling))
                    .collect();
                let (offsets, damped) = corrected(&skin, &pose, &no_tension());
                assert!(damped > 0);
                assert!(gap(&offsets, &vec![[0.0; 3]; skin.len()]) < 100.0);
                assert!(
                    deformed(&skin, &pose, &no_tension())
                        .iter()
                        .flatten()
                        .all(|number| number.is_finite())
                );
            }
        }
    }
}
