//! The nonlinear program of a reach: the cost of a pose and its gradient (mathematics/reach.md, Nonlinear
//! program; Zhao and Badler 1994, sec. 3; the thesis on motion).

use glam::DVec3;

use super::goal::{Goal, Wrench};
use super::linkage::{JointPose, Linkage};
use crate::error::Result;
use crate::math::outer::outer;

/// The cost to minimise: the weighted squared residuals of the goals, as a function of the free angles.
///
/// The unknowns are the free angles over the eagerness of their joints, so that of equally good steps the
/// solver takes those of joints with high eagerness.
#[derive(Debug, Clone)]
pub struct Program<'a> {
    linkage: &'a Linkage,
    goals: &'a [Goal],
    size_m: f64,
}

/// Buffers for evaluations of the cost.
#[derive(Debug, Clone)]
pub(super) struct Workspace {
    angles: Vec<DVec3>,
    poses: Vec<JointPose>,
    wrenches: Vec<Wrench>,
    /// The unknowns to which `angles` and `poses` belong.
    posed_at: Vec<f64>,
}

impl<'a> Program<'a> {
    /// The program of `goals`.
    ///
    /// # Errors
    /// The same as [`Goal::check`].
    pub fn new(linkage: &'a Linkage, goals: &'a [Goal]) -> Result<Self> {
        for (position, goal) in goals.iter().enumerate() {
            goal.check(position, linkage)?;
        }
        // if all joints are in one place, the points of the goals give the size
        let arms = goals.iter().map(|goal| goal.point.length());
        let size_m = linkage.size_m() + arms.fold(0.0, f64::max);
        Ok(Self {
            linkage,
            goals,
            size_m: if size_m > 1e-9 { size_m } else { 1.0 },
        })
    }

    /// The joints.
    pub fn linkage(&self) -> &Linkage {
        self.linkage
    }

    /// The goals.
    pub fn goals(&self) -> &[Goal] {
        self.goals
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.linkage.free_angles().len()
    }

    /// True if every angle is locked.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The unknowns at `angles` (three per joint, rad).
    pub fn unknowns(&self, angles: &[DVec3]) -> Vec<f64> {
        let joints = self.linkage.joints();
        let unknown = |&(joint, axis): &(usize, usize)| angles[joint][axis] / joints[joint].eagerness;
        self.linkage.free_angles().iter().map(unknown).collect()
    }

    /// Lower and upper bounds of the unknowns.
    pub fn bounds(&self) -> [Vec<f64>; 2] {
        let joints = self.linkage.joints();
        let lower = joints.iter().map(|joint| joint.lower).collect::<Vec<_>>();
        let upper = joints.iter().map(|joint| joint.upper).collect::<Vec<_>>();
        [self.unknowns(&lower), self.unknowns(&upper)]
    }

    /// The angles at `unknowns` (three per joint, rad), exactly within their limits.
    pub fn angles(&self, unknowns: &[f64]) -> Vec<DVec3> {
        let mut angles = self.linkage.start();
        self.write_angles(unknowns, &mut angles);
        angles
    }

    /// Replaces rotation vectors longer than about π by the shorter vectors of the same rotations, if the
    /// limits allow. Returns whether any was replaced.
    pub(super) fn unwind(&self, unknowns: &mut [f64]) -> bool {
        let mut angles = self.angles(unknowns);
        let mut any = false;
        for (angles, link) in angles.iter_mut().zip(self.linkage.joints()) {
            let unwound = link.parameterisation.unwound(*angles);
            let fits = link.lower.cmple(unwound).all() && unwound.cmple(link.upper).all();
            if fits && unwound != *angles {
                *angles = unwound;
                any = true;
            }
        }
        if any {
            unknowns.copy_from_slice(&self.unknowns(&angles));
        }
        any
    }

    /// The cost of the goals at `unknowns`; writes its gradient.
    pub fn cost(&self, unknowns: &[f64], gradient: &mut [f64]) -> f64 {
        self.cost_in(&mut self.workspace(), unknowns, Some(gradient))
    }

    /// The residual of each goal at `angles`: m for positions, rad otherwise.
    pub fn residuals(&self, angles: &[DVec3]) -> Vec<f64> {
        let mut poses = vec![JointPose::default(); self.linkage.len()];
        self.linkage.write_poses(angles, &mut poses);
        self.goals
            .iter()
            .map(|goal| goal.residual(&poses[goal.joint]))
            .collect()
    }

    pub(super) fn workspace(&self) -> Workspace {
        Workspace {
            angles: self.linkage.start(),
            poses: vec![JointPose::default(); self.linkage.len()],
            wrenches: vec![Wrench::default(); self.linkage.len()],
            posed_at: vec![],
        }
    }

    /// [`Program::cost`] without allocation.
    pub(super) fn cost_in(
        &self,
        workspace: &mut Workspace,
        unknowns: &[f64],
        gradient: Option<&mut [f64]>,
    ) -> f64 {
        // the solver evaluates cost and gradient at the same point, one after the other
        if workspace.posed_at != unknowns || unknowns.is_empty() {
            self.write_angles(unknowns, &mut workspace.angles);
            self.linkage.write_poses(&workspace.angles, &mut workspace.poses);
            workspace.posed_at.clear();
            workspace.posed_at.extend_from_slice(unknowns);
        }
        workspace.wrenches.fill(Wrench::default());
        let mut cost = 0.0;
        for goal in self.goals {
            let (goal_cost, wrench) = goal.cost_and_wrench(&workspace.poses[goal.joint], self.size_m);
            cost += goal_cost;
            workspace.wrenches[goal.joint] += wrench;
        }
        if let Some(gradient) = gradient {
            self.accumulate_wrenches(workspace);
            self.write_gradient(workspace, gradient);
        }
        cost
    }

    fn write_angles(&self, unknowns: &[f64], angles: &mut [DVec3]) {
        let joints = self.linkage.joints();
        for (&(joint, axis), unknown) in self.linkage.free_angles().iter().zip(unknowns) {
            let link = &joints[joint];
            angles[joint][axis] = (unknown * link.eagerness).clamp(link.lower[axis], link.upper[axis]);
        }
    }

    /// Adds to the wrench on each joint the wrenches on its descendants.
    fn accumulate_wrenches(&self, workspace: &mut Workspace) {
        let joints = self.linkage.joints();
        for index in (0..joints.len()).rev() {
            let Some(parent) = joints[index].parent else {
                continue;
            };
            let mut wrench = workspace.wrenches[index];
            if !joints[index].turns_with_parent {
                // its descendants move with its head only
                wrench.moment = outer(workspace.poses[index].head, wrench.force);
            }
            workspace.wrenches[parent] += wrench;
        }
    }

    fn write_gradient(&self, workspace: &Workspace, gradient: &mut [f64]) {
        let joints = self.linkage.joints();
        let mut torque = (usize::MAX, DVec3::ZERO);
        for (&(joint, axis), entry) in self.linkage.free_angles().iter().zip(gradient) {
            let pose = &workspace.poses[joint];
            if torque.0 != joint {
                torque = (joint, workspace.wrenches[joint].torque(pose));
            }
            *entry = torque.1.dot(pose.axes[axis]) * joints[joint].eagerness;
        }
    }
}
