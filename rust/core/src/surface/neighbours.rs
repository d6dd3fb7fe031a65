//! The neighbours and quads of each vertex of a surface.

use super::extract::QuadMesh;
use crate::math::rows::Rows;

/// The vertices that share an edge with each vertex, increasing.
pub(super) fn vertex_neighbours(mesh: &QuadMesh) -> Rows<u32> {
    let sides = |quad: &[u32; 4]| {
        let [a, b, c, d] = *quad;
        [(a, b), (b, c), (c, d), (d, a), (b, a), (c, b), (d, c), (a, d)]
    };
    Rows::from_set(mesh.positions.len(), mesh.quads.iter().flat_map(sides).collect())
}

/// The quads around each vertex, increasing.
pub(super) fn quads_around(mesh: &QuadMesh) -> Rows<u32> {
    let corners = |(quad, corners): (u32, &[u32; 4])| corners.map(|vertex| (vertex, quad));
    Rows::from_set(
        mesh.positions.len(),
        (0..).zip(&mesh.quads).flat_map(corners).collect(),
    )
}
