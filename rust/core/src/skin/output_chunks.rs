//! The output of a frame in chunks: which differ from the frame before, and writing those.

use rayon::prelude::*;

use crate::parallel::{OUTPUT_CHUNK, OUTPUT_CHUNKS_PER_TASK};
use crate::skin::contact::frame::ContactFrame;

/// Marks the chunks in which `contact` shifts a vertex as dirty.
pub(crate) fn mark_shifted(dirty_chunks: &mut [bool], contact: Option<&ContactFrame>) {
    for &vertex in contact.iter().flat_map(|contact| &contact.shifted) {
        dirty_chunks[vertex as usize / OUTPUT_CHUNK] = true;
    }
}

/// Calls `write` for the dirty chunks of the output, and stores the number of damped vertices that it
/// returns.
pub(crate) fn write_chunks(
    output: &mut [[f32; 3]],
    damped: &mut [usize],
    is_dirty: impl Fn(usize) -> bool + Sync,
    write: impl Fn(usize, &mut [[f32; 3]]) -> usize + Sync,
) {
    let chunks = output.par_chunks_mut(OUTPUT_CHUNK).zip(damped).enumerate();
    let chunks = chunks.with_max_len(OUTPUT_CHUNKS_PER_TASK);
    chunks
        .filter(|(chunk, _)| is_dirty(*chunk))
        .for_each(|(chunk, (entries, damped))| {
            *damped = write(chunk * OUTPUT_CHUNK, entries);
        });
}
