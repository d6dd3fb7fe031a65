//! The order in which a skin stores vertices: sorted by bone, then by cluster of vertices that are near
//! each other. Vertices that no bone moves are last (mathematics/skinning.md, Vertex order).
//!
//! A frame works on the skin around some joints and on parts in contact. In the order of the mesh these
//! vertices are scattered, since a subdivided mesh lists the centres of its faces after its corners, and
//! most reads would miss the cache. Vertices are therefore sorted once at bind, and results are put back
//! into the mesh's order.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::math::rows::Rows;
use crate::parallel::REORDER_CHUNK;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::weld::representatives;

/// Most vertices of a cluster. Small clusters make contact's tests tight; large ones make few pairs.
const LARGEST_CLUSTER: usize = 32;

/// Vertices that mostly move with one bone and are near each other.
#[derive(Debug, Clone)]
pub(crate) struct Cluster {
    pub bone: usize,
    /// Their sorted indices.
    pub vertices: Range<usize>,
}

/// The order of a mesh's vertices. Vertices that coincide and move alike are welded: they have one sorted
/// index.
#[derive(Debug)]
pub(crate) struct VertexOrder {
    /// The mesh index of each sorted index; of welded vertices, the first.
    vertices: Vec<u32>,
    /// The sorted index of each mesh index.
    sorted_indices: Vec<u32>,
    clusters: Vec<Cluster>,
}

impl VertexOrder {
    /// The order of a mesh with `points`, armature space, m, and `weights` for `bones` bones, both by
    /// mesh index.
    pub fn new(points: &[DVec3], weights: &BoneWeights, bones: usize) -> Self {
        let welded = representatives(points, weights);
        let mut of_bone: Vec<Vec<u32>> = vec![vec![]; bones];
        let mut unweighted = vec![];
        let is_first = |vertex: &usize| welded[*vertex] as usize == *vertex;
        for vertex in (0..points.len()).filter(is_first) {
            let list = match strongest_bone(weights, vertex) {
                Some(bone) => &mut of_bone[bone],
                None => &mut unweighted,
            };
            list.push(vertex as u32);
        }
        let (mut vertices, mut clusters) = (Vec::with_capacity(points.len()), vec![]);
        for (bone, mut entries) in of_bone.into_iter().enumerate() {
            split(points, &mut entries, &mut |cluster| {
                let first = vertices.len();
                vertices.extend_from_slice(cluster);
                clusters.push(Cluster {
                    bone,
                    vertices: first..vertices.len(),
                });
            });
        }
        vertices.extend(unweighted);
        let mut sorted_indices = vec![0; points.len()];
        for (index, &vertex) in vertices.iter().enumerate() {
            sorted_indices[vertex as usize] = index as u32;
        }
        for (vertex, &first) in welded.iter().enumerate() {
            sorted_indices[vertex] = sorted_indices[first as usize];
        }
        Self {
            vertices,
            sorted_indices,
            clusters,
        }
    }

    /// Number of sorted indices: vertices after welding.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Number of vertices of the mesh.
    pub fn mesh_len(&self) -> usize {
        self.sorted_indices.len()
    }

    /// The first of the mesh's vertices that `vertex` is welded to, or `vertex` itself.
    pub fn representative(&self, vertex: usize) -> usize {
        self.vertices[self.sorted_indices[vertex] as usize] as usize
    }

    /// The clusters of all vertices that bones move, bone by bone.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// The sorted index of a vertex of the mesh.
    pub fn sorted_index(&self, vertex: u32) -> u32 {
        self.sorted_indices[vertex as usize]
    }

    /// The mesh index of each sorted index; of welded vertices, the first.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = usize> {
        self.vertices.iter().map(|&vertex| vertex as usize)
    }

    /// The entries of `of_mesh` in sorted order.
    pub fn sorted<T: Copy>(&self, of_mesh: &[T]) -> Vec<T> {
        self.vertices().map(|vertex| of_mesh[vertex]).collect()
    }

    /// The weights `of_mesh` in sorted order.
    pub fn sorted_weights(&self, of_mesh: &BoneWeights) -> BoneWeights {
        of_mesh.of_vertices(self.vertices())
    }

    /// Triangles `of_mesh` with sorted indices, each at its lowest corner. Triangles that welding leaves without
    /// area are removed.
    pub fn triangles(&self, of_mesh: Vec<[u32; 3]>) -> Rows<[u32; 3]> {
        let sorted = of_mesh
            .into_iter()
            .map(|corners| corners.map(|vertex| self.sorted_index(vertex)));
        let pairs: Vec<(u32, [u32; 3])> = sorted
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .map(|[a, b, c]| (a.min(b).min(c), [a, b, c]))
            .collect();
        Rows::from_pairs(self.len(), &pairs)
    }

    /// Writes the entries `of_sorted` to `of_mesh` in the mesh's order.
    pub fn to_mesh_order<T: Copy + Send + Sync>(&self, of_sorted: &[T], of_mesh: &mut [T]) {
        let chunks = of_mesh
            .par_chunks_mut(REORDER_CHUNK)
            .zip(self.sorted_indices.par_chunks(REORDER_CHUNK));
        chunks.for_each(|(of_mesh, sorted_indices)| {
            for (entry, &index) in of_mesh.iter_mut().zip(sorted_indices) {
                *entry = of_sorted[index as usize];
            }
        });
    }
}

/// The bone with the largest weight at a vertex; of equals the first.
fn strongest_bone(weights: &BoneWeights, vertex: usize) -> Option<usize> {
    let entries = weights.of(vertex).iter();
    let strongest = entries.max_by(|a, b| a.weight.total_cmp(&b.weight).then(b.bone.cmp(&a.bone)));
    strongest.map(|entry| entry.bone as usize)
}

/// Splits a set of vertices across the longest side of its box until each part is small enough, and calls
/// `take` with each part.
fn split(points: &[DVec3], vertices: &mut [u32], take: &mut impl FnMut(&[u32])) {
    if vertices.is_empty() {
        return;
    }
    if vertices.len() <= LARGEST_CLUSTER {
        // A subdivided mesh numbers vertices kind by kind, so rising indices put vertices with equally
        // many neighbours in a row. The processor then predicts the ends of the loops over them (an
        // eighth fewer branch misses).
        vertices.sort_unstable();
        take(vertices);
        return;
    }
    let point = |vertex: &u32| points[*vertex as usize];
    let low = vertices.iter().map(point).reduce(DVec3::min).unwrap_or_default();
    let high = vertices.iter().map(point).reduce(DVec3::max).unwrap_or_default();
    let longest = (high - low).max_position();
    let middle = vertices.len() / 2;
    vertices.select_nth_unstable_by(middle, |a, b| {
        point(a)[longest].total_cmp(&point(b)[longest]).then(a.cmp(b))
    });
    let (one, other) = vertices.split_at_mut(middle);
    split(points, one, take);
    split(points, other, take);
}
