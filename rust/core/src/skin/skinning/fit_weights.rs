//! Fits linear-blend weights (0 or more, sum 1, at most a number of bones) to target poses: the weight
//! step of smooth skinning decomposition (Le and Deng 2012). The bones are given here and may stretch.
//!
//! The error of a vertex is `Σ_f |Σ_b w_b (B_bf x - y_f)|² + F h² |w - w0|²`. The second term keeps
//! weights that the poses do not determine at their values. Weight is moved between pairs of bones, each
//! time by the amount that lowers the error most. That keeps the sum, never raises the error, and
//! converges to its only minimum.

use rayon::prelude::*;

use crate::error::{Result, require_length};
use crate::math::rows::Rows;
use crate::pose::{ColumnMajor, Palette};
use crate::skin::mesh::bone_weights::BoneWeight;
use crate::skin::skinning::linear_skin::{LinearSkin, wide};

/// Most passes over all pairs of bones, which bounds the time of a vertex that converges slowly.
const PASSES: usize = 200;
/// Largest move of weight in a pass with which the fit has converged: the precision of f32.
const CONVERGED: f64 = 1e-7;

/// Weights in compressed rows: vertex v has the entries `offsets[v]..offsets[v + 1]`.
#[derive(Debug, Clone, Default)]
pub struct WeightRows {
    /// Where each vertex's entries start; one more than vertices.
    pub offsets: Vec<i32>,
    /// Bone of each entry.
    pub bones: Vec<i32>,
    /// Weight of each entry. Those of a vertex sum to 1.
    pub weights: Vec<f32>,
}

impl WeightRows {
    /// One row of (bone, weight) per vertex.
    pub(crate) fn new<R: IntoIterator<Item = (u32, f32)>>(rows: impl IntoIterator<Item = R>) -> Self {
        let rows = Rows::from_rows(rows);
        Self {
            offsets: rows.offsets().iter().map(|&offset| offset as i32).collect(),
            bones: rows.entries().iter().map(|&(bone, _)| bone as i32).collect(),
            weights: rows.entries().iter().map(|&(_, weight)| weight).collect(),
        }
    }
}

impl LinearSkin {
    /// The weights of at most `most` of a vertex's present bones that bring it nearest to `targets`
    /// (frame by frame, mesh space, m) in `poses` (frame by frame, one matrix per bone).
    ///
    /// `hold_m`, m: a weight changes by 1 only if that brings the vertex nearer by more than this on
    /// average. Without poses the present weights are only limited: the strongest stay, in their
    /// proportion.
    ///
    /// # Errors
    /// Lists whose lengths do not match, a matrix that is not affine.
    pub fn fitted(
        &self,
        poses: &[ColumnMajor],
        targets: &[[f32; 3]],
        most: usize,
        hold_m: f64,
    ) -> Result<WeightRows> {
        let frames = poses.chunks(self.skeleton.len().max(1));
        let palettes = frames
            .map(|pose| Palette::new(&self.skeleton, pose))
            .collect::<Result<Vec<_>>>()?;
        let expected = palettes.len() * self.len();
        require_length("targets", expected, "one per vertex in each pose", targets.len())?;
        let rows: Vec<Vec<BoneWeight>> = (0..self.len())
            .into_par_iter()
            .map(|vertex| self.row(vertex, &palettes, targets, most, hold_m))
            .collect();
        let pairs = |row: &Vec<BoneWeight>| {
            row.iter()
                .map(|weights| (weights.bone, weights.weight))
                .collect::<Vec<_>>()
        };
        Ok(WeightRows::new(rows.iter().map(pairs)))
    }

    fn row(
        &self,
        vertex: usize,
        palettes: &[Palette],
        targets: &[[f32; 3]],
        most: usize,
        hold_m: f64,
    ) -> Vec<BoneWeight> {
        let mut weights = self.weights.of(vertex).to_vec();
        let hold = palettes.len() as f64 * hold_m * hold_m;
        if !palettes.is_empty() {
            self.fit(vertex, &mut weights, palettes, targets, hold);
        }
        if weights.len() > most {
            weights.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.bone.cmp(&b.bone)));
            weights.truncate(most);
            let sum: f32 = weights.iter().map(|kept| kept.weight).sum();
            weights.iter_mut().for_each(|kept| kept.weight /= sum);
            if !palettes.is_empty() {
                self.fit(vertex, &mut weights, palettes, targets, hold);
            }
        }
        weights.retain(|kept| kept.weight > 0.0);
        weights
    }

    /// Moves the weights of a vertex to the minimum of its error.
    fn fit(
        &self,
        vertex: usize,
        weights: &mut [BoneWeight],
        palettes: &[Palette],
        targets: &[[f32; 3]],
        hold: f64,
    ) {
        let count = weights.len();
        let mut gram = vec![0.0; count * count];
        let mut differences = Vec::with_capacity(count);
        for (frame, palette) in palettes.iter().enumerate() {
            let target = &targets[frame * self.len() + vertex];
            let target = self.spaces.mesh_to_armature.transform_point3(wide(target));
            differences.clear();
            differences.extend(weights.iter().map(|entry| {
                palette.skinning_matrices()[entry.bone as usize].transform_point3(self.points[vertex])
                    - target
            }));
            for (row, a) in differences.iter().enumerate() {
                for (column, b) in differences.iter().enumerate() {
                    gram[row * count + column] += a.dot(*b);
                }
            }
        }
        let mut values: Vec<f64> = weights.iter().map(|entry| f64::from(entry.weight)).collect();
        // half the derivative of the error by each weight
        let mut slope: Vec<f64> = (0..count)
            .map(|row| {
                (0..count)
                    .map(|column| gram[row * count + column] * values[column])
                    .sum()
            })
            .collect();
        for _ in 0..PASSES {
            let mut largest_move: f64 = 0.0;
            for to in 0..count {
                for from in 0..to {
                    let curvature = gram[to * count + to] + gram[from * count + from]
                        - 2.0 * gram[to * count + from]
                        + 2.0 * hold;
                    if curvature <= 0.0 {
                        continue;
                    }
                    let moved = (slope[from] - slope[to]) / curvature;
                    let moved = moved.clamp(-values[to], values[from]);
                    values[to] += moved;
                    values[from] -= moved;
                    for row in 0..count {
                        slope[row] += moved * (gram[row * count + to] - gram[row * count + from]);
                    }
                    slope[to] += moved * hold;
                    slope[from] -= moved * hold;
                    largest_move = largest_move.max(moved.abs());
                }
            }
            if largest_move < CONVERGED {
                break;
            }
        }
        for (entry, value) in weights.iter_mut().zip(values) {
            entry.weight = value as f32;
        }
    }
}
