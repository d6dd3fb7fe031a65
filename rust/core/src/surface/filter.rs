//! Smooths a field without losing volume: each voxel becomes the weighted mean of its neighbourhood, or keeps
//! its original value if that is larger (Wilhelms 1997: 5 passes, weight e^-decay, maximum with the
//! original).
//!
//! Applied to depths this fills the grooves between tissues, and leaves planes and convex parts where they
//! are. The weights are e^(-decay · d²) with d in voxels. They are isotropic and separable, so they are
//! applied axis by axis.

use rayon::prelude::*;

use super::bricks::{Band, Bricks, EDGE, VOXELS, Values};
use super::progress::Progress;
use crate::error::Result;

/// Margin of the band, voxels.
const TO_SPARE: f32 = 1.5;

/// How a field is smoothed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Filter {
    /// Number of passes.
    pub passes: u32,
    /// Radius of the neighbourhood, voxels.
    pub radius: u32,
    /// Decay of the weights.
    pub decay: f64,
}

impl Filter {
    /// The band that leaves the surface of planes and convex parts where they are: outside, the distance that
    /// the surface can move in all passes; inside, the radius of one pass.
    pub fn band(&self) -> Band {
        Band {
            least: -((self.passes * self.radius) as f32) - TO_SPARE,
            most: self.radius as f32 + TO_SPARE,
        }
    }

    /// The weights from the middle outward. With their mirror images they sum to 1.
    fn weights(&self) -> Vec<f32> {
        let raw: Vec<f64> = (0..=self.radius)
            .map(|d| (-self.decay * f64::from(d * d)).exp())
            .collect();
        let sum = 2.0 * raw.iter().sum::<f64>() - raw[0];
        raw.iter().map(|weight| (weight / sum) as f32).collect()
    }

    /// Smooths `bricks`. Progress goes from `from` to `to`.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn apply(&self, bricks: &mut Bricks, progress: &Progress, from: f64, to: f64) -> Result<()> {
        if self.radius == 0 {
            return Ok(());
        }
        let weights = self.weights();
        let original = bricks.values.clone();
        for pass in 0..self.passes {
            let filtered: Vec<Values> = bricks
                .stored()
                .par_iter()
                .zip(&original)
                .map_init(Scratch::default, |scratch, (&brick, original)| {
                    bricks.gather(brick, self.radius as i32, &mut scratch.around);
                    scratch.mean(&weights, original)
                })
                .collect();
            bricks.values = filtered;
            progress.reach(from + (to - from) * f64::from(pass + 1) / f64::from(self.passes))?;
        }
        Ok(())
    }
}

/// The values around a brick, and the same after smoothing along x, and along x and y.
#[derive(Default)]
struct Scratch {
    around: Vec<f32>,
    along_x: Vec<f32>,
    along_y: Vec<f32>,
}

impl Scratch {
    /// The weighted means in the brick, or `original` where it is larger.
    fn mean(&mut self, weights: &[f32], original: &Values) -> Values {
        let edge = EDGE as usize;
        let wide = edge + 2 * (weights.len() - 1);
        smooth(
            &self.around,
            weights,
            wide,
            1,
            edge,
            wide * wide,
            &mut self.along_x,
        );
        smooth(&self.along_x, weights, wide, edge, edge, wide, &mut self.along_y);
        let mut means = [0.0; VOXELS];
        let radius = weights.len() - 1;
        for (index, (mean, original)) in means.iter_mut().zip(original).enumerate() {
            let layer = edge * edge;
            let middle = index + radius * layer;
            let sum = weighted(&self.along_y, weights, middle, layer);
            *mean = sum.max(*original);
        }
        means
    }
}

/// Smooths `from` along one axis: `rows` groups of `wide` steps of `step` numbers each, of which `kept` steps
/// are written.
fn smooth(
    from: &[f32],
    weights: &[f32],
    wide: usize,
    step: usize,
    kept: usize,
    rows: usize,
    to: &mut Vec<f32>,
) {
    to.clear();
    let radius = weights.len() - 1;
    for row in 0..rows {
        let start = row * wide * step;
        for position in 0..kept * step {
            to.push(weighted(from, weights, start + position + radius * step, step));
        }
    }
}

/// The weighted mean around `middle`. Neighbours are added in pairs, so that mirrored values give the same
/// bits.
fn weighted(from: &[f32], weights: &[f32], middle: usize, step: usize) -> f32 {
    let mut sum = weights[0] * from[middle];
    for (distance, weight) in weights.iter().enumerate().skip(1) {
        sum += weight * (from[middle - distance * step] + from[middle + distance * step]);
    }
    sum
}
