//! Inverse kinematics as a nonlinear program (mathematics/reach.md, Nonlinear program; Zhao and Badler 1994).

mod clip;
mod goal;
mod joint;
mod linkage;
mod panoc;
mod program;
mod rotation;
mod solve;

pub use clip::{ClipOptions, reach_clip};
pub use goal::{Goal, Target};
pub use joint::{JointRotation, Parameterisation};
pub use linkage::{EAGERNESS_RANGE, Joint, Linkage};
pub use program::Program;
pub use solve::{ReachOptions, Reached, reach};
