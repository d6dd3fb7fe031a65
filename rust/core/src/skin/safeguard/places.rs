//! Where each vertex is in a pose, with and without what Sinew does.

use glam::Vec3A;
use rayon::prelude::*;

use crate::parallel::{OUTPUT_CHUNK, OUTPUT_CHUNKS_PER_TASK};

/// The places of all vertices, m, armature space.
#[derive(Debug)]
pub(crate) struct PosedPlaces {
    /// As relaxation leaves them.
    pub relaxed: Vec<Vec3A>,
    /// As the modifier alone leaves them.
    pub modifier: Vec<Vec3A>,
}

impl PosedPlaces {
    pub fn new(vertices: usize) -> Self {
        Self {
            relaxed: vec![Vec3A::ZERO; vertices],
            modifier: vec![Vec3A::ZERO; vertices],
        }
    }

    /// Takes on the places of a pose in the chunks that are `due`; `place_of` gives those of a vertex, relaxed and by the modifier.
    pub fn set(
        &mut self,
        is_due: impl Fn(usize) -> bool + Sync,
        place_of: impl Fn(usize) -> (Vec3A, Vec3A) + Sync,
    ) {
        let chunks = self.relaxed.par_chunks_mut(OUTPUT_CHUNK);
        let chunks = chunks.zip(self.modifier.par_chunks_mut(OUTPUT_CHUNK)).enumerate();
        chunks
            .with_max_len(OUTPUT_CHUNKS_PER_TASK)
            .filter(|(chunk, _)| is_due(*chunk))
            .for_each(|(chunk, (relaxed, modifier))| {
                let own = relaxed.iter_mut().zip(modifier);
                for (vertex, (relaxed, modifier)) in (chunk * OUTPUT_CHUNK..).zip(own) {
                    (*relaxed, *modifier) = place_of(vertex);
                }
            });
    }
}
