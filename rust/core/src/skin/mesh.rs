//! The rest mesh, and which of its vertices are neighbours.

use glam::{DAffine3, DVec3};

use super::order::Order;
use crate::error::{Error, Result};
use crate::pose::{ColumnMajor, affine, inverse, require_length};

/// A mesh in the rest pose, as it comes from outside.
#[derive(Debug, Clone, Copy)]
pub struct RestMesh<'a> {
    /// Vertices in mesh space.
    pub points: &'a [[f32; 3]],
    /// Pairs of vertices; doubled edges and edges from a vertex to itself count for nothing.
    pub edges: &'a [[i32; 2]],
    /// Mesh space to armature space in the rest pose; may scale unevenly or mirror.
    pub mesh_to_armature: &'a ColumnMajor,
    /// Where the weights of each vertex start; one more than vertices, the last is the number of weights.
    pub weight_offsets: &'a [i32],
    /// The bone of each weight.
    pub weight_bones: &'a [i32],
    /// The weights, 0 or more; a vertex's need not sum to 1.
    pub weights: &'a [f32],
}

/// Mesh space and armature space, in the rest pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spaces {
    pub mesh_to_armature: DAffine3,
    pub armature_to_mesh: DAffine3,
}

impl Spaces {
    pub fn new(mesh_to_armature: &ColumnMajor) -> Result<Self> {
        let thing = || "mesh_to_armature".to_owned();
        let mesh_to_armature = affine(mesh_to_armature, thing)?;
        Ok(Self {
            mesh_to_armature,
            armature_to_mesh: inverse(&mesh_to_armature, thing)?,
        })
    }

    /// `points` of the mesh in armature space.
    pub fn to_armature(self, points: &[[f32; 3]]) -> Vec<DVec3> {
        let wide = |point: &[f32; 3]| DVec3::from_array(point.map(f64::from));
        points
            .iter()
            .map(|point| self.mesh_to_armature.transform_point3(wide(point)))
            .collect()
    }
}

/// The neighbours of each vertex, rising, in compressed rows; all by their numbers in a skin's order.
#[derive(Debug, Clone)]
pub(super) struct Adjacency {
    offsets: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Adjacency {
    /// The neighbours along `edges` of a mesh whose vertices are numbered by `order`.
    ///
    /// # Errors
    /// [`Error::Index`] for an edge to a vertex that is not there.
    pub fn new(order: &Order, edges: &[[i32; 2]]) -> Result<Self> {
        let vertices = order.len();
        let mut pairs = Vec::with_capacity(2 * edges.len());
        for (edge, ends) in edges.iter().enumerate() {
            let [a, b] = [
                vertex("edges", edge, ends[0], vertices)?,
                vertex("edges", edge, ends[1], vertices)?,
            ];
            if a != b {
                let [a, b] = [order.number(a), order.number(b)];
                pairs.extend([(a, b), (b, a)]);
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut offsets = vec![0; vertices + 1];
        for &(from, _) in &pairs {
            offsets[from as usize + 1] += 1;
        }
        for row in 0..vertices {
            offsets[row + 1] += offsets[row];
        }
        Ok(Self {
            offsets,
            neighbours: pairs.into_iter().map(|(_, to)| to).collect(),
        })
    }

    pub fn neighbours(&self, vertex: usize) -> &[u32] {
        &self.neighbours[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}

/// `triangles` as places in a list of `vertices`.
pub(crate) fn require_triangles(triangles: &[[i32; 3]], vertices: usize) -> Result<Vec<[u32; 3]>> {
    let checked = triangles.iter().enumerate().map(|(position, &[a, b, c])| {
        let corner = |found| vertex("triangles", position, found, vertices);
        Ok([corner(a)?, corner(b)?, corner(c)?])
    });
    checked.collect()
}

fn vertex(list: &'static str, position: usize, found: i32, limit: usize) -> Result<u32> {
    match u32::try_from(found) {
        Ok(index) if (index as usize) < limit => Ok(index),
        _ => Err(Error::Index {
            list,
            position,
            found: found.into(),
            limit,
            of: "vertices",
        }),
    }
}

/// Checks that a mesh has vertices and one weight row for each.
pub(super) fn require_rows(mesh: &RestMesh) -> Result<()> {
    if mesh.points.is_empty() {
        return Err(Error::NoVertices);
    }
    let rows = mesh.points.len() + 1;
    require_length(
        "weight_offsets",
        rows,
        "one a vertex and one more",
        mesh.weight_offsets.len(),
    )?;
    require_length(
        "weights",
        mesh.weight_bones.len(),
        "one a weight_bones entry",
        mesh.weights.len(),
    )
}
