//! The mesh as the elastic skin needs it.

use glam::{DVec3, Vec3A};

use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::bone_weights::BoneWeights;

/// The mesh as the elastic skin needs it.
pub(crate) struct ElasticMesh<'a> {
    pub points: &'a [DVec3],
    pub edges: &'a Adjacency,
    /// What springs lie along.
    pub energy_edges: &'a Adjacency,
    pub triangles: &'a [[u32; 3]],
    /// Unit normals, 0 where a vertex has no face.
    pub normals: &'a [Vec3A],
    pub weights: &'a BoneWeights,
    /// The carriers that move each vertex.
    pub carriers_of: &'a (dyn Fn(usize) -> Vec<u32> + Sync),
}
