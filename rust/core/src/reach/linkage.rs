//! A linkage: the IK chain as a tree of joints, from the body outward, and its poses (mathematics/reach.md,
//! Joints and limits).

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::joint::Parameterisation;
use crate::error::require_length;
use crate::error::{Error, Result, require, require_distinct};
use crate::pose::inverse;

/// The range of eagerness (the thesis has 0.1 to 2.5).
pub const EAGERNESS_RANGE: [f64; 2] = [0.1, 2.5];

/// One joint, as callers describe it.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Name of its bone, for error messages.
    pub name: String,
    /// Index of the parent joint, which must come earlier; -1 for a joint without a parent that moves.
    pub parent: i64,
    /// The bone's axes and head at angles of 0: in the axes of the parent's posed bone, or in armature space
    /// without a parent.
    pub socket: DAffine3,
    /// True if it rotates with its parent. If false, it only moves with the parent, and the linear part of
    /// `socket` is in armature space.
    pub turns_with_parent: bool,
    /// Scale of the bone along its axes, applied before its rotation.
    pub scale: DVec3,
    /// The meaning of its angles.
    pub parameterisation: Parameterisation,
    /// Its angles at the start, rad.
    pub angles: DVec3,
    /// Lower limits, rad; minus infinity for none. Equal to `upper` for a locked angle.
    pub lower: DVec3,
    /// Upper limits, rad; infinity for none.
    pub upper: DVec3,
    /// How much the joint prefers to rotate: 1 is usual, 0.1 reluctant, 2.5 eager.
    pub eagerness: f64,
}

/// A checked tree of joints.
///
/// ```
/// use glam::{DAffine3, DVec3};
/// use sinew_core::reach::{Goal, Joint, Linkage, Parameterisation, Program, ReachOptions, Target, reach};
///
/// # fn main() -> sinew_core::Result<()> {
/// // two bones of 30 cm along y, the second a hinge about x
/// let joint = |name: &str, parent, head_m: f64, parameterisation, limits: [DVec3; 2]| Joint {
///     name: name.to_owned(),
///     parent,
///     socket: DAffine3::from_translation(DVec3::Y * head_m),
///     turns_with_parent: true,
///     scale: DVec3::ONE,
///     parameterisation,
///     angles: DVec3::ZERO,
///     lower: limits[0],
///     upper: limits[1],
///     eagerness: 1.0,
/// };
/// let free = [DVec3::NEG_INFINITY, DVec3::INFINITY];
/// let hinge = [DVec3::ZERO, DVec3::X * 2.5];
/// let linkage = Linkage::new(vec![
///     joint("upper", -1, 0.0, Parameterisation::Ball, free),
///     joint("lower", 0, 0.3, Parameterisation::SwingTwist, hinge),
/// ])?;
///
/// // the end of the second bone reaches for a point 40 cm away
/// let target = Target::Position(DVec3::new(0.0, 0.0, 0.4));
/// let goals = [Goal { joint: 1, point: DVec3::Y * 0.3, target, weight: 1.0 }];
/// let program = Program::new(&linkage, &goals)?;
/// let options = ReachOptions { restarts: 2, ..ReachOptions::default() };
/// let reached = reach(&program, None, &options)?;
/// assert!(reached.residuals[0] < 1e-4);
/// assert!((0.0..=2.5).contains(&reached.angles[1].x));
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Linkage {
    joints: Vec<Link>,
    names: Vec<String>,
    /// Joint and angle (0..3) of each angle that is not locked.
    free_angles: Vec<(usize, usize)>,
    size_m: f64,
}

/// A checked joint.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub parent: Option<usize>,
    pub socket: DAffine3,
    pub turns_with_parent: bool,
    pub scale: DMat3,
    pub parameterisation: Parameterisation,
    pub start: DVec3,
    pub lower: DVec3,
    pub upper: DVec3,
    pub eagerness: f64,
}

/// The pose of one joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct JointPose {
    /// Position of the joint, armature space, m.
    pub head: DVec3,
    /// Axes before its own rotation.
    pub base: DMat3,
    /// Axes of the posed bone.
    pub posed: DMat3,
    /// The axis of rotation for each angle, in the axes `base`.
    pub axes: [DVec3; 3],
}

impl Linkage {
    /// A linkage of `joints`; each comes after its parent. Start angles outside their limits are clamped.
    ///
    /// # Errors
    /// [`Error::NoJoints`]; [`Error::Nameless`] or [`Error::Duplicate`]; [`Error::Index`] for a parent that
    /// is not an earlier joint; [`Error::Singular`] for a socket or scale; [`Error::Value`] for angles,
    /// limits or eagerness.
    pub fn new(joints: Vec<Joint>) -> Result<Self> {
        if joints.is_empty() {
            return Err(Error::NoJoints);
        }
        require_distinct("joint", joints.iter().map(|joint| joint.name.as_str()))?;
        let links = joints
            .iter()
            .enumerate()
            .map(|(position, joint)| link_of(position, joint))
            .collect::<Result<Vec<_>>>()?;
        let is_free = |&(joint, axis): &(usize, usize)| links[joint].lower[axis] < links[joint].upper[axis];
        let free_angles = (0..links.len())
            .flat_map(|joint| (0..3).map(move |axis| (joint, axis)))
            .filter(is_free)
            .collect();
        let mut linkage = Self {
            names: joints.into_iter().map(|joint| joint.name).collect(),
            joints: links,
            free_angles,
            size_m: 1.0,
        };
        linkage.size_m = linkage.reach_m();
        Ok(linkage)
    }

    /// Number of joints.
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// Always false: a linkage has at least one joint.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// The names of the joints, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Joint and angle (0..3) of each angle that is not locked, in order.
    pub fn free_angles(&self) -> &[(usize, usize)] {
        &self.free_angles
    }

    /// The angles at the start, three per joint, rad, within their limits.
    pub fn start(&self) -> Vec<DVec3> {
        self.joints.iter().map(|joint| joint.start).collect()
    }

    /// Lower and upper limits of a joint, rad.
    pub fn limits(&self, joint: usize) -> [DVec3; 2] {
        [self.joints[joint].lower, self.joints[joint].upper]
    }

    /// The rotation of a joint at `angles`.
    pub fn rotation(&self, joint: usize, angles: DVec3) -> DQuat {
        self.joints[joint].parameterisation.rotation(angles)
    }

    /// Length from the first joint to the farthest along the bones, m. Residuals of positions are divided by
    /// it.
    pub fn size_m(&self) -> f64 {
        self.size_m
    }

    /// The posed bones at `angles` (three per joint, rad), armature space, m.
    ///
    /// # Errors
    /// [`Error::Length`] for a number of angles other than the number of joints.
    pub fn posed(&self, angles: &[DVec3]) -> Result<Vec<DAffine3>> {
        require_length("angles", self.len(), "three per joint", angles.len())?;
        let mut poses = vec![JointPose::default(); self.len()];
        self.write_poses(angles, &mut poses);
        Ok(poses
            .iter()
            .map(|pose| DAffine3::from_mat3_translation(pose.posed, pose.head))
            .collect())
    }

    pub(super) fn joints(&self) -> &[Link] {
        &self.joints
    }

    /// Writes the poses of all joints at `angles`, without allocating.
    pub(super) fn write_poses(&self, angles: &[DVec3], poses: &mut [JointPose]) {
        for (index, (joint, &angles)) in self.joints.iter().zip(angles).enumerate() {
            let (base, head) = match joint.parent {
                Some(parent) => {
                    let above = &poses[parent];
                    let head = above.head + above.posed * joint.socket.translation;
                    let linear = joint.socket.matrix3;
                    let turns = joint.turns_with_parent;
                    (if turns { above.posed * linear } else { linear }, head)
                }
                None => (joint.socket.matrix3, joint.socket.translation),
            };
            let rotated = joint.parameterisation.rotation_and_axes(angles);
            poses[index] = JointPose {
                head,
                base,
                posed: base * rotated.rotation * joint.scale,
                axes: rotated.axes,
            };
        }
    }

    fn reach_m(&self) -> f64 {
        let mut poses = vec![JointPose::default(); self.len()];
        self.write_poses(&self.start(), &mut poses);
        let mut along_m = vec![0.0_f64; self.len()];
        for (index, joint) in self.joints.iter().enumerate() {
            if let Some(parent) = joint.parent {
                along_m[index] = along_m[parent] + poses[index].head.distance(poses[parent].head);
            }
        }
        along_m.into_iter().fold(0.0, f64::max)
    }
}

fn link_of(position: usize, joint: &Joint) -> Result<Link> {
    let thing = |what: &str| format!("{what} of joint \"{}\"", joint.name);
    let parent = match usize::try_from(joint.parent) {
        Ok(parent) if parent < position => Some(parent),
        Err(_) if joint.parent == -1 => None,
        _ => {
            return Err(Error::Index {
                list: "parents",
                position,
                found: joint.parent,
                limit: position,
                of: "joints before it, or -1 for none",
            });
        }
    };
    let scale = DMat3::from_diagonal(joint.scale);
    inverse(&joint.socket, || thing("Socket"))?;
    inverse(&DAffine3::from_mat3(scale), || thing("Scale"))?;
    let [least, greatest] = EAGERNESS_RANGE;
    let fits = joint.eagerness >= least && joint.eagerness <= greatest;
    require(
        fits,
        || thing("Eagerness"),
        "its value",
        joint.eagerness,
        "0.1..2.5",
    )?;
    for axis in 0..3 {
        let (found, lower, upper) = (joint.angles[axis], joint.lower[axis], joint.upper[axis]);
        require(
            found.is_finite(),
            || thing("Angles"),
            "an angle, rad",
            found,
            "finite",
        )?;
        let ordered = lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
        require(
            ordered,
            || thing("Limits"),
            "the lower limit, rad",
            lower,
            "at most the upper",
        )?;
    }
    // keep rotation vectors away from a length of 2π, unless the limits of the joint do not allow it
    let [outer_lower, outer_upper] = joint.parameterisation.outer_limits();
    let (lower, upper) = (joint.lower.max(outer_lower), joint.upper.min(outer_upper));
    let (lower, upper) = if lower.cmple(upper).all() {
        (lower, upper)
    } else {
        (joint.lower, joint.upper)
    };
    let unwound = joint.parameterisation.unwound(joint.angles);
    let is_within = lower.cmple(unwound).all() && unwound.cmple(upper).all();
    let start = if is_within { unwound } else { joint.angles };
    Ok(Link {
        parent,
        socket: joint.socket,
        turns_with_parent: joint.turns_with_parent,
        scale,
        parameterisation: joint.parameterisation,
        start: start.clamp(lower, upper),
        lower,
        upper,
        eagerness: joint.eagerness,
    })
}
