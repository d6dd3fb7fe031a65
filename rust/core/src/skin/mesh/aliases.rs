//! The mesh's vertices that are welded to another and whose own weights or place differ from it a little: where the welded vertex
//! comes to lie has to be undone through their own weights.

use glam::{DVec3, Vec3A};

use crate::skin::mesh::bone_weights::{BoneWeight, BoneWeights};
use crate::skin::mesh::vertex_order::VertexOrder;

/// A vertex of the mesh that is welded to another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Alias {
    /// The mesh's vertex.
    pub vertex: u32,
    /// The number of the vertex that it is welded to.
    pub number: u32,
    /// Its own place at rest, mesh space and armature space, m.
    pub mesh_point: Vec3A,
    pub point: Vec3A,
}

/// All of them, rising.
#[derive(Debug)]
pub(crate) struct Aliases {
    all: Vec<Alias>,
    weights: BoneWeights,
}

impl Aliases {
    /// The aliases of a mesh whose vertices are at `mesh_points`, `points` in armature space, with these weights.
    pub fn new(
        order: &VertexOrder,
        mesh_points: &[[f32; 3]],
        points: &[DVec3],
        weights: &BoneWeights,
    ) -> Self {
        let first = |vertex: usize| order.representative(vertex);
        let differs = |vertex: &usize| {
            let other = first(*vertex);
            mesh_points[*vertex] != mesh_points[other] || !are_same(weights.of(*vertex), weights.of(other))
        };
        let vertices: Vec<usize> = (0..points.len())
            .filter(|&vertex| first(vertex) != vertex)
            .filter(differs)
            .collect();
        let alias = |&vertex: &usize| Alias {
            vertex: vertex as u32,
            number: order.sorted_index(vertex as u32),
            mesh_point: Vec3A::from_array(mesh_points[vertex]),
            point: points[vertex].as_vec3a(),
        };
        Self {
            all: vertices.iter().map(alias).collect(),
            weights: weights.of_vertices(vertices.into_iter()),
        }
    }

    /// The aliases, each with its own weights.
    pub fn iter(&self) -> impl Iterator<Item = (&Alias, &[BoneWeight])> {
        let rows = (0..self.all.len()).map(|row| self.weights.of(row));
        self.all.iter().zip(rows)
    }

    /// The own weights of one of the mesh's vertices, where it is an alias.
    pub fn of_vertex(&self, vertex: usize) -> Option<&[BoneWeight]> {
        let found = self
            .all
            .binary_search_by_key(&(vertex as u32), |alias| alias.vertex);
        found.ok().map(|row| self.weights.of(row))
    }
}

/// Whether two rows of weights are the same to the bit.
fn are_same(one: &[BoneWeight], other: &[BoneWeight]) -> bool {
    let key = |own: &BoneWeight| (own.bone, own.weight.to_bits());
    one.iter().map(key).eq(other.iter().map(key))
}
