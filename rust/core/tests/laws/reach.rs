//! Reaching: gradients, limits, goals in and out of reach, the closed form, the same bits.

use glam::{DAffine3, DQuat, DVec3, EulerRot};
use proptest::prelude::*;
use sinew_core::Error;
use sinew_core::reach::{Freedoms, Goal, Joint, Linkage, Program, ReachOptions, Wish, reach};

use super::reach_rig::{chains, end_at, end_of, freedoms, joint, position, samples};

/// As the add-on solves a pose at once, not step by step as in a drag.
const THOROUGH: ReachOptions = ReachOptions {
    preference: 1e-3,
    restarts: 16,
};
const NO_LIMITS: [DVec3; 2] = [DVec3::NEG_INFINITY, DVec3::INFINITY];

/// Largest amount by which angles break their limits.
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

/// Of random goals that some pose within the limits reaches, the share that is missed by over 0.1 mm.
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

/// Goals that may be out of reach: the miss, and the smallest of 200 descents from random poses.
fn against_restarts(count: usize) {
    let places = (chains(2..13), [-1.5..1.5_f64, -1.5..1.5, -1.5..1.5], any::<u64>());
    for ((joints, _), target, _) in samples(places, count) {
        let linkage = Linkage::new(joints.clone()).unwrap();
        let goals = [position(linkage.len() - 1, end_of(linkage.len()), target.into())];
        let miss = reach(&Program::new(&linkage, &goals).unwrap(), None, &THOROUGH)
            .unwrap()
            .misses[0];
        let shares = prop::collection::vec([0.0..1.0_f64, 0.0..1.0, 0.0..1.0], joints.len());
        let best = samples(shares, 200).map(|shares| {
            let mut joints = joints.clone();
            for (joint, shares) in joints.iter_mut().zip(shares) {
                joint.angles = joint.lower + (joint.upper - joint.lower) * DVec3::from_array(shares);
            }
            let linkage = Linkage::new(joints).unwrap();
            let program = Program::new(&linkage, &goals).unwrap();
            reach(&program, None, &ReachOptions::default()).unwrap().misses[0]
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

/// A joint with all there is: scale, a socket that shears nothing but scales, now and then none of its parent's turning.
fn odd_joints() -> impl Strategy<Value = Vec<Joint>> {
    let size = 0.5..2.0_f64;
    let part = (
        freedoms(),
        [-0.9..0.9_f64, -0.9..0.9, -0.9..0.9],
        [size.clone(), size.clone(), size],
        any::<u8>(),
    );
    prop::collection::vec(part, 2..6).prop_map(|parts| {
        let joints =
            parts
                .into_iter()
                .enumerate()
                .map(|(place, ((freedoms, limits), turned, scale, luck))| {
                    let mut joint = joint(place, 0.3, freedoms, limits);
                    joint.socket *= DAffine3::from_quat(DQuat::from_euler(
                        EulerRot::XYZ,
                        turned[0],
                        turned[1],
                        turned[2],
                    ));
                    joint.angles = DVec3::from_array(turned);
                    joint.scale = scale.into();
                    joint.turns_with_parent = luck >= 64;
                    joint.parent = if luck % 3 == 0 {
                        (place as i64 - 1).min(0)
                    } else {
                        place as i64 - 1
                    };
                    joint.multiplier = 0.1 + 2.4 * f64::from(luck) / 255.0;
                    joint
                });
        joints.collect()
    })
}

fn all_goals(joints: usize, numbers: [f64; 6]) -> Vec<Goal> {
    let (point, target) = (DVec3::from_slice(&numbers), DVec3::from_slice(&numbers[3..]));
    let goal = |joint, weight, wish| Goal {
        joint,
        point,
        wish,
        weight,
    };
    vec![
        goal(joints - 1, 1.0, Wish::Position(target)),
        goal(
            joints - 1,
            0.7,
            Wish::Orientation(DQuat::from_scaled_axis(target)),
        ),
        goal(
            joints / 2,
            0.4,
            Wish::LookAt {
                axis: point,
                target: 3.0 * target,
            },
        ),
    ]
}

proptest! {
    #[test]
    fn the_gradient_is_that_of_finite_differences(
        joints in odd_joints(), numbers in prop::array::uniform6(0.1..0.8_f64)
    ) {
        let linkage = Linkage::new(joints).unwrap();
        let goals = all_goals(linkage.len(), numbers);
        let program = Program::new(&linkage, &goals).unwrap();
        let [lower, upper] = program.bounds();
        let inside = |(at, (low, high)): (f64, (&f64, &f64))| (0.98 * at).clamp(low + 4e-4, high - 4e-4);
        let at: Vec<f64> = program.unknowns(&linkage.start()).into_iter().zip(lower.iter().zip(&upper)).map(inside).collect();
        let mut gradient = vec![0.0; program.len()];
        program.cost(&at, &mut gradient);
        let mut spare = gradient.clone();
        let largest = gradient.iter().fold(1.0_f64, |most, entry| most.max(entry.abs()));
        for unknown in 0..program.len() {
            let mut slope = |step: f64| {
                let [above, below] = [step, -step].map(|step| {
                    let mut moved = at.clone();
                    moved[unknown] += step;
                    program.cost(&moved, &mut spare)
                });
                (above - below) / (2.0 * step)
            };
            // Richardson: what is left is of the fourth order of the step
            let difference = (4.0 * slope(1e-4) - slope(2e-4)) / 3.0;
            prop_assert!((difference - gradient[unknown]).abs() <= 1e-7 * largest, "{difference} {}", gradient[unknown]);
        }
    }

    #[test]
    fn angles_give_back_their_rotation((freedoms, limits) in freedoms(), shares in [0.0..1.0_f64, 0.0..1.0, 0.0..1.0], near in -7.0..7.0_f64) {
        let angles = limits[0] + (limits[1] - limits[0]) * DVec3::from_array(shares);
        let rotation = freedoms.rotation(angles);
        let again = freedoms.rotation(freedoms.angles(rotation, DVec3::splat(near)));
        prop_assert!(rotation.dot(again).abs() >= 1.0 - 1e-12);
        // and the very angles, where they are asked for
        prop_assert!(freedoms.angles(rotation, angles).distance(angles) < 1e-6 || freedoms == Freedoms::Ball);
    }

    #[test]
    fn locked_euler_axes_do_not_stop_at_gimbal_lock(first in -3.0..3.0_f64, third in -3.0..3.0_f64) {
        let freedoms = Freedoms::Euler([0, 1, 2]);
        let angles = DVec3::new(first, std::f64::consts::FRAC_PI_2, third);
        let again = freedoms.angles(freedoms.rotation(angles), DVec3::new(first, 0.0, 0.0));
        prop_assert!(freedoms.rotation(angles).dot(freedoms.rotation(again)).abs() > 1.0 - 1e-9);
        prop_assert_eq!(again.x, first);
    }

    #[test]
    fn limits_hold_whatever_is_wished(
        (joints, _) in chains(1..8), targets in prop::collection::vec(prop::array::uniform6(-9.0..9.0_f64), 1..3)
    ) {
        let linkage = Linkage::new(joints).unwrap();
        let goals: Vec<_> = targets.into_iter().flat_map(|numbers| all_goals(linkage.len(), numbers)).collect();
        let found = reach(&Program::new(&linkage, &goals).unwrap(), None, &ReachOptions::default()).unwrap();
        prop_assert!(broken(&linkage, &found.angles) <= 0.0);
        let locked = linkage.start();
        for (joint, (angles, start)) in found.angles.iter().zip(&locked).enumerate() {
            for axis in (0..3).filter(|&axis| !linkage.freedoms().contains(&(joint, axis))) {
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
        let mut joints = vec![joint(0, 0.0, Freedoms::Ball, NO_LIMITS), joint(1, upper, Freedoms::SwingTwist, hinge)];
        joints[1].angles.x = 0.5;
        let linkage = Linkage::new(joints).unwrap();
        // as far as the hinge may bend
        let nearest = (upper * upper + lower * lower + 2.0 * upper * lower * 3.0_f64.cos()).sqrt();
        let away = nearest + (upper + lower - nearest) * share;
        let goals = [position(1, DVec3::Y * lower, DVec3::from(way).normalize() * away)];
        let found = reach(&Program::new(&linkage, &goals).unwrap(), None, &ReachOptions::default()).unwrap();
        let cosine = (away * away - upper * upper - lower * lower) / (2.0 * upper * lower);
        prop_assert!(found.misses[0] < 1e-4, "{}", found.misses[0]);
        // what is left of the miss is a length, and so much of an angle
        let tolerance = 1e-6 + 2.0 * found.misses[0] * away / (upper * lower * cosine.acos().sin());
        prop_assert!((found.angles[1].x - cosine.acos()).abs() < tolerance, "{} {}", found.angles[1].x, cosine.acos());
    }

    #[test]
    fn a_goal_out_of_reach_stretches_two_bones_straight(way in [-1.0..1.0_f64, -1.0..1.0, 0.1..1.0]) {
        let joints = vec![joint(0, 0.0, Freedoms::Ball, NO_LIMITS), joint(1, 0.3, Freedoms::Ball, NO_LIMITS)];
        let linkage = Linkage::new(joints).unwrap();
        let target = DVec3::from(way).normalize() * 0.9;
        let goals = [position(1, DVec3::Y * 0.3, target)];
        let found = reach(&Program::new(&linkage, &goals).unwrap(), None, &ReachOptions::default()).unwrap();
        prop_assert!((found.misses[0] - 0.3).abs() < 1e-5, "{}", found.misses[0]);
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

fn plain(count: usize) -> Vec<Joint> {
    (0..count)
        .map(|place| joint(place, 0.25, Freedoms::Ball, NO_LIMITS))
        .collect()
}

fn reached(joints: Vec<Joint>, goals: &[Goal]) -> (Linkage, Vec<DVec3>, Vec<f64>) {
    let linkage = Linkage::new(joints).unwrap();
    let found = reach(
        &Program::new(&linkage, goals).unwrap(),
        None,
        &ReachOptions::default(),
    )
    .unwrap();
    (linkage, found.angles, found.misses)
}

#[test]
fn eager_joints_turn_more_and_lazy_ones_less() {
    let goals = [position(2, DVec3::Y * 0.25, DVec3::new(0.0, 0.3, 0.6))];
    let turned = |multiplier: f64| {
        let mut joints = plain(3);
        joints[0].multiplier = multiplier;
        let (_, angles, misses) = reached(joints, &goals);
        assert!(misses[0] < 1e-4);
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
    let (_, angles, misses) = reached(plain(3), &[position(2, DVec3::Y * 0.25, DVec3::Y * 0.4)]);
    assert!(misses[0] < 1e-4 && angles[1].length() > 0.3, "{misses:?}");
}

#[test]
fn a_ball_joint_turns_round_and_round() {
    let limits = [DVec3::new(-9.0, -9.0, -9.0), DVec3::splat(9.0)];
    for freedoms in [Freedoms::Ball, Freedoms::SwingTwist] {
        let mut bone = joint(0, 0.0, freedoms, limits);
        for step in 0..100 {
            let turn = DQuat::from_rotation_x(0.2 * f64::from(step));
            let goals = [position(0, DVec3::Y, turn * DVec3::Y)];
            let (_, angles, misses) = reached(vec![bone.clone()], &goals);
            assert!(misses[0] < 1e-4, "step {step}: {} m", misses[0]);
            assert!(angles[0].length() < 5.0, "step {step}: {}", angles[0]);
            bone.angles = angles[0];
        }
    }
}

#[test]
fn a_chain_without_length_or_freedom_stays_where_it_is() {
    let still: Vec<_> = (0..3)
        .map(|place| joint(place, 0.0, Freedoms::Ball, NO_LIMITS))
        .collect();
    let (_, angles, misses) = reached(still, &[position(2, DVec3::ZERO, DVec3::X)]);
    assert!(angles.iter().all(|angles| angles.is_finite()) && misses == [1.0]);
    let locked: Vec<_> = (0..3)
        .map(|place| joint(place, 0.2, Freedoms::Ball, [DVec3::ZERO; 2]))
        .collect();
    let (_, angles, _) = reached(locked, &[position(2, DVec3::ZERO, DVec3::X)]);
    assert_eq!(angles, [DVec3::ZERO; 3]);
}

#[test]
fn a_goal_out_of_reach_leaves_the_pose_still_from_frame_to_frame() {
    let mut joints = plain(4);
    for joint in &mut joints {
        (joint.freedoms, joint.lower, joint.upper) =
            (Freedoms::SwingTwist, DVec3::splat(-0.6), DVec3::splat(0.7));
    }
    let mut before: Option<Vec<DVec3>> = None;
    for frame in 0..30 {
        // out of reach, and slowly moving on
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
fn position_orientation_and_look_at_are_met_together() {
    let mut joints = plain(6);
    joints[3].parent = 0; // two arms on one bone
    let pose = [0.3, -0.5, 0.6, -0.4, 0.7, 0.2].map(|turn| DVec3::new(turn, 0.1, 0.4 - turn));
    let due = Linkage::new(joints.clone()).unwrap().posed(&pose).unwrap();
    let (_, rotation, _) = due[2].to_scale_rotation_translation();
    let target = due[5].transform_point3(3.0 * DVec3::Z);
    let goal = |joint, wish| Goal {
        joint,
        point: DVec3::ZERO,
        wish,
        weight: 1.0,
    };
    let goals = [
        position(2, DVec3::Y * 0.25, due[2].transform_point3(DVec3::Y * 0.25)),
        goal(2, Wish::Orientation(rotation)),
        position(4, DVec3::ZERO, due[4].translation),
        goal(
            5,
            Wish::LookAt {
                axis: DVec3::Z,
                target,
            },
        ),
    ];
    let (linkage, angles, misses) = reached(joints, &goals);
    assert!(misses.iter().all(|&miss| miss < 1e-3), "{misses:?}");
    let posed = linkage.posed(&angles).unwrap();
    let (_, turned, _) = posed[2].to_scale_rotation_translation();
    assert!(turned.dot(rotation).abs() > 1.0 - 1e-6);
    let sight = target - posed[5].translation;
    assert!((posed[5].matrix3 * DVec3::Z).angle_between(sight) < 1e-3);
}

#[test]
fn what_is_preferred_shapes_what_the_goal_leaves_open() {
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
        assert!(found.misses[0] < 1e-4);
        found.angles[1].x
    };
    assert!(knee(1.0) > knee(0.0) + 0.1 && knee(0.0) > knee(-1.0) + 0.1);
}

#[test]
fn a_linkage_that_cannot_be_is_refused_by_name() {
    let refused = |change: fn(&mut Joint)| {
        let mut joints = plain(3);
        change(&mut joints[1]);
        Linkage::new(joints).unwrap_err().to_string()
    };
    assert!(refused(|joint| joint.multiplier = 3.0).contains("multiplier of joint \"bone 1\""));
    assert!(refused(|joint| joint.parent = 2).contains("parents: entry 1 is 2"));
    assert!(refused(|joint| joint.scale.y = 0.0).contains("scale of joint \"bone 1\" cannot be inverted"));
    assert!(refused(|joint| joint.lower.x = f64::INFINITY).contains("limits of joint \"bone 1\""));
    assert!(refused(|joint| joint.name = "bone 0".to_owned()).contains("is there twice"));
    assert_eq!(Linkage::new(vec![]).unwrap_err(), Error::NoJoints);
    let linkage = Linkage::new(plain(2)).unwrap();
    let goal = |joint, weight| {
        [Goal {
            weight,
            ..position(joint, DVec3::ZERO, DVec3::X)
        }]
    };
    assert!(Program::new(&linkage, &goal(2, 1.0)).is_err());
    assert!(
        Program::new(&linkage, &goal(1, -1.0))
            .unwrap_err()
            .to_string()
            .contains("its weight is -1")
    );
}
