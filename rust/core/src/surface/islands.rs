//! The connected pieces of a surface.

use super::extract::QuadMesh;
use crate::math::union_find::UnionFind;

/// For each vertex, the first vertex of its piece.
pub(super) fn pieces(mesh: &QuadMesh) -> Vec<u32> {
    let mut parts = UnionFind::new(mesh.positions.len());
    for quad in &mesh.quads {
        for corner in 1..4 {
            parts.join(quad[0], quad[corner]);
        }
    }
    parts.roots()
}

/// The number of pieces.
pub(super) fn count(pieces: &[u32]) -> usize {
    pieces
        .iter()
        .zip(0..)
        .filter(|(piece, vertex)| **piece == *vertex)
        .count()
}

/// Removes all pieces but the one with most vertices.
pub(super) fn keep_largest(mesh: &mut QuadMesh, pieces: &[u32]) {
    let mut sizes = vec![0_usize; pieces.len()];
    pieces.iter().for_each(|&piece| sizes[piece as usize] += 1);
    let Some(largest) = (0..sizes.len()).rev().max_by_key(|&piece| sizes[piece]) else {
        return;
    };
    let mut numbers = vec![0_u32; pieces.len()];
    let mut kept = QuadMesh::default();
    for (vertex, &piece) in pieces.iter().enumerate() {
        if piece as usize == largest {
            numbers[vertex] = kept.cells.len() as u32;
            kept.cells.push(mesh.cells[vertex]);
            kept.positions.push(mesh.positions[vertex]);
        }
    }
    let quads = mesh
        .quads
        .iter()
        .filter(|quad| pieces[quad[0] as usize] as usize == largest);
    kept.quads = quads
        .map(|quad| quad.map(|corner| numbers[corner as usize]))
        .collect();
    *mesh = kept;
}
