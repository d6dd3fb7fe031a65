//! Pieces of a mesh that one bone moves rigidly: armour, eyes, teeth, the limbs of a robot
//! (mathematics/binding.md, Rigid pieces).

use crate::math::union_find::UnionFind;
use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::bone_weights::{BoneWeight, BoneWeights};

/// Fraction of a vertex's weight from which one bone has all of it. Files round weights to 1/255.
const WHOLE: f32 = 1.0 - 1.0 / 254.0;

/// Whether each vertex belongs to a rigid piece: a connected piece with an edge, all of whose vertices
/// follow one bone.
pub(crate) fn rigid_vertices(adjacency: &Adjacency, weights: &BoneWeights, vertices: usize) -> Vec<bool> {
    let mut pieces = UnionFind::new(vertices);
    for vertex in 0..vertices {
        for &neighbour in adjacency.neighbours(vertex) {
            pieces.join(vertex as u32, neighbour);
        }
    }
    let first = pieces.roots();
    let mut is_rigid: Vec<bool> = (0..vertices)
        .map(|vertex| !adjacency.neighbours(vertex).is_empty())
        .collect();
    for (vertex, &root) in first.iter().enumerate() {
        let root = root as usize;
        let bone = only_bone(weights.of(vertex));
        if bone.is_none() || bone != only_bone(weights.of(root)) {
            is_rigid[root] = false;
        }
    }
    first.iter().map(|&root| is_rigid[root as usize]).collect()
}

/// The bone that has all the weight of a row.
fn only_bone(row: &[BoneWeight]) -> Option<u32> {
    row.iter()
        .find(|entry| entry.weight >= WHOLE)
        .map(|entry| entry.bone)
}
