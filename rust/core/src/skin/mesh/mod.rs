//! The mesh in the rest pose and the data derived from it.

pub(crate) mod adjacency;
pub(crate) mod along_skin;
pub(crate) mod bone_weights;
pub(crate) mod normals;
pub(crate) mod regional;
pub(crate) mod rest_mesh;
pub(crate) mod rigid_pieces;
pub(crate) mod vertex_order;
pub(crate) mod weld;
pub(crate) mod welded;
