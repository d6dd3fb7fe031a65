//! Binding: which tissues influence which vertices, and with what weight, from the rest pose alone
//! (mathematics/binding.md, Influence weights).
//!
//! Candidates for a vertex are the tissues along the bones that weigh there and along their parents and
//! children, or all tissues if it has no weights. Distances are those of the nearest surface points.
//! Lower bounds on them exclude most candidates without a root search.

use glam::DVec3;

use crate::math::rows::Rows;
use crate::math::smoothstep::smooth_step;
use crate::muscles::musculature::Musculature;
use crate::skin::binding::influence::{
    INFLUENCE_LIMIT, Influence, is_weak, keep_strongest, scale_to, smoothed,
};
use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::rigid_pieces::rigid_vertices;
use crate::skin::settings::bind::{Anchoring, MotionSource, SkinOptions};

/// Bone weight above which the tissues along the bone are candidates. It excludes noise of painted
/// weights.
const SMALLEST_BONE_WEIGHT: f32 = 0.01;
/// Largest distance, softness included, over that of the nearest tissue: 1000^(1/4). A tissue beyond
/// would have less than a thousandth of the nearest one's weight.
const LARGEST_DISTANCE_RATIO: f64 = 5.623_413;

/// The input of a bind. Vertices have sorted indices; points are in armature space, m.
pub(crate) struct Binding<'a> {
    pub musculature: &'a Musculature,
    pub points: &'a [DVec3],
    pub adjacency: &'a Adjacency,
    pub bone_weights: &'a BoneWeights,
    pub options: &'a SkinOptions<'a>,
}

/// A carrier and the distance of a vertex from it, m, 0 inside.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    carrier: u32,
    distance_m: f64,
}

/// Buffers of one thread.
#[derive(Default)]
struct Scratch {
    bounds: Vec<Candidate>,
    near: Vec<Candidate>,
}

impl Binding<'_> {
    /// The influences on every vertex.
    pub fn influences(&self) -> Rows<Influence> {
        let candidates = CandidateCarriers::new(self.musculature);
        let is_rigid = match self.options.motion_source {
            MotionSource::Swelling => rigid_vertices(self.adjacency, self.bone_weights, self.points.len()),
            MotionSource::Full => vec![false; self.points.len()],
        };
        let write = |scratch: &mut Scratch, vertex: usize, row: &mut Vec<Influence>| {
            if !is_rigid[vertex] {
                self.add_row(vertex, &candidates, scratch, row);
            }
        };
        let rows = Rows::computed(self.points.len(), Scratch::default, write);
        let rows = match self.options.anchoring {
            Anchoring::Nearest => rows,
            Anchoring::Blended => smoothed(rows, self.adjacency, self.musculature.carriers().len()),
        };
        let finish = |(): &mut (), vertex: usize, finished: &mut Vec<Influence>| {
            let first = finished.len();
            finished.extend_from_slice(rows.row(vertex));
            if self.follows_at_any_distance(vertex) {
                scale_to(&mut finished[first..], 1.0);
            }
            if is_weak(&finished[first..]) {
                finished.truncate(first);
            }
        };
        Rows::computed(rows.len(), || (), finish)
    }

    /// Whether a vertex has nothing to follow but tissues, so that they move it at any distance.
    fn follows_at_any_distance(&self, vertex: usize) -> bool {
        self.options.motion_source == MotionSource::Full && self.bone_weights.of(vertex).is_empty()
    }

    /// Appends the influences on a vertex, before smoothing, to `row`.
    fn add_row(
        &self,
        vertex: usize,
        candidates: &CandidateCarriers,
        scratch: &mut Scratch,
        row: &mut Vec<Influence>,
    ) {
        let falloff_m = if self.follows_at_any_distance(vertex) {
            f64::INFINITY
        } else {
            self.options.falloff_m
        };
        self.find_near(vertex, candidates, falloff_m, scratch);
        let near = &scratch.near;
        let Some(nearest) = near.iter().copied().reduce(|best, next| {
            let is_nearer = (next.distance_m, next.carrier) < (best.distance_m, best.carrier);
            if is_nearer { next } else { best }
        }) else {
            return;
        };
        let nearness = nearness(nearest.distance_m, falloff_m);
        if nearness == 0.0 {
            return;
        }
        let first = row.len();
        match self.options.anchoring {
            Anchoring::Nearest => row.push(Influence {
                carrier: nearest.carrier,
                weight: nearness as f32,
            }),
            Anchoring::Blended => {
                // relative to the nearest, so that no softness overflows
                let scale = nearest.distance_m + self.options.softness_m;
                let weight = |distance_m: f64| (scale / (distance_m + self.options.softness_m)).powi(4);
                let total: f64 = near.iter().map(|candidate| weight(candidate.distance_m)).sum();
                row.extend(near.iter().map(|candidate| Influence {
                    carrier: candidate.carrier,
                    weight: (nearness * weight(candidate.distance_m) / total) as f32,
                }));
            }
        }
        keep_strongest(row, first, 2 * INFLUENCE_LIMIT);
    }

    /// Writes the candidates that may have weight to `scratch.near`, in rising order of their bounds.
    fn find_near(
        &self,
        vertex: usize,
        candidates: &CandidateCarriers,
        falloff_m: f64,
        scratch: &mut Scratch,
    ) {
        let point = self.points[vertex];
        let Scratch { bounds, near, .. } = scratch;
        bounds.clear();
        near.clear();
        candidates.for_each(
            self.bone_weights
                .of(vertex)
                .iter()
                .map(|entry| (entry.bone, entry.weight)),
            |carrier| {
                let distance_m = self.musculature.distance_bound(carrier, point);
                bounds.push(Candidate {
                    carrier: carrier as u32,
                    distance_m,
                });
            },
        );
        bounds.sort_unstable_by(|a, b| {
            a.distance_m
                .total_cmp(&b.distance_m)
                .then(a.carrier.cmp(&b.carrier))
        });
        let softness_m = self.options.softness_m;
        let mut nearest_m = f64::INFINITY;
        for bound in bounds {
            let farthest_m = LARGEST_DISTANCE_RATIO * (nearest_m + softness_m) - softness_m;
            if bound.distance_m > farthest_m || near.is_empty() && bound.distance_m > falloff_m {
                break;
            }
            let distance_m = self
                .musculature
                .nearest(bound.carrier as usize, point)
                .distance_m
                .max(0.0);
            nearest_m = nearest_m.min(distance_m);
            near.push(Candidate { distance_m, ..*bound });
        }
    }
}

/// 1 on and in a tissue, falling smoothly to 0 at `falloff_m`.
fn nearness(distance_m: f64, falloff_m: f64) -> f64 {
    if distance_m <= 0.0 {
        return 1.0; // also if the falloff is 0
    }
    smooth_step(1.0 - distance_m / falloff_m)
}

/// The carriers that are candidates for each bone's vertices, as bit sets: those of tissues along the
/// bone, its parent or its children.
pub(crate) struct CandidateCarriers {
    words: usize,
    carriers: usize,
    by_bone: Vec<u64>,
}

impl CandidateCarriers {
    pub fn new(musculature: &Musculature) -> Self {
        let skeleton = musculature.skeleton();
        let carriers = musculature.carriers();
        let words = carriers.len().div_ceil(64);
        let mut by_bone = vec![0; words * skeleton.len()];
        for (index, carrier) in carriers.iter().enumerate() {
            let path = musculature.bones_of(carrier.tissue);
            for (bone, parent) in skeleton.parents().iter().enumerate() {
                let is_child = parent.is_some_and(|parent| path.contains(&parent));
                let is_parent = path.iter().any(|&along| skeleton.parents()[along] == Some(bone));
                if path.contains(&bone) || is_child || is_parent {
                    by_bone[bone * words + index / 64] |= 1 << (index % 64);
                }
            }
        }
        Self {
            words,
            carriers: carriers.len(),
            by_bone,
        }
    }

    /// Calls `visit` with each candidate for a vertex with these `weights` (bone, weight), in rising
    /// order; with all carriers if it has none.
    pub fn for_each(&self, weights: impl Iterator<Item = (u32, f32)> + Clone, mut visit: impl FnMut(usize)) {
        if weights.clone().next().is_none() {
            (0..self.carriers).for_each(visit);
            return;
        }
        for word in 0..self.words {
            let bones = weights
                .clone()
                .filter(|(_, weight)| *weight > SMALLEST_BONE_WEIGHT);
            let mut bits = bones.fold(0, |bits, (bone, _)| {
                bits | self.by_bone[bone as usize * self.words + word]
            });
            while bits != 0 {
                visit(word * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
    }
}
