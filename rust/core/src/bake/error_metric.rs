//! How an error of a correction is measured: on the posed skin, after the Armature modifier.
//!
//! At a strongly bent joint the modifier flattens the inner side, so a correction must be large to have an
//! effect. Its own length means little there.

use glam::Vec3A;

use crate::error::Result;
use crate::error::require_length;
use crate::skin::{PosedModifier, Skin};

/// What the error of a correction looks like.
#[derive(Debug, Clone, Copy)]
pub enum ErrorMetric<'a> {
    /// The error itself.
    Identity,
    /// The error as the Armature modifier of a skin poses it. One modifier per sample.
    Posed(&'a Skin, &'a [PosedModifier]),
}

impl ErrorMetric<'_> {
    pub(super) fn require_fit(&self, vertices: usize, samples: usize) -> Result<()> {
        match self {
            Self::Identity => Ok(()),
            Self::Posed(skin, poses) => {
                require_length("corrections", skin.len(), "one per vertex of the skin", vertices)?;
                require_length("poses", samples, "one per sample", poses.len())
            }
        }
    }

    /// Largest error, m, of a weighted sum of shapes in a sample whose corrections are `expected`.
    pub(super) fn largest_m(
        &self,
        sample: usize,
        expected: &[[f32; 3]],
        shown: &[(&[[f32; 3]], f64)],
    ) -> f64 {
        let mut largest_square = 0.0_f64;
        for (vertex, expected) in expected.iter().enumerate() {
            let mut left = expected.map(f64::from);
            for (shape, weight) in shown {
                for axis in 0..3 {
                    left[axis] -= weight * f64::from(shape[vertex][axis]);
                }
            }
            let square = square_of(left);
            match self {
                Self::Identity => largest_square = largest_square.max(square),
                Self::Posed(skin, poses) => {
                    let pose = &poses[sample];
                    if square * f64::from(pose.max_lengthening()).powi(2) > largest_square {
                        let offset = Vec3A::from_array(left.map(|part| part as f32));
                        let seen = skin.posed_offset(pose, vertex, offset).to_array().map(f64::from);
                        largest_square = largest_square.max(square_of(seen));
                    }
                }
            }
        }
        largest_square.sqrt()
    }
}

fn square_of([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}
