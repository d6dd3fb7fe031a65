//! The correctives of one motion of a joint: at which angles, and what each adds (mathematics/baking.md,
//! Correctives).

use rayon::prelude::*;

use super::reduce::{Knot, Samples};
use crate::error::{Error, Result, require};

/// The corrective keys of one motion: a joint that rotates about one axis from rest, at 0, to its extremes.
///
/// Each key has a *tent weight*: 1 at its own value, and linear down to 0 at the neighbouring keys and at
/// rest. The outermost keys keep a weight of 1 beyond their value. So at the value of a key only that key
/// acts, and at rest none does.
///
/// ```
/// use sinew_core::bake::{ErrorMetric, MotionKeys, Samples};
///
/// # fn main() -> sinew_core::Result<()> {
/// // one vertex of an elbow that bends from 0 to 90 degrees: its correction grows and then stays
/// let angles = [0.0, 30.0, 60.0, 90.0];
/// let corrections = [0.0, 0.01, 0.02, 0.02].map(|z| [0.0, 0.0, z]);
/// let samples = Samples::new(1, &corrections, ErrorMetric::Identity, &angles, &[1e-4; 4])?;
/// let keys = MotionKeys::new(&samples, 0.0)?;
/// assert_eq!(keys.at(), [60.0, 90.0]);
/// assert!((keys.shown(30.0)[0][2] - 0.01).abs() < 1e-8);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct MotionKeys {
    vertices: usize,
    indices: Vec<usize>,
    at: Vec<f64>,
    corrections: Vec<Vec<[f32; 3]>>,
    /// Largest error of the samples that are keys, m: the effect of the threshold.
    pub error_at_m: f64,
    /// Largest error of all other samples, m.
    pub error_between_m: f64,
}

impl MotionKeys {
    /// The keys that `samples` of a motion need, from rest outward, each as far from the previous one as the
    /// tolerance allows. A side of rest that needs no correction has no key.
    ///
    /// Entries of a key up to `threshold_m` long become 0, so that a key is empty where it has no effect.
    ///
    /// # Errors
    /// [`Error::Value`] if no sample is at 0, or for a negative threshold.
    pub fn new(samples: &Samples, threshold_m: f64) -> Result<Self> {
        let thing = || "Corrective".to_owned();
        require(
            threshold_m >= 0.0,
            thing,
            "threshold in m",
            threshold_m,
            "0 or more",
        )?;
        let Some(rest) = samples.at().iter().position(|&at| at == 0.0) else {
            return Err(Error::Value {
                thing: "Samples of a motion".to_owned(),
                quantity: "at",
                found: samples.at().first().copied().unwrap_or(f64::NAN),
                limit: "0, the rest pose, at one of them",
            });
        };
        let start = Knot {
            index: rest,
            shown: None,
        };
        let down: Vec<usize> = (0..rest).rev().collect();
        let up: Vec<usize> = (rest + 1..samples.at().len()).collect();
        let mut indices: Vec<usize> = [down, up]
            .iter()
            .flat_map(|side| {
                let still = side.last().is_none_or(|&end| {
                    let nothing = Knot {
                        index: end,
                        shown: None,
                    };
                    samples.line_fits(start, nothing)
                });
                let knots = if still { vec![] } else { samples.walk(start, side) };
                knots.into_iter().skip(1).map(|knot| knot.index)
            })
            .collect();
        indices.sort_unstable();
        Ok(Self::of_indices(samples, indices, threshold_m))
    }

    /// Keys at the samples with these indices, whatever the samples need, so that meshes that are worn over
    /// each other have the same keys. Rest, 0, can't be among them.
    ///
    /// # Errors
    /// [`Error::Value`] for an index that does not exist, that does not increase, or at 0, or for a negative
    /// threshold.
    pub fn at_samples(samples: &Samples, indices: &[usize], threshold_m: f64) -> Result<Self> {
        require(
            threshold_m >= 0.0,
            || "Corrective".to_owned(),
            "threshold in m",
            threshold_m,
            "0 or more",
        )?;
        for (position, &index) in indices.iter().enumerate() {
            let is_next = position == 0 || indices[position - 1] < index;
            require(
                is_next && samples.at().get(index).is_some_and(|&at| at != 0.0),
                || format!("Index {position}"),
                "sample",
                index as f64,
                "increasing, one of the samples and not at rest",
            )?;
        }
        Ok(Self::of_indices(samples, indices.to_vec(), threshold_m))
    }

    fn of_indices(samples: &Samples, indices: Vec<usize>, threshold_m: f64) -> Self {
        let at = indices.iter().map(|&index| samples.at()[index]).collect();
        let kept = indices.iter().map(|&index| samples.sample(index));
        let mut keys = Self {
            vertices: samples.vertices(),
            corrections: kept.map(|shape| pruned(shape, threshold_m)).collect(),
            at,
            indices,
            error_at_m: 0.0,
            error_between_m: 0.0,
        };
        keys.compare(samples);
        keys
    }

    /// Number of vertices of each key.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Indices of the samples that are keys, increasing.
    pub fn indices(&self) -> &[usize] {
        &self.indices
    }

    /// The value of each key. Rest, 0, is not among them.
    pub fn at(&self) -> &[f64] {
        &self.at
    }

    /// The correction of each key, one vector per vertex, m.
    pub fn corrections(&self) -> &[Vec<[f32; 3]>] {
        &self.corrections
    }

    /// The sum of all keys at a value, one vector per vertex, m.
    pub fn shown(&self, value: f64) -> Vec<[f64; 3]> {
        let mut sum = vec![[0.0; 3]; self.vertices];
        for (key, weight) in tent_weights(&self.at, value) {
            add(&mut sum, weight, &self.corrections[key]);
        }
        sum
    }

    fn compare(&mut self, samples: &Samples) {
        let errors_m: Vec<f64> = (0..samples.at().len())
            .into_par_iter()
            .map(|index| {
                let tent_weights = tent_weights(&self.at, samples.at()[index]);
                let shown: Vec<_> = tent_weights
                    .map(|(key, weight)| (self.corrections[key].as_slice(), weight))
                    .collect();
                samples.metric().largest_m(index, samples.sample(index), &shown)
            })
            .collect();
        for (index, error_m) in errors_m.into_iter().enumerate() {
            let worst_m = if self.indices.contains(&index) {
                &mut self.error_at_m
            } else {
                &mut self.error_between_m
            };
            *worst_m = worst_m.max(error_m);
        }
    }
}

/// The keys that act at a value, with their tent weights: at most two, none at 0. `at` is increasing.
pub(super) fn tent_weights(at: &[f64], value: f64) -> impl Iterator<Item = (usize, f64)> {
    let next = at.partition_point(|&at| at < value);
    // the neighbour towards rest; `None` for rest itself
    let (inner, outer) = if value < 0.0 {
        let outer = next.checked_sub(1);
        (
            Some(next).filter(|&key| at.get(key).is_some_and(|&at| at < 0.0)),
            outer,
        )
    } else {
        let inner = next.checked_sub(1).filter(|&key| at[key] > 0.0);
        (inner, Some(next).filter(|&key| key < at.len()))
    };
    let pair = match (inner, outer) {
        (Some(inner), None) => [Some((inner, 1.0)), None],
        (inner, Some(outer)) => {
            let from = inner.map_or(0.0, |key| at[key]);
            let fraction = (value - from) / (at[outer] - from);
            [inner.map(|key| (key, 1.0 - fraction)), Some((outer, fraction))]
        }
        (None, None) => [None, None],
    };
    pair.into_iter().flatten()
}

/// `shape`, with entries up to `threshold_m` long set to 0.
pub(super) fn pruned(shape: &[[f32; 3]], threshold_m: f64) -> Vec<[f32; 3]> {
    let kept = |&[x, y, z]: &[f32; 3]| {
        let length_m = [x, y, z]
            .map(f64::from)
            .map(|part| part * part)
            .iter()
            .sum::<f64>()
            .sqrt();
        if length_m > threshold_m {
            [x, y, z]
        } else {
            [0.0; 3]
        }
    };
    shape.iter().map(kept).collect()
}

/// Adds a weighted shape.
fn add(sum: &mut [[f64; 3]], weight: f64, shape: &[[f32; 3]]) {
    for (sum, key) in sum.iter_mut().zip(shape) {
        for axis in 0..3 {
            sum[axis] += weight * f64::from(key[axis]);
        }
    }
}
