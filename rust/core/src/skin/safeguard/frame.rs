//! How far each joint returns to the modifier's skin in a pose (mathematics/safeguard.md, Return).

use std::collections::HashMap;

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::math::smoothstep::smooth_step_single;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::safeguard::faults::Faults;
use crate::skin::safeguard::guard::{Crossed, Guard, Others};
use crate::skin::safeguard::posed_positions::PosedPositions;

/// Number of inverted or intersecting faces more than the modifier's at which a joint starts to return, and
/// the range to a full return.
pub(crate) const FACES_MORE: f32 = 0.25;
const FACES_OVER: f32 = 1.5;
/// Stretch more than the modifier's at which a joint starts to return, and the range to a full return.
const STRETCH_MORE: f32 = 0.02;
const STRETCH_OVER: f32 = 0.08;

/// Comparisons per frame. A blend of two skins can be worse than both, and the joint then returns further.
const PASSES: usize = 3;

/// Faces per parallel task.
const FACES_CHUNK: usize = 512;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct GuardFrame {
    /// Position of each vertex after the return, m, armature space.
    pub guarded: Vec<Vec3A>,
    /// How far each joint returns, 0 to 1.
    returning: Vec<f32>,
    /// How far the skin of each bone returns where no active joint owns it, 0 to 1.
    bones: Vec<f32>,
    /// How far each vertex returns, 0 to 1, and in the frame before.
    fraction: Vec<f32>,
    fraction_before: Vec<f32>,
    /// The vertices that return, and those of the frame before.
    returned: Vec<u32>,
    returned_before: Vec<u32>,
}

impl GuardFrame {
    pub fn new(guard: &Guard, vertices: usize, bones: usize) -> Self {
        Self {
            guarded: vec![Vec3A::ZERO; vertices],
            returning: vec![0.0; guard.joints.len()],
            bones: vec![0.0; bones],
            fraction: vec![0.0; vertices],
            fraction_before: vec![0.0; vertices],
            returned: vec![],
            returned_before: vec![],
        }
    }

    /// Fraction of the modifier's skin at a vertex, 0 to 1.
    pub fn fraction(&self, vertex: usize) -> f32 {
        self.fraction[vertex]
    }

    /// Compares the skin of the `active` joints with the modifier's. `axes` are the rotations of the vertices'
    /// anchors. Calls `changed` with each vertex whose fraction differs from the frame before.
    pub fn compare(
        &mut self,
        guard: &Guard,
        active: &[usize],
        axes: &[Mat3A],
        positions: &PosedPositions,
        weights: &BoneWeights,
        mut changed: impl FnMut(u32),
    ) {
        let slots: HashMap<u32, usize> = active
            .iter()
            .enumerate()
            .map(|(slot, &joint)| (joint as u32, slot))
            .collect();
        let others = guard.others(active, self.bones.len(), positions);
        let faults = |positions: &[Vec3A]| -> Vec<Faults> {
            let work = active.par_iter().with_min_len(1);
            work.map(|&joint| guard.faults(joint, positions, axes)).collect()
        };
        let crossed = |positions: &[Vec3A]| guard.crossed(active, &slots, &others, weights, positions);
        let measured = |positions: &[Vec3A]| rayon::join(|| faults(positions), || crossed(positions));
        self.fraction_before.clone_from(&self.fraction);
        self.returned_before.clone_from(&self.returned);
        self.reset();
        self.returning.fill(0.0);
        self.bones.fill(0.0);
        let (mut guarded, alone) =
            rayon::join(|| measured(&positions.relaxed), || faults(&positions.modifier));
        let intersections = guarded.1.joints.iter().chain(&guarded.1.bones);
        let alone = if intersections.copied().fold(0.0, f32::max) > FACES_MORE {
            (alone, crossed(&positions.modifier))
        } else {
            // the return starts above FACES_MORE, so the modifier's count is not needed
            (alone, Crossed::none(active.len(), self.bones.len()))
        };
        for pass in 0..PASSES {
            let mut is_worse = false;
            let more = |guarded: f32, alone: f32| (guarded - alone - FACES_MORE) / FACES_OVER;
            for (slot, &joint) in active.iter().enumerate() {
                let inverted = more(guarded.0[slot].inverted, alone.0[slot].inverted);
                let crossed = more(guarded.1.joints[slot], alone.1.joints[slot]);
                let stretched =
                    (guarded.0[slot].stretch() / alone.0[slot].stretch() - 1.0 - STRETCH_MORE) / STRETCH_OVER;
                let further = smooth_step_single(inverted.max(crossed).max(stretched));
                is_worse |= return_further(&mut self.returning[joint], further);
            }
            for (bone, returning) in self.bones.iter_mut().enumerate() {
                let further = smooth_step_single(more(guarded.1.bones[bone], alone.1.bones[bone]));
                is_worse |= return_further(returning, further);
            }
            if !is_worse {
                break;
            }
            self.spread(guard, &others, weights);
            if pass + 1 < PASSES {
                self.blend(positions);
                guarded = measured(&self.guarded);
            }
        }
        self.blend(positions);
        for &vertex in self.returned.iter().chain(&self.returned_before) {
            if self.fraction[vertex as usize] != self.fraction_before[vertex as usize] {
                changed(vertex);
            }
        }
    }

    /// Finds the positions after the return.
    fn blend(&mut self, positions: &PosedPositions) {
        self.guarded.clone_from(&positions.relaxed);
        for &vertex in &self.returned {
            let vertex = vertex as usize;
            let (relaxed, modifier) = (positions.relaxed[vertex], positions.modifier[vertex]);
            self.guarded[vertex] = relaxed + (modifier - relaxed) * self.fraction[vertex];
        }
    }

    /// Resets the fraction of every vertex to 0.
    fn reset(&mut self) {
        for vertex in self.returned.drain(..) {
            self.fraction[vertex as usize] = 0.0;
        }
    }

    /// Finds how far each vertex returns: as far as the joint that returns furthest there, or, if no active
    /// joint owns it, its bones by their weights.
    fn spread(&mut self, guard: &Guard, others: &Others, weights: &BoneWeights) {
        self.reset();
        let Self {
            fraction, returned, ..
        } = self;
        let mut raise = |vertex: u32, to: f32| {
            let fraction = &mut fraction[vertex as usize];
            if to > 0.0 && *fraction == 0.0 {
                returned.push(vertex);
            }
            *fraction = fraction.max(to);
        };
        for (joint, &returning) in guard.joints.iter().zip(&self.returning) {
            if returning > 0.0 {
                joint
                    .shown
                    .iter()
                    .for_each(|&(vertex, shown)| raise(vertex, returning * shown));
            }
        }
        if self.bones.iter().any(|&returning| returning > 0.0) {
            let corners = others
                .faces
                .iter()
                .flat_map(|&face| guard.faces[face as usize].corners);
            for vertex in corners {
                let entries = weights.of(vertex as usize).iter();
                raise(
                    vertex,
                    entries
                        .map(|entry| entry.weight * self.bones[entry.bone as usize])
                        .sum::<f32>()
                        .min(1.0),
                );
            }
        }
    }
}

/// Increases `returning` by the fraction `further` of the rest to 1. Returns whether it increased.
fn return_further(returning: &mut f32, further: f32) -> bool {
    *returning = 1.0 - (1.0 - *returning) * (1.0 - further);
    further > 0.0
}

impl Guard {
    fn faults(&self, joint: usize, positions: &[Vec3A], axes: &[Mat3A]) -> Faults {
        let chunks = self.joints[joint].faces.par_chunks(FACES_CHUNK);
        let parts: Vec<Faults> = chunks
            .map(|faces| {
                let mut faults = Faults::default();
                for &face in faces {
                    let face = &self.faces[face as usize];
                    let [a, b, c] = face.corners.map(|vertex| vertex as usize);
                    let rotation = axes[a] + axes[b] + axes[c];
                    faults.add(face, [positions[a], positions[b], positions[c]], &rotation);
                }
                faults
            })
            .collect();
        parts.into_iter().fold(Faults::default(), Faults::and)
    }
}
