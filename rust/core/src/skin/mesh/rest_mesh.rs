//! The mesh in the rest pose, as the caller passes it.

use glam::{DAffine3, DVec3};

use crate::error::{Error, Result, require_length};
use crate::pose::{ColumnMajor, affine, inverse};

/// A mesh in the rest pose, as the caller passes it. N is the number of vertices, E of edges, W of
/// weights.
#[derive(Debug, Clone, Copy)]
pub struct RestMesh<'a> {
    /// (N) positions, mesh space, m.
    pub points: &'a [[f32; 3]],
    /// (E) pairs of vertices. Repeated edges and edges from a vertex to itself are ignored.
    pub edges: &'a [[i32; 2]],
    /// Map from mesh space to armature space in the rest pose. It may scale unevenly or mirror.
    pub mesh_to_armature: &'a ColumnMajor,
    /// (N + 1) where the weights of each vertex start; the last entry is W.
    pub weight_offsets: &'a [i32],
    /// (W) the bone of each weight.
    pub weight_bones: &'a [i32],
    /// (W) weights, 0 or more. Those of a vertex need not sum to 1.
    pub weights: &'a [f32],
}

/// The maps between mesh space and armature space, in the rest pose.
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

    /// `points` in armature space.
    pub fn to_armature(self, points: &[[f32; 3]]) -> Vec<DVec3> {
        let wide = |point: &[f32; 3]| DVec3::from_array(point.map(f64::from));
        points
            .iter()
            .map(|point| self.mesh_to_armature.transform_point3(wide(point)))
            .collect()
    }
}

/// Checks that a mesh has vertices, and one row of weights per vertex.
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
