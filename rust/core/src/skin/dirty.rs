//! Which inputs of a frame differ from those of the frame before it.

use fixedbitset::FixedBitSet;

/// Which inputs of a frame differ from those of the frame before it in the same buffers.
#[derive(Debug)]
pub(crate) struct Dirty {
    pub bones: FixedBitSet,
    pub carriers: FixedBitSet,
    pub is_everything: bool,
}

impl Dirty {
    /// True where nothing of an earlier frame holds.
    pub fn is_everything(&self) -> bool {
        self.is_everything
    }

    /// True where nothing moved at all.
    pub fn is_nothing(&self) -> bool {
        !self.is_everything && self.bones.is_clear() && self.carriers.is_clear()
    }

    /// Whether any of some bones or carriers moved.
    pub fn any_of(&self, bones: &FixedBitSet, carriers: &FixedBitSet) -> bool {
        self.is_everything || !self.bones.is_disjoint(bones) || !self.carriers.is_disjoint(carriers)
    }
}
