//! What the vertices of each chunk of the output hang on.

use std::ops::Range;

use fixedbitset::FixedBitSet;

use crate::parallel::OUTPUT_CHUNK;
use crate::skin::binding::influence::Row;
use crate::skin::mesh::bone_weights::BoneWeights;

/// What the vertices of each chunk hang on.
#[derive(Debug)]
pub(crate) struct ChunkNeeds {
    pub bones: Vec<FixedBitSet>,
    pub carriers: Vec<FixedBitSet>,
}

impl ChunkNeeds {
    pub fn new(bone_weights: &BoneWeights, rows: &[Row], bones: usize, carriers: usize) -> Self {
        let chunks = || {
            (0..rows.len())
                .step_by(OUTPUT_CHUNK)
                .map(|first| first..(first + OUTPUT_CHUNK).min(rows.len()))
        };
        let bones_of = |vertices: Range<usize>| {
            let mut found = FixedBitSet::with_capacity(bones);
            found.extend(
                vertices
                    .flat_map(|vertex| bone_weights.of(vertex))
                    .map(|own| own.bone as usize),
            );
            found
        };
        let carriers_of = |vertices: Range<usize>| {
            let mut found = FixedBitSet::with_capacity(carriers);
            found.extend(
                vertices
                    .flat_map(|vertex| rows[vertex].entries())
                    .map(|own| own.carrier as usize),
            );
            found
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
