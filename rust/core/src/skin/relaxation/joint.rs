//! The joints at which the skin bends: those that muscles cross or that skin surrounds, how far each
//! reaches over the skin, and which side each vertex is on (mathematics/relaxation.md, Joints).

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::math::rows::Rows;
use crate::muscles::musculature::Musculature;
use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::along_skin::distances_along_skin;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::settings::segments::Segments;

/// Weight on the child side between which a vertex belongs to the transition between two bones. The
/// middle half, so that noise in weights near 0 and 1 does not count.
const TRANSITION: std::ops::Range<f64> = 0.25..0.75;
/// Fewest vertices in the transition of a joint. Fewer say nothing about a joint.
const FEWEST_TRANSITION_VERTICES: usize = 4;
/// Largest one-sidedness of a joint's transition, 0 if the skin surrounds the joint and 1 if all of it is
/// on one side. Above it the joint counts only if a muscle crosses it: a breast, an eyelid or a jaw is
/// not a limb.
const MOST_ONE_SIDED: f64 = 0.5;
/// Length of the parent's segment, over that of the child's, below which it does not limit the joint's
/// radius: a pelvis or a shoulder girdle is short, but its skin is not.
const SHORT_SEGMENT: f64 = 0.8;
/// Smallest radius, over the mean distance of the transition from the joint. A short hand or foot alone
/// would give too small a radius.
const REACH_OF_TRANSITION: f64 = 4.0;
/// Radius of a patch, in radii of its joint. It must not be below the end of the fade in `elastic.rs`.
const PATCH_RADII: f64 = 1.3;

/// A joint, at the head of its child bone. Positions are at rest in armature space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Joint {
    pub child: usize,
    pub parent: usize,
    /// The head of the child bone, m.
    pub centre: DVec3,
    /// Radius of the skin that the joint bends, m.
    pub radius_m: f64,
    /// Unit direction of the child bone.
    pub direction: DVec3,
    /// Vector from the head of the parent bone to the joint, m.
    pub from_parent: DVec3,
}

/// A joint and its skin, while the mesh is bound.
#[derive(Debug)]
pub(crate) struct JointSkin {
    pub joint: Joint,
    /// Whether each bone is the child bone or a descendant of it.
    pub is_below: Vec<bool>,
    /// The vertices within [`PATCH_RADII`] radii of the joint, rising.
    pub patch: Vec<u32>,
    /// The child weight of each vertex of the patch.
    pub child_weights: Vec<f32>,
}

/// All joints at which the skin bends, in the order of their child bones: those that muscles of
/// `musculature` cross, and those that the skin surrounds.
pub(crate) fn joints(
    musculature: &Musculature,
    points: &[DVec3],
    edges: &Adjacency,
    weights: &BoneWeights,
    segments: &Segments,
) -> Vec<JointSkin> {
    let skeleton = musculature.skeleton();
    let weighed = WeighedVertices::new(points.len(), weights, skeleton.len());
    let lengths = segment_lengths(segments);
    let length_of = |bone: usize| lengths[&segments.of_bone[bone]];
    let crossed = crossed(musculature);
    let joint_of = |child: usize| {
        let parent = skeleton.parents()[child]?;
        let is_below: Vec<bool> = (0..skeleton.len())
            .map(|bone| skeleton.is_below(bone, child))
            .collect();
        let child_weights = weighed.child_weights(&is_below, weights);
        let centre = skeleton.rest()[child].translation;
        let axis = skeleton.rest()[child].matrix3.y_axis.normalize_or(DVec3::Y);
        let transition = Transition::new(points, &child_weights, centre, axis)?;
        if !crossed[child] && transition.one_sided > MOST_ONE_SIDED {
            return None;
        }
        let (child_m, parent_m) = (length_of(child), length_of(parent));
        let is_split = segments.of_bone[child] == segments.of_bone[parent];
        let limiting_m = if is_split || parent_m < SHORT_SEGMENT * child_m {
            child_m
        } else {
            child_m.min(parent_m)
        };
        let joint = Joint {
            child,
            parent,
            centre,
            radius_m: (0.5 * limiting_m)
                .max((0.5 * parent_m).min(REACH_OF_TRANSITION * transition.distance_m)),
            direction: axis,
            from_parent: centre - skeleton.rest()[parent].translation,
        };
        let patch = joint.patch(points, edges, weights, &child_weights);
        Some(JointSkin {
            child_weights: of_patch(&patch, &child_weights),
            joint,
            is_below,
            patch,
        })
    };
    (0..skeleton.len()).into_par_iter().filter_map(joint_of).collect()
}

impl Joint {
    /// Distance of a point from the joint at rest, in radii of the joint.
    pub fn radii_to(&self, point: DVec3) -> f64 {
        point.distance(self.centre) / self.radius_m
    }

    /// The vertices within [`PATCH_RADII`] radii of the joint, in space and along the skin from its
    /// transition, rising. The distance along the skin (Dijkstra) excludes the other leg, which is as
    /// near in space. Vertices that no bone moves are not crossed.
    fn patch(
        &self,
        points: &[DVec3],
        edges: &Adjacency,
        weights: &BoneWeights,
        child_weights: &[(u32, f32)],
    ) -> Vec<u32> {
        let limit_m = PATCH_RADII * self.radius_m;
        let is_near =
            |vertex: usize| points[vertex].distance(self.centre) < limit_m && !weights.of(vertex).is_empty();
        let is_source = |&&(vertex, child_weight): &&(u32, f32)| {
            TRANSITION.contains(&f64::from(child_weight)) && is_near(vertex as usize)
        };
        let along_m = distances_along_skin(
            points.len(),
            child_weights.iter().filter(is_source).map(|&(vertex, _)| vertex),
            limit_m,
            |vertex| edges.neighbours(vertex),
            |from, to| points[from].distance(points[to]),
            is_near,
        );
        (0..points.len() as u32)
            .filter(|&vertex| along_m[vertex as usize] < limit_m)
            .collect()
    }
}

impl JointSkin {
    /// The vertices of the patch, each with its child weight.
    pub fn weighed_patch(&self) -> impl Iterator<Item = (usize, f32)> {
        let vertices = self.patch.iter().map(|&vertex| vertex as usize);
        vertices.zip(self.child_weights.iter().copied())
    }

    /// The child weight of a vertex; `None` if it is not in the patch.
    pub fn child_weight(&self, vertex: u32) -> Option<f32> {
        let slot = self.patch.binary_search(&vertex).ok()?;
        Some(self.child_weights[slot])
    }
}

/// Whether a muscle's path through the hierarchy leads from each bone to its parent.
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

/// The vertices that each bone moves, so that the skin below a joint is found without a look at all vertices.
struct WeighedVertices(Rows<u32>);

impl WeighedVertices {
    fn new(vertices: usize, weights: &BoneWeights, bones: usize) -> Self {
        let entries =
            (0..vertices).flat_map(|vertex| weights.of(vertex).iter().map(move |entry| (entry, vertex)));
        let pairs: Vec<(u32, u32)> = entries
            .map(|(entry, vertex)| (entry.bone, vertex as u32))
            .collect();
        Self(Rows::from_pairs(bones, &pairs))
    }

    /// The vertices with weight on a bone that `is_below` the joint, rising, each with its child weight.
    fn child_weights(&self, is_below: &[bool], weights: &BoneWeights) -> Vec<(u32, f32)> {
        let bones = (0..is_below.len()).filter(|&bone| is_below[bone]);
        let mut vertices: Vec<u32> = bones.flat_map(|bone| self.0.row(bone)).copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let weight_of = |vertex: u32| {
            let weights = weights.of(vertex as usize).iter();
            weights
                .filter(|entry| is_below[entry.bone as usize])
                .map(|entry| entry.weight)
                .sum()
        };
        vertices
            .into_iter()
            .map(|vertex| (vertex, weight_of(vertex)))
            .collect()
    }
}

/// The child weight of each vertex of a `patch`; 0 where none is given. Both lists are rising.
fn of_patch(patch: &[u32], child_weights: &[(u32, f32)]) -> Vec<f32> {
    let mut rest = child_weights;
    let weight_of = |&vertex: &u32| {
        let before = rest.partition_point(|&(other, _)| other < vertex);
        rest = &rest[before..];
        rest.first()
            .filter(|&&(other, _)| other == vertex)
            .map_or(0.0, |&(_, weight)| weight)
    };
    patch.iter().map(weight_of).collect()
}

/// The skin between the two bones of a joint.
struct Transition {
    /// Mean distance from the joint, m.
    distance_m: f64,
    /// 0 if it surrounds the bone's axis, 1 if all of it is on one side.
    one_sided: f64,
}

impl Transition {
    /// The transition around `centre`, or `None` if it has too few vertices.
    fn new(points: &[DVec3], child_weights: &[(u32, f32)], centre: DVec3, axis: DVec3) -> Option<Self> {
        let (mut count, mut distance, mut side, mut total) = (0, 0.0, DVec3::ZERO, 0.0);
        for &(vertex, child_weight) in child_weights {
            let child_weight = f64::from(child_weight);
            if TRANSITION.contains(&child_weight) {
                let from_centre = points[vertex as usize] - centre;
                let weight = child_weight * (1.0 - child_weight);
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
