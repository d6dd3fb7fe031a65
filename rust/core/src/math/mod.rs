//! Mathematics without muscles and skin.

pub(crate) mod aabb;
pub(crate) mod eigen;
pub(crate) mod norm;
pub(crate) mod outer;
pub(crate) mod polar;
pub(crate) mod rows;
pub(crate) mod segment;
pub(crate) mod smoothstep;
pub(crate) mod superposition;
pub(crate) mod union_find;
pub(crate) mod vec3x4;
