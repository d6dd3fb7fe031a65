//! The springs of the elastic skin, from both ends.

use std::ops::Range;

use glam::{Vec3, Vec3A, Vec4};

use crate::skin::relaxation::elastic_mesh::ElasticMesh;

/// How fast a spring's weight falls with its rest length: short edges, as in a groin, must hold. 0 would weigh all alike
/// (a hip's edges then stretch to 3.4 times their length), 2 leaves the long edges of a coarse crease so limp that faces
/// turn over.
const WEIGHT_EXPONENT: f64 = -1.5;
/// Rest length below which a spring's weight grows no more, as a share of the median.
const SHORTEST_OF_MEDIAN: f64 = 0.02;

/// Where a spring at a vertex leads. Apart from its rest, so that rounds which fit no turns read a third as much.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Link {
    pub to: u32,
    /// Share of this spring in all that pull at the vertex.
    pub share: f32,
}

/// What a spring is at rest, to be read at once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rest(Vec4);

impl Rest {
    fn new(edge: Vec3, bending: f32) -> Self {
        Self(edge.extend(bending))
    }

    /// From the vertex to the other end, times the share.
    #[inline]
    pub fn edge(self) -> Vec3A {
        Vec3A::from_vec4(self.0)
    }

    /// How much the other end's turn counts for this one's.
    #[inline]
    pub fn bending(self) -> f32 {
        self.0.w
    }
}

/// The springs at each vertex, in compressed rows.
#[derive(Debug)]
pub(crate) struct EdgeWeights {
    offsets: Vec<u32>,
    links: Vec<Link>,
    rests: Vec<Rest>,
    rest_rhs: Vec<Vec3A>,
}

impl EdgeWeights {
    /// The springs of `mesh`, each as stiff as the mean of its ends' `stiffness`; `bending` is how strongly the turns
    /// of neighbours are held together. What no bone moves pulls at nothing: it stays behind when the character walks off.
    pub fn new(mesh: &ElasticMesh, stiffness: &[f32], bending: f64) -> Self {
        let (points, along) = (mesh.points, mesh.springs);
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
        let (mut offsets, mut links, mut rests, mut rest_rhs) = (vec![0], vec![], vec![], vec![]);
        for from in 0..points.len() {
            let weight = |to: u32| {
                let relative = (length(from, to) / median).max(SHORTEST_OF_MEDIAN);
                let stiff = 0.5 * f64::from(stiffness[from] + stiffness[to as usize]);
                stiff * relative.powf(WEIGHT_EXPONENT)
            };
            let neighbours = || along.neighbours(from).iter().filter(is_moved);
            let total: f64 = neighbours().map(|&to| weight(to)).sum();
            for &to in neighbours() {
                let rest = points[to as usize] - points[from];
                let share = if total > 0.0 { weight(to) / total } else { 0.0 };
                links.push(Link {
                    to,
                    share: share as f32,
                });
                let bending = bending * share * rest.length_squared();
                rests.push(Rest::new((rest * share).as_vec3(), bending as f32));
            }
            let own: &[Rest] = &rests[offsets[from] as usize..];
            rest_rhs.push(own.iter().map(|rest| rest.edge()).sum());
            offsets.push(links.len() as u32);
        }
        Self {
            offsets,
            links,
            rests,
            rest_rhs,
        }
    }

    /// Sum of the springs at `vertex` at rest, each by its share.
    #[inline]
    pub fn rest_rhs(&self, vertex: usize) -> Vec3A {
        self.rest_rhs[vertex]
    }

    /// The springs at each of some `vertices`.
    #[inline]
    pub fn rows(&self, vertices: Range<usize>) -> impl Iterator<Item = &[Link]> {
        let ends = self.offsets[vertices.start..=vertices.end].windows(2);
        ends.map(|ends| &self.links[ends[0] as usize..ends[1] as usize])
    }

    /// The springs at `vertex`, with what they are at rest.
    #[inline]
    pub fn at(&self, vertex: usize) -> impl Iterator<Item = (&Link, &Rest)> {
        let own = self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize;
        self.links[own.clone()].iter().zip(&self.rests[own])
    }
}
