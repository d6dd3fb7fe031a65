//! The order in which a skin sorted_indices its vertices: what moves with one bone and lies together, cluster after cluster, and what no
//! bone moves last.
//!
//! A frame works on the skin around some joints and on parts that meet. In a mesh's entries order these lie scattered over all of its
//! vertices (a subdivided mesh has its faces' middles after its corners), and most of what is read comes from afar. So vertices get
//! their sorted_indices once, where a mesh comes in, and get back to their places in the mesh where a frame goes out.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::parallel::REORDER_CHUNK;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::weld::representatives;

/// Most vertices of a cluster.
const LARGEST_CLUSTER: usize = 32;

/// Vertices that move with one bone, nearly, and lie together.
#[derive(Debug, Clone)]
pub(crate) struct Cluster {
    pub bone: usize,
    /// Their sorted_indices.
    pub vertices: Range<usize>,
}

/// Numbers of a mesh's vertices.
#[derive(Debug)]
pub(crate) struct VertexOrder {
    /// The mesh's vertex of each index: of those that are welded, the first.
    vertices: Vec<u32>,
    /// The index of each of the mesh's vertices; what is welded has one.
    sorted_indices: Vec<u32>,
    clusters: Vec<Cluster>,
}

impl VertexOrder {
    /// The order of a mesh's `points`, armature space, which `weights` tie to `bones` bones; all by the mesh's entries sorted_indices. What
    /// coincides and moves alike is welded.
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

    /// Number of vertices, welded.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Number of the mesh's vertices.
    pub fn mesh_len(&self) -> usize {
        self.sorted_indices.len()
    }

    /// The first of the mesh's vertices that one of them is welded to; itself where it is to none.
    pub fn representative(&self, vertex: usize) -> usize {
        self.vertices[self.sorted_indices[vertex] as usize] as usize
    }

    /// The clusters, bone by bone, of all that bones move.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// The index of one of the mesh's vertices; what is welded has one.
    pub fn sorted_index(&self, vertex: u32) -> u32 {
        self.sorted_indices[vertex as usize]
    }

    /// The mesh's vertices, by their sorted_indices; of those that are welded, the first.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = usize> {
        self.vertices.iter().map(|&vertex| vertex as usize)
    }

    /// What `of_mesh` has of the mesh's vertices, by their sorted_indices.
    pub fn sorted<T: Copy>(&self, of_mesh: &[T]) -> Vec<T> {
        self.vertices().map(|vertex| of_mesh[vertex]).collect()
    }

    /// The weights of the mesh's vertices, by their sorted_indices.
    pub fn sorted_weights(&self, of_mesh: &BoneWeights) -> BoneWeights {
        of_mesh.of_vertices(self.vertices())
    }

    /// Triangles of the mesh's vertices by their sorted_indices, beside those of the vertices beside them; less those that welding leaves no
    /// area.
    pub fn triangles(&self, mut of_mesh: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        for triangle in &mut of_mesh {
            *triangle = triangle.map(|vertex| self.sorted_index(vertex));
        }
        of_mesh.retain(|[a, b, c]| a != b && b != c && c != a);
        of_mesh.sort_by_key(|corners| corners.iter().min().copied());
        of_mesh
    }

    /// Writes what vertices have by their sorted_indices to `of_mesh`, in the mesh's entries order.
    pub fn to_mesh_order<T: Copy + Send + Sync>(&self, of_sorted: &[T], of_mesh: &mut [T]) {
        let chunks = of_mesh
            .par_chunks_mut(REORDER_CHUNK)
            .zip(self.sorted_indices.par_chunks(REORDER_CHUNK));
        chunks.for_each(|(chunk, sorted_indices)| {
            for (chunk, &index) in chunk.iter_mut().zip(sorted_indices) {
                *chunk = of_sorted[index as usize];
            }
        });
    }
}

/// The bone that moves a vertex most; of equals the first.
fn strongest_bone(weights: &BoneWeights, vertex: usize) -> Option<usize> {
    let entries = weights.of(vertex).iter();
    let strongest = entries.max_by(|a, b| a.weight.total_cmp(&b.weight).then(b.bone.cmp(&a.bone)));
    strongest.map(|entries| entries.bone as usize)
}

/// Sorts a set of vertices and halves it across its longest side until each part is small enough to be taken.
fn split(points: &[DVec3], vertices: &mut [u32], take: &mut impl FnMut(&[u32])) {
    if vertices.is_empty() {
        return;
    }
    if vertices.len() <= LARGEST_CLUSTER {
        // a subdivided mesh sorted_indices its vertices kind by kind: those with as many neighbours come one after the other, and a
        // processor foresees where the loops over them end (an eighth fewer branches go wrong)
        vertices.sort_unstable();
        take(vertices);
        return;
    }
    let point = |vertex: &u32| points[*vertex as usize];
    let low = vertices.iter().map(point).reduce(DVec3::min).unwrap_or_default();
    let high = vertices.iter().map(point).reduce(DVec3::max).unwrap_or_default();
    let longest = (high - low).max_position();
    vertices.sort_unstable_by(|a, b| point(a)[longest].total_cmp(&point(b)[longest]).then(a.cmp(b)));
    let (one, other) = vertices.split_at_mut(vertices.len() / 2);
    split(points, one, take);
    split(points, other, take);
}
