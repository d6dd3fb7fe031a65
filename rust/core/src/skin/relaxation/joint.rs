//! Where the skin bends: the joints that muscles cross or skin surrounds, how far each reaches over the skin, and on which side of
//! it each vertex lies (ALGORITHM 5).

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use glam::DVec3;
use rayon::prelude::*;

use crate::muscles::musculature::Musculature;
use crate::pose::Skeleton;
use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::settings::segments::Segments;

/// Share of the child bone between which a vertex counts as of the transition between two bones.
const TRANSITION: std::ops::Range<f64> = 0.25..0.75;
/// Fewest such vertices of a joint that the skin shows.
const FEWEST_TRANSITION_VERTICES: usize = 4;
/// How far to one side of a joint its skin may lie, 0 all around it to 1 all on one side, for it to bend with the joint where no
/// muscle says so: a breast, an eyelid or a jaw is no limb.
const MOST_ONE_SIDED: f64 = 0.5;
/// A segment shorter than this child_weight of the next does not limit the joint between them: a pelvis, a shoulder girdle.
const SHORT_SEGMENT: f64 = 0.8;
/// Reach over the mean distance of the transition from the joint, where a short hand or foot says too little.
const REACH_OF_TRANSITION: f64 = 4.0;
/// A patch's radius over its joint's.
const PATCH_RADII: f64 = 1.3;

/// A joint, at the head of its child bone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Joint {
    pub child: usize,
    pub parent: usize,
    /// The head of the child bone at rest, armature space, m.
    pub centre: DVec3,
    /// Reach over the skin, m.
    pub radius_m: f64,
    /// Direction of the child bone at rest.
    pub direction: DVec3,
    /// From the head of the parent bone to the joint at rest, m.
    pub from_parent: DVec3,
}

/// A joint as the mesh shows it, while it is bound.
#[derive(Debug)]
pub(crate) struct JointSkin {
    pub joint: Joint,
    /// Whether each bone is the child or below it.
    pub is_below: Vec<bool>,
    /// Share of each of the mesh's vertices that hangs on the child bone and all below it.
    pub child_weight: Vec<f32>,
    /// The vertices within [`PATCH_RADII`] radii of the joint, rising.
    pub patch: Vec<u32>,
}

/// All joints that the skin shows and bends at: those that muscles of `musculature` cross, and those that it surrounds, in the
/// order of their child bones.
pub(crate) fn joints(
    musculature: &Musculature,
    points: &[DVec3],
    edges: &Adjacency,
    weights: &BoneWeights,
    segments: &Segments,
) -> Vec<JointSkin> {
    let skeleton = musculature.skeleton();
    let lengths = segment_lengths(segments);
    let length_of = |bone: usize| lengths[&segments.of_bone[bone]];
    let crossed = crossed(musculature);
    let joint_of = |child: usize| {
        let parent = skeleton.parents()[child]?;
        let is_below = below(skeleton, child);
        let child_weight = child_weights(&is_below, points.len(), weights);
        let centre = skeleton.rest()[child].translation;
        let axis = skeleton.rest()[child].matrix3.y_axis.normalize_or(DVec3::Y);
        let transition = Transition::new(points, &child_weight, centre, axis)?;
        if !crossed[child] && transition.one_sided > MOST_ONE_SIDED {
            return None;
        }
        let (own_m, above_m) = (length_of(child), length_of(parent));
        let is_split = segments.of_bone[child] == segments.of_bone[parent];
        let limiting_m = if is_split || above_m < SHORT_SEGMENT * own_m {
            own_m
        } else {
            own_m.min(above_m)
        };
        let joint = Joint {
            child,
            parent,
            centre,
            radius_m: (0.5 * limiting_m)
                .max((0.5 * above_m).min(REACH_OF_TRANSITION * transition.distance_m)),
            direction: axis,
            from_parent: centre - skeleton.rest()[parent].translation,
        };
        Some(JointSkin {
            patch: joint.patch(points, edges, weights, &child_weight),
            joint,
            is_below,
            child_weight,
        })
    };
    (0..skeleton.len()).into_par_iter().filter_map(joint_of).collect()
}

impl Joint {
    /// Distance of a point from the joint at rest, in the joint's radii.
    pub fn radii_to(&self, point: DVec3) -> f64 {
        point.distance(self.centre) / self.radius_m
    }

    /// The vertices within [`PATCH_RADII`] radii of the joint, through space and along the skin from its transition, rising. Along
    /// the skin, because through space the other leg is as near; and not over vertices that no bone moves.
    fn patch(&self, points: &[DVec3], edges: &Adjacency, weights: &BoneWeights, child_weight: &[f32]) -> Vec<u32> {
        let limit_m = PATCH_RADII * self.radius_m;
        let is_near =
            |vertex: usize| points[vertex].distance(self.centre) < limit_m && !weights.of(vertex).is_empty();
        let mut along_m = vec![f64::INFINITY; points.len()];
        let mut queue = BinaryHeap::new();
        for vertex in 0..points.len() {
            if TRANSITION.contains(&f64::from(child_weight[vertex])) && is_near(vertex) {
                along_m[vertex] = 0.0;
                queue.push(Reached(0.0, vertex as u32));
            }
        }
        while let Some(Reached(reached_m, vertex)) = queue.pop() {
            let from = vertex as usize;
            if reached_m > along_m[from] {
                continue;
            }
            for &neighbour in edges.neighbours(from) {
                let to = neighbour as usize;
                let next_m = reached_m + points[from].distance(points[to]);
                if next_m < along_m[to] && next_m < limit_m && is_near(to) {
                    along_m[to] = next_m;
                    queue.push(Reached(next_m, neighbour));
                }
            }
        }
        (0..points.len() as u32)
            .filter(|&vertex| along_m[vertex as usize] < limit_m)
            .collect()
    }
}

/// A vertex and how far it was reached along the skin, m; the nearest comes first.
#[derive(PartialEq)]
struct Reached(f64, u32);

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Whether a muscle's bones pass from each bone to its parent.
fn crossed(musculature: &Musculature) -> Vec<bool> {
    let skeleton = musculature.skeleton();
    let mut crossed = vec![false; skeleton.len()];
    for tissue in musculature
        .tissues()
        .iter()
        .filter(|tissue| tissue.muscle().is_some())
    {
        let path = skeleton.path(tissue.origin_bone(), tissue.insertion_bone());
        for &bone in &path {
            crossed[bone] |= skeleton.parents()[bone].is_some_and(|parent| path.contains(&parent));
        }
    }
    crossed
}

fn segment_lengths(segments: &Segments) -> HashMap<i32, f64> {
    let mut lengths = HashMap::new();
    for (&segment, &length_m) in segments.of_bone.iter().zip(segments.lengths_m) {
        *lengths.entry(segment).or_default() += f64::from(length_m);
    }
    lengths
}

fn below(skeleton: &Skeleton, child: usize) -> Vec<bool> {
    let is_below = |bone: usize| {
        std::iter::successors(Some(bone), |&bone| skeleton.parents()[bone]).any(|bone| bone == child)
    };
    (0..skeleton.len()).map(is_below).collect()
}

fn child_weights(is_below: &[bool], vertices: usize, weights: &BoneWeights) -> Vec<f32> {
    let weight_of = |vertex| {
        let own = weights.of(vertex).iter();
        own.filter(|own| is_below[own.bone as usize])
            .map(|own| own.weight)
            .sum()
    };
    (0..vertices).map(weight_of).collect()
}

/// The skin between the two bones of a joint.
struct Transition {
    /// Mean distance from the joint, m.
    distance_m: f64,
    /// 0 where it lies all around the bone's axis, 1 where all on one side.
    one_sided: f64,
}

impl Transition {
    /// The transition around `centre`, or `None` where the skin hardly has any.
    fn new(points: &[DVec3], child_weight: &[f32], centre: DVec3, axis: DVec3) -> Option<Self> {
        let (mut count, mut distance, mut side, mut total) = (0, 0.0, DVec3::ZERO, 0.0);
        for (point, &child_weight) in points.iter().zip(child_weight) {
            let child_weight = f64::from(child_weight);
            if TRANSITION.contains(&child_weight) {
                let (weight, from_centre) = (child_weight * (1.0 - child_weight), *point - centre);
                count += 1;
                total += weight;
                distance += weight * from_centre.length();
                side += from_centre.reject_from_normalized(axis).normalize_or_zero() * weight;
            }
        }
        (count >= FEWEST_TRANSITION_VERTICES).then(|| Self {
            distance_m: distance / total,
            one_sided: side.length() / total,
        })
    }
}
