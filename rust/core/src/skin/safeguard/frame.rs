//! The safeguard of one frame: what is known of each joint in its rotation, and how far each vertex returns.

use glam::DQuat;

use crate::pose::Palette;
use crate::skin::dirty::Dirty;
use crate::skin::safeguard::guard::Guard;
use crate::skin::safeguard::sampled_rotations::{Counted, MOST_COUNTED, counted};

/// Fraction of Sinew's skin below which a vertex keeps nothing. Rounding of a weight must not leave an offset:
/// without one the vertex is where the modifier puts it, to the bit.
const NOTHING: f32 = 1e-4;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct GuardFrame {
    /// The samples that count for each guarded bone.
    counted: Vec<Vec<Counted>>,
    /// Whether any of them differs from the frame before.
    is_changed: bool,
    /// Factor of the strength of the crease plane at the head of each bone, 0 to 1.
    crease_factors: Vec<f32>,
    /// How much of Sinew's skin each vertex keeps, 0 to 1, and in the frame before.
    kept: Vec<f32>,
    kept_before: Vec<f32>,
    /// The vertices that do not keep all, and those of the frame before.
    returned: Vec<u32>,
    returned_before: Vec<u32>,
}

impl GuardFrame {
    pub fn new(guard: &Guard, vertices: usize, bones: usize) -> Self {
        Self {
            counted: guard
                .bones
                .iter()
                .map(|_| Vec::with_capacity(MOST_COUNTED))
                .collect(),
            is_changed: true,
            crease_factors: vec![1.0; bones],
            kept: vec![1.0; vertices],
            kept_before: vec![1.0; vertices],
            returned: vec![],
            returned_before: vec![],
        }
    }

    /// How much of Sinew's skin a vertex keeps, 0 to 1; the rest is the modifier's skin.
    pub fn kept(&self, vertex: usize) -> f32 {
        self.kept[vertex]
    }

    /// Finds the samples that count in a pose. Returns whether they differ from the frame before.
    pub fn find_counted(&mut self, guard: &Guard, palette: &Palette, dirty: &Dirty) -> bool {
        self.is_changed = dirty.is_everything();
        for (bone, entries) in guard.bones.iter().zip(&mut self.counted) {
            let is_dirty = |bone: usize| dirty.bones.contains(bone);
            if !(dirty.is_everything() || is_dirty(bone.bone) || is_dirty(bone.parent)) {
                continue;
            }
            let (mut known, mut is_same) = (0, true);
            let rotation: DQuat = bone.rotation(palette);
            counted(rotation, |entry| {
                if known < entries.len() {
                    is_same &= entries[known] == entry;
                    entries[known] = entry;
                } else {
                    is_same = false;
                    entries.push(entry);
                }
                known += 1;
            });
            is_same &= known == entries.len();
            entries.truncate(known);
            self.is_changed |= !is_same;
        }
        self.is_changed
    }

    /// The samples that count and are not known, as index of the guarded bone and sample.
    pub fn missing(&self, guard: &Guard) -> Vec<(usize, u32)> {
        let all = self.counted.iter().enumerate();
        let all = all.flat_map(|(index, entries)| entries.iter().map(move |entry| (index, entry.sample)));
        all.filter(|&(index, sample)| guard.sample(index, sample).is_none())
            .collect()
    }

    /// The factor of the strength of the crease plane at the head of each bone, 0 to 1.
    pub fn crease_factors(&mut self, guard: &Guard) -> &[f32] {
        for (index, entries) in self.counted.iter().enumerate() {
            let known = entries
                .iter()
                .filter_map(|entry| Some((entry.weight, guard.sample(index, entry.sample)?)));
            let factors = known.map(|(weight, sample)| 1.0 - weight * (1.0 - sample.crease));
            self.crease_factors[guard.bones[index].bone] = factors.product();
        }
        &self.crease_factors
    }

    /// Finds how much of Sinew's skin each vertex keeps. Calls `changed` with each vertex for which it differs
    /// from the frame before.
    pub fn find_kept(&mut self, guard: &Guard, mut changed: impl FnMut(u32)) {
        if !self.is_changed {
            return;
        }
        let Self {
            counted,
            kept,
            kept_before,
            returned,
            returned_before,
            ..
        } = self;
        std::mem::swap(returned, returned_before);
        for vertex in returned.drain(..) {
            kept_before[vertex as usize] = 1.0;
        }
        std::mem::swap(kept, kept_before);
        for (index, entries) in counted.iter().enumerate() {
            for entry in entries.iter() {
                let Some(sample) = guard.sample(index, entry.sample) else {
                    continue;
                };
                let returning = entry.weight * sample.returning;
                if returning == 0.0 {
                    continue;
                }
                for &(vertex, fraction) in &sample.field {
                    let kept = &mut kept[vertex as usize];
                    if *kept == 1.0 {
                        returned.push(vertex);
                    }
                    *kept *= 1.0 - returning * fraction;
                    if *kept < NOTHING {
                        *kept = 0.0;
                    }
                }
            }
        }
        for &vertex in returned.iter().chain(returned_before.iter()) {
            if kept[vertex as usize] != kept_before[vertex as usize] {
                changed(vertex);
            }
        }
    }
}
