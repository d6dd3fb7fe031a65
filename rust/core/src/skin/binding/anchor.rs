//! Anchors: the position of a vertex in the axes of the tissues that influence it, at rest
//! (mathematics/binding.md, Anchors and Motion source).
//!
//! Positions are stored times their weights, so that a frame only adds.

use std::ops::Range;

use glam::{DVec3, Vec2, Vec3};

use crate::math::rows::Rows;
use crate::muscles::musculature::Musculature;
use crate::skin::binding::bind::Binding;
use crate::skin::binding::influence::{Influence, RowEntry};
use crate::skin::binding::muscle_stack::MuscleStacks;
use crate::skin::settings::bind::{Anchoring, MotionSource, SkinOptions};

/// Weight up to which an influence adds no swelling: 2 µm on a thigh that swells by 2 cm. Measured: a
/// seventh of all influences are weaker.
const WEAKEST_SWELLING: f32 = 1e-4;

/// The anchor of a vertex on a muscle that swells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SwellingAnchor {
    pub carrier: u32,
    /// Position across the belly, times weight and muscle influence, m. This part swells.
    pub across: Vec2,
}

/// The anchor of a vertex on a tissue that moves it with its whole motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullAnchor {
    pub carrier: u32,
    pub weight: f32,
    /// The part that changes shape with the tissue, times weight, m.
    pub surface: Vec3,
    /// The part that keeps its length, times weight, m.
    pub fat: Vec3,
}

/// The anchors that `anchor_of` makes of each vertex and each of its influences.
fn anchor_rows<A: Send>(
    influences: &Rows<Influence>,
    anchor_of: impl Fn(usize, &Influence) -> Option<A> + Sync,
) -> Rows<A> {
    let write = |(): &mut (), vertex: usize, anchors: &mut Vec<A>| {
        anchors.extend(
            influences
                .row(vertex)
                .iter()
                .filter_map(|entry| anchor_of(vertex, entry)),
        );
    };
    Rows::computed(influences.len(), || (), write)
}

/// The anchors of a skin, one row per vertex.
#[derive(Debug, Clone)]
pub(crate) enum Anchors {
    Swelling(Rows<SwellingAnchor>),
    Full(Rows<FullAnchor>),
}

impl Anchors {
    /// The anchors of `points` (armature space, m) by their `influences`. `muscle_influence`, one per
    /// vertex, scales the swelling; a vertex where it is 0 has no anchor.
    pub fn new(binding: &Binding, influences: &Rows<Influence>, muscle_influence: &[f32]) -> Self {
        let Binding {
            musculature,
            points,
            options,
            ..
        } = *binding;
        match options.motion_source {
            MotionSource::Swelling if options.anchoring == Anchoring::Blended && !options.scales_fat => {
                Self::Swelling(stack_anchors(binding, influences, muscle_influence))
            }
            MotionSource::Swelling => Self::Swelling(anchor_rows(influences, |vertex, entry| {
                let influence = muscle_influence[vertex];
                let is_weak = influence == 0.0 || entry.weight <= WEAKEST_SWELLING;
                if is_weak || !swells(musculature, entry.carrier) {
                    return None;
                }
                let position = AnchorPosition::new(musculature, entry.carrier, points[vertex], options);
                let factor = f64::from(entry.weight) * f64::from(influence);
                Some(SwellingAnchor {
                    carrier: entry.carrier,
                    across: (position.surface * factor).truncate().as_vec2(),
                })
            })),
            MotionSource::Full => Self::Full(anchor_rows(influences, |vertex, entry| {
                let position = AnchorPosition::new(musculature, entry.carrier, points[vertex], options);
                let weight = f64::from(entry.weight);
                Some(FullAnchor {
                    carrier: entry.carrier,
                    weight: entry.weight,
                    surface: (position.surface * weight).as_vec3(),
                    fat: (position.fat * weight).as_vec3(),
                })
            })),
        }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.offsets().len() - 1
    }

    /// The carriers of the anchors of a vertex.
    pub fn carriers_of(&self, vertex: usize) -> Vec<u32> {
        match self {
            Self::Swelling(rows) => rows.row(vertex).iter().map(|anchor| anchor.carrier).collect(),
            Self::Full(rows) => rows.row(vertex).iter().map(|anchor| anchor.carrier).collect(),
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
            Self::Swelling(rows) => rows.offsets(),
            Self::Full(rows) => rows.offsets(),
        }
    }
}

/// The anchors of vertices on all bellies below them.
fn stack_anchors(
    binding: &Binding,
    influences: &Rows<Influence>,
    muscle_influence: &[f32],
) -> Rows<SwellingAnchor> {
    let thicknesses = MuscleStacks::new(binding).thicknesses(influences);
    let write = |(): &mut (), vertex: usize, anchors: &mut Vec<SwellingAnchor>| {
        let influence = muscle_influence[vertex];
        if influence == 0.0 {
            return;
        }
        let row = thicknesses.row(vertex);
        let total_m: f32 = row.iter().map(RowEntry::strength).sum();
        let strong = row
            .iter()
            .filter(|entry| entry.strength() > WEAKEST_SWELLING * total_m);
        anchors.extend(strong.map(|entry| SwellingAnchor {
            carrier: entry.carrier,
            across: entry.across * influence,
        }));
    };
    Rows::computed(thicknesses.len(), || (), write)
}

/// The position of a vertex in a carrier's axes at rest, m: the part that changes shape with the tissue,
/// and the fat on it.
struct AnchorPosition {
    surface: DVec3,
    fat: DVec3,
}

impl AnchorPosition {
    fn new(musculature: &Musculature, carrier: u32, point: DVec3, options: &SkinOptions) -> Self {
        let rest = &musculature.carriers()[carrier as usize];
        let local = |position: DVec3| rest.axes.transpose() * (position - rest.centre);
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
