//! The depth up to which skin contact acts, by the thickness of the flesh: skin that went through a
//! finger or a lip is left alone (mathematics/contact.md, Skin contact).

use glam::Vec3A;
use rayon::prelude::*;

use crate::skin::contact::cluster::Cluster;
use crate::skin::contact::cluster_tree::ClusterTree;
use crate::skin::contact::contact_mesh::ContactMesh;
use crate::skin::contact::facing_pairs::ROUNDING;

/// Reach over the thickness of the flesh. Each side moves half of it, so the two walls stay apart.
const REACH_OF_THICKNESS: f32 = 0.6;
/// Vertices of a cluster whose thickness is measured, to bound the time of a bind.
const SAMPLES: usize = 12;
/// Cosine of two normals below which two walls of skin count as opposite.
const OPPOSITE_COS: f32 = -0.5;
/// Cosine between the vector to the opposite wall and the normal below which the vector counts as
/// straight inwards.
const INWARD_COS: f32 = -0.8;

/// The reach of each cluster, m: `most_m`, or a fraction of its thinnest flesh.
pub(crate) fn reaches(
    mesh: &ContactMesh,
    clusters: &[Cluster],
    tree: &ClusterTree,
    normals: &[Vec3A],
    most_m: f32,
) -> Vec<f32> {
    let thickest_m = most_m / REACH_OF_THICKNESS;
    let of_cluster = |cluster: &Cluster| {
        let mut near = vec![];
        tree.each_near(cluster, thickest_m, &mut |other| {
            let other = &clusters[other];
            near.push((other, other.cone.at_rest().min_cos(OPPOSITE_COS) + ROUNDING));
        });
        let step = cluster.vertices.len().div_ceil(SAMPLES).max(1);
        let samples = cluster.vertices.clone().step_by(step);
        let thinnest_m = samples.fold(thickest_m, |least, vertex| {
            thickness_m(mesh, &near, normals, vertex, least)
        });
        REACH_OF_THICKNESS * thinnest_m
    };
    clusters.par_iter().map(of_cluster).collect()
}

/// The distance from a vertex straight inwards to the opposite skin, m, of the clusters `near`; up to `most_m`. With
/// each cluster comes the cosine between its axis and a normal below which it may be opposite.
fn thickness_m(
    mesh: &ContactMesh,
    near: &[(&Cluster, f32)],
    normals: &[Vec3A],
    vertex: usize,
    most_m: f32,
) -> f32 {
    let position = |vertex: usize| mesh.points[vertex].as_vec3a();
    let (from, normal) = (position(vertex), normals[vertex]);
    let mut least = most_m;
    for (cluster, min_cos) in near {
        if !cluster.may_reach(from, least) || cluster.axis.dot(normal) >= *min_cos {
            continue;
        }
        for other in cluster.vertices.clone() {
            let vector = position(other) - from;
            let length = vector.length();
            let is_wall = normals[other].dot(normal) < OPPOSITE_COS;
            if length < least && is_wall && vector.dot(normal) < INWARD_COS * length {
                least = length;
            }
        }
    }
    least
}
