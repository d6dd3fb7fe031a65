//! Goals: the position and orientation that a bone reaches for, and what it looks at (mathematics/reach.md,
//! Nonlinear program).

use glam::{DMat3, DQuat, DVec3};

use super::linkage::{JointPose, Linkage};
use crate::error::{Error, Result, require};
use crate::math::outer::outer;

/// The kinds of target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The point moves here, armature space, m.
    Position(DVec3),
    /// The bone takes this rotation, armature space.
    Orientation(DQuat),
    /// This axis of the bone, starting at the point, points at `target`, armature space, m.
    LookAt {
        /// In the axes of the bone; of any length above 0.
        axis: DVec3,
        /// The point to look at.
        target: DVec3,
    },
}

/// A target of one bone, and its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Index of the joint of the bone.
    pub joint: usize,
    /// A point in the axes of the posed bone, from its head, m.
    pub point: DVec3,
    /// The target.
    pub target: Target,
    /// Weight, 0 or more; 1 is usual.
    pub weight: f64,
}

/// The gradient of the cost by motions of a bone and of everything attached to it, as a wrench about the
/// origin (principle of virtual work).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Wrench {
    /// Sum of `x gᵀ` over points x and of `v gᵀ` over directions v, where g is the gradient of the cost by
    /// each.
    pub moment: DMat3,
    /// Sum of the gradients by points.
    pub force: DVec3,
}

impl Wrench {
    pub fn of_point(point: DVec3, gradient: DVec3) -> Self {
        Self {
            moment: outer(point, gradient),
            force: gradient,
        }
    }

    pub fn of_direction(direction: DVec3, gradient: DVec3) -> Self {
        Self {
            moment: outer(direction, gradient),
            force: DVec3::ZERO,
        }
    }

    /// The torque on a joint, in its axes before its own rotation.
    pub fn torque(&self, pose: &JointPose) -> DVec3 {
        let moment = pose.base.inverse() * (self.moment - outer(pose.head, self.force)) * pose.base;
        DVec3::new(
            moment.z_axis.y - moment.y_axis.z,
            moment.x_axis.z - moment.z_axis.x,
            moment.y_axis.x - moment.x_axis.y,
        )
    }
}

impl std::ops::AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        self.moment += other.moment;
        self.force += other.force;
    }
}

impl Goal {
    /// Checks a goal; `position` is its index in the list of goals.
    ///
    /// # Errors
    /// [`Error::Index`] for a joint that is not in the linkage; [`Error::Value`] for a number that is not
    /// finite, a negative weight, or an axis or rotation of length 0.
    pub fn check(&self, position: usize, linkage: &Linkage) -> Result<()> {
        if self.joint >= linkage.len() {
            return Err(Error::Index {
                list: "goals",
                position,
                found: i64::try_from(self.joint).unwrap_or(i64::MAX),
                limit: linkage.len(),
                of: "joints",
            });
        }
        let thing = || format!("Goal {position}, of joint \"{}\"", linkage.names()[self.joint]);
        let fits = self.weight.is_finite() && self.weight >= 0.0;
        require(fits, thing, "its weight", self.weight, "finite, 0 or more")?;
        let finite =
            |vector: DVec3, quantity| require(vector.is_finite(), thing, quantity, f64::NAN, "finite");
        finite(self.point, "its point")?;
        match self.target {
            Target::Position(target) => finite(target, "its target")?,
            Target::Orientation(rotation) => {
                let length = rotation.length();
                require(
                    length > 1e-6 && length.is_finite(),
                    thing,
                    "the length of its rotation",
                    length,
                    "1",
                )?
            }
            Target::LookAt { axis, target } => {
                finite(target, "its target")?;
                let length = axis.length();
                require(
                    length > 1e-6 && length.is_finite(),
                    thing,
                    "the length of its axis",
                    length,
                    "above 0",
                )?
            }
        };
        Ok(())
    }

    /// The cost of the goal and the wrench on its joint. The cost is the weight times the squared residual,
    /// in lengths of the linkage or in radians.
    pub(super) fn cost_and_wrench(&self, pose: &JointPose, size_m: f64) -> (f64, Wrench) {
        let arm = pose.posed * self.point;
        match self.target {
            Target::Position(target) => {
                let scale = self.weight / (size_m * size_m);
                let residual = pose.head + arm - target;
                let gradient = 2.0 * scale * residual;
                (
                    scale * residual.length_squared(),
                    Wrench::of_point(pose.head + arm, gradient),
                )
            }
            Target::Orientation(rotation) => {
                let wanted = DMat3::from_quat(rotation.normalize());
                let mut total = (0.0, Wrench::default());
                for axis in 0..3 {
                    let along = pose.posed.col(axis);
                    let residual = Heading::of(along).cost(wanted.col(axis), 0.5 * self.weight);
                    total.0 += residual.0;
                    total.1 += Wrench::of_direction(along, residual.1);
                }
                total
            }
            Target::LookAt { axis, target } => {
                let along = pose.posed * axis;
                let eye = pose.head + arm;
                let (heading, sight) = (Heading::of(along), Heading::of(target - eye));
                let (cost, by_heading) = heading.cost(sight.unit, self.weight);
                let (_, by_sight) = sight.cost(heading.unit, self.weight);
                let mut wrench = Wrench::of_direction(along, by_heading);
                wrench += Wrench::of_point(eye, -by_sight);
                (cost, wrench)
            }
        }
    }

    /// The distance from the target: m for a position, rad otherwise.
    pub(super) fn residual(&self, pose: &JointPose) -> f64 {
        let arm = pose.posed * self.point;
        match self.target {
            Target::Position(target) => (pose.head + arm).distance(target),
            Target::Orientation(rotation) => {
                let wanted = DMat3::from_quat(rotation.normalize());
                let squared: f64 = (0..3)
                    .map(|axis| {
                        Heading::of(pose.posed.col(axis))
                            .unit
                            .distance_squared(wanted.col(axis))
                    })
                    .sum();
                2.0 * (squared / 8.0).sqrt().min(1.0).asin()
            }
            Target::LookAt { axis, target } => {
                let sight = target - pose.head - arm;
                let (heading, sight) = (Heading::of(pose.posed * axis), Heading::of(sight));
                2.0 * (0.5 * heading.unit.distance(sight.unit)).min(1.0).asin()
            }
        }
    }
}

/// A unit direction, and the length of the vector that it comes from.
struct Heading {
    unit: DVec3,
    length: f64,
}

impl Heading {
    fn of(vector: DVec3) -> Self {
        let length = vector.length();
        let unit = if length > 1e-12 {
            vector / length
        } else {
            DVec3::ZERO
        };
        Self { unit, length }
    }

    /// `weight |unit - wanted|²`, and its gradient by the vector that the direction comes from.
    fn cost(&self, wanted: DVec3, weight: f64) -> (f64, DVec3) {
        let residual = self.unit - wanted;
        if self.length <= 1e-12 {
            return (weight * residual.length_squared(), DVec3::ZERO);
        }
        let gradient = 2.0 * weight * residual;
        let square = gradient - self.unit * self.unit.dot(gradient);
        (weight * residual.length_squared(), square / self.length)
    }
}
