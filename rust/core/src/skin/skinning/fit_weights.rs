//! The weights with which linear skinning comes nearest to a skin in given poses, none below 0, summing to 1, of a limited
//! number of bones (as in B. Le and Z. Deng, "Smooth Skinning Decomposition with Rigid Bones", 2012, its weights' step;
//! the bones are given here, and may stretch).
//!
//! A vertex's error is `Σ_f |Σ_b w_b (B_bf x - y_f)|² + F h² |w - w0|²`: the second part holds on to the weights that it
//! had, so that what the poses do not tell stays as it was. Weight is moved between pairs of bones, each time by what
//! lowers the error most, which keeps the sum, never raises the error, and ends at its one minimum.

use rayon::prelude::*;

use crate::error::{Result, require_length};
use crate::math::rows::Rows;
use crate::pose::{ColumnMajor, Palette};
use crate::skin::mesh::bone_weights::BoneWeight;
use crate::skin::skinning::linear_skin::{LinearSkin, wide};

/// Passes over all pairs of bones at most.
const PASSES: usize = 200;
/// Weight moved in a pass below which nothing more is to be gained.
const SETTLED: f64 = 1e-7;

/// Weights in compressed rows: vertex v has the entries `offsets[v]..offsets[v + 1]`.
#[derive(Debug, Clone, Default)]
pub struct WeightRows {
    /// Where each vertex's entries start; one more than vertices.
    pub offsets: Vec<i32>,
    /// The bone of each entry.
    pub bones: Vec<i32>,
    /// Its share, of a sum of 1.
    pub weights: Vec<f32>,
}

impl WeightRows {
    /// One row of (bone, weight) for each vertex.
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
    /// The weights, of at most `most` of the bones that a vertex is weighed to now, that bring it nearest to `targets` (a
    /// frame's vertices after the other's, mesh space) in `poses` (a frame's bones after the other's).
    ///
    /// hold_m: m; a weight is changed by 1 where that brings the vertex nearer by more than this in the mean. Without poses
    /// the present weights are limited alone: the strongest are kept, and share what the others had in proportion.
    ///
    /// # Errors
    /// Lists of lengths that do not fit, a matrix that is not affine.
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
        require_length("targets", expected, "one a vertex in each pose", targets.len())?;
        let rows: Vec<Vec<BoneWeight>> = (0..self.len())
            .into_par_iter()
            .map(|vertex| self.row(vertex, &palettes, targets, most, hold_m))
            .collect();
        let pairs = |row: &Vec<BoneWeight>| row.iter().map(|own| (own.bone, own.weight)).collect::<Vec<_>>();
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
        let mut own = self.weights.of(vertex).to_vec();
        let hold = palettes.len() as f64 * hold_m * hold_m;
        if !palettes.is_empty() {
            self.fit(vertex, &mut own, palettes, targets, hold);
        }
        if own.len() > most {
            own.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.bone.cmp(&b.bone)));
            own.truncate(most);
            let sum: f32 = own.iter().map(|kept| kept.weight).sum();
            own.iter_mut().for_each(|kept| kept.weight /= sum);
            if !palettes.is_empty() {
                self.fit(vertex, &mut own, palettes, targets, hold);
            }
        }
        own.retain(|kept| kept.weight > 0.0);
        own
    }

    /// Moves the weights of a vertex to where its error is least.
    fn fit(
        &self,
        vertex: usize,
        own: &mut [BoneWeight],
        palettes: &[Palette],
        targets: &[[f32; 3]],
        hold: f64,
    ) {
        let count = own.len();
        let mut gram = vec![0.0; count * count];
        let mut apart = Vec::with_capacity(count);
        for (frame, palette) in palettes.iter().enumerate() {
            let target = &targets[frame * self.len() + vertex];
            let target = self.spaces.mesh_to_armature.transform_point3(wide(target));
            apart.clear();
            apart.extend(own.iter().map(|weight| {
                palette.skinning_matrices()[weight.bone as usize].transform_point3(self.points[vertex])
                    - target
            }));
            for (row, a) in apart.iter().enumerate() {
                for (column, b) in apart.iter().enumerate() {
                    gram[row * count + column] += a.dot(*b);
                }
            }
        }
        let before: Vec<f64> = own.iter().map(|weight| f64::from(weight.weight)).collect();
        let mut weights = before.clone();
        // half of the error's slope along each weight
        let mut slope: Vec<f64> = (0..count)
            .map(|row| {
                (0..count)
                    .map(|column| gram[row * count + column] * weights[column])
                    .sum()
            })
            .collect();
        for _ in 0..PASSES {
            let mut most_moved: f64 = 0.0;
            for to in 0..count {
                for from in 0..to {
                    let bend = gram[to * count + to] + gram[from * count + from]
                        - 2.0 * gram[to * count + from]
                        + 2.0 * hold;
                    if bend <= 0.0 {
                        continue;
                    }
                    let moved = (slope[from] - slope[to]) / bend;
                    let moved = moved.clamp(-weights[to], weights[from]);
                    weights[to] += moved;
                    weights[from] -= moved;
                    for row in 0..count {
                        slope[row] += moved * (gram[row * count + to] - gram[row * count + from]);
                    }
                    slope[to] += moved * hold;
                    slope[from] -= moved * hold;
                    most_moved = most_moved.max(moved.abs());
                }
            }
            if most_moved < SETTLED {
                break;
            }
        }
        for (weight, found) in own.iter_mut().zip(weights) {
            weight.weight = found as f32;
        }
    }
}
