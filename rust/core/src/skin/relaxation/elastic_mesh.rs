//! The part of a mesh that the relaxation is bound from.

use glam::{DVec3, Vec3A};

use crate::math::rows::Rows;
use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::bone_weights::BoneWeights;

/// The mesh at rest. Vertices have sorted indices; positions are in armature space, m.
pub(crate) struct ElasticMesh<'a> {
    pub points: &'a [DVec3],
    pub edges: &'a Adjacency,
    /// The edges that the energy acts along.
    pub energy_edges: &'a Adjacency,
    pub triangles: &'a [[u32; 3]],
    /// The same, each at its lowest corner.
    pub triangles_from: &'a Rows<[u32; 3]>,
    /// Unit normals at rest; 0 at a vertex without faces.
    pub normals: &'a [Vec3A],
    pub weights: &'a BoneWeights,
    /// The carriers that influence a vertex.
    pub carriers_of: &'a (dyn Fn(usize) -> Vec<u32> + Sync),
}
