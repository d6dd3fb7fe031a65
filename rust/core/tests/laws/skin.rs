//! Laws of a skin without elasticity: it does not move at rest, and it moves, scales and mirrors with its
//! rig.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{Anchoring, MotionSource, SkinOptions, Skinning};

use super::fixtures::rig::{
    ALONG, AROUND, Limb, PLAIN, corrected, deformed, gap, mapped, motions, no_tension, options, tensions,
    turns, weighted,
};

const MIRROR: DAffine3 = DAffine3 {
    matrix3: DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
    translation: DVec3::ZERO,
};

fn all_options() -> impl Iterator<Item = SkinOptions<'static>> {
    let skinnings = [Skinning::Linear, Skinning::PreserveVolume, Skinning::None];
    skinnings.into_iter().flat_map(|skinning| {
        [MotionSource::Swelling, MotionSource::Full]
            .into_iter()
            .flat_map(move |motion_source| {
                [Anchoring::Blended, Anchoring::Nearest]
                    .into_iter()
                    .flat_map(move |anchoring| {
                        [false, true].map(|scales_fat| SkinOptions {
                            skinning,
                            motion_source,
                            anchoring,
                            scales_fat,
                            ..SkinOptions::default()
                        })
                    })
            })
    })
}

#[test]
fn at_rest_nothing_moves_with_any_options() {
    let leaning =
        DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.7), DVec3::new(0.3, -1.0, 1.2));
    for limb in [
        PLAIN,
        Limb { placed: leaning },
        Limb {
            placed: leaning * MIRROR,
        },
    ] {
        for options in all_options() {
            let skin = limb.skin(&options);
            assert!(skin.anchored() > 100);
            assert!(gap(&deformed(&skin, &limb.rest_pose(), &no_tension()), &limb.points()) <= 1e-6);
            let (offsets, damped) = corrected(&skin, &limb.rest_pose(), &no_tension());
            assert!(gap(&offsets, &vec![[0.0; 3]; skin.len()]) <= 1e-6);
            assert_eq!(damped, 0);
        }
    }
}

#[test]
fn a_tense_muscle_lifts_its_skin_only() {
    for options in all_options() {
        let skin = PLAIN.skin(&options);
        let mut tension = no_tension();
        tension[0] = 1.0;
        let (offsets, _) = corrected(&skin, &PLAIN.rest_pose(), &tension);
        let weights = skin.tissue_weights();
        let tissues = skin.musculature().len();
        for (vertex, offset) in offsets.iter().enumerate() {
            // under the default options a muscle also lifts what is above its neighbours
            let height_m = f64::from(PLAIN.points()[vertex][2]);
            let is_far = !(-0.1..0.4).contains(&height_m);
            let is_by_weight = options.anchoring == Anchoring::Nearest
                || options.motion_source == MotionSource::Full
                || options.scales_fat;
            if weights[vertex * tissues] == 0.0 && (is_by_weight || is_far) {
                assert!(
                    gap(&[*offset], &[[0.0; 3]]) < 1e-7,
                    "vertex {vertex} moved without weight"
                );
            }
        }
        assert!(gap(&offsets, &vec![[0.0; 3]; skin.len()]) > 5e-4, "{options:?}");
    }
}

#[test]
fn rigid_tissues_do_not_swell() {
    let skin = PLAIN.skin(&SkinOptions {
        anchoring: Anchoring::Nearest,
        ..SkinOptions::default()
    });
    let tissues = skin.musculature().len();
    let weights = skin.tissue_weights();
    let turned = PLAIN.pose(
        &[
            DQuat::from_rotation_x(0.2),
            DQuat::from_rotation_x(0.9),
            DQuat::IDENTITY,
        ],
        MIRROR * MIRROR,
    );
    let (offsets, _) = corrected(&skin, &turned, &no_tension());
    let mut seen = 0;
    for (vertex, offset) in offsets.iter().enumerate() {
        if weights[vertex * tissues + 4..(vertex + 1) * tissues]
            .iter()
            .any(|&weight| weight > 0.0)
        {
            assert_eq!(*offset, [0.0; 3]);
            seen += 1;
        }
    }
    assert!(seen > 0);
}

#[test]
fn skin_without_weights_follows_tissues_at_any_distance() {
    let options = SkinOptions {
        motion_source: MotionSource::Full,
        ..SkinOptions::default()
    };
    let mut points = PLAIN.points();
    let last = AROUND * ALONG - 1;
    points[last] = [5.0, 5.0, 5.0];
    let skin = PLAIN.skin_of(&points, &DAffine3::IDENTITY, &options);
    let row = &skin.tissue_weights()[last * skin.musculature().len()..];
    assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5);
    let bare = PLAIN.skin_of(&points, &DAffine3::IDENTITY, &SkinOptions::default());
    let row = &bare.tissue_weights()[(last - 1) * bare.musculature().len()..];
    assert!(row.iter().sum::<f32>() < 1.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_moved_rig_moves_its_skin_and_keeps_its_correction(
        options in options(), turns in turns(1.2), tension in tensions(), motion in motions(),
    ) {
        let skin = PLAIN.skin(&options);
        let (here, there) = (PLAIN.pose(&turns, DAffine3::IDENTITY), PLAIN.pose(&turns, motion));
        let expected = mapped(&deformed(&skin, &here, &tension), motion);
        prop_assert!(gap(weighted(&expected), weighted(&deformed(&skin, &there, &tension))) < 1e-5);
        let (a, damped_a) = corrected(&skin, &here, &tension);
        let (b, damped_b) = corrected(&skin, &there, &tension);
        prop_assume!(damped_a == 0 && damped_b == 0);
        prop_assert!(gap(weighted(&a), weighted(&b)) < 2e-5);
    }

    #[test]
    fn a_scaled_rig_scales_its_skin(
        options in options(), turns in turns(1.2), tension in tensions(), scale in 0.3..4.0f64,
    ) {
        let scaling = DAffine3::from_scale(DVec3::splat(scale));
        let skin = PLAIN.skin(&options);
        let (here, there) = (PLAIN.pose(&turns, DAffine3::IDENTITY), PLAIN.pose(&turns, scaling));
        let expected = mapped(&deformed(&skin, &here, &tension), scaling);
        prop_assert!(gap(weighted(&expected), weighted(&deformed(&skin, &there, &tension))) < 1e-5 * scale.max(1.0));
    }

    #[test]
    fn a_mirrored_character_is_the_mirror_image(options in options(), turns in turns(1.2), tension in tensions()) {
        let mirrored = Limb { placed: MIRROR };
        let here = deformed(&PLAIN.skin(&options), &PLAIN.pose(&turns, DAffine3::IDENTITY), &tension);
        let there = deformed(&mirrored.skin(&options), &mirrored.pose(&turns, DAffine3::IDENTITY), &tension);
        prop_assert!(gap(&mapped(&here, MIRROR), &there) < 5e-6);
    }

    #[test]
    fn a_rig_of_negative_scale_mirrors_its_skin(turns in turns(1.2), tension in tensions(), full in any::<bool>()) {
        let motion_source = if full { MotionSource::Full } else { MotionSource::Swelling };
        let skin = PLAIN.skin(&SkinOptions { motion_source, ..SkinOptions::default() });
        let here = deformed(&skin, &PLAIN.pose(&turns, DAffine3::IDENTITY), &tension);
        let there = deformed(&skin, &PLAIN.pose(&turns, MIRROR), &tension);
        prop_assert!(gap(weighted(&mapped(&here, MIRROR)), weighted(&there)) < 5e-6);
    }

    #[test]
    fn mesh_space_does_not_change_the_skin(
        options in options(), turns in turns(1.0), motion in motions(),
        scale in prop::array::uniform3(0.4..2.0f64), flips in any::<bool>(),
    ) {
        let scale = DVec3::from_array(scale) * if flips { -1.0 } else { 1.0 };
        let to_armature = motion * DAffine3::from_scale(scale);
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let points = mapped(&PLAIN.points(), to_armature.inverse());
        let skin = PLAIN.skin_of(&points, &to_armature, &options);
        let expected = deformed(&PLAIN.skin(&options), &pose, &no_tension());
        let got = mapped(&deformed(&skin, &pose, &no_tension()), to_armature);
        prop_assert!(gap(&expected, &got) < 3e-5);
    }

    #[test]
    fn small_changes_of_pose_change_the_skin_little(options in options(), turns in turns(2.2), tension in tensions()) {
        let skin = PLAIN.skin(&options);
        let mut nudged = turns;
        nudged[1] *= DQuat::from_rotation_x(1e-4);
        let here = deformed(&skin, &PLAIN.pose(&turns, DAffine3::IDENTITY), &tension);
        let there = deformed(&skin, &PLAIN.pose(&nudged, DAffine3::IDENTITY), &tension);
        prop_assume!(options.skinning == Skinning::Linear);
        prop_assert!(gap(&here, &there) < 3e-3);
    }
}

#[test]
fn swelling_moves_skin_across_a_belly_only() {
    const ALONG_Z: usize = 2; // the muscle whose belly is along z
    let skin = PLAIN.skin(&SkinOptions::default());
    let mut tension = no_tension();
    tension[ALONG_Z] = 1.0;
    let (offsets, _) = corrected(&skin, &PLAIN.rest_pose(), &tension);
    assert!(offsets.iter().all(|offset| offset[2].abs() < 1e-7));
    assert!(offsets.iter().any(|offset| offset[0].hypot(offset[1]) > 5e-4));
}
