//! The bones and carriers that each chunk of the output depends on.

use std::ops::Range;

use fixedbitset::FixedBitSet;

use crate::parallel::OUTPUT_CHUNK;
use crate::skin::binding::anchor::Anchors;
use crate::skin::mesh::bone_weights::BoneWeights;

/// The bones and carriers that each chunk of [`OUTPUT_CHUNK`] vertices depends on.
#[derive(Debug)]
pub(crate) struct ChunkNeeds {
    pub bones: Vec<FixedBitSet>,
    pub carriers: Vec<FixedBitSet>,
}

impl ChunkNeeds {
    pub fn new(bone_weights: &BoneWeights, anchors: &Anchors, bones: usize, carriers: usize) -> Self {
        let chunks = || {
            (0..anchors.len())
                .step_by(OUTPUT_CHUNK)
                .map(|first| first..(first + OUTPUT_CHUNK).min(anchors.len()))
        };
        let bones_of = |vertices: Range<usize>| {
            let mut set = FixedBitSet::with_capacity(bones);
            set.extend(
                vertices
                    .flat_map(|vertex| bone_weights.of(vertex))
                    .map(|entry| entry.bone as usize),
            );
            set
        };
        let carriers_of = |vertices: Range<usize>| {
            let mut set = FixedBitSet::with_capacity(carriers);
            set.extend(
                vertices
                    .flat_map(|vertex| anchors.carriers_of(vertex))
                    .map(|carrier| carrier as usize),
            );
            set
        };
        Self {
            bones: chunks().map(bones_of).collect(),
            carriers: chunks().map(carriers_of).collect(),
        }
    }

    pub fn len(&self) -> usize {
        self.bones.len()
    }
}
