//! Welded vertices whose bone weights differ from those of the vertex that they are welded to. Their correction
//! is computed with their own weights. All others get the correction of that vertex: a correction of their own
//! would differ from it by rounding only, and so move both apart.

use glam::{DVec3, Vec3A};

use crate::skin::mesh::bone_weights::{BoneWeight, BoneWeights};
use crate::skin::mesh::vertex_order::VertexOrder;

/// Largest difference of a weight up to which two vertices move alike.
const ALIKE: f32 = 1e-6;
/// Distance, over the size of the mesh, up to which the modifier moves two vertices to one position.
const TOGETHER_OF_SIZE: f64 = 1e-6;

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
    /// Distance up to which the modifier moves two vertices to one position, m.
    pub together_m: f32,
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
            !are_alike(weights.of(*vertex), weights.of(other))
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
        let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        Self {
            together_m: (TOGETHER_OF_SIZE * (high - low).max_element()) as f32,
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

/// Whether two rows have the same bones in the same order, with weights that hardly differ. Dual quaternions
/// depend on the order.
fn are_alike(one: &[BoneWeight], other: &[BoneWeight]) -> bool {
    let is_alike = |(one, other): (&BoneWeight, &BoneWeight)| {
        one.bone == other.bone && (one.weight - other.weight).abs() <= ALIKE
    };
    one.len() == other.len() && one.iter().zip(other).all(is_alike)
}
