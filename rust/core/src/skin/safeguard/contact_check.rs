//! Contact that makes more faces cross than it parts is given up, bone by bone.

use glam::Vec3A;
use rayon::prelude::*;

use crate::math::smoothstep::smooth_step_single;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::safeguard::frame::{FACES_MORE, FACES_OVER};
use crate::skin::safeguard::guard::Guard;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct ContactCheck {
    places: Vec<Vec3A>,
    is_placed: Vec<bool>,
    placed: Vec<u32>,
    fresh: Vec<Vec3A>,
    /// How much crosses of each bone's skin without contact and with it.
    before: Vec<f32>,
    after: Vec<f32>,
}

impl ContactCheck {
    pub fn new(vertices: usize, bones: usize) -> Self {
        Self {
            places: vec![Vec3A::ZERO; vertices],
            is_placed: vec![false; vertices],
            placed: vec![],
            fresh: vec![],
            before: vec![0.0; bones],
            after: vec![0.0; bones],
        }
    }

    /// Weakens the `shift` of the vertices in `shifted` where it does harm to the skin of their bones; `met` are the vertices that were
    /// looked at, `place_of` is where a vertex is without it.
    pub fn restrain(
        &mut self,
        guard: &Guard,
        weights: &BoneWeights,
        (shifted, met): (&[u32], &[u32]),
        shift: &mut [Vec3A],
        place_of: impl Fn(usize) -> Vec3A + Sync,
    ) {
        if shifted.is_empty() {
            return;
        }
        let faces = shifted
            .iter()
            .chain(met)
            .flat_map(|&vertex| guard.faces_at(vertex));
        let leaves = guard.leaves.of(faces.copied());
        self.place(guard, &leaves, place_of);
        let mut sums = std::mem::take(&mut self.before);
        self.count(guard, weights, &leaves, &mut sums);
        self.before = sums;
        for &vertex in shifted {
            self.places[vertex as usize] += shift[vertex as usize];
        }
        let mut sums = std::mem::take(&mut self.after);
        self.count(guard, weights, &leaves, &mut sums);
        self.after = sums;
        let kept = |bone: u32| {
            let (before, after) = (self.before[bone as usize], self.after[bone as usize]);
            let more = (after - before - FACES_MORE) / FACES_OVER;
            1.0 - smooth_step_single(more)
        };
        for &vertex in shifted {
            let own = weights.of(vertex as usize).iter();
            let share: f32 = own.map(|own| own.weight * kept(own.bone)).sum();
            shift[vertex as usize] *= share.min(1.0);
        }
    }

    fn place(&mut self, guard: &Guard, leaves: &[u32], place_of: impl Fn(usize) -> Vec3A + Sync) {
        for &vertex in &self.placed {
            self.is_placed[vertex as usize] = false;
        }
        self.placed.clear();
        for &vertex in leaves.iter().flat_map(|&leaf| guard.leaves.corners_of(leaf)) {
            if !std::mem::replace(&mut self.is_placed[vertex as usize], true) {
                self.placed.push(vertex);
            }
        }
        self.fresh.resize(self.placed.len(), Vec3A::ZERO);
        let work = self.fresh.par_iter_mut().zip(&self.placed).with_min_len(256);
        work.for_each(|(fresh, &vertex)| *fresh = place_of(vertex as usize));
        for (&vertex, &fresh) in self.placed.iter().zip(&self.fresh) {
            self.places[vertex as usize] = fresh;
        }
    }

    /// Counts what crosses of each bone's skin.
    fn count(&self, guard: &Guard, weights: &BoneWeights, leaves: &[u32], sums: &mut [f32]) {
        sums.fill(0.0);
        for crossing in guard.leaves.crossings(leaves, &self.places) {
            let counted = guard.counted(&crossing);
            let corners = [crossing.one, crossing.other]
                .into_iter()
                .flat_map(|face| guard.faces[face as usize].corners);
            for corner in corners {
                for own in weights.of(corner as usize) {
                    sums[own.bone as usize] += counted * own.weight / 3.0;
                }
            }
        }
    }
}
