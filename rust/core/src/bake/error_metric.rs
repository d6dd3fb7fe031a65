//! How an error of a correction shows: on the posed skin, behind the Armature modifier.
//!
//! Where a joint is far bent, the modifier flattens the crook and a correction has to be large to move it at all: its own
//! lengths say nothing there.

use glam::Vec3A;

use crate::error::Result;
use crate::error::require_length;
use crate::skin::{PosedModifier, Skin};

/// What is done to each sample's corrections before anybody sees them.
#[derive(Debug, Clone, Copy)]
pub enum ErrorMetric<'a> {
    /// Nothing: they are seen as they are.
    Identity,
    /// The Armature modifier of a skin poses them, in each sample otherwise.
    Posed(&'a Skin, &'a [PosedModifier]),
}

impl ErrorMetric<'_> {
    pub(super) fn require_fit(&self, vertices: usize, samples: usize) -> Result<()> {
        match self {
            Self::Identity => Ok(()),
            Self::Posed(skin, poses) => {
                require_length("corrections", skin.len(), "one a vertex of the skin", vertices)?;
                require_length("poses", samples, "one a sample", poses.len())
            }
        }
    }

    /// Largest seen distance, m, between what is due in a sample and a weighted sum of shapes.
    pub(super) fn largest_m(&self, sample: usize, due: &[[f32; 3]], shown: &[(&[[f32; 3]], f64)]) -> f64 {
        let mut largest_square = 0.0_f64;
        for (vertex, due) in due.iter().enumerate() {
            let mut left = due.map(f64::from);
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
                    if square * f64::from(pose.longest()).powi(2) > largest_square {
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
