//! The cost of one step of a drag: an arm with four joints, and a body with 30 joints and five goals.
#![allow(clippy::unwrap_used, missing_docs)]

use divan::Bencher;
use glam::{DAffine3, DVec3};
use sinew_core::reach::{
    Goal, Joint, Linkage, Parameterisation, Program, ReachOptions, Reached, Target, reach,
};

/// The target of the drag.
#[derive(Debug, Clone, Copy)]
enum Drag {
    Within,
    OutOfReach,
}

/// A bone of `length` along the parent's axis, from `at` in the parent's axes.
fn bone(
    joints: &mut Vec<Joint>,
    parent: i64,
    at: DVec3,
    parameterisation: Parameterisation,
    limits: [DVec3; 2],
) -> i64 {
    let place = joints.len() as i64;
    joints.push(Joint {
        name: place.to_string(),
        parent,
        socket: DAffine3::from_translation(at),
        turns_with_parent: true,
        scale: DVec3::ONE,
        parameterisation,
        angles: DVec3::ZERO.clamp(limits[0], limits[1]),
        lower: limits[0],
        upper: limits[1],
        eagerness: 1.0,
    });
    place
}

const FREE: [DVec3; 2] = [DVec3::NEG_INFINITY, DVec3::INFINITY];
const HINGE: [DVec3; 2] = [DVec3::new(0.02, -0.5, 0.0), DVec3::new(2.6, 0.5, 0.0)];
const SOME: [DVec3; 2] = [DVec3::splat(-0.6), DVec3::splat(0.6)];

/// Girdle, upper arm, forearm and hand; returns the hand.
fn arm(joints: &mut Vec<Joint>, parent: i64, at: DVec3) -> i64 {
    let girdle = bone(joints, parent, at, Parameterisation::SwingTwist, SOME);
    let upper = bone(joints, girdle, DVec3::Y * 0.15, Parameterisation::Ball, FREE);
    let lower = bone(
        joints,
        upper,
        DVec3::Y * 0.28,
        Parameterisation::SwingTwist,
        HINGE,
    );
    bone(joints, lower, DVec3::Y * 0.25, Parameterisation::SwingTwist, SOME)
}

/// Pelvis, nine bones of spine, neck and head, two arms and two legs of five bones each: 30 joints.
fn body() -> (Vec<Joint>, [i64; 5]) {
    let mut joints = vec![];
    let mut spine = bone(&mut joints, -1, DVec3::ZERO, Parameterisation::Ball, FREE);
    let mut chest = spine;
    for place in 0..9 {
        spine = bone(
            &mut joints,
            spine,
            DVec3::Y * 0.07,
            Parameterisation::SwingTwist,
            SOME,
        );
        chest = if place == 5 { spine } else { chest };
    }
    let mut ends = [spine; 5];
    for side in 0..2 {
        let out = if side == 0 { DVec3::X } else { DVec3::NEG_X };
        let hand = arm(&mut joints, chest, 0.05 * out);
        ends[1 + side] = bone(
            &mut joints,
            hand,
            DVec3::Y * 0.08,
            Parameterisation::SwingTwist,
            SOME,
        );
        let thigh = bone(&mut joints, 0, 0.1 * out, Parameterisation::Ball, FREE);
        let shin = bone(
            &mut joints,
            thigh,
            DVec3::Y * 0.42,
            Parameterisation::SwingTwist,
            HINGE,
        );
        let mut foot = bone(
            &mut joints,
            shin,
            DVec3::Y * 0.42,
            Parameterisation::SwingTwist,
            SOME,
        );
        for _ in 0..2 {
            foot = bone(
                &mut joints,
                foot,
                DVec3::Y * 0.1,
                Parameterisation::SwingTwist,
                SOME,
            );
        }
        ends[3 + side] = foot;
    }
    assert_eq!(joints.len(), 30);
    (joints, ends)
}

fn goals(joints: &[Joint], ends: &[i64], moved: DVec3) -> Vec<Goal> {
    let linkage = Linkage::new(joints.to_vec()).unwrap();
    let posed = linkage.posed(&linkage.start()).unwrap();
    let goal = |(place, &end): (usize, &i64)| Goal {
        joint: end as usize,
        point: DVec3::Y * 0.05,
        target: Target::Position(
            posed[end as usize].transform_point3(DVec3::Y * 0.05)
                + if place == 0 { moved } else { DVec3::ZERO },
        ),
        weight: 1.0,
    };
    ends.iter().enumerate().map(goal).collect()
}

fn solved(joints: &[Joint], goals: &[Goal]) -> Reached {
    let linkage = Linkage::new(joints.to_vec()).unwrap();
    reach(
        &Program::new(&linkage, goals).unwrap(),
        None,
        &ReachOptions::default(),
    )
    .unwrap()
}

/// One step of 1 cm during a drag. The linkage is created again, as the add-on does.
fn step(bencher: Bencher, mut joints: Vec<Joint>, ends: &[i64], drag: Drag) {
    let way = match drag {
        Drag::Within => DVec3::new(0.1, -0.2, 0.15),
        Drag::OutOfReach => DVec3::new(0.6, 0.9, 0.4),
    };
    let at_first = goals(&joints, ends, way);
    let now = goals(&joints, ends, way + DVec3::new(0.0, 0.0, 0.01));
    for _ in 0..5 {
        let found = solved(&joints, &at_first);
        joints
            .iter_mut()
            .zip(found.angles)
            .for_each(|(joint, angles)| joint.angles = angles);
    }
    bencher.bench_local(|| solved(&joints, &now));
}

#[divan::bench(args = [Drag::Within, Drag::OutOfReach])]
fn drag_step_of_a_four_joint_arm(bencher: Bencher, drag: Drag) {
    let mut joints = vec![];
    let hand = arm(&mut joints, -1, DVec3::ZERO);
    step(bencher, joints, &[hand], drag);
}

#[divan::bench(args = [Drag::Within, Drag::OutOfReach])]
fn drag_step_of_a_body_of_30_joints(bencher: Bencher, drag: Drag) {
    let (joints, [_, ends @ ..]) = body();
    step(bencher, joints, &ends, drag);
}

fn main() {
    divan::main();
}
