//! The safeguard as a stage of a frame: after relaxation, before contact.

use crate::parallel::OUTPUT_CHUNK;
use crate::skin::skin::Skin;
use crate::skin::workspace::Workspace;

impl Skin {
    /// Finds the joints that return to the modifier's skin, and marks the chunks that this changes.
    pub(crate) fn safeguard(&self, frame: &mut Workspace) {
        if frame.dirty.is_nothing() {
            return;
        }
        let (Some(guard), Some(mut guard_frame)) = (&self.guard, frame.guard.take()) else {
            return;
        };
        let mut dirty_chunks = std::mem::take(&mut frame.dirty_chunks);
        let mut positions = frame.positions.take();
        let shared = &*frame;
        let positions_of = |vertex: usize| {
            let modifier_offset = self.modifier_offset(shared, vertex);
            let relaxed = self.relaxed_position(shared, vertex, || modifier_offset);
            (relaxed, self.points[vertex] + modifier_offset)
        };
        if let Some(positions) = &mut positions {
            positions.set(|chunk| self.is_chunk_dirty(shared, chunk), positions_of);
            let elastic = shared.elastic.as_ref();
            let active: Vec<usize> = elastic
                .iter()
                .flat_map(|elastic| elastic.relaxation.moved_joints())
                .collect();
            let axes = elastic.map_or(&[][..], |elastic| elastic.relaxation.anchor_axes());
            guard_frame.compare(guard, &active, axes, positions, &self.bone_weights, |vertex| {
                dirty_chunks[vertex as usize / OUTPUT_CHUNK] = true;
            });
        }
        (frame.dirty_chunks, frame.positions) = (dirty_chunks, positions);
        frame.guard = Some(guard_frame);
    }
}
