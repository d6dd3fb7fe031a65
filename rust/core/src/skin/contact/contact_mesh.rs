//! The part of a mesh that contact is bound from.

use glam::DVec3;

use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::vertex_order;
use crate::skin::settings::segments::Segments;

/// The mesh at rest. Vertices have sorted indices; positions are in armature space, m.
pub(crate) struct ContactMesh<'a> {
    pub points: &'a [DVec3],
    pub edges: &'a Adjacency,
    pub triangles: &'a [[u32; 3]],
    pub weights: &'a BoneWeights,
    pub segments: &'a Segments<'a>,
    pub clusters: &'a [vertex_order::Cluster],
}
