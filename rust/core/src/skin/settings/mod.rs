//! The settings of a skin.

pub(crate) mod bind;
pub(crate) mod elasticity;
pub(crate) mod segments;
