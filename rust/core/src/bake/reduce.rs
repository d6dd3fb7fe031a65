//! Which samples of a skin have to be kept, so that straight lines between them stay near all the others (ALGORITHM 11).

use rayon::prelude::*;

use super::error_metric::ErrorMetric;
use crate::error::require_length;
use crate::error::{Result, require};

/// Where samples between two kept neighbours miss the tolerance anyway, what counts as no farther.
const HARDLY_FARTHER: f64 = 1.001;

/// One sample: a vector a vertex.
type Shape = [[f32; 3]];

/// A skin's corrections at rising values of a frame or an angle.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    vertices: usize,
    corrections: &'a [[f32; 3]],
    seen: ErrorMetric<'a>,
    at: &'a [f64],
    tolerances_m: &'a [f64],
}

/// Which samples are kept, and which shape is shown at each.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptSamples {
    /// Where a shape is shown in full, rising. Between two of them both cross-fade; before the first and after the last that one
    /// stays.
    pub places: Vec<usize>,
    /// The sample whose corrections are shown at each place: itself, an earlier kept one that does as well, or none at all.
    pub shown: Vec<Option<usize>>,
    /// Largest distance of each sample from what is shown there, m.
    pub errors_m: Vec<f64>,
}

/// A place with what is shown there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Knot {
    pub place: usize,
    pub shown: Option<usize>,
}

impl Knot {
    pub(super) fn of(place: usize) -> Self {
        Self {
            place,
            shown: Some(place),
        }
    }
}

impl<'a> Samples<'a> {
    /// Samples of `vertices` corrections each, one after the other, taken `at` rising values.
    ///
    /// seen: how a correction of each sample shows on the posed skin, where distances are measured. tolerances_m: how far what is
    /// shown may be from each sample.
    ///
    /// # Errors
    /// Lists that do not fit each other, values that do not rise, a negative tolerance.
    pub fn new(
        vertices: usize,
        corrections: &'a [[f32; 3]],
        seen: ErrorMetric<'a>,
        at: &'a [f64],
        tolerances_m: &'a [f64],
    ) -> Result<Self> {
        let due = vertices * at.len();
        require_length("corrections", due, "one a vertex and sample", corrections.len())?;
        seen.require_fit(vertices, at.len())?;
        require_length("tolerances", at.len(), "one a sample", tolerances_m.len())?;
        for (place, pair) in at.windows(2).enumerate() {
            let rises = pair[1] > pair[0];
            require(
                rises,
                || format!("sample {}", place + 1),
                "at",
                pair[1],
                "more than the one before",
            )?;
        }
        for (place, &tolerance_m) in tolerances_m.iter().enumerate() {
            let allowed = tolerance_m >= 0.0;
            require(
                allowed,
                || format!("sample {place}"),
                "tolerance in m",
                tolerance_m,
                "0 or more",
            )?;
        }
        Ok(Self {
            vertices,
            corrections,
            seen,
            at,
            tolerances_m,
        })
    }

    /// Few of the `candidates` (one a sample) whose cross-fade is within the tolerance of every sample, candidate or not, from
    /// the first candidate to the last.
    ///
    /// Each straight line goes as far as it may before the next sample is kept. A place at which an earlier kept sample, or no
    /// correction at all, is near enough takes that one: a cycle needs its shapes once. With a tolerance of 0 only lines
    /// that are exact are straight. Where even neighbouring candidates are too far from the samples between them, both are kept:
    /// `errors_m` says by how much.
    ///
    /// # Errors
    /// Another number of candidates than samples.
    pub fn keep(&self, candidates: &[bool]) -> Result<KeptSamples> {
        require_length("candidates", self.at.len(), "one a sample", candidates.len())?;
        let order: Vec<usize> = (0..self.at.len()).filter(|&place| candidates[place]).collect();
        let mut knots: Vec<Knot> = match order.first() {
            None => vec![],
            Some(&first) => self.walk(Knot::of(first), &order[1..]),
        };
        self.share(&mut knots);
        self.drop_held_ends(&mut knots);
        Ok(KeptSamples {
            places: knots.iter().map(|knot| knot.place).collect(),
            shown: knots.iter().map(|knot| knot.shown).collect(),
            errors_m: self.errors_m(&knots),
        })
    }

    /// Largest distance of each sample from what `knots` (in order of their places) show there, m.
    pub(super) fn errors_m(&self, knots: &[Knot]) -> Vec<f64> {
        let samples = 0..self.at.len();
        samples
            .into_par_iter()
            .map(|sample| {
                let next = knots.partition_point(|knot| knot.place < sample);
                let (from, to) = match (next.checked_sub(1), knots.get(next)) {
                    (Some(before), Some(_)) => (before, next),
                    (Some(last), None) => (last, last),
                    (None, _) => (next, next),
                };
                match (knots.get(from), knots.get(to)) {
                    (Some(&from), Some(&to)) => self.distance_m(sample, from, to),
                    _ => self.seen.largest_m(sample, self.sample(sample), &[]),
                }
            })
            .collect()
    }

    /// The knots from `start` on, along `order` (places that go one way), each as far from the one before as the tolerance allows.
    pub(super) fn walk(&self, start: Knot, order: &[usize]) -> Vec<Knot> {
        let mut knots = vec![start];
        let (mut from, mut next) = (start, 0);
        while next < order.len() {
            // doubled steps first, then halved: as good as one by one where a longer line is never better than a shorter one
            let fits = |place: usize| self.line_fits(from, Knot::of(order[place]));
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

    /// Whether all samples from one knot to another, both included, are within the tolerance of the line between them.
    pub(super) fn line_fits(&self, from: Knot, to: Knot) -> bool {
        let (low, high) = (from.place.min(to.place), from.place.max(to.place));
        let fits = |sample: usize| self.fits(sample, [from, to]);
        // the ends first: where they do not fit, nothing else has to be looked at
        fits(low) && fits(high) && (low + 1..high.max(low + 1)).into_par_iter().all(fits)
    }

    /// Whether a sample is within the tolerance of a line.
    fn fits(&self, sample: usize, [from, to]: [Knot; 2]) -> bool {
        self.distance_m(sample, from, to) <= self.tolerances_m[sample]
    }

    /// Whether all samples of a line are within the tolerance, or hardly farther than from the line that is there.
    fn is_as_good(&self, line: [Knot; 2], present: [Knot; 2]) -> bool {
        (line[0].place..=line[1].place).into_par_iter().all(|sample| {
            let distance_m = self.distance_m(sample, line[0], line[1]);
            distance_m <= self.tolerances_m[sample]
                || distance_m <= HARDLY_FARTHER * self.distance_m(sample, present[0], present[1])
        })
    }

    /// Shows at each knot no correction or an earlier one, where that is near enough with its neighbours as they are.
    fn share(&self, knots: &mut [Knot]) {
        for own in 0..knots.len() {
            let mut earlier: Vec<Option<usize>> = knots[..own].iter().map(|knot| knot.shown).collect();
            earlier.push(None);
            earlier.sort_unstable();
            earlier.dedup();
            let present = knots[own];
            let fits = |shown: &Option<usize>| {
                let knot = Knot {
                    shown: *shown,
                    ..present
                };
                let before = own.checked_sub(1).map(|before| knots[before]);
                let after = knots.get(own + 1).copied();
                self.fits(present.place, [knot, knot])
                    && before.is_none_or(|before| self.is_as_good([before, knot], [before, present]))
                    && after.is_none_or(|after| self.is_as_good([knot, after], [present, after]))
            };
            if let Some(shown) = earlier.into_iter().find(fits) {
                knots[own].shown = shown;
            }
        }
    }

    /// Leaves out a first and a last knot that show what the knot beside them shows: that one stays anyway.
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
        let share = if from.place == to.place {
            0.0
        } else {
            (self.at[sample] - self.at[from.place]) / (self.at[to.place] - self.at[from.place])
        };
        let shown = [(from.shown, 1.0 - share), (to.shown, share)];
        let shown = shown.map(|(shown, weight)| (self.shape(shown), weight));
        let shown: Vec<_> = shown
            .into_iter()
            .filter_map(|(shape, weight)| Some((shape?, weight)))
            .collect();
        self.seen.largest_m(sample, self.sample(sample), &shown)
    }

    pub(super) fn seen(&self) -> ErrorMetric<'a> {
        self.seen
    }
}
