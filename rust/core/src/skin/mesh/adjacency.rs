//! The neighbours of each vertex of a mesh.

use crate::error::{Result, require_vertex};
use crate::math::rows::Rows;
use crate::skin::mesh::vertex_order::VertexOrder;

/// The neighbours of each vertex, in rising order. All indices are sorted indices (see [`VertexOrder`]).
#[derive(Debug, Clone)]
pub(crate) struct Adjacency(Rows<u32>);

impl Adjacency {
    /// The neighbours along `edges`, pairs of mesh indices. Repeated edges and edges from a vertex to itself are
    /// ignored.
    ///
    /// # Errors
    /// [`Error::Index`](crate::error::Error::Index) if an edge refers to a vertex that does not exist.
    pub fn new(order: &VertexOrder, edges: &[[i32; 2]]) -> Result<Self> {
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
        Ok(Self(Rows::from_set(order.len(), pairs)))
    }

    pub fn neighbours(&self, vertex: usize) -> &[u32] {
        self.0.row(vertex)
    }
}
