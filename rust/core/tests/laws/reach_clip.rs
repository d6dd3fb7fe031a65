//! Reaching over a clip: smooth motion and pinned points.

use glam::{DAffine3, DQuat, DVec3};
use sinew_core::reach::{ClipOptions, Goal, Linkage, Parameterisation, Program, Reached, reach_clip};

use super::fixtures::reach_rig::{NO_LIMITS, joint, plain, position};

/// 24 frames of four bones that follow a trembling goal. `rise_m` per frame lifts all; `pin` pins the second
/// bone.
fn clip(smoothness: f64, tremble_m: f64, rise_m: f64, pin: Option<f64>) -> Vec<Reached> {
    let frames = (0..24).map(|frame| {
        let mut joints = plain(4);
        joints[0].socket = DAffine3::from_translation(DVec3::Z * rise_m * f64::from(frame));
        let tremble = if frame % 2 == 0 { tremble_m } else { -tremble_m };
        let target = DVec3::new(0.4 + tremble, 0.5 + 0.005 * f64::from(frame), 0.1);
        let mut goals = vec![position(3, DVec3::Y * 0.25, target)];
        goals.extend(pin.map(|weight| Goal {
            weight,
            ..position(1, DVec3::Y * 0.25, DVec3::new(0.1, 0.45, 0.05))
        }));
        (Linkage::new(joints).unwrap(), goals)
    });
    let frames: Vec<_> = frames.collect();
    let programs: Vec<_> = frames
        .iter()
        .map(|(linkage, goals)| Program::new(linkage, goals).unwrap())
        .collect();
    let options = ClipOptions {
        smoothness,
        ..ClipOptions::default()
    };
    reach_clip(&programs, &options).unwrap()
}

/// Largest second difference of an angle, rad.
fn jerkiness(frames: &[Reached]) -> f64 {
    let bend = |three: &[Reached]| {
        let each = (0..4).map(|joint| {
            (three[0].angles[joint] - 2.0 * three[1].angles[joint] + three[2].angles[joint])
                .abs()
                .max_element()
        });
        each.fold(0.0, f64::max)
    };
    frames.windows(3).map(bend).fold(0.0, f64::max)
}

fn worst(frames: &[Reached], goal: usize) -> f64 {
    frames
        .iter()
        .map(|frame| frame.residuals[goal])
        .fold(0.0, f64::max)
}

#[test]
fn a_trembling_goal_is_followed_smoothly() {
    let [rough, smooth] = [0.0, 0.1].map(|smoothness| clip(smoothness, 0.01, 0.0, None));
    assert!(worst(&rough, 0) < 1e-4, "{}", worst(&rough, 0));
    assert!(
        jerkiness(&smooth) < 0.3 * jerkiness(&rough),
        "{} {}",
        jerkiness(&smooth),
        jerkiness(&rough)
    );
    // the mean of the trembling goal is still followed
    assert!(worst(&smooth, 0) < 0.015, "{}", worst(&smooth, 0));
}

#[test]
fn a_steady_goal_is_met_for_all_smoothness() {
    let frames = clip(0.01, 0.0, 0.0, None);
    assert!(worst(&frames, 0) < 2e-4, "{}", worst(&frames, 0));
}

#[test]
fn a_joint_that_turns_past_half_a_turn_goes_on() {
    let frames: Vec<_> = (0..24)
        .map(|frame| {
            let linkage = Linkage::new(vec![joint(0, 0.0, Parameterisation::Ball, NO_LIMITS)]).unwrap();
            let target = DQuat::from_rotation_x(0.3 * f64::from(frame)) * DVec3::Y;
            (linkage, [position(0, DVec3::Y, target)])
        })
        .collect();
    let programs: Vec<_> = frames
        .iter()
        .map(|(linkage, goals)| Program::new(linkage, goals).unwrap())
        .collect();
    let reached = reach_clip(&programs, &ClipOptions::default()).unwrap();
    assert!(worst(&reached, 0) < 1e-3, "{}", worst(&reached, 0));
}

#[test]
fn a_pinned_point_stays_while_the_body_moves() {
    let frames = clip(0.01, 0.003, 0.002, Some(100.0));
    assert!(worst(&frames, 1) < 2e-4, "{}", worst(&frames, 1));
    let free = clip(0.01, 0.003, 0.002, Some(0.0));
    assert!(worst(&free, 1) > 5e-3);
}

#[test]
fn frames_of_other_joints_and_no_frames_are_refused() {
    let options = ClipOptions::default();
    assert!(reach_clip(&[], &options).is_err());
    let linkages = [2, 3].map(|count| Linkage::new(plain(count)).unwrap());
    let programs = linkages
        .each_ref()
        .map(|linkage| Program::new(linkage, &[]).unwrap());
    let refused = reach_clip(&programs, &options).unwrap_err().to_string();
    assert!(refused.contains("frames: expected 6 entries"), "{refused}");
}
