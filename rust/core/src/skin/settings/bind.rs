//! How a mesh is bound: what its modifier does, what its vertices are anchored to, and what that does to them.

use crate::error::{Result, require};
use crate::skin::mesh::regional::Regional;

/// What the mesh's Armature modifier does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Skinning {
    /// Linear blend skinning.
    #[default]
    Linear,
    /// Dual quaternions, as Blender blends them.
    PreserveVolume,
    /// There is no such modifier.
    None,
}

/// Which tissues a vertex is anchored to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Anchoring {
    /// All near ones, the nearer the more, smoothed over the mesh.
    #[default]
    Blended,
    /// The nearest one (thesis).
    Nearest,
}

/// What a tissue does to the skin anchored to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MotionSource {
    /// Adds its change of shape to what the mesh's own weights do.
    #[default]
    Swelling,
    /// Carries the skin with its whole motion (thesis, Wilhelms).
    Full,
}

/// How to bind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinOptions<'a> {
    /// What the mesh's Armature modifier does.
    pub skinning: Skinning,
    /// Which tissues a vertex is anchored to.
    pub anchoring: Anchoring,
    /// What a tissue does to its skin.
    pub motion_source: MotionSource,
    /// True scales the fat between tissue and skin with the tissue (Wilhelms), false keeps its thickness (thesis).
    pub scales_fat: bool,
    /// Distance from a tissue, m, at which its influence has fallen to 0.
    pub falloff_m: f64,
    /// Softness of the blend between tissues, m, above 0.
    pub softness_m: f64,
    /// Factor on the swelling.
    pub muscle_influence: Regional<'a>,
}

impl Default for SkinOptions<'_> {
    fn default() -> Self {
        Self {
            skinning: Skinning::default(),
            anchoring: Anchoring::default(),
            motion_source: MotionSource::default(),
            scales_fat: false,
            falloff_m: 0.03,
            softness_m: 0.004,
            muscle_influence: Regional::default(),
        }
    }
}

impl SkinOptions<'_> {
    pub(crate) fn require_valid(&self) -> Result<()> {
        let thing = || "skin".to_owned();
        let (reach, softness) = (self.falloff_m, self.softness_m);
        require(
            reach.is_finite() && reach >= 0.0,
            thing,
            "reach (m)",
            reach,
            "finite and 0 or more",
        )?;
        require(
            softness.is_finite() && softness > 0.0,
            thing,
            "softness (m)",
            softness,
            "finite and above 0",
        )?;
        Ok(())
    }
}
