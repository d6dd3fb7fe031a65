//! Muscles and other tissues that move skin: their shapes at rest and in a pose.

pub(crate) mod belly_chain;
pub mod joint_axes;
pub mod muscle;
pub(crate) mod muscle_path;
pub mod musculature;
pub(crate) mod path;
pub mod posing;
pub mod shown;
pub mod tissue;
pub(crate) mod wrap;
