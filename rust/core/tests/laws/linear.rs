//! Linear blend skinning: corrected vertices are at their target, and fitted weights are valid and come at
//! least as near.

use glam::{DAffine3, DQuat};
use proptest::prelude::*;
use sinew_core::{ColumnMajor, LinearSkin, RestMesh, SkinOptions};

use super::fixtures::rig::{BONES, PLAIN, columns, deformed, gap, no_tension, tensions, turns, weights};

fn skin_of(offsets: &[i32], bones: &[i32], weights: &[f32]) -> LinearSkin {
    let mesh = RestMesh {
        points: &PLAIN.points(),
        edges: &[],
        mesh_to_armature: &columns(DAffine3::IDENTITY),
        weight_offsets: offsets,
        weight_bones: bones,
        weights,
    };
    LinearSkin::new(PLAIN.skeleton(), &mesh).unwrap()
}

fn limb_skin() -> LinearSkin {
    let (offsets, bones, weights) = weights();
    skin_of(&offsets, &bones, &weights)
}

/// The skin in a pose without offsets.
fn posed(skin: &LinearSkin, pose: &[ColumnMajor]) -> Vec<[f32; 3]> {
    let (nothing, mut out) = (vec![[0.0; 3]; skin.len()], vec![[0.0; 3]; skin.len()]);
    skin.deform(pose, &nothing, &mut out).unwrap();
    out
}

fn squares(a: &[[f32; 3]], b: &[[f32; 3]], vertex: usize) -> f64 {
    (0..3)
        .map(|axis| f64::from(a[vertex][axis] - b[vertex][axis]).powi(2))
        .sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_correction_moves_the_skin_to_the_target(turns in turns(1.2), tension in tensions()) {
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let skin = limb_skin();
        let target = deformed(&PLAIN.skin(&SkinOptions::default()), &pose, &tension);
        let (mut added, mut got) = (target.clone(), target.clone());
        prop_assume!(skin.correct(&pose, &target, &mut added).unwrap() == 0);
        skin.deform(&pose, &added, &mut got).unwrap();
        prop_assert!(gap(&got, &target) < 1e-6);
    }

    #[test]
    fn fitted_weights_are_valid_and_at_least_as_near(
        first in turns(1.2), second in turns(1.2), most in 1..=BONES,
    ) {
        let poses = [first, second].map(|turns| PLAIN.pose(&turns, DAffine3::IDENTITY));
        let live = PLAIN.skin(&SkinOptions::default());
        let targets = poses.clone().map(|pose| deformed(&live, &pose, &no_tension()));
        let start = limb_skin();
        let fitted = start.fitted(&poses.concat(), &targets.concat(), most, 0.0).unwrap();
        let skin = skin_of(&fitted.offsets, &fitted.bones, &fitted.weights);
        for vertex in 0..skin.len() {
            let row = fitted.offsets[vertex] as usize..fitted.offsets[vertex + 1] as usize;
            let sum: f32 = fitted.weights[row.clone()].iter().sum();
            prop_assert!(row.len() <= most && (row.is_empty() || (sum - 1.0).abs() < 1e-5));
            prop_assert!(fitted.weights[row].iter().all(|&weight| weight > 0.0));
            let error = |skin: &LinearSkin| -> f64 {
                poses.iter().zip(&targets).map(|(pose, target)| squares(&posed(skin, pose), target, vertex)).sum()
            };
            // a few vertices are enough, since the sum over all needs a skin for each
            if most == BONES && vertex % 97 == 0 {
                // within the rounding of positions in f32
                prop_assert!(error(&skin).sqrt() <= error(&start).sqrt() + 1e-6);
            }
        }
    }

    #[test]
    fn weights_that_made_a_skin_are_found_again(first in turns(1.2), second in turns(1.2), third in turns(1.2)) {
        let poses = [first, second, third].map(|turns| PLAIN.pose(&turns, DAffine3::IDENTITY));
        let (offsets, bones, weights) = weights();
        let targets = poses.clone().map(|pose| posed(&limb_skin(), &pose));
        let even = vec![1.0; weights.len()];
        let start = skin_of(&offsets, &bones, &even);
        let fitted = start.fitted(&poses.concat(), &targets.concat(), BONES, 0.0).unwrap();
        let skin = skin_of(&fitted.offsets, &fitted.bones, &fitted.weights);
        for (pose, target) in poses.iter().zip(&targets) {
            prop_assert!(gap(&posed(&skin, pose), target) < 1e-4);
        }
    }
}

#[test]
fn without_poses_the_strongest_weights_stay_in_their_proportion() {
    let bones = [0, 1, 2].repeat(PLAIN.points().len());
    let weights = [0.2, 0.5, 0.3].repeat(PLAIN.points().len());
    let offsets: Vec<i32> = (0..=PLAIN.points().len() as i32).map(|row| 3 * row).collect();
    let limited = skin_of(&offsets, &bones, &weights)
        .fitted(&[], &[], 2, 0.01)
        .unwrap();
    assert_eq!((limited.bones[0], limited.bones[1]), (1, 2));
    assert!((limited.weights[0] - 0.625).abs() < 1e-6 && (limited.weights[1] - 0.375).abs() < 1e-6);
}

#[test]
fn a_held_weight_changes_only_for_a_gain() {
    let pose = PLAIN.pose(
        &[DQuat::from_rotation_x(0.02), DQuat::IDENTITY, DQuat::IDENTITY],
        DAffine3::IDENTITY,
    );
    let skin = limb_skin();
    let away: Vec<[f32; 3]> = posed(&skin, &pose)
        .iter()
        .map(|&[x, y, z]| [x + 1e-4, y, z])
        .collect();
    let fitted = skin.fitted(&pose, &away, BONES, 1.0).unwrap();
    let held = skin_of(&fitted.offsets, &fitted.bones, &fitted.weights);
    assert!(gap(&posed(&held, &pose), &posed(&skin, &pose)) < 1e-6);
}
