//! What the mesh's Armature modifier does to a vertex, as an affine map of its place (ALGORITHM 6).
//!
//! Linear: `Σ w B` of normalised weights. Preserve Volume: blended dual quaternions (L. Kavan et al., "Geometric Skinning
//! with Approximate Dual Quaternion Blending", 2008) as Blender blends them: a bone's scale and shear (what is left of
//! `B` without its rotation, taken from the posed bone with its y axis kept) acts on the vertex before its rotation is
//! blended in. The quaternions' weights do not depend on the vertex, so the map is affine in it, and exact.
//!
//! Maps are kept as displacements, `x -> M x - x`: at rest they vanish to the last bit.

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
}

impl BoneMaps {
    /// The maps of the rest pose.
    pub fn at_rest(skinning: Skinning, bones: usize) -> Self {
        match skinning {
            Skinning::None => Self::None,
            Skinning::Linear => Self::Linear(vec![Displacement::NONE; bones]),
            Skinning::PreserveVolume => {
                Self::PreserveVolume(PreserveVolume::at_rest(bones, BLENDERS_TOLERANCE))
            }
        }
    }

    /// Takes on the pose of the bones that `moved`, allocating nothing.
    pub fn set(&mut self, skeleton: &Skeleton, palette: &Palette, moved: &FixedBitSet) {
        match self {
            Self::None => {}
            Self::Linear(maps) => {
                for bone in moved.ones() {
                    maps[bone] = Displacement::of(&palette.skinning_matrices()[bone]);
                }
            }
            Self::PreserveVolume(maps) => maps.set(skeleton, palette, moved),
        }
    }

    /// What no vector becomes longer than, over its own length; infinite where bones that stretch are blended as dual quaternions.
    pub fn max_lengthening(&self) -> f32 {
        let of_linear = |map: &Displacement| {
            // the Frobenius norm of a matrix is at least its largest stretch
            frobenius_squared(&(map.linear + Mat3A::IDENTITY)).sqrt()
        };
        match self {
            Self::None => 1.0,
            Self::Linear(maps) => maps.iter().map(of_linear).fold(1.0, f32::max),
            Self::PreserveVolume(maps) if maps.any_stretches() => f32::INFINITY,
            Self::PreserveVolume(_) => 1.0,
        }
    }

    /// What the modifier does to a vertex of `weights`, which sum to 1; nothing where there are none.
    pub fn blend(&self, weights: &[BoneWeight]) -> Displacement {
        match self {
            Self::None => Displacement::NONE,
            Self::Linear(maps) => {
                let mut blended = Displacement::NONE;
                for own in weights {
                    let map = &maps[own.bone as usize];
                    blended.linear += map.linear * own.weight;
                    blended.shift += map.shift * own.weight;
                }
                blended
            }
            Self::PreserveVolume(_) if weights.is_empty() => Displacement::NONE,
            Self::PreserveVolume(maps) => maps.displacement(weights),
        }
    }
}
