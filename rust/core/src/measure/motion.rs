//! Jitter and pop over a sequence of frames, beside a sequence that has neither: the same poses by linear skinning.

use glam::DVec3;
use rayon::prelude::*;

use super::percentile::percentile;

/// Movement over a whole sequence below which a vertex counts as still, m.
const STILL_M: f64 = 1e-6;
/// Least divisor of a ratio, m.
const LEAST_M: f64 = 1e-12;
/// Excess below which persistence says nothing, m.
const NO_EXCESS_M: f64 = 1e-9;

/// A skin and its reference over the same poses, at equal small steps.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Vertices a frame.
    pub vertices: usize,
    /// The skin, frame after frame, m.
    pub skin: &'a [[f32; 3]],
    /// The same poses by linear skinning, as many.
    pub reference: &'a [[f32; 3]],
    /// Which vertices count, one a vertex; all where it is `None`.
    pub counted: Option<&'a [bool]>,
}

/// How unsteadily vertices move: 99th percentiles of the second difference of their positions, m a frame².
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Jitter {
    /// Of the skin.
    pub p99_m: f64,
    /// Of the reference.
    pub reference_p99_m: f64,
    /// Of the difference between both.
    pub excess_p99_m: f64,
}

/// The largest jump of a vertex from one frame to the next.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pop {
    /// Farthest that any vertex moves in one frame, m.
    pub max_m: f64,
    /// The same of the reference, m.
    pub reference_max_m: f64,
    /// Farthest that any vertex moves in one frame against its reference, m.
    pub excess_m: f64,
    /// Where: from this frame to the next.
    pub frame: usize,
    /// The vertex.
    pub vertex: usize,
    /// The excess over one frame as a share of that over two: about a half where movement is continuous, near 1 at a jump.
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

    /// Jitter of the vertices that move in the reference; zero where none does or there are less than three frames.
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

    /// The worst jump; zero with less than two frames.
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
