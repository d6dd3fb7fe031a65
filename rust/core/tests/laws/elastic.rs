//! Laws of the elastic skin: it does not move at rest, it moves and mirrors with its rig, and its bits do
//! not depend on the number of threads.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use sinew_core::SkinOptions;

use super::fixtures::rig::{
    LENGTH_M, Limb, PLAIN, corrected, deformed, gap, mapped, motions, no_tension, options, tensions, turns,
    weighted,
};

const MIRROR: DAffine3 = DAffine3 {
    matrix3: DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
    translation: DVec3::ZERO,
};

#[test]
fn at_rest_nothing_moves() {
    let skin = PLAIN.elastic_skin(&SkinOptions::default());
    let (offsets, damped) = corrected(&skin, &PLAIN.rest_pose(), &no_tension());
    assert!(gap(&offsets, &vec![[0.0; 3]; skin.len()]) <= 1e-6);
    assert_eq!(damped, 0);
}

#[test]
fn a_joint_in_its_rest_pose_changes_nothing() {
    let (elastic, stiff) = (
        PLAIN.elastic_skin(&SkinOptions::default()),
        PLAIN.skin(&SkinOptions::default()),
    );
    let whole = DAffine3::from_rotation_x(1.0);
    let pose = PLAIN.pose(&[DQuat::IDENTITY; 3], whole);
    let tension = [1.0, 0.5, 0.0, 0.0, 0.0, 0.0];
    assert!(
        gap(
            &deformed(&elastic, &pose, &tension),
            &deformed(&stiff, &pose, &tension)
        ) <= 1e-6
    );
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let frame = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let pose = PLAIN.pose(&[0.1, 1.4, -0.8].map(DQuat::from_rotation_x), DAffine3::IDENTITY);
        pool.install(|| deformed(&PLAIN.elastic_skin(&SkinOptions::default()), &pose, &no_tension()))
    };
    assert_eq!(frame(1), frame(2));
    assert_eq!(frame(1), frame(8));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn it_moves_with_the_whole_rig(turns in turns(1.5), motion in motions(), tension in tensions(), options in options()) {
        let skin = PLAIN.elastic_skin(&options);
        let still = deformed(&skin, &PLAIN.pose(&turns, DAffine3::IDENTITY), &tension);
        let moved = deformed(&skin, &PLAIN.pose(&turns, motion), &tension);
        let (still, moved) = (mapped(weighted(&still), motion), weighted(&moved));
        prop_assert!(gap(&still, moved) < 1e-5 * LENGTH_M);
    }

    #[test]
    fn a_mirrored_limb_moves_as_its_mirror_image(turns in turns(1.5), tension in tensions()) {
        let mirrored = Limb { placed: MIRROR };
        let (plain_skin, other_skin) = (
            PLAIN.elastic_skin(&SkinOptions::default()),
            mirrored.elastic_skin(&SkinOptions::default()),
        );
        let plain = deformed(&plain_skin, &PLAIN.pose(&turns, DAffine3::IDENTITY), &tension);
        let other = deformed(&other_skin, &mirrored.pose(&turns, DAffine3::IDENTITY), &tension);
        prop_assert!(gap(&mapped(&plain, MIRROR), &other) < 1e-5 * LENGTH_M);
    }

    #[test]
    fn it_stays_finite_and_near_its_anchors(turns in turns(3.1), tension in tensions()) {
        let (elastic, stiff) = (
            PLAIN.elastic_skin(&SkinOptions::default()),
            PLAIN.skin(&SkinOptions::default()),
        );
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        // Folded onto itself, the skin overshoots by about the length of a segment (0.3 m) after 8
        // iterations. More iterations converge to half of that.
        prop_assert!(gap(&deformed(&elastic, &pose, &tension), &deformed(&stiff, &pose, &tension)) < 0.45);
    }
}
