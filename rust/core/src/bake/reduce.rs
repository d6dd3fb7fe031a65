//! The samples of a skin that must be kept so that linear interpolation between them stays near all others
//! (mathematics/baking.md, Reduction of frames).

use rayon::prelude::*;

use super::error_metric::ErrorMetric;
use crate::error::require_length;
use crate::error::{Result, require};

/// If a line is out of tolerance anyway, another line counts as equally good up to this factor.
const HARDLY_FARTHER: f64 = 1.001;

/// One sample: one vector per vertex, m.
type Shape = [[f32; 3]];

/// The corrections of a skin at increasing values of a frame number or an angle.
///
/// ```
/// use sinew_core::bake::{ErrorMetric, Samples};
///
/// # fn main() -> sinew_core::Result<()> {
/// // one vertex that moves up and down again in five frames
/// let corrections = [0.0, 0.01, 0.02, 0.01, 0.0].map(|z| [0.0, 0.0, z]);
/// let frames = [1.0, 2.0, 3.0, 4.0, 5.0];
/// let samples = Samples::new(1, &corrections, ErrorMetric::Identity, &frames, &[1e-6; 5])?;
/// let kept = samples.keep(&[true; 5])?;
/// assert_eq!(kept.indices, [0, 2, 4]);
/// assert_eq!(kept.shown, [None, Some(2), None]); // no correction at the ends
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    vertices: usize,
    corrections: &'a [[f32; 3]],
    metric: ErrorMetric<'a>,
    at: &'a [f64],
    tolerances_m: &'a [f64],
}

/// The samples that are kept, and the shape that each shows.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptSamples {
    /// Indices of samples at which one shape is shown in full, increasing. Between two of them their shapes
    /// cross-fade. Before the first and after the last, its shape stays.
    pub indices: Vec<usize>,
    /// The sample whose corrections are shown at each index: the same sample, an earlier kept one that is as
    /// good, or none.
    pub shown: Vec<Option<usize>>,
    /// The error of each sample, m.
    pub errors_m: Vec<f64>,
}

/// A sample's index, and the sample whose corrections are shown there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Knot {
    pub index: usize,
    pub shown: Option<usize>,
}

impl Knot {
    pub(super) fn of(index: usize) -> Self {
        Self {
            index,
            shown: Some(index),
        }
    }
}

impl<'a> Samples<'a> {
    /// Samples of `vertices` corrections each, one after another, at increasing values `at`.
    ///
    /// `metric`: how errors are measured. `tolerances_m`: the allowed error of each sample.
    ///
    /// # Errors
    /// [`crate::Error::Length`] for lists that do not fit one another; [`crate::Error::Value`] for values
    /// that do not increase or a negative tolerance.
    pub fn new(
        vertices: usize,
        corrections: &'a [[f32; 3]],
        metric: ErrorMetric<'a>,
        at: &'a [f64],
        tolerances_m: &'a [f64],
    ) -> Result<Self> {
        let expected = vertices * at.len();
        require_length(
            "corrections",
            expected,
            "one per vertex and sample",
            corrections.len(),
        )?;
        metric.require_fit(vertices, at.len())?;
        require_length("tolerances", at.len(), "one per sample", tolerances_m.len())?;
        for (index, pair) in at.windows(2).enumerate() {
            let rises = pair[1] > pair[0];
            require(
                rises,
                || format!("Sample {}", index + 1),
                "at",
                pair[1],
                "more than the previous one",
            )?;
        }
        for (index, &tolerance_m) in tolerances_m.iter().enumerate() {
            let allowed = tolerance_m >= 0.0;
            require(
                allowed,
                || format!("Sample {index}"),
                "tolerance in m",
                tolerance_m,
                "0 or more",
            )?;
        }
        Ok(Self {
            vertices,
            corrections,
            metric,
            at,
            tolerances_m,
        })
    }

    /// A small set of the `candidates` (one flag per sample) whose cross-fade is within the tolerance of
    /// every sample, from the first candidate to the last.
    ///
    /// Each line extends as far as possible before the next sample is kept. Where an earlier kept sample, or
    /// no correction, is near enough, it is shown instead: a cycle needs its shapes once. With a tolerance of
    /// 0 only exact lines are straight. If even neighbouring candidates are too far from the samples between
    /// them, both are kept, and `errors_m` has the error.
    ///
    /// # Errors
    /// [`crate::Error::Length`] for a number of candidates other than the number of samples.
    pub fn keep(&self, candidates: &[bool]) -> Result<KeptSamples> {
        require_length("candidates", self.at.len(), "one per sample", candidates.len())?;
        let order: Vec<usize> = (0..self.at.len()).filter(|&index| candidates[index]).collect();
        let mut knots: Vec<Knot> = match order.first() {
            None => vec![],
            Some(&first) => self.walk(Knot::of(first), &order[1..]),
        };
        self.reuse_shapes(&mut knots);
        self.drop_held_ends(&mut knots);
        Ok(KeptSamples {
            indices: knots.iter().map(|knot| knot.index).collect(),
            shown: knots.iter().map(|knot| knot.shown).collect(),
            errors_m: self.errors_m(&knots),
        })
    }

    /// The error of each sample, m, with `knots` in increasing order.
    pub(super) fn errors_m(&self, knots: &[Knot]) -> Vec<f64> {
        let samples = 0..self.at.len();
        samples
            .into_par_iter()
            .map(|sample| {
                let next = knots.partition_point(|knot| knot.index < sample);
                let (from, to) = match (next.checked_sub(1), knots.get(next)) {
                    (Some(before), Some(_)) => (before, next),
                    (Some(last), None) => (last, last),
                    (None, _) => (next, next),
                };
                match (knots.get(from), knots.get(to)) {
                    (Some(&from), Some(&to)) => self.distance_m(sample, from, to),
                    _ => self.metric.largest_m(sample, self.sample(sample), &[]),
                }
            })
            .collect()
    }

    /// The knots from `start` on, along `order` (indices in one direction), each as far from the previous one
    /// as the tolerance allows.
    pub(super) fn walk(&self, start: Knot, order: &[usize]) -> Vec<Knot> {
        let mut knots = vec![start];
        let (mut from, mut next) = (start, 0);
        while next < order.len() {
            // double the step, then halve it: the same as one by one if a longer line is never better than a
            // shorter one
            let fits = |index: usize| self.line_fits(from, Knot::of(order[index]));
            let (mut fitting, mut step) = (next, 1);
            while fitting + step < order.len() && fits(fitting + step) {
                fitting += step;
                step *= 2;
            }
            while step > 1 {
                step /= 2;
                if fitting + step < order.len() && fits(fitting + step) {
                    fitting += step;
                }
            }
            from = Knot::of(order[fitting]);
            knots.push(from);
            next = fitting + 1;
        }
        knots
    }

    /// Whether all samples from one knot to another, both included, are within the tolerance of the line
    /// between them.
    pub(super) fn line_fits(&self, from: Knot, to: Knot) -> bool {
        let (low, high) = (from.index.min(to.index), from.index.max(to.index));
        let fits = |sample: usize| self.fits(sample, [from, to]);
        // the ends first: if they do not fit, nothing else has to be tested
        fits(low) && fits(high) && (low + 1..high.max(low + 1)).into_par_iter().all(fits)
    }

    /// Whether a sample is within its tolerance of a line.
    fn fits(&self, sample: usize, [from, to]: [Knot; 2]) -> bool {
        self.distance_m(sample, from, to) <= self.tolerances_m[sample]
    }

    /// Whether all samples of `line` are within their tolerance, or at most slightly farther away than from
    /// the line `present`.
    fn is_as_good(&self, line: [Knot; 2], present: [Knot; 2]) -> bool {
        (line[0].index..=line[1].index).into_par_iter().all(|sample| {
            let distance_m = self.distance_m(sample, line[0], line[1]);
            distance_m <= self.tolerances_m[sample]
                || distance_m <= HARDLY_FARTHER * self.distance_m(sample, present[0], present[1])
        })
    }

    /// Shows no correction or an earlier one at each knot where that is good enough, with the neighbouring
    /// knots unchanged.
    fn reuse_shapes(&self, knots: &mut [Knot]) {
        for key in 0..knots.len() {
            let mut earlier: Vec<Option<usize>> = knots[..key].iter().map(|knot| knot.shown).collect();
            earlier.push(None);
            earlier.sort_unstable();
            earlier.dedup();
            let present = knots[key];
            let fits = |shown: &Option<usize>| {
                let knot = Knot {
                    shown: *shown,
                    ..present
                };
                let before = key.checked_sub(1).map(|before| knots[before]);
                let after = knots.get(key + 1).copied();
                self.fits(present.index, [knot, knot])
                    && before.is_none_or(|before| self.is_as_good([before, knot], [before, present]))
                    && after.is_none_or(|after| self.is_as_good([knot, after], [present, after]))
            };
            if let Some(shown) = earlier.into_iter().find(fits) {
                knots[key].shown = shown;
            }
        }
    }

    /// Removes a first and a last knot that show the same as their neighbour, which stays in effect anyway.
    fn drop_held_ends(&self, knots: &mut Vec<Knot>) {
        while let [.., before, last] = knots.as_slice()
            && before.shown == last.shown
        {
            knots.pop();
        }
        while let [first, after, ..] = knots.as_slice()
            && first.shown == after.shown
        {
            knots.remove(0);
        }
    }

    pub(super) fn vertices(&self) -> usize {
        self.vertices
    }

    pub(super) fn at(&self) -> &[f64] {
        self.at
    }

    pub(super) fn sample(&self, sample: usize) -> &'a Shape {
        &self.corrections[sample * self.vertices..][..self.vertices]
    }

    fn shape(&self, shown: Option<usize>) -> Option<&'a Shape> {
        shown.map(|sample| self.sample(sample))
    }

    fn distance_m(&self, sample: usize, from: Knot, to: Knot) -> f64 {
        let fraction = if from.index == to.index {
            0.0
        } else {
            (self.at[sample] - self.at[from.index]) / (self.at[to.index] - self.at[from.index])
        };
        let shown = [(from.shown, 1.0 - fraction), (to.shown, fraction)];
        let shown = shown.map(|(shown, weight)| (self.shape(shown), weight));
        let shown: Vec<_> = shown
            .into_iter()
            .filter_map(|(shape, weight)| Some((shape?, weight)))
            .collect();
        self.metric.largest_m(sample, self.sample(sample), &shown)
    }

    pub(super) fn metric(&self) -> ErrorMetric<'a> {
        self.metric
    }
}
