//! Safeguard: a joint whose relaxed skin is worse than the Armature modifier's in the same pose returns to
//! the modifier's skin (mathematics/safeguard.md).

pub(crate) mod contact_check;
pub(crate) mod crossing;
pub(crate) mod faults;
pub(crate) mod frame;
pub(crate) mod guard;
pub(crate) mod posed_positions;
pub(crate) mod stage;
pub(crate) mod triangle_clusters;
