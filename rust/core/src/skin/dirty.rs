//! Dirty tracking: which inputs of a frame differ from those of the frame before
//! (mathematics/skinning.md, One frame).

use fixedbitset::FixedBitSet;

/// The inputs of a frame that differ from those of the frame before in the same buffers.
#[derive(Debug)]
pub(crate) struct Dirty {
    pub bones: FixedBitSet,
    pub carriers: FixedBitSet,
    pub is_everything: bool,
}

impl Dirty {
    /// Whether no result of an earlier frame can be kept.
    pub fn is_everything(&self) -> bool {
        self.is_everything
    }

    /// Whether no input differs.
    pub fn is_nothing(&self) -> bool {
        !self.is_everything && self.bones.is_clear() && self.carriers.is_clear()
    }

    /// Whether any of some bones or carriers is dirty.
    pub fn any_of(&self, bones: &FixedBitSet, carriers: &FixedBitSet) -> bool {
        self.is_everything || !self.bones.is_disjoint(bones) || !self.carriers.is_disjoint(carriers)
    }
}
