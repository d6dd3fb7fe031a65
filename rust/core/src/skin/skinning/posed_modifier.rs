//! What the Armature modifier makes of an offset of a resting vertex, in one pose: how far an error before it shows after it.

use crate::skin::skinning::modifier::BoneMaps;

/// The maps of the Armature modifier in one pose.
#[derive(Debug, Clone)]
pub struct PosedModifier {
    pub(crate) maps: BoneMaps,
    /// What no offset is lengthened by more than.
    pub(crate) max_lengthening: f32,
}

impl PosedModifier {
    /// A factor that no offset is lengthened by more than.
    pub fn max_lengthening(&self) -> f32 {
        self.max_lengthening
    }
}
