//! What tissues each vertex is anchored to.

pub(crate) mod anchor;
pub(crate) mod bind;
pub(crate) mod influence;
