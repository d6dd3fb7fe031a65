//! Linkages for the laws of reach, random and simple.

use std::f64::consts::PI;

use glam::{DAffine3, DQuat, DVec3, EulerRot};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use sinew_core::reach::{Goal, Joint, Linkage, Parameterisation, Program, ReachOptions, Target, reach};

pub const NO_LIMITS: [DVec3; 2] = [DVec3::NEG_INFINITY, DVec3::INFINITY];

/// The point of a chain that reaches: the end of its last bone.
pub fn end_of(bones: usize) -> DVec3 {
    DVec3::Y / bones as f64
}

/// A joint of a chain of bones along y, `length_m` after the previous one.
pub fn joint(
    position: usize,
    length_m: f64,
    parameterisation: Parameterisation,
    limits: [DVec3; 2],
) -> Joint {
    Joint {
        name: format!("bone {position}"),
        parent: position as i64 - 1,
        socket: DAffine3::from_translation(if position > 0 {
            DVec3::Y * length_m
        } else {
            DVec3::ZERO
        }),
        turns_with_parent: true,
        scale: DVec3::ONE,
        parameterisation,
        angles: DVec3::ZERO,
        lower: limits[0],
        upper: limits[1],
        eagerness: 1.0,
    }
}

pub fn position(joint: usize, point: DVec3, target: DVec3) -> Goal {
    Goal {
        joint,
        point,
        target: Target::Position(target),
        weight: 1.0,
    }
}

/// A goal of each kind, for the last joint and a middle one.
pub fn all_goals(joints: usize, numbers: [f64; 6]) -> Vec<Goal> {
    let (point, target) = (DVec3::from_slice(&numbers), DVec3::from_slice(&numbers[3..]));
    let goal = |joint, weight, target| Goal {
        joint,
        point,
        target,
        weight,
    };
    vec![
        goal(joints - 1, 1.0, Target::Position(target)),
        goal(
            joints - 1,
            0.7,
            Target::Orientation(DQuat::from_scaled_axis(target)),
        ),
        goal(
            joints / 2,
            0.4,
            Target::LookAt {
                axis: point,
                target: 3.0 * target,
            },
        ),
    ]
}

/// A chain of ball joints without limits, 0.25 m apart.
pub fn plain(count: usize) -> Vec<Joint> {
    (0..count)
        .map(|place| joint(place, 0.25, Parameterisation::Ball, NO_LIMITS))
        .collect()
}

/// Any parameterisation, with limits that contain 0, and one to three free angles.
pub fn parameterisations() -> impl Strategy<Value = (Parameterisation, [DVec3; 2])> {
    let span = || (0.2..2.0_f64, 0.2..2.0_f64);
    let kind = prop_oneof![
        Just(Parameterisation::Ball),
        Just(Parameterisation::SwingTwist),
        Just(Parameterisation::SwingTwist),
        prop::sample::select(vec![
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0]
        ])
        .prop_map(Parameterisation::Euler),
    ];
    (kind, 1..4_usize, 0..3_usize, [span(), span(), span()]).prop_map(
        |(parameterisation, count, first, spans)| {
            if parameterisation == Parameterisation::Ball {
                return (parameterisation, [DVec3::splat(-PI), DVec3::splat(PI)]);
            }
            let mut limits = [DVec3::ZERO; 2];
            for step in 0..count {
                let axis = (first + step) % 3;
                limits[0][axis] = -spans[axis].0;
                limits[1][axis] = spans[axis].1;
            }
            (parameterisation, limits)
        },
    )
}

/// A chain 1 m long, and angles within its limits that are not its start.
pub fn chains(bones: std::ops::Range<usize>) -> impl Strategy<Value = (Vec<Joint>, Vec<DVec3>)> {
    let one = (
        parameterisations(),
        [0.0..1.0_f64, 0.0..1.0, 0.0..1.0],
        [-0.4..0.4_f64, -3.0..3.0, -0.4..0.4],
    );
    prop::collection::vec(one, bones).prop_map(|parts| {
        let length_m = 1.0 / parts.len() as f64;
        let joints = parts
            .iter()
            .enumerate()
            .map(|(place, ((parameterisation, limits), _, [x, y, z]))| {
                let mut joint = joint(place, length_m, *parameterisation, *limits);
                joint.socket *= DAffine3::from_quat(DQuat::from_euler(EulerRot::XYZ, *x, *y, *z));
                joint
            });
        let joints: Vec<_> = joints.collect();
        let pose = joints.iter().zip(&parts).map(|(joint, (_, shares, _))| {
            joint.lower + (joint.upper - joint.lower) * DVec3::from_array(*shares)
        });
        let pose = pose.collect();
        (joints, pose)
    })
}

/// The end of a chain in a pose.
pub fn end_at(linkage: &Linkage, pose: &[DVec3]) -> DVec3 {
    linkage.posed(pose).unwrap()[linkage.len() - 1].transform_point3(end_of(linkage.len()))
}

/// `count` values of a strategy, the same in every run.
pub fn samples<S: Strategy>(strategy: S, count: usize) -> impl Iterator<Item = S::Value> {
    let seeded = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(Config::default(), seeded);
    (0..count).map(move |_| strategy.new_tree(&mut runner).unwrap().current())
}

/// The linkage of these joints, and the angles and residuals that reaching step by step finds.
pub fn reached(joints: Vec<Joint>, goals: &[Goal]) -> (Linkage, Vec<DVec3>, Vec<f64>) {
    let linkage = Linkage::new(joints).unwrap();
    let found = reach(
        &Program::new(&linkage, goals).unwrap(),
        None,
        &ReachOptions::default(),
    )
    .unwrap();
    (linkage, found.angles, found.residuals)
}
