//! A linkage: joints that hang on each other as a tree, from the body outward, and where they stand at some angles.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::joint::Parameterisation;
use crate::error::require_length;
use crate::error::{Error, Result, require, require_distinct};
use crate::pose::inverse;

/// The multipliers that a joint may have (the thesis' 0.1 to 2.5).
pub const MULTIPLIERS: [f64; 2] = [0.1, 2.5];

/// One joint as it comes from outside.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Its bone's name, for messages.
    pub name: String,
    /// The joint that it hangs on, an earlier one; -1 for one that hangs on nothing that moves.
    pub parent: i64,
    /// Where the bone stands at angles of 0: in the axes of the parent's posed bone, or in armature space without one.
    pub socket: DAffine3,
    /// Whether it turns with its parent; if not, it only moves with it, and the linear part of `socket` is in armature space.
    pub turns_with_parent: bool,
    /// Scale of the bone along its own axes, after its rotation.
    pub scale: DVec3,
    /// What its angles mean.
    pub freedoms: Parameterisation,
    /// Its angles now, rad.
    pub angles: DVec3,
    /// Least angles, rad; minus infinity for none. The same as `upper` where a joint is locked.
    pub lower: DVec3,
    /// Greatest angles, rad.
    pub upper: DVec3,
    /// How eager it is to turn: 1 as any, 0.1 lazy, 2.5 eager.
    pub multiplier: f64,
}

/// Joints as a tree, checked.
#[derive(Debug, Clone)]
pub struct Linkage {
    joints: Vec<Link>,
    names: Vec<String>,
    /// Joint and angle of each freedom: of every angle that is not locked.
    freedoms: Vec<(usize, usize)>,
    size_m: f64,
}

/// A joint within a linkage.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub parent: Option<usize>,
    pub socket: DAffine3,
    pub turns_with_parent: bool,
    pub scale: DMat3,
    pub freedoms: Parameterisation,
    pub start: DVec3,
    pub lower: DVec3,
    pub upper: DVec3,
    pub multiplier: f64,
}

/// Where one joint stands.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Frame {
    /// The place of the joint, armature space.
    pub head: DVec3,
    /// Axes before its own rotation.
    pub before: DMat3,
    /// Axes of the posed bone.
    pub posed: DMat3,
    /// About what it turns as each angle grows, in the axes `before`.
    pub axes: [DVec3; 3],
}

impl Linkage {
    /// A linkage of `joints`, each after the one that it hangs on.
    ///
    /// Angles outside their limits are brought to the nearest limit.
    ///
    /// # Errors
    /// No joint, a name twice, a parent that is no earlier joint, a socket or scale that cannot be inverted, numbers that are
    /// not finite, limits in the wrong order, a multiplier outside 0.1..2.5.
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
        let freedoms = (0..links.len())
            .flat_map(|joint| (0..3).map(move |axis| (joint, axis)))
            .filter(is_free)
            .collect();
        let mut linkage = Self {
            names: joints.into_iter().map(|joint| joint.name).collect(),
            joints: links,
            freedoms,
            size_m: 1.0,
        };
        linkage.size_m = linkage.measured();
        Ok(linkage)
    }

    /// Number of joints.
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// True for a linkage without joints, which there is none of.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// The joints' names, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Joint and angle of each freedom, in order.
    pub fn freedoms(&self) -> &[(usize, usize)] {
        &self.freedoms
    }

    /// The angles at the start, one triple a joint, within their limits.
    pub fn start(&self) -> Vec<DVec3> {
        self.joints.iter().map(|joint| joint.start).collect()
    }

    /// The limits of a joint: its least and its greatest angles.
    pub fn limits(&self, joint: usize) -> [DVec3; 2] {
        [self.joints[joint].lower, self.joints[joint].upper]
    }

    /// The rotation of a joint at some angles.
    pub fn rotation(&self, joint: usize, angles: DVec3) -> DQuat {
        self.joints[joint].freedoms.rotation(angles)
    }

    /// The length from the first joint to the farthest, along the way, m: the unit in which goals are missed.
    pub fn size_m(&self) -> f64 {
        self.size_m
    }

    /// The posed bones at `angles`, armature space.
    ///
    /// # Errors
    /// Another number of angles than joints.
    pub fn posed(&self, angles: &[DVec3]) -> Result<Vec<DAffine3>> {
        require_length("angles", self.len(), "three a joint", angles.len())?;
        let mut frames = vec![Frame::default(); self.len()];
        self.place(angles, &mut frames);
        Ok(frames
            .iter()
            .map(|frame| DAffine3::from_mat3_translation(frame.posed, frame.head))
            .collect())
    }

    pub(super) fn joints(&self) -> &[Link] {
        &self.joints
    }

    /// Where all joints stand at `angles`; allocates nothing.
    pub(super) fn place(&self, angles: &[DVec3], frames: &mut [Frame]) {
        for (index, (joint, &angles)) in self.joints.iter().zip(angles).enumerate() {
            let (before, head) = match joint.parent {
                Some(parent) => {
                    let above = &frames[parent];
                    let head = above.head + above.posed * joint.socket.translation;
                    let linear = joint.socket.matrix3;
                    let turns = joint.turns_with_parent;
                    (if turns { above.posed * linear } else { linear }, head)
                }
                None => (joint.socket.matrix3, joint.socket.translation),
            };
            let turn = joint.freedoms.turn(angles);
            frames[index] = Frame {
                head,
                before,
                posed: before * turn.rotation * joint.scale,
                axes: turn.axes,
            };
        }
    }

    fn measured(&self) -> f64 {
        let mut frames = vec![Frame::default(); self.len()];
        self.place(&self.start(), &mut frames);
        let mut along_m = vec![0.0_f64; self.len()];
        for (index, joint) in self.joints.iter().enumerate() {
            if let Some(parent) = joint.parent {
                along_m[index] = along_m[parent] + frames[index].head.distance(frames[parent].head);
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
    inverse(&joint.socket, || thing("socket"))?;
    inverse(&DAffine3::from_mat3(scale), || thing("scale"))?;
    let [least, greatest] = MULTIPLIERS;
    let fits = joint.multiplier >= least && joint.multiplier <= greatest;
    require(
        fits,
        || thing("multiplier"),
        "a multiplier",
        joint.multiplier,
        "0.1..2.5",
    )?;
    for axis in 0..3 {
        let (found, lower, upper) = (joint.angles[axis], joint.lower[axis], joint.upper[axis]);
        require(
            found.is_finite(),
            || thing("angles"),
            "an angle, rad",
            found,
            "finite",
        )?;
        let ordered = lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
        require(
            ordered,
            || thing("limits"),
            "the lower limit, rad",
            lower,
            "at most the upper",
        )?;
    }
    // vectors near a whole turn are kept out, where that leaves the joint its limits
    let [wall_below, wall_above] = joint.freedoms.walls();
    let (lower, upper) = (joint.lower.max(wall_below), joint.upper.min(wall_above));
    let (lower, upper) = if lower.cmple(upper).all() {
        (lower, upper)
    } else {
        (joint.lower, joint.upper)
    };
    let unwound = joint.freedoms.unwound(joint.angles);
    let is_within = lower.cmple(unwound).all() && unwound.cmple(upper).all();
    let start = if is_within { unwound } else { joint.angles };
    Ok(Link {
        parent,
        socket: joint.socket,
        turns_with_parent: joint.turns_with_parent,
        scale,
        freedoms: joint.freedoms,
        start: start.clamp(lower, upper),
        lower,
        upper,
        multiplier: joint.multiplier,
    })
}
