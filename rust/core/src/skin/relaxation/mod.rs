//! Relaxation of the skin around joints that bend (mathematics/relaxation.md).

pub(crate) mod anchor_springs;
pub(crate) mod arap;
pub(crate) mod crease_plane;
pub(crate) mod edges;
pub(crate) mod elastic;
pub(crate) mod elastic_mesh;
pub(crate) mod frame;
pub(crate) mod islands;
pub(crate) mod joint;
pub(crate) mod rotation_fit;
pub(crate) mod volume;
