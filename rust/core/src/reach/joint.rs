//! A joint: what rotations it allows, told by three angles, and how it turns as each of them changes.
//!
//! The angles are chosen so that a joint's limits are a box. Which three they are is its [`Parameterisation`]: an animator's limits
//! come as swing and twist (Blender's IK limits) or as Euler angles (its Limit Rotation), and a joint without limits has
//! neither's singular poses.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};

use super::rotation::{exponential, exponential_jacobian, logarithm};

/// The greatest part of a rotation vector. Vectors a whole turn long turn nothing when they change (Grassia 1998, sec. 3.1), and a
/// solver that comes there stays; within these walls none is so long, and every rotation has a name.
const WALL_RAD: f64 = 3.6;
/// A rotation vector longer than that is better told by the other one of the same rotation. A little over half a turn, so
/// that a joint just there keeps its name.
const UNWOUND_RAD: f64 = 3.3;

/// What a joint's three angles mean, rad. A bone lies along y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameterisation {
    /// A rotation vector: a ball joint without limits.
    Ball,
    /// x and z are the rotation vector of a swing of the bone, after a twist y about it.
    SwingTwist,
    /// Euler angles; the axes (0 x, 1 y, 2 z) in the order in which they turn.
    Euler([usize; 3]),
}

/// The rotation of a joint at some angles.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// The rotation.
    pub rotation: DMat3,
    /// The axis about which it turns as each angle grows, as long as it turns fast; seen from outside.
    pub axes: [DVec3; 3],
}

impl Parameterisation {
    /// The rotation at `angles`.
    pub fn rotation(&self, angles: DVec3) -> DQuat {
        match self {
            Self::Ball => exponential(angles),
            Self::SwingTwist => exponential(swing_of(angles)) * DQuat::from_rotation_y(angles.y),
            Self::Euler(order) => order.iter().fold(DQuat::IDENTITY, |turned, &axis| {
                about(axis, angles[axis]) * turned
            }),
        }
    }

    /// The rotation at `angles`, and how it turns.
    pub fn turn(&self, angles: DVec3) -> Turn {
        match self {
            Self::Ball => {
                let jacobian = exponential_jacobian(angles);
                Turn {
                    rotation: DMat3::from_quat(exponential(angles)),
                    axes: [jacobian.x_axis, jacobian.y_axis, jacobian.z_axis],
                }
            }
            Self::SwingTwist => {
                let swing = swing_of(angles);
                let (turned, jacobian) = (exponential(swing), exponential_jacobian(swing));
                Turn {
                    rotation: DMat3::from_quat(turned * DQuat::from_rotation_y(angles.y)),
                    axes: [jacobian.x_axis, turned * DVec3::Y, jacobian.z_axis],
                }
            }
            Self::Euler(order) => {
                let mut after = DQuat::IDENTITY;
                let mut axes = [DVec3::ZERO; 3];
                for &axis in order.iter().rev() {
                    axes[axis] = after * DVec3::AXES[axis];
                    after *= about(axis, angles[axis]);
                }
                Turn {
                    rotation: DMat3::from_quat(after),
                    axes,
                }
            }
        }
    }

    /// Limits within which the angles never turn nothing.
    pub fn walls(&self) -> [DVec3; 2] {
        let wall = match self {
            Self::Ball => DVec3::splat(WALL_RAD),
            Self::SwingTwist => DVec3::new(WALL_RAD, f64::INFINITY, WALL_RAD),
            Self::Euler(_) => DVec3::INFINITY,
        };
        [-wall, wall]
    }

    /// The same rotation with a rotation vector, of the whole or the swing, of about half a turn at most.
    pub fn unwound(&self, angles: DVec3) -> DVec3 {
        let vector = match self {
            Self::Ball => angles,
            Self::SwingTwist => swing_of(angles),
            Self::Euler(_) => return angles,
        };
        let length = vector.length();
        if length <= UNWOUND_RAD {
            return angles;
        }
        let turns = (length / TAU).round();
        angles - vector * (TAU * turns / length)
    }

    /// The angles of a rotation (unit quaternion): of those that give it, the ones nearest to `near`.
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

/// `angle` and whole turns, as near to `near` as can be.
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

/// Euler angles of a rotation; where the middle axis locks, the first angle stays as `near` has it.
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
        let turned = DMat3::from_quat(rest);
        let (cosine, sine) = (turned.col(first)[first], turned.col(first)[second]);
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
