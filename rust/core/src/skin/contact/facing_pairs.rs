//! Pairs of clusters of one segment whose skin faces each other across a narrow gap at rest, as at the buttocks. They
//! move with one bone and may still be pressed together.

use glam::Vec3A;
use rayon::prelude::*;

use crate::skin::contact::cluster::{Cluster, Pair};
use crate::skin::contact::cluster_tree::ClusterTree;
use crate::skin::contact::contact_mesh::ContactMesh;
use crate::skin::contact::facing::FACING;

/// Added to a bound of a cosine, because f32 rounds.
pub(crate) const ROUNDING: f32 = 1e-4;

/// The pairs across gaps of up to `gap_m`, rising.
pub(crate) fn facing_pairs(
    mesh: &ContactMesh,
    clusters: &[Cluster],
    tree: &ClusterTree,
    normals: &[Vec3A],
    gap_m: f32,
) -> Vec<Pair> {
    let position = |vertex: usize| mesh.points[vertex].as_vec3a();
    let is_facing = |one: usize, other: usize| {
        let (vector, normal) = (position(other) - position(one), normals[one]);
        vector.length_squared() < gap_m * gap_m
            && normal.dot(normals[other]) < FACING
            && vector.dot(normal) > 0.0
    };
    let are_facing = |one: &Cluster, other: &Cluster| {
        one.segment == other.segment
            && one.axis.dot(other.axis)
                < one.cone.at_rest().and(other.cone.at_rest()).min_opposing_cos() + ROUNDING
            && one.centre.distance(other.centre) < one.radius_m + other.radius_m + gap_m
            && one
                .vertices
                .clone()
                .any(|a| other.vertices.clone().any(|b| is_facing(a, b)))
    };
    let pairs = (0..clusters.len()).into_par_iter().flat_map_iter(|index| {
        let mut pairs = vec![];
        tree.each_near(&clusters[index], gap_m, &mut |other| {
            if other >= index && are_facing(&clusters[index], &clusters[other]) {
                pairs.push(Pair {
                    one: index as u32,
                    other: other as u32,
                });
            }
        });
        pairs
    });
    pairs.collect()
}
