//! The mesh that is bound, and what follows from it at rest.

pub(crate) mod adjacency;
pub(crate) mod aliases;
pub(crate) mod bone_weights;
pub(crate) mod normals;
pub(crate) mod regional;
pub(crate) mod rest_mesh;
pub(crate) mod vertex_order;
pub(crate) mod weld;
