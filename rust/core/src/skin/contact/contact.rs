//! Skin on skin: what two parts of a body press into each other is moved apart, half of the way each, and the skin around it
//! goes along (an arm on the chest, a calf on the thigh, a finger on the palm).
//!
//! It acts on the skin as bones, tissues and relaxation have left it, from that alone. Only parts that came nearer to each other
//! than they are at rest are looked at, in bounded time: `PASSES` times, each vertex against the skin within [`REACH`].
//! Deeper than that, nothing is moved: the pose itself is at fault, and the push ends smoothly before.

use glam::{DVec3, Vec3A};

use crate::skin::contact::cluster::{BoneClusters, Cluster, Pair};
use crate::skin::contact::contact_mesh::ContactMesh;
use crate::skin::contact::{cluster, thickness};
use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::regional::mean;

/// Depth up to which parts are moved apart, over the size of the body.
const REACH: f64 = 0.015;
/// Distance that parts keep, over the size of the body.
const MARGIN: f64 = 0.00025;

/// What skin on skin needs of a mesh.
#[derive(Debug)]
pub(crate) struct Contact {
    pub clusters: Vec<Cluster>,
    /// The cluster of each vertex; past the last where it is in none.
    pub cluster_of: Vec<u32>,
    pub bones: Vec<BoneClusters>,
    /// Clusters of one segment that face each other at rest.
    pub facing: Vec<Pair>,
    /// The clusters of these pairs, rising.
    pub faced: Vec<u32>,
    pub rest: Vec<Vec3A>,
    /// Where the triangles of each vertex start in `around`.
    pub offsets: Vec<u32>,
    /// The other two corners of each triangle, in turn.
    pub around: Vec<[u32; 2]>,
    pub edges: Adjacency,
    /// How fully each vertex is moved, 0..1.
    pub strength: Vec<f32>,
    /// Depth up to which the skin of each cluster is moved, m.
    pub reaches_m: Vec<f32>,
    /// The largest that any may have, m.
    pub reach_m: f32,
    pub margin_m: f32,
}

impl Contact {
    /// The contact of a mesh with itself; `normals` are those of its vertices at rest, `strength` is how fully the skin of
    /// each bone is moved, 0..1.
    pub fn new(mesh: &ContactMesh, normals: &[Vec3A], strength: &[f32]) -> Self {
        let clusters = cluster::clusters(mesh, normals);
        let low = mesh.points.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = mesh.points.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let size_m = (high - low).max_element();
        let reaches_m = thickness::reaches(mesh, &clusters, normals, (REACH * size_m) as f32);
        let facing = cluster::facing(mesh, &clusters, normals, (REACH * size_m) as f32);
        let mut faced: Vec<u32> = facing.iter().flat_map(|pair| [pair.one, pair.other]).collect();
        faced.sort_unstable();
        faced.dedup();
        let bones = cluster::by_bone(&clusters);
        let mut offsets = vec![0_u32; mesh.points.len() + 1];
        for &vertex in mesh.triangles.iter().flatten() {
            offsets[vertex as usize + 1] += 1;
        }
        for vertex in 0..mesh.points.len() {
            offsets[vertex + 1] += offsets[vertex];
        }
        let (mut next, mut around) = (offsets.clone(), vec![[0; 2]; 3 * mesh.triangles.len()]);
        for &[a, b, c] in mesh.triangles {
            for (vertex, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                around[next[vertex as usize] as usize] = others;
                next[vertex as usize] += 1;
            }
        }
        Self {
            reaches_m,
            facing,
            faced,
            bones,
            cluster_of: cluster::cluster_of(&clusters, mesh.points.len()),
            clusters,
            rest: mesh.points.iter().map(|point| point.as_vec3a()).collect(),
            offsets,
            around,
            edges: mesh.edges.clone(),
            strength: (0..mesh.points.len())
                .map(|vertex| mean(strength, mesh.weights, vertex) as f32)
                .collect(),
            reach_m: (REACH * size_m) as f32,
            margin_m: (MARGIN * size_m) as f32,
        }
    }

    /// The other two corners of each triangle at a vertex.
    pub fn around(&self, vertex: usize) -> &[[u32; 2]] {
        &self.around[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}
