//! The safeguard: where the skin of a joint would be worse than the Armature modifier's, it returns to the
//! modifier's (mathematics/safeguard.md).
//!
//! Each joint is compared with the modifier in sampled rotations, once, when a pose first comes near them. A
//! frame only reads the results, so the skin depends on the bind and the pose alone.

mod both_skins;
mod faults;
pub(crate) mod frame;
pub(crate) mod guard;
mod rest_skin;
mod sampled_rotations;
pub(crate) mod sampler;
mod sampling;
mod touching;
