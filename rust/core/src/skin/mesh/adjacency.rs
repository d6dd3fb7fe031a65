//! Which vertices of a mesh are neighbours.

use crate::error::{Result, require_vertex};
use crate::skin::mesh::vertex_order::VertexOrder;

/// The neighbours of each vertex, rising, in compressed rows; all by their numbers in a skin's order.
#[derive(Debug, Clone)]
pub(crate) struct Adjacency {
    offsets: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Adjacency {
    /// The neighbours along `edges` of a mesh whose vertices are numbered by `order`.
    ///
    /// # Errors
    /// [`Error::Index`](crate::error::Error::Index) for an edge to a vertex that is not there.
    pub fn new(order: &VertexOrder, edges: &[[i32; 2]]) -> Result<Self> {
        let vertices = order.len();
        let mut pairs = Vec::with_capacity(2 * edges.len());
        for (edge, ends) in edges.iter().enumerate() {
            let [a, b] = [
                require_vertex("edges", edge, ends[0], order.mesh_len())?,
                require_vertex("edges", edge, ends[1], order.mesh_len())?,
            ];
            let [a, b] = [order.sorted_index(a), order.sorted_index(b)];
            if a != b {
                pairs.extend([(a, b), (b, a)]);
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut offsets = vec![0; vertices + 1];
        for &(from, _) in &pairs {
            offsets[from as usize + 1] += 1;
        }
        for row in 0..vertices {
            offsets[row + 1] += offsets[row];
        }
        Ok(Self {
            offsets,
            neighbours: pairs.into_iter().map(|(_, to)| to).collect(),
        })
    }

    pub fn neighbours(&self, vertex: usize) -> &[u32] {
        &self.neighbours[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}
