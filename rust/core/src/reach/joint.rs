//! A joint: its rotation as a function of three angles, and the derivatives (mathematics/reach.md, Joints and limits).
//!
//! The angles are chosen so that the limits of the joint are a box. The choice is its [`Parameterisation`]:
//! limits come as swing and twist (Blender's IK limits) or as Euler angles (its Limit Rotation constraint). A
//! joint without limits uses a rotation vector, which avoids the singular poses of both.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};

use super::rotation::{exponential, exponential_jacobian, logarithm};

/// Largest component of a rotation vector. For vectors of length 2π the derivative of the rotation is
/// singular (Grassia 1998, sec. 3.1), and a solver would stay there. Within these bounds no vector is that
/// long, and every rotation has a vector.
const LONGEST_RAD: f64 = 3.6;
/// A longer rotation vector is replaced by the shorter vector of the same rotation. The value is a little
/// more than π, so that a joint near π does not alternate between the two.
const UNWIND_FROM_RAD: f64 = 3.3;

/// The meaning of a joint's three angles, rad. A bone points along y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameterisation {
    /// A rotation vector: a ball joint without limits.
    Ball,
    /// x and z are the rotation vector of a swing of the bone, y is the twist about the bone, which comes
    /// first.
    SwingTwist,
    /// Euler angles. The axes (0 x, 1 y, 2 z) are in the order in which they rotate.
    Euler([usize; 3]),
}

/// The rotation of a joint and its derivatives.
#[derive(Debug, Clone, Copy)]
pub struct JointRotation {
    /// The rotation.
    pub rotation: DMat3,
    /// The axis of rotation for each angle: the derivative of the rotation by the angle, as a rotation vector
    /// in the axes before the rotation.
    pub axes: [DVec3; 3],
}

impl Parameterisation {
    /// The rotation at `angles`.
    pub fn rotation(&self, angles: DVec3) -> DQuat {
        match self {
            Self::Ball => exponential(angles),
            Self::SwingTwist => exponential(swing_of(angles)) * DQuat::from_rotation_y(angles.y),
            Self::Euler(order) => order.iter().fold(DQuat::IDENTITY, |rotated, &axis| {
                about(axis, angles[axis]) * rotated
            }),
        }
    }

    /// The rotation at `angles` and its derivatives.
    pub fn rotation_and_axes(&self, angles: DVec3) -> JointRotation {
        match self {
            Self::Ball => {
                let jacobian = exponential_jacobian(angles);
                JointRotation {
                    rotation: DMat3::from_quat(exponential(angles)),
                    axes: [jacobian.x_axis, jacobian.y_axis, jacobian.z_axis],
                }
            }
            Self::SwingTwist => {
                let swing = swing_of(angles);
                let (rotated, jacobian) = (exponential(swing), exponential_jacobian(swing));
                JointRotation {
                    rotation: DMat3::from_quat(rotated * DQuat::from_rotation_y(angles.y)),
                    axes: [jacobian.x_axis, rotated * DVec3::Y, jacobian.z_axis],
                }
            }
            Self::Euler(order) => {
                let mut after = DQuat::IDENTITY;
                let mut axes = [DVec3::ZERO; 3];
                for &axis in order.iter().rev() {
                    axes[axis] = after * DVec3::AXES[axis];
                    after *= about(axis, angles[axis]);
                }
                JointRotation {
                    rotation: DMat3::from_quat(after),
                    axes,
                }
            }
        }
    }

    /// Lower and upper limits that keep rotation vectors away from the singular length 2π.
    pub fn outer_limits(&self) -> [DVec3; 2] {
        let limit = match self {
            Self::Ball => DVec3::splat(LONGEST_RAD),
            Self::SwingTwist => DVec3::new(LONGEST_RAD, f64::INFINITY, LONGEST_RAD),
            Self::Euler(_) => DVec3::INFINITY,
        };
        [-limit, limit]
    }

    /// Angles of the same rotation, with a rotation vector (of the whole rotation or of the swing) of at most
    /// about π.
    pub fn unwound(&self, angles: DVec3) -> DVec3 {
        let vector = match self {
            Self::Ball => angles,
            Self::SwingTwist => swing_of(angles),
            Self::Euler(_) => return angles,
        };
        let length = vector.length();
        if length <= UNWIND_FROM_RAD {
            return angles;
        }
        let turns = (length / TAU).round();
        angles - vector * (TAU * turns / length)
    }

    /// The angles of a rotation (unit quaternion) that are nearest to `near`.
    pub fn angles(&self, rotation: DQuat, near: DVec3) -> DVec3 {
        match self {
            Self::Ball => {
                let short = logarithm(rotation);
                let length = short.length();
                if length < 1e-9 {
                    return short;
                }
                let other = short * (1.0 - TAU / length);
                nearest([short, other], near)
            }
            Self::SwingTwist => {
                let half = rotation.y.atan2(rotation.w);
                let twist = if rotation.y.hypot(rotation.w) < 1e-12 {
                    near.y
                } else {
                    wrapped(2.0 * half, near.y)
                };
                let swing = logarithm(rotation * DQuat::from_rotation_y(-twist));
                DVec3::new(swing.x, twist, swing.z)
            }
            Self::Euler(order) => euler_angles(*order, rotation, near),
        }
    }
}

fn swing_of(angles: DVec3) -> DVec3 {
    DVec3::new(angles.x, 0.0, angles.z)
}

fn about(axis: usize, angle: f64) -> DQuat {
    DQuat::from_axis_angle(DVec3::AXES[axis], angle)
}

/// `angle` plus the multiple of 2π that brings it nearest to `near`.
fn wrapped(angle: f64, near: f64) -> f64 {
    angle + TAU * ((near - angle) / TAU).round()
}

fn nearest(candidates: [DVec3; 2], near: DVec3) -> DVec3 {
    let [first, second] = candidates;
    if second.distance_squared(near) < first.distance_squared(near) {
        second
    } else {
        first
    }
}

/// Euler angles of a rotation. In gimbal lock, the first angle is that of `near`.
fn euler_angles([first, second, third]: [usize; 3], rotation: DQuat, near: DVec3) -> DVec3 {
    let matrix = DMat3::from_quat(rotation);
    let entry = |row: usize, column: usize| matrix.col(column)[row];
    let sign = if (second + 3 - first) % 3 == 1 { 1.0 } else { -1.0 };
    let across = entry(first, first).hypot(entry(second, first));
    let mut angles = DVec3::ZERO;
    angles[second] = (-sign * entry(third, first)).atan2(across);
    if across < 1e-9 {
        angles[first] = near[first];
        let rest = rotation * about(first, -near[first]) * about(second, -angles[second]);
        let rotated = DMat3::from_quat(rest);
        let (cosine, sine) = (rotated.col(first)[first], rotated.col(first)[second]);
        angles[third] = (sign * sine).atan2(cosine);
    } else {
        angles[first] = (sign * entry(third, second)).atan2(entry(third, third));
        angles[third] = (sign * entry(second, first)).atan2(entry(first, first));
    }
    let mut other = angles;
    other[first] += PI;
    other[second] = PI - angles[second];
    other[third] += PI;
    nearest([angles, other].map(|angles| wrapped_each(angles, near)), near)
}

fn wrapped_each(angles: DVec3, near: DVec3) -> DVec3 {
    DVec3::new(
        wrapped(angles.x, near.x),
        wrapped(angles.y, near.y),
        wrapped(angles.z, near.z),
    )
}
