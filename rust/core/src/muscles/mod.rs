//! Muscles and all else that carries skin: their shapes, and what a pose does to them.

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
