//! The angle from which skin faces other skin.

/// Cosine of two normals below which skin faces skin. Somewhat below 0: skin that is perpendicular to
/// other skin is beside it.
pub(crate) const FACING: f32 = -0.3;
/// Difference of the cosine below [`FACING`] over which contact fades in.
pub(crate) const FACING_FADE: f32 = 0.3;
