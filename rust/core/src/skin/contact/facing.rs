//! From when on skin counts as facing other skin.

/// Cosine of two normals below which skin faces skin.
pub(crate) const FACING: f32 = -0.3;
/// How far beyond that skin faces it fully.
pub(crate) const FACING_FADE: f32 = 0.3;
