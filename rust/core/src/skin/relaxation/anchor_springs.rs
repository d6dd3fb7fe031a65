//! How the vertices of an elastic skin hold on to their anchors (Wilhelms 1997: anchor springs, region by region).

use glam::{Mat3A, Vec3A};

use crate::skin::settings::elasticity::ElasticSettings;

/// How each vertex takes part.
#[derive(Debug)]
pub(crate) struct AnchorSprings {
    /// How stiff its anchor is against its edges: the share of the way back that a vertex goes in a iteration, and above 1 that of
    /// the way back in all of its way.
    pub stiffness: Vec<f32>,
    /// How far from its anchor it may lie before it is pulled, m; `None` where nowhere.
    pub slack_m: Option<Vec<f32>>,
    /// How freely it slides along the skin's own plane, 0..1; `None` where nowhere.
    pub sliding: Option<Vec<f32>>,
    /// Rounds it takes part in; `None` where all do in all.
    pub iterations: Option<Vec<f32>>,
    /// Unit normals at rest; used where something slides.
    pub normals: Vec<Vec3A>,
}

impl AnchorSprings {
    /// How vertices take part in `iterations` iterations with `settings`; `stiffness` is the share of the way back that a vertex with
    /// factors 1 goes in one.
    pub fn new(settings: &ElasticSettings, stiffness: f32, iterations: usize, normals: Vec<Vec3A>) -> Self {
        // what counts is how stiff the anchor is against the edges; without edges there is the anchor alone
        let share = |(anchor, edges): (&f32, &f32)| {
            if *edges > 0.0 {
                (stiffness * anchor / edges).min(f32::MAX)
            } else {
                1.0
            }
        };
        let any = |list: &[f32]| list.iter().any(|&value| value > 0.0).then(|| list.to_vec());
        let is_whole = settings.relaxation.iter().all(|&share| share == 1.0);
        let iterations_of = |share: &f32| share * iterations as f32;
        Self {
            stiffness: settings
                .anchor_stiffness
                .iter()
                .zip(&settings.edge_stiffness)
                .map(share)
                .collect(),
            slack_m: any(&settings.slack_m),
            sliding: any(&settings.fat_sliding),
            iterations: (!is_whole).then(|| settings.relaxation.iter().map(iterations_of).collect()),
            normals,
        }
    }

    /// Whether each anchor pulls all of the way.
    pub fn is_plain(&self) -> bool {
        self.slack_m.is_none() && self.sliding.is_none()
    }

    /// Whether a vertex takes part in a iteration.
    pub fn takes_part(&self, vertex: usize, iteration: usize) -> bool {
        let iterations = self.iterations.as_ref();
        iterations.is_none_or(|iterations| iterations[vertex] > iteration as f32)
    }

    /// What of the way back to its anchor pulls at a vertex.
    pub fn restoring(&self, vertex: usize, displacement: Vec3A, axes: &Mat3A, scale: f32) -> Vec3A {
        let mut displacement = displacement;
        if let Some(free) = &self.slack_m {
            let (length_m, free_m) = (displacement.length(), free[vertex] * scale);
            displacement *= if length_m > free_m {
                (length_m - free_m) / length_m
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
