//! How far each joint returns to the modifier's skin in a pose.

use std::collections::HashMap;

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::math::smoothstep::smooth_step_single;
use crate::skin::safeguard::faults::Faults;
use crate::skin::safeguard::guard::Guard;

/// Inverted or crossing faces beyond the modifier's from which a joint begins to return, and over how many it does.
pub(crate) const FACES_MORE: f32 = 0.25;
pub(crate) const FACES_OVER: f32 = 1.5;
/// Stretch over the modifier's from which a joint begins to return, and over how much it does.
const STRETCH_MORE: f32 = 0.0;
const STRETCH_OVER: f32 = 0.1;

/// Times that a joint is compared: what lies between two skins may be worse than both, and then returns farther.
const PASSES: usize = 3;

/// Where a vertex is in a pose, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    /// As relaxation and contact left it.
    pub relaxed: Vec3A,
    /// As the modifier alone leaves it.
    pub modifier: Vec3A,
}

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct GuardFrame {
    relaxed: Vec<Vec3A>,
    modifier: Vec<Vec3A>,
    blended: Vec<Vec3A>,
    is_placed: Vec<bool>,
    placed: Vec<u32>,
    fresh: Vec<Candidate>,
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
            relaxed: vec![Vec3A::ZERO; vertices],
            modifier: vec![Vec3A::ZERO; vertices],
            blended: vec![Vec3A::ZERO; vertices],
            is_placed: vec![false; vertices],
            placed: vec![],
            fresh: vec![],
            returning: vec![0.0; guard.joints.len()],
            share: vec![0.0; vertices],
            returned: vec![],
        }
    }

    /// Share of the modifier's skin at a vertex, 0..1.
    pub fn share(&self, vertex: usize) -> f32 {
        self.share[vertex]
    }

    /// Compares the skin of the `active` joints with the modifier's; `axes` is how each vertex is turned, `changed` is called with each
    /// joint that returns farther or less far than in the frame before.
    pub fn compare(
        &mut self,
        guard: &Guard,
        active: &[usize],
        axes: &[Mat3A],
        place_of: impl Fn(usize) -> Candidate + Sync,
        mut changed: impl FnMut(usize),
    ) {
        self.place(guard, active, place_of);
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
        let (mut own, mut alone) = (measured(&self.relaxed), None);
        for pass in 0..PASSES {
            let alone = alone.get_or_insert_with(|| measured(&self.modifier));
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
                self.blend();
                own = measured(&self.blended);
            }
        }
        for joint in 0..before.len() {
            if before[joint] != self.returning[joint] {
                changed(joint);
            }
        }
        self.spread(guard);
    }

    /// Where the vertices are as far as they have returned.
    fn blend(&mut self) {
        for &vertex in &self.placed {
            let vertex = vertex as usize;
            let (relaxed, modifier) = (self.relaxed[vertex], self.modifier[vertex]);
            self.blended[vertex] = relaxed + (modifier - relaxed) * self.share[vertex];
        }
    }

    fn place(&mut self, guard: &Guard, active: &[usize], place_of: impl Fn(usize) -> Candidate + Sync) {
        for &vertex in &self.placed {
            self.is_placed[vertex as usize] = false;
        }
        self.placed.clear();
        for &vertex in active.iter().flat_map(|&joint| &guard.joints[joint].vertices) {
            if !std::mem::replace(&mut self.is_placed[vertex as usize], true) {
                self.placed.push(vertex);
            }
        }
        let nowhere = Candidate {
            relaxed: Vec3A::ZERO,
            modifier: Vec3A::ZERO,
        };
        self.fresh.resize(self.placed.len(), nowhere);
        let work = self.fresh.par_iter_mut().zip(&self.placed).with_min_len(256);
        work.for_each(|(fresh, &vertex)| *fresh = place_of(vertex as usize));
        for (&vertex, fresh) in self.placed.iter().zip(&self.fresh) {
            self.relaxed[vertex as usize] = fresh.relaxed;
            self.modifier[vertex as usize] = fresh.modifier;
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
