//! Goals: where a point of a bone shall be, how the bone shall be turned, what it shall look at.

use glam::{DMat3, DQuat, DVec3};

use super::linkage::{Frame, Linkage};
use crate::error::{Error, Result, require};

/// What is wished of a bone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The point shall be here, armature space, m.
    Position(DVec3),
    /// The bone's axes shall have this rotation, armature space.
    Orientation(DQuat),
    /// This axis of the bone, from the point on, shall point at `target`, armature space, m.
    LookAt {
        /// In the bone's axes; need not be of unit length.
        axis: DVec3,
        /// What it looks at.
        target: DVec3,
    },
}

/// A wish of one bone, and how much it counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// The joint whose bone it is.
    pub joint: usize,
    /// A point in the axes of the posed bone, from its head, m.
    pub point: DVec3,
    /// What is wished.
    pub wish: Target,
    /// Its weight; 1 as any, 0 for none.
    pub weight: f64,
}

/// The pull of goals on a bone and all that hangs on it, told as a wrench about the origin (virtual work): whatever small
/// motion the bone makes, these sums give by how much the cost grows.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Wrench {
    /// Sum of `x gᵀ` over points x, and of `v gᵀ` over directions v; g is the cost's gradient by each.
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

    /// The torque on a joint of all that it carries, in its axes before its own rotation.
    pub fn torque(&self, frame: &Frame) -> DVec3 {
        let moment = frame.before.inverse() * (self.moment - outer(frame.head, self.force)) * frame.before;
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

/// `a bᵀ`.
pub(super) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

impl Goal {
    /// Checks a goal against the linkage that it is for.
    ///
    /// # Errors
    /// A joint that is none, numbers that are not finite, a weight below 0, an axis or rotation of no length.
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
        let thing = || format!("goal {position}, of joint \"{}\"", linkage.names()[self.joint]);
        let fits = self.weight.is_finite() && self.weight >= 0.0;
        require(fits, thing, "its weight", self.weight, "finite, 0 or more")?;
        let finite =
            |vector: DVec3, quantity| require(vector.is_finite(), thing, quantity, f64::NAN, "finite");
        finite(self.point, "its point")?;
        match self.wish {
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

    /// Its cost, and the pull on its joint: weight times the squared miss, in lengths of the linkage or in radians.
    pub(super) fn pull(&self, frame: &Frame, size_m: f64) -> (f64, Wrench) {
        let arm = frame.posed * self.point;
        match self.wish {
            Target::Position(target) => {
                let scale = self.weight / (size_m * size_m);
                let miss = frame.head + arm - target;
                let gradient = 2.0 * scale * miss;
                (
                    scale * miss.length_squared(),
                    Wrench::of_point(frame.head + arm, gradient),
                )
            }
            Target::Orientation(rotation) => {
                let due = DMat3::from_quat(rotation.normalize());
                let mut total = (0.0, Wrench::default());
                for axis in 0..3 {
                    let along = frame.posed.col(axis);
                    let miss = Heading::of(along).missed(due.col(axis), 0.5 * self.weight);
                    total.0 += miss.0;
                    total.1 += Wrench::of_direction(along, miss.1);
                }
                total
            }
            Target::LookAt { axis, target } => {
                let along = frame.posed * axis;
                let eye = frame.head + arm;
                let (heading, sight) = (Heading::of(along), Heading::of(target - eye));
                let (cost, by_heading) = heading.missed(sight.unit, self.weight);
                let (_, by_sight) = sight.missed(heading.unit, self.weight);
                let mut pull = Wrench::of_direction(along, by_heading);
                pull += Wrench::of_point(eye, -by_sight);
                (cost, pull)
            }
        }
    }

    /// How far its bone is from it: m for a position, rad for the others.
    pub(super) fn miss(&self, frame: &Frame) -> f64 {
        let arm = frame.posed * self.point;
        match self.wish {
            Target::Position(target) => (frame.head + arm).distance(target),
            Target::Orientation(rotation) => {
                let due = DMat3::from_quat(rotation.normalize());
                let squared: f64 = (0..3)
                    .map(|axis| {
                        Heading::of(frame.posed.col(axis))
                            .unit
                            .distance_squared(due.col(axis))
                    })
                    .sum();
                2.0 * (squared / 8.0).sqrt().min(1.0).asin()
            }
            Target::LookAt { axis, target } => {
                let sight = target - frame.head - arm;
                let (heading, sight) = (Heading::of(frame.posed * axis), Heading::of(sight));
                2.0 * (0.5 * heading.unit.distance(sight.unit)).min(1.0).asin()
            }
        }
    }
}

/// A direction, and the length that it was told by.
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

    /// `weight |unit - due|²`, and its gradient by the vector that the direction was told by.
    fn missed(&self, due: DVec3, weight: f64) -> (f64, DVec3) {
        let miss = self.unit - due;
        if self.length <= 1e-12 {
            return (weight * miss.length_squared(), DVec3::ZERO);
        }
        let gradient = 2.0 * weight * miss;
        let square = gradient - self.unit * self.unit.dot(gradient);
        (weight * miss.length_squared(), square / self.length)
    }
}
