//! Reaching: goals in and out of reach, limits, closed-form solutions, the same bits.

use glam::DVec3;
use proptest::prelude::*;
use sinew_core::reach::{Goal, Linkage, Parameterisation, Program, ReachOptions, Target, reach};

use super::fixtures::reach_rig::{
    NO_LIMITS, all_goals, chains, end_at, end_of, joint, plain, position, reached, samples,
};

/// The settings with which the add-on solves a single pose, as opposed to a step of a drag.
const THOROUGH: ReachOptions = ReachOptions {
    preference: 1e-3,
    restarts: 16,
};

/// Largest amount by which angles exceed their limits.
fn broken(linkage: &Linkage, angles: &[DVec3]) -> f64 {
    let over = |(joint, angles): (usize, &DVec3)| {
        let [lower, upper] = linkage.limits(joint);
        (lower - *angles).max(*angles - upper).max_element()
    };
    angles
        .iter()
        .enumerate()
        .map(over)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Of random goals that are within reach and limits, the fraction missed by more than 0.1 mm.
fn share_missed(count: usize) -> f64 {
    let mut missed = 0;
    for (joints, pose) in samples(chains(2..21), count) {
        let linkage = Linkage::new(joints).unwrap();
        let last = linkage.len() - 1;
        let goals = [position(last, end_of(linkage.len()), end_at(&linkage, &pose))];
        let found = reach(&Program::new(&linkage, &goals).unwrap(), None, &THOROUGH).unwrap();
        assert!(broken(&linkage, &found.angles) <= 1e-9);
        missed += usize::from(end_at(&linkage, &found.angles).distance(end_at(&linkage, &pose)) > 1e-4);
    }
    missed as f64 / count as f64
}

#[test]
fn goals_within_reach_are_reached() {
    assert!(share_missed(300) <= 0.001);
}

#[test]
#[ignore = "slow: the whole proof, 10,000 goals"]
fn ten_thousand_goals_within_reach_are_reached() {
    let share = share_missed(10_000);
    assert!(share <= 0.001, "{share} missed");
}

/// For goals that may be out of reach: the residual, and the smallest residual of 200 descents from random
/// poses.
fn against_restarts(count: usize) {
    let places = (chains(2..13), [-1.5..1.5_f64, -1.5..1.5, -1.5..1.5], any::<u64>());
    for ((joints, _), target, _) in samples(places, count) {
        let linkage = Linkage::new(joints.clone()).unwrap();
        let goals = [position(linkage.len() - 1, end_of(linkage.len()), target.into())];
        let miss = reach(&Program::new(&linkage, &goals).unwrap(), None, &THOROUGH)
            .unwrap()
            .residuals[0];
        let shares = prop::collection::vec([0.0..1.0_f64, 0.0..1.0, 0.0..1.0], joints.len());
        let best = samples(shares, 200).map(|shares| {
            let mut joints = joints.clone();
            for (joint, shares) in joints.iter_mut().zip(shares) {
                joint.angles = joint.lower + (joint.upper - joint.lower) * DVec3::from_array(shares);
            }
            let linkage = Linkage::new(joints).unwrap();
            let program = Program::new(&linkage, &goals).unwrap();
            reach(&program, None, &ReachOptions::default()).unwrap().residuals[0]
        });
        let best = best.fold(f64::INFINITY, f64::min);
        assert!(miss <= 1.01 * best + 1e-4, "{miss} m, of restarts {best} m");
    }
}

#[test]
fn goals_out_of_reach_are_missed_by_as_little_as_can_be() {
    against_restarts(6);
}

#[test]
#[ignore = "slow: 200 restarts for each of 150 goals"]
fn many_goals_out_of_reach_are_missed_by_as_little_as_can_be() {
    against_restarts(150);
}

proptest! {
    #[test]
    fn limits_hold_for_all_goals(
        (joints, _) in chains(1..8), targets in prop::collection::vec(prop::array::uniform6(-9.0..9.0_f64), 1..3)
    ) {
        let linkage = Linkage::new(joints).unwrap();
        let goals: Vec<_> = targets.into_iter().flat_map(|numbers| all_goals(linkage.len(), numbers)).collect();
        let found = reach(&Program::new(&linkage, &goals).unwrap(), None, &ReachOptions::default()).unwrap();
        prop_assert!(broken(&linkage, &found.angles) <= 0.0);
        let locked = linkage.start();
        for (joint, (angles, start)) in found.angles.iter().zip(&locked).enumerate() {
            for axis in (0..3).filter(|&axis| !linkage.free_angles().contains(&(joint, axis))) {
                prop_assert_eq!(angles[axis], start[axis]);
            }
        }
    }

    #[test]
    fn two_bones_bend_as_the_law_of_cosines_says(
        lengths in (0.2..0.6_f64, 0.2..0.6_f64), share in 0.02..0.98_f64, way in [-1.0..1.0_f64, -1.0..1.0, 0.1..1.0]
    ) {
        let (upper, lower) = lengths;
        let hinge = [DVec3::ZERO, DVec3::X * 3.0];
        let mut joints = vec![joint(0, 0.0, Parameterisation::Ball, NO_LIMITS), joint(1, upper, Parameterisation::SwingTwist, hinge)];
        joints[1].angles.x = 0.5;
        let linkage = Linkage::new(joints).unwrap();
        // as far as the hinge bends
        let nearest = (upper * upper + lower * lower + 2.0 * upper * lower * 3.0_f64.cos()).sqrt();
        let away = nearest + (upper + lower - nearest) * share;
        let goals = [position(1, DVec3::Y * lower, DVec3::from(way).normalize() * away)];
        let found = reach(&Program::new(&linkage, &goals).unwrap(), None, &ReachOptions::default()).unwrap();
        let cosine = (away * away - upper * upper - lower * lower) / (2.0 * upper * lower);
        prop_assert!(found.residuals[0] < 1e-4, "{}", found.residuals[0]);
        // the residual is a length; converted to an angle
        let tolerance = 1e-6 + 2.0 * found.residuals[0] * away / (upper * lower * cosine.acos().sin());
        prop_assert!((found.angles[1].x - cosine.acos()).abs() < tolerance, "{} {}", found.angles[1].x, cosine.acos());
    }

    #[test]
    fn a_goal_out_of_reach_stretches_two_bones_straight(way in [-1.0..1.0_f64, -1.0..1.0, 0.1..1.0]) {
        let joints = vec![joint(0, 0.0, Parameterisation::Ball, NO_LIMITS), joint(1, 0.3, Parameterisation::Ball, NO_LIMITS)];
        let linkage = Linkage::new(joints).unwrap();
        let target = DVec3::from(way).normalize() * 0.9;
        let goals = [position(1, DVec3::Y * 0.3, target)];
        let found = reach(&Program::new(&linkage, &goals).unwrap(), None, &ReachOptions::default()).unwrap();
        prop_assert!((found.residuals[0] - 0.3).abs() < 1e-5, "{}", found.residuals[0]);
    }

    #[test]
    fn the_same_goal_from_the_same_pose_gives_the_same_bits((joints, pose) in chains(2..8)) {
        let linkage = Linkage::new(joints).unwrap();
        let goals = [position(linkage.len() - 1, end_of(linkage.len()), 1.2 * end_at(&linkage, &pose))];
        let found = || reach(&Program::new(&linkage, &goals).unwrap(), None, &THOROUGH).unwrap();
        let (here, there) = (found(), std::thread::scope(|scope| scope.spawn(found).join().unwrap()));
        prop_assert_eq!(here, there);
    }
}

#[test]
fn position_orientation_and_look_at_are_met_together() {
    let mut joints = plain(6);
    joints[3].parent = 0; // two arms on one bone
    let pose = [0.3, -0.5, 0.6, -0.4, 0.7, 0.2].map(|turn| DVec3::new(turn, 0.1, 0.4 - turn));
    let due = Linkage::new(joints.clone()).unwrap().posed(&pose).unwrap();
    let (_, rotation, _) = due[2].to_scale_rotation_translation();
    let target = due[5].transform_point3(3.0 * DVec3::Z);
    let goal = |joint, target| Goal {
        joint,
        point: DVec3::ZERO,
        target,
        weight: 1.0,
    };
    let goals = [
        position(2, DVec3::Y * 0.25, due[2].transform_point3(DVec3::Y * 0.25)),
        goal(2, Target::Orientation(rotation)),
        position(4, DVec3::ZERO, due[4].translation),
        goal(
            5,
            Target::LookAt {
                axis: DVec3::Z,
                target,
            },
        ),
    ];
    let (linkage, angles, residuals) = reached(joints, &goals);
    assert!(residuals.iter().all(|&miss| miss < 1e-3), "{residuals:?}");
    let posed = linkage.posed(&angles).unwrap();
    let (_, turned, _) = posed[2].to_scale_rotation_translation();
    assert!(turned.dot(rotation).abs() > 1.0 - 1e-6);
    let sight = target - posed[5].translation;
    assert!((posed[5].matrix3 * DVec3::Z).angle_between(sight) < 1e-3);
}
