//! Mathematics that knows nothing of muscles and skin.

pub(crate) mod norm;
pub(crate) mod polar;
pub(crate) mod smoothstep;
pub(crate) mod union_find;
pub(crate) mod vec3x4;
