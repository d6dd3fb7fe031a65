//! Do no harm: where the relaxed skin of a joint is worse than what the Armature modifier gives in the same pose, the joint returns
//! to the modifier's skin.

pub(crate) mod contact_check;
pub(crate) mod crossing;
pub(crate) mod faults;
pub(crate) mod frame;
pub(crate) mod guard;
pub(crate) mod leaves;
pub(crate) mod places;
