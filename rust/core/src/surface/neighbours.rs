//! What lies around each vertex of a surface, in compressed rows.

use super::extract::QuadMesh;

/// A row of numbers for each vertex.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    offsets: Vec<u32>,
    entries: Vec<u32>,
}

impl Rows {
    /// The rows of (vertex, entry) pairs; each row rises, without repetition.
    fn new(vertices: usize, mut pairs: Vec<(u32, u32)>) -> Self {
        pairs.sort_unstable();
        pairs.dedup();
        let mut offsets = vec![0; vertices + 1];
        pairs
            .iter()
            .for_each(|&(vertex, _)| offsets[vertex as usize + 1] += 1);
        (0..vertices).for_each(|vertex| offsets[vertex + 1] += offsets[vertex]);
        Self {
            offsets,
            entries: pairs.into_iter().map(|(_, entry)| entry).collect(),
        }
    }

    /// The vertices that share an edge with each.
    pub fn of_vertices(mesh: &QuadMesh) -> Self {
        let sides = |quad: &[u32; 4]| {
            let [a, b, c, d] = *quad;
            [(a, b), (b, c), (c, d), (d, a), (b, a), (c, b), (d, c), (a, d)]
        };
        Self::new(mesh.places.len(), mesh.quads.iter().flat_map(sides).collect())
    }

    /// The quads around each vertex.
    pub fn of_quads(mesh: &QuadMesh) -> Self {
        let corners = |(quad, corners): (u32, &[u32; 4])| corners.map(|vertex| (vertex, quad));
        Self::new(
            mesh.places.len(),
            (0..).zip(&mesh.quads).flat_map(corners).collect(),
        )
    }

    /// The row of a vertex.
    pub fn of(&self, vertex: usize) -> &[u32] {
        &self.entries[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}
