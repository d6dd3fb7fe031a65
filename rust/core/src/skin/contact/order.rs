//! The order in which contact looks at vertices: cluster after cluster, what is in none last.

use super::super::mesh::Adjacency;
use super::clusters::Cluster;

/// Numbers of the mesh's vertices in contact.
#[derive(Debug)]
pub(super) struct Order {
    /// The mesh's vertex of each number.
    vertices: Vec<u32>,
    /// The number of each of the mesh's vertices.
    numbers: Vec<u32>,
}

impl Order {
    /// The order of a mesh of `count` vertices, of which `clusters` hold some.
    pub fn new(clusters: &[Cluster], count: usize) -> Self {
        let mut vertices = Vec::with_capacity(count);
        let mut numbers = vec![u32::MAX; count];
        let held = clusters
            .iter()
            .flat_map(|cluster| cluster.vertices.iter().copied());
        for vertex in held.chain(0..count as u32) {
            let number = &mut numbers[vertex as usize];
            if *number == u32::MAX {
                *number = vertices.len() as u32;
                vertices.push(vertex);
            }
        }
        Self { vertices, numbers }
    }

    /// The mesh's vertex of a number.
    pub fn vertex(&self, number: usize) -> usize {
        self.vertices[number] as usize
    }

    /// The number of one of the mesh's vertices.
    pub fn number(&self, vertex: u32) -> u32 {
        self.numbers[vertex as usize]
    }

    /// What `of` gives of the mesh's vertices, in this order.
    pub fn sorted<T>(&self, of: impl Fn(usize) -> T) -> Vec<T> {
        self.vertices.iter().map(|&vertex| of(vertex as usize)).collect()
    }

    /// The neighbours of each vertex, all by their numbers.
    pub fn neighbours(&self, of_mesh: &Adjacency) -> Adjacency {
        of_mesh.renumbered(&self.vertices, &self.numbers)
    }
}
