//! Anchor springs, which pull vertices back to their anchors (Wilhelms 1997: springs with stiffness and
//! rest distance per region; mathematics/relaxation.md, Anchor springs).

use glam::{Mat3A, Vec3A};

use crate::skin::settings::elasticity::ElasticSettings;

/// The anchor springs, one per vertex.
#[derive(Debug)]
pub(crate) struct AnchorSprings {
    /// Stiffness over that of the vertex's edges: the fraction of the vector back to the anchor that a
    /// vertex moves in an iteration. Above 1 that fraction stays 1, and the edges' part is divided by the
    /// stiffness.
    pub stiffness: Vec<f32>,
    /// Slack: the distance from the anchor below which the vertex is not pulled, m; `None` if it is 0
    /// everywhere.
    pub slack_m: Option<Vec<f32>>,
    /// How freely the vertex slides in the tangent plane of the skin, 0 to 1; `None` if not at all
    /// anywhere.
    pub sliding: Option<Vec<f32>>,
    /// Number of iterations that the vertex takes part in; `None` if all vertices take part in all of
    /// them.
    pub iterations: Option<Vec<f32>>,
    /// Unit normals at rest; none if `sliding` is `None`.
    normals: Vec<Vec3A>,
}

impl AnchorSprings {
    /// The anchor springs of `settings` for `iterations` iterations. `stiffness` is that of a vertex
    /// whose factors are all 1.
    pub fn new(settings: &ElasticSettings, stiffness: f32, iterations: usize, normals: &[Vec3A]) -> Self {
        // only the ratio to the edges counts; without edges only the anchor acts
        let ratio = |(anchor, edges): (&f32, &f32)| {
            if *edges > 0.0 {
                (stiffness * anchor / edges).min(f32::MAX)
            } else {
                1.0
            }
        };
        let any = |list: &[f32]| list.iter().any(|&value| value > 0.0).then(|| list.to_vec());
        let is_whole = settings.relaxation.iter().all(|&fraction| fraction == 1.0);
        let iterations_of = |fraction: &f32| fraction * iterations as f32;
        let sliding = any(&settings.fat_sliding);
        Self {
            normals: sliding.as_ref().map_or(vec![], |_| normals.to_vec()),
            stiffness: settings
                .anchor_stiffness
                .iter()
                .zip(&settings.edge_stiffness)
                .map(ratio)
                .collect(),
            slack_m: any(&settings.slack_m),
            sliding,
            iterations: (!is_whole).then(|| settings.relaxation.iter().map(iterations_of).collect()),
        }
    }

    /// Whether every anchor pulls with the full displacement: no slack, no sliding.
    pub fn is_plain(&self) -> bool {
        self.slack_m.is_none() && self.sliding.is_none()
    }

    /// Whether a vertex takes part in an iteration.
    pub fn takes_part(&self, vertex: usize, iteration: usize) -> bool {
        let iterations = self.iterations.as_ref();
        iterations.is_none_or(|iterations| iterations[vertex] > iteration as f32)
    }

    /// The part of `displacement`, the vector back to the anchor, that pulls at a vertex with these axes
    /// and scale; m.
    pub fn restoring(&self, vertex: usize, displacement: Vec3A, axes: &Mat3A, scale: f32) -> Vec3A {
        let mut displacement = displacement;
        if let Some(slacks) = &self.slack_m {
            let (length_m, slack_m) = (displacement.length(), slacks[vertex] * scale);
            displacement *= if length_m > slack_m {
                (length_m - slack_m) / length_m
            } else {
                0.0
            };
        }
        if let Some(sliding) = &self.sliding {
            let normal = (*axes * self.normals[vertex]).normalize_or_zero();
            let along = displacement - normal * displacement.dot(normal);
            displacement -= along * sliding[vertex];
        }
        displacement
    }
}
