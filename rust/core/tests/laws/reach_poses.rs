//! Which of the poses that meet a goal, or come nearest, is found: near the previous pose, by the preferences
//! of joints.

use glam::{DQuat, DVec3};
use sinew_core::reach::{Linkage, Parameterisation, Program, ReachOptions, reach};

use super::fixtures::reach_rig::{NO_LIMITS, joint, plain, position, reached};

#[test]
fn joints_with_high_multipliers_rotate_more() {
    let goals = [position(2, DVec3::Y * 0.25, DVec3::new(0.0, 0.3, 0.6))];
    let turned = |eagerness: f64| {
        let mut joints = plain(3);
        joints[0].eagerness = eagerness;
        let (_, angles, residuals) = reached(joints, &goals);
        assert!(residuals[0] < 1e-4);
        angles[0].length()
    };
    let [lazy, plain, eager] = [0.1, 1.0, 2.5].map(turned);
    assert!(
        1.05 * lazy < plain && 1.05 * plain < eager,
        "{lazy} {plain} {eager}"
    );
}

#[test]
fn a_straight_arm_bends_for_a_goal_on_its_own_line() {
    let (_, angles, residuals) = reached(plain(3), &[position(2, DVec3::Y * 0.25, DVec3::Y * 0.4)]);
    assert!(residuals[0] < 1e-4 && angles[1].length() > 0.3, "{residuals:?}");
}

#[test]
fn a_ball_joint_can_rotate_without_end() {
    let limits = [DVec3::new(-9.0, -9.0, -9.0), DVec3::splat(9.0)];
    for parameterisation in [Parameterisation::Ball, Parameterisation::SwingTwist] {
        let mut bone = joint(0, 0.0, parameterisation, limits);
        for step in 0..100 {
            let turn = DQuat::from_rotation_x(0.2 * f64::from(step));
            let goals = [position(0, DVec3::Y, turn * DVec3::Y)];
            let (_, angles, residuals) = reached(vec![bone.clone()], &goals);
            assert!(residuals[0] < 1e-4, "step {step}: {} m", residuals[0]);
            assert!(angles[0].length() < 5.0, "step {step}: {}", angles[0]);
            bone.angles = angles[0];
        }
    }
}

#[test]
fn a_chain_without_length_or_freedom_stays_where_it_is() {
    let still: Vec<_> = (0..3)
        .map(|place| joint(place, 0.0, Parameterisation::Ball, NO_LIMITS))
        .collect();
    let (_, angles, residuals) = reached(still, &[position(2, DVec3::ZERO, DVec3::X)]);
    assert!(angles.iter().all(|angles| angles.is_finite()) && residuals == [1.0]);
    let locked: Vec<_> = (0..3)
        .map(|place| joint(place, 0.2, Parameterisation::Ball, [DVec3::ZERO; 2]))
        .collect();
    let (_, angles, _) = reached(locked, &[position(2, DVec3::ZERO, DVec3::X)]);
    assert_eq!(angles, [DVec3::ZERO; 3]);
}

#[test]
fn a_goal_out_of_reach_leaves_the_pose_still_from_frame_to_frame() {
    let mut joints = plain(4);
    for joint in &mut joints {
        (joint.parameterisation, joint.lower, joint.upper) = (
            Parameterisation::SwingTwist,
            DVec3::splat(-0.6),
            DVec3::splat(0.7),
        );
    }
    let mut before: Option<Vec<DVec3>> = None;
    for frame in 0..30 {
        // out of reach, and moving slowly
        let target = DVec3::new(1.5, 0.3 + 0.001 * f64::from(frame), 0.8);
        let (_, angles, _) = reached(joints.clone(), &[position(3, DVec3::Y * 0.25, target)]);
        if let Some(before) = before {
            let moved = angles
                .iter()
                .zip(&before)
                .map(|(now, then)| now.distance(*then))
                .fold(0.0, f64::max);
            assert!(
                moved < if frame < 3 { 0.1 } else { 0.01 },
                "frame {frame}: {moved} rad"
            );
        }
        for (joint, angles) in joints.iter_mut().zip(&angles) {
            joint.angles = *angles;
        }
        before = Some(angles);
    }
}

#[test]
fn the_preferred_pose_decides_what_the_goal_leaves_open() {
    let goals = [position(2, DVec3::Y * 0.25, DVec3::new(0.0, 0.5, 0.3))];
    let linkage = Linkage::new(plain(3)).unwrap();
    let program = Program::new(&linkage, &goals).unwrap();
    let options = ReachOptions {
        preference: 0.01,
        restarts: 0,
    };
    let knee = |bend: f64| {
        let preferred = [DVec3::ZERO, DVec3::X * bend, DVec3::ZERO];
        let found = reach(&program, Some(&preferred), &options).unwrap();
        assert!(found.residuals[0] < 1e-4);
        found.angles[1].x
    };
    assert!(knee(1.0) > knee(0.0) + 0.1 && knee(0.0) > knee(-1.0) + 0.1);
}
