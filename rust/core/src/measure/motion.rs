//! Jitter and pop over a sequence of frames, relative to a smooth sequence: the same poses with linear blend
//! skinning.

use glam::DVec3;
use rayon::prelude::*;

use crate::faults::percentile::percentile;

/// Movement over a whole sequence below which a vertex counts as still, m.
const STILL_M: f64 = 1e-6;
/// Smallest divisor of a ratio, m.
const LEAST_M: f64 = 1e-12;
/// Excess below which persistence is not defined, m.
const NO_EXCESS_M: f64 = 1e-9;

/// A skin and its reference in the same poses, at equal small steps.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Number of vertices.
    pub vertices: usize,
    /// The skin, frame after frame, m; one position per vertex.
    pub skin: &'a [[f32; 3]],
    /// The same poses with linear blend skinning, with the same shape.
    pub reference: &'a [[f32; 3]],
    /// One flag per vertex: whether it counts. `None`: all count.
    pub counted: Option<&'a [bool]>,
}

/// How unsteadily vertices move: 99th percentiles of the second difference of their positions, m per frame².
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Jitter {
    /// Of the skin.
    pub p99_m: f64,
    /// Of the reference.
    pub reference_p99_m: f64,
    /// Of the difference between the two.
    pub excess_p99_m: f64,
}

/// The largest jump of a vertex from one frame to the next.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pop {
    /// Longest motion of a vertex in one frame, m.
    pub max_m: f64,
    /// The same for the reference, m.
    pub reference_max_m: f64,
    /// Longest motion of a vertex relative to its reference in one frame, m.
    pub excess_m: f64,
    /// The frame before that motion.
    pub frame: usize,
    /// The vertex that moves so.
    pub vertex: usize,
    /// The excess over one frame as a fraction of the excess over two: about 0.5 for continuous motion, near
    /// 1 at a jump.
    pub persistence: f64,
}

impl Motion<'_> {
    fn frames(&self) -> usize {
        let entries = self.skin.len().min(self.reference.len());
        entries.checked_div(self.vertices).unwrap_or(0)
    }

    fn skin(&self, frame: usize, vertex: usize) -> DVec3 {
        DVec3::from_array(self.skin[frame * self.vertices + vertex].map(f64::from))
    }

    fn reference(&self, frame: usize, vertex: usize) -> DVec3 {
        DVec3::from_array(self.reference[frame * self.vertices + vertex].map(f64::from))
    }

    fn excess(&self, frame: usize, vertex: usize) -> DVec3 {
        self.skin(frame, vertex) - self.reference(frame, vertex)
    }

    fn counted(&self) -> impl Iterator<Item = usize> {
        (0..self.vertices).filter(|&vertex| self.counted.is_none_or(|counted| counted[vertex]))
    }

    /// The jitter of the vertices that move in the reference; 0 if none moves, or with fewer than three
    /// frames.
    pub fn jitter(&self) -> Jitter {
        let moves = |&vertex: &usize| {
            let positions = (0..self.frames()).map(|frame| self.reference(frame, vertex));
            let (low, high) = positions
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), position| {
                    (low.min(position), high.max(position))
                });
            (high - low).max_element() > STILL_M
        };
        let moving: Vec<usize> = self.counted().filter(moves).collect();
        let p99 = |position: &(dyn Fn(usize, usize) -> DVec3 + Sync)| {
            let second = |frame: usize, vertex: usize| {
                let [before, now, after] = [frame, frame + 1, frame + 2].map(|frame| position(frame, vertex));
                (before - 2.0 * now + after).length()
            };
            let frames = self.frames().saturating_sub(2);
            let mut differences: Vec<f64> = moving
                .par_iter()
                .flat_map_iter(|&vertex| (0..frames).map(move |frame| second(frame, vertex)))
                .collect();
            percentile(&mut differences, 99.0).unwrap_or(0.0)
        };
        Jitter {
            p99_m: p99(&|frame, vertex| self.skin(frame, vertex)),
            reference_p99_m: p99(&|frame, vertex| self.reference(frame, vertex)),
            excess_p99_m: p99(&|frame, vertex| self.excess(frame, vertex)),
        }
    }

    /// The largest jump; 0 with fewer than two frames.
    pub fn pop(&self) -> Pop {
        let mut worst = Pop::default();
        for frame in 0..self.frames().saturating_sub(1) {
            for vertex in self.counted() {
                let [skin, reference, excess] = [
                    self.skin(frame + 1, vertex) - self.skin(frame, vertex),
                    self.reference(frame + 1, vertex) - self.reference(frame, vertex),
                    self.excess(frame + 1, vertex) - self.excess(frame, vertex),
                ];
                worst.max_m = worst.max_m.max(skin.length());
                worst.reference_max_m = worst.reference_max_m.max(reference.length());
                if excess.length() > worst.excess_m {
                    (worst.excess_m, worst.frame, worst.vertex) = (excess.length(), frame, vertex);
                }
            }
        }
        worst.persistence = self.persistence(&worst);
        worst
    }

    fn persistence(&self, worst: &Pop) -> f64 {
        let over_two = |first: usize| {
            let inside = first + 2 < self.frames();
            inside.then(|| (self.excess(first + 2, worst.vertex) - self.excess(first, worst.vertex)).length())
        };
        let before = worst.frame.checked_sub(1).and_then(over_two);
        let widest = before.into_iter().chain(over_two(worst.frame)).reduce(f64::max);
        match widest {
            Some(widest) if worst.excess_m > NO_EXCESS_M => worst.excess_m / widest.max(LEAST_M),
            _ => 0.0,
        }
    }
}
