//! Skinning by bone weights alone, as game engines skin: each vertex goes to `Σ w B x`.
//!
//! It says where such a skin stands, what has to be added to its rest points so that it stands where it should, and (in
//! `fitted`) which weights come nearest to that without anything added.

use glam::{DAffine3, DVec3, Mat3A};
use rayon::prelude::*;

use crate::error::{Result, require_length};
use crate::pose::{ColumnMajor, Palette, Skeleton};
use crate::skin::correction::inverse::invert;
use crate::skin::mesh::bone_weights::{BoneWeight, BoneWeights};
use crate::skin::mesh::rest_mesh::{RestMesh, Spaces, require_rows};

/// A mesh that bones carry by their weights and nothing else.
#[derive(Debug, Clone)]
pub struct LinearSkin {
    pub(crate) skeleton: Skeleton,
    pub(crate) spaces: Spaces,
    /// Rest points, armature space.
    pub(crate) points: Vec<DVec3>,
    pub(crate) weights: BoneWeights,
}

impl LinearSkin {
    /// The skin of `mesh`, whose edges do not count, on `skeleton`.
    ///
    /// # Errors
    /// A mesh without vertices, lists of lengths that do not fit, a bone that is not there, a weight below 0, a matrix that
    /// can't be inverted.
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

    /// False: there is no skin without vertices.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Its bones.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// Where the vertices stand in `pose` once `offsets` are added to their rest points; all in mesh space.
    ///
    /// # Errors
    /// Lists of lengths that do not fit, a matrix that is not affine.
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
                .carry(&palette, vertex)
                .transform_point3(self.points[vertex] + offset);
            *out = armature_to_mesh.transform_point3(moved).as_vec3().to_array();
        });
        Ok(())
    }

    /// What to add to the rest points so that `pose` takes them to `target`; all in mesh space. Returns at how many
    /// vertices that is damped, because bones flatten them there.
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
            let (carry, rest) = (self.carry(&palette, vertex), self.points[vertex]);
            let wanted =
                mesh_to_armature.transform_point3(wide(&target[vertex])) - carry.transform_point3(rest);
            let undone = invert(Mat3A::from(carry.matrix3.as_mat3()), wanted.as_vec3a());
            let offset = armature_to_mesh.transform_vector3(undone.offset.as_dvec3());
            *out = offset.as_vec3().to_array();
            usize::from(undone.is_damped)
        });
        Ok(damped.sum())
    }

    /// What the bones do to a vertex; nothing to one without weights.
    fn carry(&self, palette: &Palette, vertex: usize) -> DAffine3 {
        let own = self.weights.of(vertex);
        if own.is_empty() {
            return DAffine3::IDENTITY;
        }
        let share = |&BoneWeight { bone, weight }: &BoneWeight| {
            let carry = &palette.skinning_matrices()[bone as usize];
            (
                carry.matrix3 * f64::from(weight),
                carry.translation * f64::from(weight),
            )
        };
        let (matrix3, translation) = own
            .iter()
            .map(share)
            .reduce(|(matrix, shift), (next, by)| (matrix + next, shift + by))
            .unwrap_or_default();
        DAffine3 { matrix3, translation }
    }
}

pub(crate) fn wide(point: &[f32; 3]) -> DVec3 {
    DVec3::from_array(point.map(f64::from))
}
