//! Contact that makes more faces cross than it parts is given up, bone by bone.

use glam::Vec3A;

use crate::math::smoothstep::smooth_step_single;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::safeguard::frame::FACES_MORE;
use crate::skin::safeguard::guard::Guard;

/// Crossing faces beyond those without contact over which a bone's skin gives it up: with half as many a limb that came on another
/// jumped, over a step of its way, by 5.5 times as far as it went.
const FACES_OVER: f32 = 3.0;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct ContactCheck {
    places: Vec<Vec3A>,
    /// How much crosses of each bone's skin without contact and with it.
    before: Vec<f32>,
    after: Vec<f32>,
}

impl ContactCheck {
    pub fn new(vertices: usize, bones: usize) -> Self {
        Self {
            places: vec![Vec3A::ZERO; vertices],
            before: vec![0.0; bones],
            after: vec![0.0; bones],
        }
    }

    /// Weakens the `shift` of the vertices in `shifted` where it does harm to the skin of their bones; `places` is where
    /// vertices are without it.
    pub fn restrain(
        &mut self,
        guard: &Guard,
        weights: &BoneWeights,
        shifted: &[u32],
        shift: &mut [Vec3A],
        places: &[Vec3A],
    ) {
        if shifted.is_empty() || !guard.is_on {
            return;
        }
        let faces = shifted.iter().flat_map(|&vertex| guard.faces_at(vertex));
        let leaves = guard.leaves.of(faces.copied());
        self.places.clone_from_slice(places);
        for &vertex in shifted {
            self.places[vertex as usize] += shift[vertex as usize];
        }
        let mut sums = std::mem::take(&mut self.after);
        self.count(guard, weights, &leaves, &mut sums);
        self.after = sums;
        if self.after.iter().all(|&after| after <= FACES_MORE) {
            return;
        }
        self.places.clone_from_slice(places);
        let mut sums = std::mem::take(&mut self.before);
        self.count(guard, weights, &leaves, &mut sums);
        self.before = sums;
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

    /// Counts what crosses of each bone's skin.
    fn count(&self, guard: &Guard, weights: &BoneWeights, leaves: &[u32], sums: &mut [f32]) {
        sums.fill(0.0);
        for crossing in guard.leaves.crossings(leaves, &self.places) {
            let counted = guard.counted(&crossing);
            for face in [crossing.one, crossing.other] {
                guard.add_to_bones(face, counted, weights, sums);
            }
        }
    }
}
