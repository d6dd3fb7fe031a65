//! Anchors: where a vertex hangs on a tissue, in the tissue's own frame at rest (ALGORITHM 3).
//!
//! Lengths in an anchor are multiplied by its weight, so that a frame only adds up.

use std::ops::Range;

use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

use crate::muscles::musculature::Musculature;
use crate::skin::binding::influence::{Influence, Row};
use crate::skin::settings::bind::{MotionSource, SkinOptions};

/// Share of a tissue's swelling up to which a vertex takes none of it: of a thigh that swells by 2 cm, 2 micrometres. A seventh of all
/// influences are weaker.
const WEAKEST_SWELLING: f32 = 1e-4;

/// A vertex's place on a swelling tissue.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SwellingAnchor {
    pub carrier: u32,
    /// What swells, across the belly, times weight and muscle influence, m.
    pub across: Vec2,
}

/// A vertex's place on a tissue that carries it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullAnchor {
    pub carrier: u32,
    pub weight: f32,
    /// What changes shape with the tissue, times weight, m.
    pub surface: Vec3,
    /// What keeps its length, times weight, m.
    pub fat: Vec3,
}

/// Rows of anchors, one a vertex.
#[derive(Debug, Clone)]
pub(crate) struct Rows<A> {
    offsets: Vec<u32>,
    anchors: Vec<A>,
}

impl<A: Send> Rows<A> {
    /// Rows of what `anchor_of` makes of a vertex and one of its influences.
    fn of(rows: &[Row], anchor_of: impl Fn(usize, &Influence) -> Option<A> + Sync) -> Self {
        let made: Vec<Vec<A>> = rows
            .par_iter()
            .enumerate()
            .map(|(vertex, row)| {
                row.entries()
                    .iter()
                    .filter_map(|entry| anchor_of(vertex, entry))
                    .collect()
            })
            .collect();
        let (mut offsets, mut anchors) = (Vec::with_capacity(rows.len() + 1), vec![]);
        offsets.push(0);
        for row in made {
            anchors.extend(row);
            offsets.push(anchors.len() as u32);
        }
        Self { offsets, anchors }
    }

    pub fn row(&self, vertex: usize) -> &[A] {
        let ends = &self.offsets[vertex..vertex + 2];
        &self.anchors[ends[0] as usize..ends[1] as usize]
    }
}

/// All anchors of a skin.
#[derive(Debug, Clone)]
pub(crate) enum Anchors {
    Swelling(Rows<SwellingAnchor>),
    Full(Rows<FullAnchor>),
}

impl Anchors {
    /// Anchors of `points` (armature space) by the influences in `rows`; `muscle_influence`, one a vertex, scales what
    /// swells, and a vertex where it is 0 has no anchor.
    pub fn new(
        musculature: &Musculature,
        points: &[DVec3],
        rows: &[Row],
        muscle_influence: &[f32],
        options: &SkinOptions,
    ) -> Self {
        match options.motion_source {
            MotionSource::Swelling => Self::Swelling(Rows::of(rows, |vertex, entry| {
                let influence = muscle_influence[vertex];
                let is_weak = influence == 0.0 || entry.weight <= WEAKEST_SWELLING;
                if is_weak || !swells(musculature, entry.carrier) {
                    return None;
                }
                let place = Place::new(musculature, entry.carrier, points[vertex], options);
                let factor = f64::from(entry.weight) * f64::from(influence);
                Some(SwellingAnchor {
                    carrier: entry.carrier,
                    across: (place.surface * factor).truncate().as_vec2(),
                })
            })),
            MotionSource::Full => Self::Full(Rows::of(rows, |vertex, entry| {
                let place = Place::new(musculature, entry.carrier, points[vertex], options);
                let weight = f64::from(entry.weight);
                Some(FullAnchor {
                    carrier: entry.carrier,
                    weight: entry.weight,
                    surface: (place.surface * weight).as_vec3(),
                    fat: (place.fat * weight).as_vec3(),
                })
            })),
        }
    }

    /// Each of some vertices, and whether it has an anchor.
    pub fn each(&self, vertices: Range<usize>) -> impl Iterator<Item = (usize, bool)> {
        let ends = &self.offsets()[vertices.start..=vertices.end];
        vertices.zip(ends.windows(2).map(|ends| ends[0] < ends[1]))
    }

    /// Whether a vertex has an anchor.
    pub fn is_occupied(&self, vertex: usize) -> bool {
        let offsets = self.offsets();
        offsets[vertex] < offsets[vertex + 1]
    }

    fn offsets(&self) -> &[u32] {
        match self {
            Self::Swelling(rows) => &rows.offsets,
            Self::Full(rows) => &rows.offsets,
        }
    }
}

/// A vertex in a carrier's rest frame, m: what changes shape with the tissue, and the fat on it.
struct Place {
    surface: DVec3,
    fat: DVec3,
}

impl Place {
    fn new(musculature: &Musculature, carrier: u32, point: DVec3, options: &SkinOptions) -> Self {
        let frame = &musculature.carriers()[carrier as usize];
        let local = |place: DVec3| frame.axes.transpose() * (place - frame.centre);
        if options.scales_fat {
            return Self {
                surface: local(point),
                fat: DVec3::ZERO,
            };
        }
        let surface = local(musculature.nearest(carrier as usize, point).surface);
        Self {
            surface,
            fat: local(point) - surface,
        }
    }
}

fn swells(musculature: &Musculature, carrier: u32) -> bool {
    let tissue = musculature.carriers()[carrier as usize].tissue;
    musculature.tissues()[tissue].muscle().is_some()
}
