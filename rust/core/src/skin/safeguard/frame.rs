//! How far each joint returns to the modifier's skin in a pose.

use std::collections::HashMap;

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::math::smoothstep::smooth_step_single;
use crate::skin::safeguard::faults::Faults;
use crate::skin::safeguard::guard::Guard;
use crate::skin::safeguard::places::PosedPlaces;

/// Inverted or crossing faces beyond the modifier's from which a joint begins to return, and over how many it does.
pub(crate) const FACES_MORE: f32 = 0.25;
pub(crate) const FACES_OVER: f32 = 1.5;
/// Stretch over the modifier's from which a joint begins to return, and over how much it does.
const STRETCH_MORE: f32 = 0.0;
const STRETCH_OVER: f32 = 0.1;

/// Times that a joint is compared: what lies between two skins may be worse than both, and then returns farther.
const PASSES: usize = 3;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct GuardFrame {
    /// Where each vertex is with what has returned, m.
    pub guarded: Vec<Vec3A>,
    /// How far each joint returns, 0..1.
    returning: Vec<f32>,
    /// How far each vertex does.
    share: Vec<f32>,
    /// The vertices of which any does.
    returned: Vec<u32>,
}

impl GuardFrame {
    pub fn new(guard: &Guard, vertices: usize) -> Self {
        Self {
            guarded: vec![Vec3A::ZERO; vertices],
            returning: vec![0.0; guard.joints.len()],
            share: vec![0.0; vertices],
            returned: vec![],
        }
    }

    /// Share of the modifier's skin at a vertex, 0..1.
    pub fn share(&self, vertex: usize) -> f32 {
        self.share[vertex]
    }

    /// Compares the skin of the `active` joints with the modifier's; `axes` is how each vertex is turned, `places` is where it is, `changed` is called with each
    /// joint that returns farther or less far than in the frame before.
    pub fn compare(
        &mut self,
        guard: &Guard,
        active: &[usize],
        axes: &[Mat3A],
        places: &PosedPlaces,
        mut changed: impl FnMut(usize),
    ) {
        let slots: HashMap<u32, usize> = active
            .iter()
            .enumerate()
            .map(|(slot, &joint)| (joint as u32, slot))
            .collect();
        let measured = |places: &[Vec3A]| {
            let faults = || -> Vec<Faults> {
                let work = active.par_iter().with_min_len(1);
                work.map(|&joint| guard.faults(joint, places, axes)).collect()
            };
            rayon::join(faults, || guard.crossed(active, &slots, places))
        };
        let before = std::mem::take(&mut self.returning);
        self.returning = vec![0.0; guard.joints.len()];
        let (mut own, mut alone) = (measured(&places.relaxed), None);
        for pass in 0..PASSES {
            let alone = alone.get_or_insert_with(|| measured(&places.modifier));
            let mut is_worse = false;
            for (slot, &joint) in active.iter().enumerate() {
                let more = |own: f32, alone: f32| (own - alone - FACES_MORE) / FACES_OVER;
                let inverted = more(own.0[slot].inverted, alone.0[slot].inverted);
                let crossed = more(own.1[slot], alone.1[slot]);
                let stretched =
                    (own.0[slot].stretch() / alone.0[slot].stretch() - 1.0 - STRETCH_MORE) / STRETCH_OVER;
                let farther = smooth_step_single(inverted.max(crossed).max(stretched));
                let returning = &mut self.returning[joint];
                *returning = 1.0 - (1.0 - *returning) * (1.0 - farther);
                is_worse |= farther > 0.0;
            }
            if !is_worse {
                break;
            }
            self.spread(guard);
            if pass + 1 < PASSES {
                self.blend(places);
                own = measured(&self.guarded);
            }
        }
        for joint in 0..before.len() {
            if before[joint] != self.returning[joint] {
                changed(joint);
            }
        }
        self.spread(guard);
        self.blend(places);
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

    /// Each vertex returns as far as the joint does that returns farthest there.
    fn spread(&mut self, guard: &Guard) {
        for vertex in self.returned.drain(..) {
            self.share[vertex as usize] = 0.0;
        }
        for (joint, &returning) in guard.joints.iter().zip(&self.returning) {
            if returning == 0.0 {
                continue;
            }
            for &(vertex, shown) in &joint.shown {
                let share = &mut self.share[vertex as usize];
                if *share == 0.0 {
                    self.returned.push(vertex);
                }
                *share = share.max(returning * shown);
            }
        }
    }
}

impl Guard {
    fn faults(&self, joint: usize, places: &[Vec3A], axes: &[Mat3A]) -> Faults {
        let mut faults = Faults::default();
        for &face in &self.joints[joint].faces {
            let face = &self.faces[face as usize];
            let [a, b, c] = face.corners.map(|vertex| vertex as usize);
            let turned = axes[a] + axes[b] + axes[c];
            faults.add(face, [places[a], places[b], places[c]], &turned);
        }
        faults
    }
}
