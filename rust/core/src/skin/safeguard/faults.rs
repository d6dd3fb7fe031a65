//! What is wrong with a joint's skin in a pose, as numbers that change smoothly with the pose: faces that turn against the skin
//! around them, and edges that are stretched.

use glam::{Mat3A, Vec3A};

use crate::math::smoothstep::smooth_step_single;

/// Cosine between a face and its rest normal, turned as the skin there is, at which it counts as inverted by half; it counts not at
/// all and fully this far above and below.
const INVERTED_AT: f32 = 0.0;
const INVERTED_WITHIN: f32 = 0.25;

/// How much the square of an edge's stretch is above 1 from which the edge counts as stretched fully: 2 % of its length.
const STRETCHED: f32 = 0.04;

/// A triangle at rest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RestFace {
    pub corners: [u32; 3],
    /// Not of unit length.
    pub normal: Vec3A,
    /// One over the square of the length of each edge, from each corner to the next; 0 for an edge without length.
    pub inverse_squares: [f32; 3],
}

impl RestFace {
    pub fn new(corners: [u32; 3], points: [Vec3A; 3], shortest_m: f32) -> Self {
        let [a, b, c] = points;
        let inverse = |edge: Vec3A| {
            let square = edge.length_squared();
            if square > shortest_m * shortest_m {
                1.0 / square
            } else {
                0.0
            }
        };
        Self {
            corners,
            normal: (b - a).cross(c - a),
            inverse_squares: [inverse(b - a), inverse(c - b), inverse(a - c)],
        }
    }
}

/// The sum of the faults of some faces.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Faults {
    /// Number of inverted faces, nearly.
    pub inverted: f32,
    /// Sum over the edges of the fourth power of how much the square of each stretch is above 1: what the worst edges rule.
    stretch: f64,
    /// Number of edges that are stretched, nearly.
    edges: f32,
}

impl Faults {
    /// Adds a face whose corners are at `places`; `axes` is how the skin there is turned.
    pub fn add(&mut self, face: &RestFace, [a, b, c]: [Vec3A; 3], axes: &Mat3A) {
        let normal = (b - a).cross(c - a);
        let rest = *axes * face.normal;
        let size = (normal.length_squared() * rest.length_squared()).sqrt();
        if size > 0.0 {
            let cosine = normal.dot(rest) / size;
            let turned = (INVERTED_AT + INVERTED_WITHIN - cosine) / (2.0 * INVERTED_WITHIN);
            self.inverted += smooth_step_single(turned);
        }
        for (edge, inverse) in [b - a, c - b, a - c].into_iter().zip(face.inverse_squares) {
            if inverse > 0.0 {
                let square = (edge.length_squared() * inverse).max(1e-6);
                let above = square.max(1.0 / square) - 1.0;
                self.stretch += f64::from(above * above * above * above);
                self.edges += smooth_step_single(above / STRETCHED);
            }
        }
    }

    /// The sum of both.
    pub fn and(self, other: Self) -> Self {
        Self {
            inverted: self.inverted + other.inverted,
            stretch: self.stretch + other.stretch,
            edges: self.edges + other.edges,
        }
    }

    /// How far the worst edges are stretched: 1 for not at all.
    pub fn stretch(&self) -> f32 {
        let mean = self.stretch / f64::from(self.edges.max(1.0));
        (1.0 + mean.sqrt().sqrt()).sqrt() as f32
    }
}
