//! The bellies below a vertex, one under the other, down to its bone (mathematics/binding.md, Stack of bellies).
//!
//! Flesh keeps its volume and a bone does not yield, so what a belly gains in thickness raises all that is above it. A line goes
//! from the vertex inwards. Each belly on it gets the length that the line is inside of it, less the deeper it is: around a
//! bone, what is gained at a small radius is spread over a larger one.

use glam::{DVec3, Vec2};

use crate::math::rows::Rows;
use crate::math::smoothstep::smooth_step;
use crate::muscles::musculature::Musculature;
use crate::skin::binding::bind::{Binding, CandidateCarriers};
use crate::skin::binding::influence::{Influence, RowEntry, SMALLEST_ENTRY, smoothed};
use crate::skin::mesh::bone_weights::BoneWeights;

/// Length of the blended normal of the tissues below which it has no direction: tissues on all sides.
const SHORTEST_NORMAL: f64 = 1e-3;

/// Nearness of tissues from which they raise the skin fully: where fat is half as deep as the falloff. Fat does not yield, either.
const FULL_NEARNESS: f64 = 0.5;

/// The thickness of one belly below a vertex.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Thickness {
    pub carrier: u32,
    /// Outward vector across the belly, in its axes, m: as long as the part of the line inside the belly, times weight.
    pub across: Vec2,
}

impl RowEntry for Thickness {
    type Value = Vec2;

    fn new(carrier: u32, across: Vec2) -> Self {
        Self { carrier, across }
    }

    fn carrier(&self) -> u32 {
        self.carrier
    }

    fn value(&self) -> Vec2 {
        self.across
    }

    fn strength(&self) -> f32 {
        self.across.length()
    }

    fn negligible(total: f32) -> f32 {
        SMALLEST_ENTRY * total
    }

    // the others are not thicker without the bellies that were dropped
    fn make_up(_row: &mut [Self], _total: f32) {}
}

/// A part of the line inside a belly, m from the vertex.
#[derive(Debug, Clone, Copy)]
struct Chord {
    carrier: u32,
    from_m: f64,
    to_m: f64,
}

/// Finds the stack of bellies of each vertex.
pub(crate) struct MuscleStacks<'a> {
    binding: &'a Binding<'a>,
    candidates: CandidateCarriers,
    bone_axes: BoneAxes,
}

impl<'a> MuscleStacks<'a> {
    pub fn new(binding: &'a Binding<'a>) -> Self {
        Self {
            binding,
            candidates: CandidateCarriers::new(binding.musculature),
            bone_axes: BoneAxes::new(binding.musculature),
        }
    }

    /// The thicknesses below every vertex, smoothed over the mesh. The sum of its `influences` is its weight.
    pub fn thicknesses(&self, influences: &Rows<Influence>) -> Rows<Thickness> {
        let write = |chords: &mut Vec<Chord>, vertex: usize, row: &mut Vec<Thickness>| {
            self.add_row(vertex, influences.row(vertex), chords, row);
        };
        let rows = Rows::computed(influences.len(), Vec::new, write);
        smoothed(
            rows,
            self.binding.adjacency,
            self.binding.musculature.carriers().len(),
        )
    }

    fn add_row(
        &self,
        vertex: usize,
        influences: &[Influence],
        chords: &mut Vec<Chord>,
        row: &mut Vec<Thickness>,
    ) {
        let Some(outward) = self.outward(vertex, influences) else {
            return;
        };
        let Binding {
            musculature,
            points,
            bone_weights,
            ..
        } = self.binding;
        let point = points[vertex];
        let bottom_m = self.bone_axes.depth_m(point, -outward, bone_weights, vertex);
        chords.clear();
        let bones = bone_weights
            .of(vertex)
            .iter()
            .map(|entry| (entry.bone, entry.weight));
        self.candidates.for_each(bones, |carrier| {
            if let Some(chord) = chord(musculature, carrier, point, -outward, bottom_m) {
                chords.push(chord);
            }
        });
        let top_m = chords
            .iter()
            .map(|chord| chord.from_m)
            .fold(f64::INFINITY, f64::min);
        let nearness: f64 = influences.iter().map(|entry| f64::from(entry.weight)).sum();
        let reached = smooth_step(nearness / FULL_NEARNESS);
        let first = row.len();
        row.extend(chords.iter().map(|chord| Thickness {
            carrier: chord.carrier,
            across: Vec2::ZERO,
        }));
        share_out(chords, |index, from_m, to_m, fraction| {
            let axes = musculature.carriers()[chords[index].carrier as usize].axes;
            let across = (axes.transpose() * outward).truncate();
            // the radius in the middle of the part, over that of the flesh
            let middle_m = 0.5 * (from_m + to_m);
            let spread = 1.0 - (middle_m - top_m) / (bottom_m - top_m);
            row[first + index].across += (across * ((to_m - from_m) * fraction * spread * reached)).as_vec2();
        });
    }

    /// The mean outward direction of the tissues that influence a vertex; `None` if there is none.
    fn outward(&self, vertex: usize, influences: &[Influence]) -> Option<DVec3> {
        let musculature = self.binding.musculature;
        let point = self.binding.points[vertex];
        let sum = influences.iter().fold(DVec3::ZERO, |sum, entry| {
            let normal = musculature.normal_towards(entry.carrier as usize, point);
            sum + normal * f64::from(entry.weight)
        });
        let weight: f64 = influences.iter().map(|entry| f64::from(entry.weight)).sum();
        (sum.length() > SHORTEST_NORMAL * weight).then(|| sum.normalize())
    }
}

/// The part of the line from `point` in `direction` (unit) inside a carrier's belly, up to `bottom_m`.
fn chord(
    musculature: &Musculature,
    carrier: usize,
    point: DVec3,
    direction: DVec3,
    bottom_m: f64,
) -> Option<Chord> {
    let belly = musculature.belly_of(carrier)?;
    let to_unit = |vector: DVec3| (belly.axes.transpose() * vector) / belly.semi_axes;
    let (from, step) = (to_unit(point - belly.centre), to_unit(direction));
    let (a, b, c) = (step.length_squared(), from.dot(step), from.length_squared() - 1.0);
    let root = b * b - a * c;
    if root <= 0.0 {
        return None;
    }
    let (from_m, to_m) = ((-b - root.sqrt()) / a, (-b + root.sqrt()) / a);
    let to_m = to_m.min(bottom_m);
    (to_m > from_m.max(0.0)).then_some(Chord {
        carrier: carrier as u32,
        from_m,
        to_m,
    })
}

/// Calls `add` with the index, the ends and the fraction of each part of the line that is inside bellies, m from the vertex.
/// Bellies that overlap share it equally.
fn share_out(chords: &[Chord], mut add: impl FnMut(usize, f64, f64, f64)) {
    let mut ends: Vec<f64> = chords
        .iter()
        .flat_map(|chord| [chord.from_m, chord.to_m])
        .collect();
    ends.sort_unstable_by(f64::total_cmp);
    for pair in ends.windows(2) {
        let middle_m = 0.5 * (pair[0] + pair[1]);
        let is_in = |chord: &Chord| chord.from_m < middle_m && middle_m < chord.to_m;
        let fraction = 1.0 / chords.iter().filter(|chord| is_in(chord)).count() as f64;
        for (index, chord) in chords.iter().enumerate() {
            if is_in(chord) {
                add(index, pair[0], pair[1], fraction);
            }
        }
    }
}

/// The axes of all bones: from each head to the heads of the children.
struct BoneAxes {
    heads: Vec<DVec3>,
    /// Vectors from the head to other ends of the bone, m.
    ends: Vec<Vec<DVec3>>,
    /// Unit vector along a bone without children.
    along: Vec<DVec3>,
}

impl BoneAxes {
    fn new(musculature: &Musculature) -> Self {
        let skeleton = musculature.skeleton();
        let heads: Vec<DVec3> = skeleton.rest().iter().map(|rest| rest.translation).collect();
        let mut ends = vec![vec![]; heads.len()];
        for (bone, parent) in skeleton.parents().iter().enumerate() {
            if let Some(parent) = *parent {
                ends[parent].push(heads[bone] - heads[parent]);
            }
        }
        let along = skeleton
            .rest()
            .iter()
            .map(|rest| rest.matrix3.y_axis.normalize_or_zero());
        Self {
            along: along.collect(),
            heads,
            ends,
        }
    }

    /// Distance along a line from `point` at which it is nearest to the bones of a vertex, m, by their weights; infinite for
    /// a vertex without bones.
    fn depth_m(&self, point: DVec3, direction: DVec3, weights: &BoneWeights, vertex: usize) -> f64 {
        let bones = weights.of(vertex);
        if bones.is_empty() {
            return f64::INFINITY;
        }
        bones
            .iter()
            .map(|entry| {
                f64::from(entry.weight) * self.depth_of_bone_m(point, direction, entry.bone as usize)
            })
            .sum()
    }

    fn depth_of_bone_m(&self, point: DVec3, direction: DVec3, bone: usize) -> f64 {
        let to_head = self.heads[bone] - point;
        let ends = &self.ends[bone];
        if ends.is_empty() {
            // the line through the bone, without ends
            let along = self.along[bone];
            let cosine = along.dot(direction);
            let sine_squared = 1.0 - cosine * cosine;
            if sine_squared < 1e-6 {
                return to_head.dot(direction).max(0.0);
            }
            return ((to_head.dot(direction) - cosine * to_head.dot(along)) / sine_squared).max(0.0);
        }
        let nearest = ends
            .iter()
            .map(|&end| nearest_to_segment(to_head, end, direction));
        let (depth_m, _) = nearest.fold(
            (0.0, f64::INFINITY),
            |best, next| if next.1 < best.1 { next } else { best },
        );
        depth_m
    }
}

/// Where a line from the origin is nearest to the segment from `start` to `start + span`: the distance along the line, at
/// least 0, and the distance between both.
fn nearest_to_segment(start: DVec3, span: DVec3, direction: DVec3) -> (f64, f64) {
    let across = |vector: DVec3| vector - direction * vector.dot(direction);
    let (start_across, span_across) = (across(start), across(span));
    let squared = span_across.length_squared();
    let fraction = if squared > 0.0 {
        (-start_across.dot(span_across) / squared).clamp(0.0, 1.0)
    } else {
        0.5
    };
    let at = start + span * fraction;
    let depth_m = at.dot(direction).max(0.0);
    (depth_m, at.distance(direction * depth_m))
}
