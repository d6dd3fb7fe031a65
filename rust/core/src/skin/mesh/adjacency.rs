//! The neighbours of each vertex of a mesh.

use crate::error::{Result, require_vertex};
use crate::math::rows::Rows;
use crate::skin::mesh::vertex_order::VertexOrder;

/// The neighbours of each vertex, in rising order. All indices are sorted indices (see [`VertexOrder`]).
#[derive(Debug, Clone)]
pub(crate) struct Adjacency(Rows<u32>);

impl Adjacency {
    /// The neighbours along `edges`, pairs of mesh indices. Repeated edges and edges from a vertex to
    /// itself are ignored.
    ///
    /// # Errors
    /// [`Error::Index`](crate::error::Error::Index) if an edge refers to a vertex that does not exist.
    pub fn new(order: &VertexOrder, edges: &[[i32; 2]]) -> Result<Self> {
        let mut pairs = Vec::with_capacity(2 * edges.len());
        for (edge, &ends) in edges.iter().enumerate() {
            let [a, b] = require_ends(order, edge, ends)?.map(|vertex| order.sorted_index(vertex));
            if a != b {
                pairs.extend([(a, b), (b, a)]);
            }
        }
        Ok(Self(Rows::from_set(order.len(), pairs)))
    }

    pub fn neighbours(&self, vertex: usize) -> &[u32] {
        self.0.row(vertex)
    }
}

/// Fails if one of `edges` refers to a vertex that does not exist.
pub(crate) fn require_edges(order: &VertexOrder, edges: &[[i32; 2]]) -> Result<()> {
    let mut ends = edges.iter().enumerate();
    ends.try_for_each(|(edge, &ends)| require_ends(order, edge, ends).map(drop))
}

fn require_ends(order: &VertexOrder, edge: usize, [a, b]: [i32; 2]) -> Result<[u32; 2]> {
    let vertex = |vertex| require_vertex("edges", edge, vertex, order.mesh_len());
    Ok([vertex(a)?, vertex(b)?])
}
