//! The weighted edges of the elastic skin, listed at both of their ends (mathematics/relaxation.md, Energy).

use std::ops::Range;

use glam::{Vec3, Vec3A, Vec4};

use crate::math::rows::Rows;
use crate::skin::relaxation::elastic_mesh::ElasticMesh;

/// Exponent of an edge's weight over its rest length: short edges, as in a groin, must be stiff.
/// Measured: with 0 (equal weights) the edges of a hip stretch to 3.4 times their length; with -2 the
/// long edges of a coarse crease are so weak that faces invert.
const WEIGHT_EXPONENT: f64 = -1.5;
/// Rest length below which a weight does not grow further, as a fraction of the median length. It bounds
/// the weights of degenerate edges.
const SHORTEST_OF_MEDIAN: f64 = 0.02;

/// An edge from a vertex. Its rest state is stored apart, so that an iteration without a fit reads a
/// third as much.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    pub to: u32,
    /// Weight, as a fraction of the sum over the vertex's edges.
    pub weight: f32,
}

/// The rest state of an edge, in one register.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RestEdge(Vec4);

impl RestEdge {
    fn new(vector: Vec3, bending: f32) -> Self {
        Self(vector.extend(bending))
    }

    /// The vector from the vertex to the other end, times the weight, m.
    #[inline]
    pub fn vector(self) -> Vec3A {
        Vec3A::from_vec4(self.0)
    }

    /// Weight of the other end's axes in the fit of this vertex (the bending term), m².
    #[inline]
    pub fn bending(self) -> f32 {
        self.0.w
    }
}

/// The edges at each vertex.
#[derive(Debug)]
pub(crate) struct EdgeWeights {
    edges: Rows<Edge>,
    /// One per entry of `edges`.
    rest_edges: Vec<RestEdge>,
    rest_rhs: Vec<Vec3A>,
}

impl EdgeWeights {
    /// The edges of `mesh`, each as stiff as the mean of its ends' `stiffness`. `bending` is the weight
    /// of the bending term. Vertices that no bone moves have no influence, because they stay behind when
    /// the character walks away.
    pub fn new(mesh: &ElasticMesh, stiffness: &[f32], bending: f64) -> Self {
        let (points, along) = (mesh.points, mesh.energy_edges);
        let is_moved = |vertex: &&u32| !mesh.weights.of(**vertex as usize).is_empty();
        let length = |from: usize, to: u32| points[from].distance(points[to as usize]);
        let mut lengths: Vec<f64> = (0..points.len())
            .flat_map(|from| along.neighbours(from).iter().map(move |&to| (from, to)))
            .map(|(from, to)| length(from, to))
            .collect();
        let middle = lengths.len() / 2;
        let median = match lengths.len() {
            0 => 1.0,
            _ => *lengths.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        let median = median.max(f64::MIN_POSITIVE);
        let write = |(): &mut (), from: usize, row: &mut Vec<(Edge, RestEdge)>| {
            let stiffness_of = |to: u32| {
                let relative = (length(from, to) / median).max(SHORTEST_OF_MEDIAN);
                let mean = 0.5 * f64::from(stiffness[from] + stiffness[to as usize]);
                mean * relative.powf(WEIGHT_EXPONENT)
            };
            let neighbours = || along.neighbours(from).iter().filter(is_moved);
            let total: f64 = neighbours().map(|&to| stiffness_of(to)).sum();
            row.extend(neighbours().map(|&to| {
                let weight = if total > 0.0 {
                    stiffness_of(to) / total
                } else {
                    0.0
                };
                let rest = points[to as usize] - points[from];
                let bending = bending * weight * rest.length_squared();
                let edge = Edge {
                    to,
                    weight: weight as f32,
                };
                (edge, RestEdge::new((rest * weight).as_vec3(), bending as f32))
            }));
        };
        let (edges, rest_edges) = Rows::computed(points.len(), || (), write).unzip();
        let rest_rhs = (0..points.len())
            .map(|vertex| {
                rest_edges[edges.range(vertex)]
                    .iter()
                    .map(|rest| rest.vector())
                    .sum()
            })
            .collect();
        Self {
            edges,
            rest_edges,
            rest_rhs,
        }
    }

    /// The weighted sum of the rest vectors at `vertex`, m.
    #[inline]
    pub fn rest_rhs(&self, vertex: usize) -> Vec3A {
        self.rest_rhs[vertex]
    }

    /// The edges at each of some `vertices`.
    #[inline]
    pub fn rows(&self, vertices: Range<usize>) -> impl Iterator<Item = &[Edge]> {
        let ends = self.edges.offsets()[vertices.start..=vertices.end].windows(2);
        ends.map(|ends| &self.edges.entries()[ends[0] as usize..ends[1] as usize])
    }

    /// The edges at `vertex`, and their rest states.
    #[inline]
    pub fn at(&self, vertex: usize) -> (&[Edge], &[RestEdge]) {
        let range = self.edges.range(vertex);
        (&self.edges.entries()[range.clone()], &self.rest_edges[range])
    }
}
