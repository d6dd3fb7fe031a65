//! The position of each vertex in a pose, relaxed and by the Armature modifier alone.

use glam::Vec3A;
use rayon::prelude::*;

use crate::parallel::{OUTPUT_CHUNK, OUTPUT_CHUNKS_PER_TASK};

/// The positions of all vertices, m, armature space.
#[derive(Debug)]
pub(crate) struct PosedPositions {
    /// After relaxation.
    pub relaxed: Vec<Vec3A>,
    /// After the modifier alone.
    pub modifier: Vec<Vec3A>,
}

impl PosedPositions {
    pub fn new(vertices: usize) -> Self {
        Self {
            relaxed: vec![Vec3A::ZERO; vertices],
            modifier: vec![Vec3A::ZERO; vertices],
        }
    }

    /// Sets the positions in the dirty chunks. `positions_of` gives those of a vertex: relaxed, and by the
    /// modifier.
    pub fn set(
        &mut self,
        is_dirty: impl Fn(usize) -> bool + Sync,
        positions_of: impl Fn(usize) -> (Vec3A, Vec3A) + Sync,
    ) {
        let chunks = self.relaxed.par_chunks_mut(OUTPUT_CHUNK);
        let chunks = chunks.zip(self.modifier.par_chunks_mut(OUTPUT_CHUNK)).enumerate();
        chunks
            .with_max_len(OUTPUT_CHUNKS_PER_TASK)
            .filter(|(chunk, _)| is_dirty(*chunk))
            .for_each(|(chunk, (relaxed, modifier))| {
                let entries = relaxed.iter_mut().zip(modifier);
                for (vertex, (relaxed, modifier)) in (chunk * OUTPUT_CHUNK..).zip(entries) {
                    (*relaxed, *modifier) = positions_of(vertex);
                }
            });
    }
}
