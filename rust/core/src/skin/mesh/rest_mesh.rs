//! The rest mesh.

use glam::{DAffine3, DVec3};

use crate::error::{Error, Result, require_length};
use crate::pose::{ColumnMajor, affine, inverse};

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
pub(crate) struct Spaces {
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

/// Checks that a mesh has vertices and one weight row for each.
pub(crate) fn require_rows(mesh: &RestMesh) -> Result<()> {
    if mesh.points.is_empty() {
        return Err(Error::NoVertices);
    }
    let rows = mesh.points.len() + 1;
    require_length(
        "weight_offsets",
        rows,
        "one per vertex and one more",
        mesh.weight_offsets.len(),
    )?;
    require_length(
        "weights",
        mesh.weight_bones.len(),
        "one per weight_bones entry",
        mesh.weights.len(),
    )
}
