//! The map of the mesh's Armature modifier at a vertex (mathematics/skinning.md).
//!
//! Linear blend skinning: `Σ w B` with normalised weights. Preserve Volume: dual quaternions (Kavan et
//! al. 2008) blended as in Blender. The scale and shear of a bone act on the vertex before its rotation
//! is blended. The weights of the quaternions do not depend on the position, so the map is affine and
//! exact.
//!
//! A pair of Armature modifiers with Multi Modifier blends both results at each vertex: a fraction of
//! Preserve Volume, and linear for the rest. The blend of two affine maps is affine.
//!
//! Maps are stored as displacements, `x -> M x - x`, which vanish exactly at rest.

use fixedbitset::FixedBitSet;
use glam::Mat3A;

use crate::math::norm::frobenius_squared;
use crate::pose::{Palette, Skeleton};
use crate::skin::mesh::bone_weights::BoneWeight;
use crate::skin::settings::bind::Skinning;
use crate::skin::skinning::displacement::Displacement;
use crate::skin::skinning::dual_quaternion::BLENDERS_TOLERANCE;
use crate::skin::skinning::dual_quaternion_blend::PreserveVolume;

/// The maps of all bones in one pose.
#[derive(Debug, Clone)]
pub(crate) enum BoneMaps {
    None,
    Linear(Vec<Displacement>),
    PreserveVolume(PreserveVolume),
    Both(Vec<Displacement>, PreserveVolume),
}

impl BoneMaps {
    /// The maps of the rest pose. `are_both_blended`: vertices have fractions of both skinnings.
    pub fn at_rest(skinning: Skinning, are_both_blended: bool, bones: usize) -> Self {
        let linear = || vec![Displacement::NONE; bones];
        let preserving = || PreserveVolume::at_rest(bones, BLENDERS_TOLERANCE);
        match skinning {
            Skinning::None => Self::None,
            _ if are_both_blended => Self::Both(linear(), preserving()),
            Skinning::Linear => Self::Linear(linear()),
            Skinning::PreserveVolume => Self::PreserveVolume(preserving()),
        }
    }

    /// Sets the pose of the bones that are `dirty`. Allocates nothing.
    pub fn set(&mut self, skeleton: &Skeleton, palette: &Palette, dirty: &FixedBitSet) {
        match self {
            Self::None => {}
            Self::Linear(maps) => set_linear(maps, palette, dirty),
            Self::PreserveVolume(maps) => maps.set(skeleton, palette, dirty),
            Self::Both(linear, preserving) => {
                set_linear(linear, palette, dirty);
                preserving.set(skeleton, palette, dirty);
            }
        }
    }

    /// Bound of the factor by which any vector is lengthened; infinite if bones that scale or shear are
    /// blended as dual quaternions.
    pub fn max_lengthening(&self) -> f32 {
        let of_linear = |map: &Displacement| {
            // the Frobenius norm of a matrix is at least its largest stretch
            frobenius_squared(&(map.linear + Mat3A::IDENTITY)).sqrt()
        };
        match self {
            Self::None => 1.0,
            Self::PreserveVolume(maps) | Self::Both(_, maps) if maps.any_stretches() => f32::INFINITY,
            Self::Linear(maps) | Self::Both(maps, _) => maps.iter().map(of_linear).fold(1.0, f32::max),
            Self::PreserveVolume(_) => 1.0,
        }
    }

    /// The modifier's map for `weights`, which sum to 1; no displacement without weights. `preserved` is the
    /// fraction of Preserve Volume, 0 to 1, for vertices that have fractions of both skinnings.
    pub fn blend(&self, weights: &[BoneWeight], preserved: f32) -> Displacement {
        match self {
            Self::None => Displacement::NONE,
            Self::Linear(maps) => linear_blend(maps, weights),
            Self::PreserveVolume(_) if weights.is_empty() => Displacement::NONE,
            Self::PreserveVolume(maps) => maps.displacement(weights),
            Self::Both(linear, _) if preserved == 0.0 => linear_blend(linear, weights),
            Self::Both(_, preserving) if preserved == 1.0 => preserving.displacement(weights),
            Self::Both(linear, preserving) => {
                let (one, other) = (linear_blend(linear, weights), preserving.displacement(weights));
                Displacement {
                    linear: one.linear * (1.0 - preserved) + other.linear * preserved,
                    shift: one.shift * (1.0 - preserved) + other.shift * preserved,
                }
            }
        }
    }
}

fn set_linear(maps: &mut [Displacement], palette: &Palette, dirty: &FixedBitSet) {
    for bone in dirty.ones() {
        maps[bone] = Displacement::of(&palette.skinning_matrices()[bone]);
    }
}

fn linear_blend(maps: &[Displacement], weights: &[BoneWeight]) -> Displacement {
    let mut blended = Displacement::NONE;
    for entry in weights {
        let map = &maps[entry.bone as usize];
        blended.linear += map.linear * entry.weight;
        blended.shift += map.shift * entry.weight;
    }
    blended
}
