//! The correction before the Armature modifier.

pub(crate) mod inverse;
