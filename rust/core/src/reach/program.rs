//! The nonlinear program of a reach: the cost of a pose and its gradient (Zhao and Badler 1994, sec. 3; thesis, motion).

use glam::DVec3;

use super::goal::{Goal, Wrench, outer};
use super::linkage::{Frame, Linkage};
use crate::error::Result;

/// What is minimised: the goals' misses, squared and weighed, over the free angles of a linkage.
///
/// The unknowns are the free angles over their joint's multipliers, so that a step that is as good in any joint is taken by
/// the eager ones.
#[derive(Debug, Clone)]
pub struct Program<'a> {
    linkage: &'a Linkage,
    goals: &'a [Goal],
    size_m: f64,
}

/// Room to compute in.
#[derive(Debug, Clone)]
pub(super) struct Workspace {
    angles: Vec<DVec3>,
    frames: Vec<Frame>,
    pulls: Vec<Wrench>,
    /// The unknowns that `angles` and `frames` are of.
    placed: Vec<f64>,
}

impl<'a> Program<'a> {
    /// The program of some goals.
    ///
    /// # Errors
    /// As [`Goal::check`].
    pub fn new(linkage: &'a Linkage, goals: &'a [Goal]) -> Result<Self> {
        for (position, goal) in goals.iter().enumerate() {
            goal.check(position, linkage)?;
        }
        // where all joints stand in one place their goals' points tell the size
        let arms = goals.iter().map(|goal| goal.point.length());
        let size_m = linkage.size_m() + arms.fold(0.0, f64::max);
        Ok(Self {
            linkage,
            goals,
            size_m: if size_m > 1e-9 { size_m } else { 1.0 },
        })
    }

    /// The linkage.
    pub fn linkage(&self) -> &Linkage {
        self.linkage
    }

    /// The goals.
    pub fn goals(&self) -> &[Goal] {
        self.goals
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.linkage.freedoms().len()
    }

    /// True where every joint is locked.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The unknowns at some angles.
    pub fn unknowns(&self, angles: &[DVec3]) -> Vec<f64> {
        let joints = self.linkage.joints();
        let unknown = |&(joint, axis): &(usize, usize)| angles[joint][axis] / joints[joint].multiplier;
        self.linkage.freedoms().iter().map(unknown).collect()
    }

    /// Least and greatest values of the unknowns.
    pub fn bounds(&self) -> [Vec<f64>; 2] {
        let joints = self.linkage.joints();
        let lower = joints.iter().map(|joint| joint.lower).collect::<Vec<_>>();
        let upper = joints.iter().map(|joint| joint.upper).collect::<Vec<_>>();
        [self.unknowns(&lower), self.unknowns(&upper)]
    }

    /// The angles at `unknowns`, within their limits to the last bit.
    pub fn angles(&self, unknowns: &[f64]) -> Vec<DVec3> {
        let mut angles = self.linkage.start();
        self.write_angles(unknowns, &mut angles);
        angles
    }

    /// Gives rotation vectors that became longer than about half a turn the other name of their rotation, where the limits
    /// allow it; returns whether there were any.
    pub(super) fn unwind(&self, unknowns: &mut [f64]) -> bool {
        let mut angles = self.angles(unknowns);
        let mut any = false;
        for (angles, link) in angles.iter_mut().zip(self.linkage.joints()) {
            let unwound = link.freedoms.unwound(*angles);
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

    /// Cost of the goals at `unknowns`, and its gradient.
    pub fn cost(&self, unknowns: &[f64], gradient: &mut [f64]) -> f64 {
        self.cost_in(&mut self.workspace(), unknowns, Some(gradient))
    }

    /// How far each goal is missed at some angles: m for positions, rad for the others.
    pub fn residuals(&self, angles: &[DVec3]) -> Vec<f64> {
        let mut frames = vec![Frame::default(); self.linkage.len()];
        self.linkage.place(angles, &mut frames);
        self.goals
            .iter()
            .map(|goal| goal.miss(&frames[goal.joint]))
            .collect()
    }

    pub(super) fn workspace(&self) -> Workspace {
        Workspace {
            angles: self.linkage.start(),
            frames: vec![Frame::default(); self.linkage.len()],
            pulls: vec![Wrench::default(); self.linkage.len()],
            placed: vec![],
        }
    }

    /// As [`Program::cost`], allocating nothing.
    pub(super) fn cost_in(
        &self,
        workspace: &mut Workspace,
        unknowns: &[f64],
        gradient: Option<&mut [f64]>,
    ) -> f64 {
        // solvers ask for cost and gradient of one place one after the other
        if workspace.placed != unknowns || unknowns.is_empty() {
            self.write_angles(unknowns, &mut workspace.angles);
            self.linkage.place(&workspace.angles, &mut workspace.frames);
            workspace.placed.clear();
            workspace.placed.extend_from_slice(unknowns);
        }
        workspace.pulls.fill(Wrench::default());
        let mut cost = 0.0;
        for goal in self.goals {
            let (missed, pull) = goal.pull(&workspace.frames[goal.joint], self.size_m);
            cost += missed;
            workspace.pulls[goal.joint] += pull;
        }
        if let Some(gradient) = gradient {
            self.pass_down(workspace);
            self.write_gradient(workspace, gradient);
        }
        cost
    }

    fn write_angles(&self, unknowns: &[f64], angles: &mut [DVec3]) {
        let joints = self.linkage.joints();
        for (&(joint, axis), unknown) in self.linkage.freedoms().iter().zip(unknowns) {
            let link = &joints[joint];
            angles[joint][axis] = (unknown * link.multiplier).clamp(link.lower[axis], link.upper[axis]);
        }
    }

    /// Adds to the pull on each joint that on all that hang on it.
    fn pass_down(&self, workspace: &mut Workspace) {
        let joints = self.linkage.joints();
        for index in (0..joints.len()).rev() {
            let Some(parent) = joints[index].parent else {
                continue;
            };
            let mut pull = workspace.pulls[index];
            if !joints[index].turns_with_parent {
                // whatever hangs on it moves with its head alone
                pull.moment = outer(workspace.frames[index].head, pull.force);
            }
            workspace.pulls[parent] += pull;
        }
    }

    fn write_gradient(&self, workspace: &Workspace, gradient: &mut [f64]) {
        let joints = self.linkage.joints();
        let mut torque = (usize::MAX, DVec3::ZERO);
        for (&(joint, axis), entry) in self.linkage.freedoms().iter().zip(gradient) {
            let frame = &workspace.frames[joint];
            if torque.0 != joint {
                torque = (joint, workspace.pulls[joint].torque(frame));
            }
            *entry = torque.1.dot(frame.axes[axis]) * joints[joint].multiplier;
        }
    }
}
