//! Bind data of skin contact: skin of two parts that press into each other (an arm on the chest, a calf
//! on the thigh, a finger on the palm) is moved apart, half by each, and the skin around it follows
//! (mathematics/contact.md, Skin contact).
//!
//! Contact acts on the skin as bones, tissues and relaxation left it, and depends on nothing else. Only
//! parts that came nearer to each other than at rest are tested, in a fixed number of passes and up to
//! [`REACH`]. Deeper skin is not moved, since the pose itself is wrong there; contact fades out before.

use glam::{DVec3, Vec3A};

use crate::math::rows::Rows;
use crate::skin::contact::cluster::{BoneClusters, Cluster, Pair};
use crate::skin::contact::cluster_tree::ClusterTree;
use crate::skin::contact::contact_mesh::ContactMesh;
use crate::skin::contact::facing_pairs::facing_pairs;
use crate::skin::contact::{cluster, thickness};
use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::regional::mean;

/// Depth up to which parts are moved apart, as a fraction of the body's size: 26 mm on a body of 1.73 m.
/// Deeper than that, flesh would not yield.
const REACH: f64 = 0.015;
/// Distance that parts keep, as a fraction of the body's size: 0.43 mm on a body of 1.73 m, above f32
/// rounding and not visible.
const MARGIN: f64 = 0.00025;

/// The bind data of contact. Vertices have sorted indices.
#[derive(Debug)]
pub(crate) struct Contact {
    pub clusters: Vec<Cluster>,
    /// The cluster of each vertex; `u32::MAX` if it is in none.
    pub cluster_of: Vec<u32>,
    pub bones: Vec<BoneClusters>,
    /// Pairs of clusters of one segment that face each other at rest.
    pub facing_pairs: Vec<Pair>,
    /// The clusters of these pairs, rising.
    pub facing_clusters: Vec<u32>,
    pub rest: Vec<Vec3A>,
    /// The other two corners of each triangle at a vertex, in order.
    pub around: Rows<[u32; 2]>,
    pub edges: Adjacency,
    /// Strength of contact at each vertex, 0 to 1.
    pub strength: Vec<f32>,
    /// Reach of each cluster: the depth up to which its skin is moved, m.
    pub reaches_m: Vec<f32>,
    /// Largest reach, m.
    pub reach_m: f32,
    pub margin_m: f32,
}

impl Contact {
    /// The contact of a mesh with itself. `normals` are the vertices' unit normals at rest, `strength` is
    /// that of each bone, 0 to 1.
    pub fn new(mesh: &ContactMesh, normals: &[Vec3A], strength: &[f32]) -> Self {
        let clusters = cluster::clusters(mesh, normals);
        let low = mesh.points.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = mesh.points.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let size_m = (high - low).max_element();
        let (tree, reach_m) = (ClusterTree::new(&clusters), (REACH * size_m) as f32);
        let reaches_m = thickness::reaches(mesh, &clusters, &tree, normals, reach_m);
        let facing = facing_pairs(mesh, &clusters, &tree, normals, reach_m);
        let mut facing_clusters: Vec<u32> = facing.iter().flat_map(|pair| [pair.one, pair.other]).collect();
        facing_clusters.sort_unstable();
        facing_clusters.dedup();
        let bones = cluster::by_bone(&clusters);
        let triangles = mesh.triangles.iter();
        let corners: Vec<(u32, [u32; 2])> = triangles
            .flat_map(|&[a, b, c]| [(a, [b, c]), (b, [c, a]), (c, [a, b])])
            .collect();
        Self {
            reaches_m,
            facing_pairs: facing,
            facing_clusters,
            bones,
            cluster_of: cluster::cluster_of(&clusters, mesh.points.len()),
            clusters,
            rest: mesh.points.iter().map(|point| point.as_vec3a()).collect(),
            around: Rows::from_pairs(mesh.points.len(), &corners),
            edges: mesh.edges.clone(),
            strength: (0..mesh.points.len())
                .map(|vertex| mean(strength, mesh.weights, vertex) as f32)
                .collect(),
            reach_m,
            margin_m: (MARGIN * size_m) as f32,
        }
    }

    /// The other two corners of each triangle at a vertex.
    pub fn around(&self, vertex: usize) -> &[[u32; 2]] {
        self.around.row(vertex)
    }
}
