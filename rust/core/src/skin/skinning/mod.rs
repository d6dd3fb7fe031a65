//! Skinning: the motion that bone weights alone give to a mesh (mathematics/skinning.md).

pub(crate) mod displacement;
pub(crate) mod dual_quaternion;
pub(crate) mod dual_quaternion_blend;
pub(crate) mod fit_weights;
pub(crate) mod linear_skin;
pub(crate) mod modifier;
pub(crate) mod posed_modifier;
