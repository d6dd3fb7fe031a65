//! Binding: the anchors of vertices on tissues, from the rest pose (mathematics/binding.md).

pub(crate) mod anchor;
pub(crate) mod bind;
pub(crate) mod influence;
pub(crate) mod muscle_stack;
