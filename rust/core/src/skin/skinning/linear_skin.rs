//! Linear blend skinning by bone weights alone, as in game engines: each vertex is at `Σ w B x`
//! (mathematics/skinning.md, Linear blend skinning).
//!
//! It computes the skin of a pose, the offsets of the rest positions that move it to a target, and (in
//! `fit_weights`) the weights that come nearest to targets without offsets.

use glam::{DAffine3, DVec3, Mat3A};
use rayon::prelude::*;

use crate::error::{Result, require_length};
use crate::pose::{ColumnMajor, Palette, Skeleton};
use crate::skin::correction::inverse::invert;
use crate::skin::mesh::bone_weights::{BoneWeight, BoneWeights};
use crate::skin::mesh::rest_mesh::{RestMesh, Spaces, require_rows};

/// A mesh that bones move by its weights alone.
#[derive(Debug, Clone)]
pub struct LinearSkin {
    pub(crate) skeleton: Skeleton,
    pub(crate) spaces: Spaces,
    /// Rest positions, armature space, m.
    pub(crate) points: Vec<DVec3>,
    pub(crate) weights: BoneWeights,
}

impl LinearSkin {
    /// The skin of `mesh`, whose edges are ignored, on `skeleton`.
    ///
    /// # Errors
    /// A mesh without vertices, lists whose lengths do not match, a bone that does not exist, a weight
    /// below 0, a matrix that cannot be inverted.
    pub fn new(skeleton: Skeleton, mesh: &RestMesh) -> Result<Self> {
        require_rows(mesh)?;
        let spaces = Spaces::new(mesh.mesh_to_armature)?;
        Ok(Self {
            weights: BoneWeights::new(mesh, skeleton.len())?,
            points: spaces.to_armature(mesh.points),
            skeleton,
            spaces,
        })
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// False, since a skin without vertices is refused.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Its bones.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// Writes the positions of the vertices in `pose`, with `offsets` added to the rest positions, to
    /// `out`. All are (N, 3), mesh space, m.
    ///
    /// # Errors
    /// Lists whose lengths do not match, a matrix that is not affine.
    pub fn deform(&self, pose: &[ColumnMajor], offsets: &[[f32; 3]], out: &mut [[f32; 3]]) -> Result<()> {
        require_length("offsets", self.len(), "one per vertex", offsets.len())?;
        require_length("out", self.len(), "one per vertex", out.len())?;
        let palette = Palette::new(&self.skeleton, pose)?;
        let Spaces {
            mesh_to_armature,
            armature_to_mesh,
        } = self.spaces;
        out.par_iter_mut().enumerate().for_each(|(vertex, out)| {
            let offset = mesh_to_armature.transform_vector3(wide(&offsets[vertex]));
            let moved = self
                .matrix(&palette, vertex)
                .transform_point3(self.points[vertex] + offset);
            *out = armature_to_mesh.transform_point3(moved).as_vec3().to_array();
        });
        Ok(())
    }

    /// Writes the offsets of the rest positions with which `pose` moves the vertices to `target` to
    /// `out`. All are (N, 3), mesh space, m. Returns the number of vertices at which bones are so flat
    /// that the offset is damped or bounded.
    ///
    /// # Errors
    /// As [`LinearSkin::deform`].
    pub fn correct(&self, pose: &[ColumnMajor], target: &[[f32; 3]], out: &mut [[f32; 3]]) -> Result<usize> {
        require_length("target", self.len(), "one per vertex", target.len())?;
        require_length("out", self.len(), "one per vertex", out.len())?;
        let palette = Palette::new(&self.skeleton, pose)?;
        let Spaces {
            mesh_to_armature,
            armature_to_mesh,
        } = self.spaces;
        let damped = out.par_iter_mut().enumerate().map(|(vertex, out)| {
            let (matrix, rest) = (self.matrix(&palette, vertex), self.points[vertex]);
            let wanted =
                mesh_to_armature.transform_point3(wide(&target[vertex])) - matrix.transform_point3(rest);
            let rest_offset = invert(Mat3A::from(matrix.matrix3.as_mat3()), wanted.as_vec3a());
            let offset = armature_to_mesh.transform_vector3(rest_offset.offset.as_dvec3());
            *out = offset.as_vec3().to_array();
            usize::from(rest_offset.is_damped)
        });
        Ok(damped.sum())
    }

    /// The blended matrix of a vertex; the identity for one without weights.
    fn matrix(&self, palette: &Palette, vertex: usize) -> DAffine3 {
        let weights = self.weights.of(vertex);
        if weights.is_empty() {
            return DAffine3::IDENTITY;
        }
        let weighted = |&BoneWeight { bone, weight }: &BoneWeight| {
            let matrix = &palette.skinning_matrices()[bone as usize];
            (
                matrix.matrix3 * f64::from(weight),
                matrix.translation * f64::from(weight),
            )
        };
        let (matrix3, translation) = weights
            .iter()
            .map(weighted)
            .reduce(|(matrix, shift), (next, by)| (matrix + next, shift + by))
            .unwrap_or_default();
        DAffine3 { matrix3, translation }
    }
}

pub(crate) fn wide(point: &[f32; 3]) -> DVec3 {
    DVec3::from_array(point.map(f64::from))
}
