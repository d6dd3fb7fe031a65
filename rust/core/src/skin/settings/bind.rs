//! Options of a bind: what the Armature modifier does, which tissues vertices are anchored to, and what
//! those take from them.

use crate::error::{Result, require, require_length};
use crate::skin::mesh::regional::Regional;

/// How the mesh's Armature modifier blends bones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Skinning {
    /// Linear blend skinning.
    #[default]
    Linear,
    /// Dual quaternions, as Blender's Preserve Volume.
    PreserveVolume,
    /// The mesh has no Armature modifier.
    None,
}

/// Which tissues a vertex is anchored to (mathematics/binding.md, Influence weights).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Anchoring {
    /// All tissues near it. Weights fall with the distance and are smoothed over the mesh.
    #[default]
    Blended,
    /// The nearest tissue alone (Arabacı 2001).
    Nearest,
}

/// What a vertex takes from bones and tissues (mathematics/binding.md, Motion source).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MotionSource {
    /// Bones move it by the mesh's weights, and muscles add their swelling.
    #[default]
    Swelling,
    /// Tissues move it with their whole motion (Arabacı 2001; Wilhelms 1997).
    Full,
}

/// Options of a bind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinOptions<'a> {
    /// How the mesh's Armature modifier blends bones.
    pub skinning: Skinning,
    /// Fraction of Preserve Volume at each vertex, 0 to 1; the rest is linear. `None`: as `skinning` says.
    /// Blender blends so with two Armature modifiers, of which the second has Multi Modifier on.
    pub preserved_fractions: Option<&'a [f32]>,
    /// Which tissues a vertex is anchored to.
    pub anchoring: Anchoring,
    /// What a vertex takes from bones and tissues.
    pub motion_source: MotionSource,
    /// True: the fat between tissue and skin scales with the tissue (Wilhelms 1997). False: it keeps its
    /// thickness (Arabacı 2001).
    pub scales_fat: bool,
    /// Falloff: distance from a tissue at which its influence reaches 0, m.
    pub falloff_m: f64,
    /// Distance that blurs the border between tissues in the weights, m, above 0.
    pub softness_m: f64,
    /// Factor of the swelling; 1 is true to scale.
    pub muscle_influence: Regional<'a>,
}

impl Default for SkinOptions<'_> {
    fn default() -> Self {
        Self {
            skinning: Skinning::default(),
            preserved_fractions: None,
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
        let (falloff, softness) = (self.falloff_m, self.softness_m);
        require(
            falloff.is_finite() && falloff >= 0.0,
            thing,
            "falloff (m)",
            falloff,
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

    /// Checks the fractions of Preserve Volume of a mesh with this number of vertices.
    pub(crate) fn require_fractions(&self, vertices: usize) -> Result<()> {
        let Some(fractions) = self.preserved_fractions else {
            return Ok(());
        };
        require_length("preserved_fractions", vertices, "one per vertex", fractions.len())?;
        for (vertex, &fraction) in fractions.iter().enumerate() {
            require(
                (0.0..=1.0).contains(&fraction),
                || format!("vertex {vertex}"),
                "preserved_fractions",
                f64::from(fraction),
                "0 to 1",
            )?;
        }
        Ok(())
    }
}
