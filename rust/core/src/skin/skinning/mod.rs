//! What bones alone do to a mesh.

pub(crate) mod displacement;
pub(crate) mod dual_quaternion;
pub(crate) mod dual_quaternion_blend;
pub(crate) mod fit_weights;
pub(crate) mod linear_skin;
pub(crate) mod modifier;
pub(crate) mod posed_modifier;
