//! Weakens contact, bone by bone, if it makes more faces intersect than it separates.

use glam::Vec3A;

use crate::math::smoothstep::smooth_step_single;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::safeguard::frame::FACES_MORE;
use crate::skin::safeguard::guard::Guard;

/// Range, in intersecting faces more than without contact, over which contact at a bone weakens to 0.
/// Measured: with half this range, the skin of a limb that came into contact with another jumped by 5.5 times
/// the limb's step.
const FACES_OVER: f32 = 3.0;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct ContactCheck {
    positions: Vec<Vec3A>,
    /// Weighted number of intersections of each bone's skin, without contact and with it.
    before: Vec<f32>,
    after: Vec<f32>,
}

impl ContactCheck {
    pub fn new(vertices: usize, bones: usize) -> Self {
        Self {
            positions: vec![Vec3A::ZERO; vertices],
            before: vec![0.0; bones],
            after: vec![0.0; bones],
        }
    }

    /// Weakens the `shift` of the `shifted` vertices at bones whose skin intersects more with it than
    /// without. `positions` are the positions before contact.
    pub fn restrain(
        &mut self,
        guard: &Guard,
        weights: &BoneWeights,
        shifted: &[u32],
        shift: &mut [Vec3A],
        positions: &[Vec3A],
    ) {
        if shifted.is_empty() {
            return;
        }
        let faces = shifted.iter().flat_map(|&vertex| guard.faces_at(vertex));
        let clusters = guard.clusters.of(faces.copied());
        self.positions.clone_from_slice(positions);
        for &vertex in shifted {
            self.positions[vertex as usize] += shift[vertex as usize];
        }
        let mut sums = std::mem::take(&mut self.after);
        self.count(guard, weights, &clusters, &mut sums);
        self.after = sums;
        if self.after.iter().all(|&after| after <= FACES_MORE) {
            return;
        }
        self.positions.clone_from_slice(positions);
        let mut sums = std::mem::take(&mut self.before);
        self.count(guard, weights, &clusters, &mut sums);
        self.before = sums;
        let kept = |bone: u32| {
            let (before, after) = (self.before[bone as usize], self.after[bone as usize]);
            let more = (after - before - FACES_MORE) / FACES_OVER;
            1.0 - smooth_step_single(more)
        };
        for &vertex in shifted {
            let entries = weights.of(vertex as usize).iter();
            let fraction: f32 = entries.map(|entry| entry.weight * kept(entry.bone)).sum();
            shift[vertex as usize] *= fraction.min(1.0);
        }
    }

    /// Sums the intersections of each bone's skin.
    fn count(&self, guard: &Guard, weights: &BoneWeights, clusters: &[u32], sums: &mut [f32]) {
        sums.fill(0.0);
        for crossing in guard.clusters.crossings(clusters, &self.positions) {
            let counted = guard.counted(&crossing);
            for face in [crossing.one, crossing.other] {
                guard.add_to_bones(face, counted, weights, sums);
            }
        }
    }
}
