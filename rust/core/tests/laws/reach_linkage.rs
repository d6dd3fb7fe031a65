//! Linkages for reach: the gradient for all kinds of joints, conversion between angles and rotations, and
//! invalid linkages.

use glam::{DAffine3, DQuat, DVec3, EulerRot};
use proptest::prelude::*;
use sinew_core::Error;
use sinew_core::reach::{Goal, Joint, Linkage, Parameterisation, Program};

use super::fixtures::reach_rig::{all_goals, joint, parameterisations, plain, position};

/// Joints with all features: scale, a socket with scale but without shear, some that do not rotate with their
/// parent.
fn odd_joints() -> impl Strategy<Value = Vec<Joint>> {
    let size = 0.5..2.0_f64;
    let part = (
        parameterisations(),
        [-0.9..0.9_f64, -0.9..0.9, -0.9..0.9],
        [size.clone(), size.clone(), size],
        any::<u8>(),
    );
    prop::collection::vec(part, 2..6).prop_map(|parts| {
        let joints = parts.into_iter().enumerate().map(
            |(place, ((parameterisation, limits), turned, scale, luck))| {
                let mut joint = joint(place, 0.3, parameterisation, limits);
                joint.socket *=
                    DAffine3::from_quat(DQuat::from_euler(EulerRot::XYZ, turned[0], turned[1], turned[2]));
                joint.angles = DVec3::from_array(turned);
                joint.scale = scale.into();
                joint.turns_with_parent = luck >= 64;
                joint.parent = if luck % 3 == 0 {
                    (place as i64 - 1).min(0)
                } else {
                    place as i64 - 1
                };
                joint.eagerness = 0.1 + 2.4 * f64::from(luck) / 255.0;
                joint
            },
        );
        joints.collect()
    })
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
            // Richardson extrapolation: the error is of fourth order in the step
            let difference = (4.0 * slope(1e-4) - slope(2e-4)) / 3.0;
            prop_assert!((difference - gradient[unknown]).abs() <= 1e-7 * largest, "{difference} {}", gradient[unknown]);
        }
    }

    #[test]
    fn angles_give_back_their_rotation((parameterisation, limits) in parameterisations(), shares in [0.0..1.0_f64, 0.0..1.0, 0.0..1.0], near in -7.0..7.0_f64) {
        let angles = limits[0] + (limits[1] - limits[0]) * DVec3::from_array(shares);
        let rotation = parameterisation.rotation(angles);
        let again = parameterisation.rotation(parameterisation.angles(rotation, DVec3::splat(near)));
        prop_assert!(rotation.dot(again).abs() >= 1.0 - 1e-12);
        // and the same angles, if they are asked for as the nearest
        prop_assert!(parameterisation.angles(rotation, angles).distance(angles) < 1e-6 || parameterisation == Parameterisation::Ball);
    }

    #[test]
    fn locked_euler_axes_do_not_stop_at_gimbal_lock(first in -3.0..3.0_f64, third in -3.0..3.0_f64) {
        let parameterisation = Parameterisation::Euler([0, 1, 2]);
        let angles = DVec3::new(first, std::f64::consts::FRAC_PI_2, third);
        let again = parameterisation.angles(parameterisation.rotation(angles), DVec3::new(first, 0.0, 0.0));
        prop_assert!(parameterisation.rotation(angles).dot(parameterisation.rotation(again)).abs() > 1.0 - 1e-9);
        prop_assert_eq!(again.x, first);
    }
}

#[test]
fn an_invalid_linkage_is_refused_by_name() {
    let refused = |change: fn(&mut Joint)| {
        let mut joints = plain(3);
        change(&mut joints[1]);
        Linkage::new(joints).unwrap_err().to_string()
    };
    assert!(refused(|joint| joint.eagerness = 3.0).contains("Eagerness of joint \"bone 1\""));
    assert!(refused(|joint| joint.parent = 2).contains("parents: entry 1 is 2"));
    assert!(refused(|joint| joint.scale.y = 0.0).contains("Scale of joint \"bone 1\" cannot be inverted"));
    assert!(refused(|joint| joint.lower.x = f64::INFINITY).contains("Limits of joint \"bone 1\""));
    assert!(refused(|joint| joint.name = "bone 0".to_owned()).contains("is the name of two joints"));
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
