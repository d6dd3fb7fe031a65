//! How far each joint returns to the modifier's skin in a pose.

use std::collections::HashMap;

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::math::smoothstep::smooth_step_single;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::safeguard::faults::Faults;
use crate::skin::safeguard::guard::{Crossed, Guard, Others};
use crate::skin::safeguard::places::PosedPlaces;

/// Inverted or crossing faces beyond the modifier's from which a joint begins to return, and over how many it does.
pub(crate) const FACES_MORE: f32 = 0.25;
const FACES_OVER: f32 = 1.5;
/// Stretch over the modifier's from which a joint begins to return, and over how much it does.
const STRETCH_MORE: f32 = 0.02;
const STRETCH_OVER: f32 = 0.08;

/// Times that a joint is compared: what lies between two skins may be worse than both, and then returns farther.
const PASSES: usize = 3;

/// Faces that one thread takes at a time.
const FACES_CHUNK: usize = 512;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct GuardFrame {
    /// Where each vertex is with what has returned, m.
    pub guarded: Vec<Vec3A>,
    /// How far each joint returns, 0..1.
    returning: Vec<f32>,
    /// How far each bone does, where tissues alone move its skin.
    bones: Vec<f32>,
    /// How far each vertex does, and did in the frame before.
    share: Vec<f32>,
    share_before: Vec<f32>,
    /// The vertices of which any does, and did in the frame before.
    returned: Vec<u32>,
    returned_before: Vec<u32>,
}

impl GuardFrame {
    pub fn new(guard: &Guard, vertices: usize, bones: usize) -> Self {
        Self {
            guarded: vec![Vec3A::ZERO; vertices],
            returning: vec![0.0; guard.joints.len()],
            bones: vec![0.0; bones],
            share: vec![0.0; vertices],
            share_before: vec![0.0; vertices],
            returned: vec![],
            returned_before: vec![],
        }
    }

    /// Share of the modifier's skin at a vertex, 0..1.
    pub fn share(&self, vertex: usize) -> f32 {
        self.share[vertex]
    }

    /// Compares the skin of the `active` joints with the modifier's; `axes` is how each vertex is turned, `places` is where it is, `changed` is called with each
    /// vertex that returns farther or less far than in the frame before.
    pub fn compare(
        &mut self,
        guard: &Guard,
        active: &[usize],
        axes: &[Mat3A],
        places: &PosedPlaces,
        weights: &BoneWeights,
        mut changed: impl FnMut(u32),
    ) {
        if !guard.is_on {
            self.guarded.clone_from(&places.relaxed);
            return;
        }
        let slots: HashMap<u32, usize> = active
            .iter()
            .enumerate()
            .map(|(slot, &joint)| (joint as u32, slot))
            .collect();
        let others = guard.others(active, self.bones.len(), places);
        let faults = |places: &[Vec3A]| -> Vec<Faults> {
            let work = active.par_iter().with_min_len(1);
            work.map(|&joint| guard.faults(joint, places, axes)).collect()
        };
        let crossed = |places: &[Vec3A]| guard.crossed(active, &slots, &others, weights, places);
        let measured = |places: &[Vec3A]| rayon::join(|| faults(places), || crossed(places));
        self.share_before.clone_from(&self.share);
        self.returned_before.clone_from(&self.returned);
        self.forget();
        self.returning.fill(0.0);
        self.bones.fill(0.0);
        let (mut own, alone) = rayon::join(|| measured(&places.relaxed), || faults(&places.modifier));
        let all = own.1.joints.iter().chain(&own.1.bones);
        let alone = if all.copied().fold(0.0, f32::max) > FACES_MORE {
            (alone, crossed(&places.modifier))
        } else {
            (alone, Crossed::none(active.len(), self.bones.len())) // it can only be worse
        };
        for pass in 0..PASSES {
            let mut is_worse = false;
            let more = |own: f32, alone: f32| (own - alone - FACES_MORE) / FACES_OVER;
            for (slot, &joint) in active.iter().enumerate() {
                let inverted = more(own.0[slot].inverted, alone.0[slot].inverted);
                let crossed = more(own.1.joints[slot], alone.1.joints[slot]);
                let stretched =
                    (own.0[slot].stretch() / alone.0[slot].stretch() - 1.0 - STRETCH_MORE) / STRETCH_OVER;
                let farther = smooth_step_single(inverted.max(crossed).max(stretched));
                is_worse |= return_farther(&mut self.returning[joint], farther);
            }
            for (bone, returning) in self.bones.iter_mut().enumerate() {
                let farther = smooth_step_single(more(own.1.bones[bone], alone.1.bones[bone]));
                is_worse |= return_farther(returning, farther);
            }
            if !is_worse {
                break;
            }
            self.spread(guard, &others, weights);
            if pass + 1 < PASSES {
                self.blend(places);
                own = measured(&self.guarded);
            }
        }
        self.blend(places);
        for &vertex in self.returned.iter().chain(&self.returned_before) {
            if self.share[vertex as usize] != self.share_before[vertex as usize] {
                changed(vertex);
            }
        }
    }

    /// Where the vertices are as far as they have returned.
    fn blend(&mut self, places: &PosedPlaces) {
        self.guarded.clone_from(&places.relaxed);
        for &vertex in &self.returned {
            let vertex = vertex as usize;
            let (relaxed, modifier) = (places.relaxed[vertex], places.modifier[vertex]);
            self.guarded[vertex] = relaxed + (modifier - relaxed) * self.share[vertex];
        }
    }

    /// Lets no vertex return.
    fn forget(&mut self) {
        for vertex in self.returned.drain(..) {
            self.share[vertex as usize] = 0.0;
        }
    }

    /// Each vertex returns as far as the joint does that returns farthest there, or, where tissues alone move it, its bones.
    fn spread(&mut self, guard: &Guard, others: &Others, weights: &BoneWeights) {
        self.forget();
        let Self { share, returned, .. } = self;
        let mut raise = |vertex: u32, to: f32| {
            let share = &mut share[vertex as usize];
            if to > 0.0 && *share == 0.0 {
                returned.push(vertex);
            }
            *share = share.max(to);
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
                let own = weights.of(vertex as usize).iter();
                raise(
                    vertex,
                    own.map(|own| own.weight * self.bones[own.bone as usize])
                        .sum::<f32>()
                        .min(1.0),
                );
            }
        }
    }
}

/// Lets what has returned so far return farther, of what is left; says whether it does.
fn return_farther(returning: &mut f32, farther: f32) -> bool {
    *returning = 1.0 - (1.0 - *returning) * (1.0 - farther);
    farther > 0.0
}

impl Guard {
    fn faults(&self, joint: usize, places: &[Vec3A], axes: &[Mat3A]) -> Faults {
        let parts = self.joints[joint].faces.par_chunks(FACES_CHUNK);
        let parts: Vec<Faults> = parts
            .map(|faces| {
                let mut faults = Faults::default();
                for &face in faces {
                    let face = &self.faces[face as usize];
                    let [a, b, c] = face.corners.map(|vertex| vertex as usize);
                    let turned = axes[a] + axes[b] + axes[c];
                    faults.add(face, [places[a], places[b], places[c]], &turned);
                }
                faults
            })
            .collect();
        parts.into_iter().fold(Faults::default(), Faults::and)
    }
}
