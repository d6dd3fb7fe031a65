//! Inverse kinematics as a nonlinear program (ALGORITHM 10; Zhao and Badler 1994).

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
pub use joint::{Parameterisation, Turn};
pub use linkage::{Joint, Linkage, MULTIPLIERS};
pub use program::Program;
pub use solve::{ReachOptions, Reached, reach};
