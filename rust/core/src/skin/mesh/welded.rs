//! Welded vertices whose bone weights or rest position differ slightly from those of the vertex that they
//! are welded to. Their correction is computed with their own weights.

use glam::{DVec3, Vec3A};

use crate::skin::mesh::bone_weights::{BoneWeight, BoneWeights};
use crate::skin::mesh::vertex_order::VertexOrder;

/// A vertex that is welded to another one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WeldedVertex {
    /// Its mesh index.
    pub vertex: u32,
    /// The sorted index of the vertex that it is welded to.
    pub sorted_index: u32,
    /// Its rest position in mesh space, and in armature space, m.
    pub mesh_point: Vec3A,
    pub point: Vec3A,
}

/// The welded vertices of a mesh, by rising mesh index.
#[derive(Debug)]
pub(crate) struct WeldedVertices {
    all: Vec<WeldedVertex>,
    weights: BoneWeights,
}

impl WeldedVertices {
    /// The welded vertices of a mesh with rest positions `mesh_points` (mesh space) and `points` (armature
    /// space, m).
    pub fn new(
        order: &VertexOrder,
        mesh_points: &[[f32; 3]],
        points: &[DVec3],
        weights: &BoneWeights,
    ) -> Self {
        let representative = |vertex: usize| order.representative(vertex);
        let differs = |vertex: &usize| {
            let other = representative(*vertex);
            mesh_points[*vertex] != mesh_points[other] || !are_same(weights.of(*vertex), weights.of(other))
        };
        let vertices: Vec<usize> = (0..points.len())
            .filter(|&vertex| representative(vertex) != vertex)
            .filter(differs)
            .collect();
        let welded = |&vertex: &usize| WeldedVertex {
            vertex: vertex as u32,
            sorted_index: order.sorted_index(vertex as u32),
            mesh_point: Vec3A::from_array(mesh_points[vertex]),
            point: points[vertex].as_vec3a(),
        };
        Self {
            all: vertices.iter().map(welded).collect(),
            weights: weights.of_vertices(vertices.into_iter()),
        }
    }

    /// The welded vertices, each with its bone weights.
    pub fn iter(&self) -> impl Iterator<Item = (&WeldedVertex, &[BoneWeight])> {
        let rows = (0..self.all.len()).map(|row| self.weights.of(row));
        self.all.iter().zip(rows)
    }

    /// The bone weights of a vertex by mesh index; `None` if it is not in this list.
    pub fn of_vertex(&self, vertex: usize) -> Option<&[BoneWeight]> {
        let row = self
            .all
            .binary_search_by_key(&(vertex as u32), |welded| welded.vertex);
        row.ok().map(|row| self.weights.of(row))
    }
}

/// Whether two rows of weights have the same bits.
fn are_same(one: &[BoneWeight], other: &[BoneWeight]) -> bool {
    let key = |entry: &BoneWeight| (entry.bone, entry.weight.to_bits());
    one.iter().map(key).eq(other.iter().map(key))
}
