//! The Armature modifier in one pose, applied to offsets of the rest mesh: how far an error before it
//! shows after it (mathematics/correction.md, Correction).

use crate::skin::skinning::modifier::BoneMaps;

/// The maps of the Armature modifier in one pose.
#[derive(Debug, Clone)]
pub struct PosedModifier {
    pub(crate) maps: BoneMaps,
    /// Bound of the factor by which an offset is lengthened.
    pub(crate) max_lengthening: f32,
}

impl PosedModifier {
    /// Bound of the factor by which an offset is lengthened.
    pub fn max_lengthening(&self) -> f32 {
        self.max_lengthening
    }
}
