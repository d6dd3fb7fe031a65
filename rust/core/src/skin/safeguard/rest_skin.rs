//! A skin at rest, against which the faults of its poses are found.

use fixedbitset::FixedBitSet;
use glam::{DVec3, Mat3A, Vec3A};
use rayon::prelude::*;

use crate::faults::inverted::Neighbourhoods;
use crate::faults::percentile::percentile;
use crate::faults::stretch::either_way;
use crate::faults::triangle_clusters::TriangleClusters;
use crate::math::rows::Rows;

/// Length of an edge, over the size of the mesh, up to which its stretch is ignored.
const SHORTEST_OF_SIZE: f32 = 1e-4;
/// Distance between both skins, over the size of the mesh, from which a vertex counts as moved.
const MOVED_OF_SIZE: f32 = 1e-7;
/// Stretch of an edge from which it counts as stretched, and from which the faces at it count as bent. Only
/// bent faces count as inverted: one that moves rigidly is not at fault if the skin around it is.
const STRETCHED: f64 = 1.02;
const BENT: f64 = 1.001;
/// Cosine between the normal of a face and its rest normal, moved by the modifier's map, up to which the face
/// may be inverted. The fit of the surrounding skin, which decides, is near the map.
const SUSPECT: f32 = 0.8;

/// A mesh as its file has it, where vertices are split along seams.
#[derive(Debug)]
pub(crate) struct SplitMesh {
    pub triangles: Vec<[u32; 3]>,
    /// The welded vertex of each vertex.
    pub welded: Vec<u32>,
    /// Neighbours of each vertex along the edges of the triangles.
    beside: Rows<u32>,
}

/// A skin at rest. Positions are in armature space, m.
#[derive(Debug)]
pub(crate) struct RestSkin {
    points: Vec<Vec3A>,
    /// Neighbours of each vertex along the edges of the triangles.
    pub beside: Rows<u32>,
    /// The edges whose stretch counts, and their lengths, m.
    edges: Vec<([u32; 2], f32)>,
    clusters: TriangleClusters,
    /// Faces are inverted against their own part of a split mesh, too: so an artist sees them who rotates it.
    split: Option<SplitMesh>,
    /// Pairs of faces that intersect at rest, rising.
    crossing_at_rest: Vec<[u32; 2]>,
    /// The longest side of the bounding box, m.
    pub size_m: f32,
}

/// A state of the skin in a pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Posed<'a> {
    pub positions: &'a [Vec3A],
    /// The linear part of the modifier's map at each vertex.
    pub maps: &'a [Mat3A],
}

/// The part of a skin that two states of it differ in.
#[derive(Debug, Clone)]
pub(crate) struct Difference {
    /// The vertices that differ, rising.
    pub moved: Vec<u32>,
    /// The faces at them, and all edges at the corners of these faces.
    faces: Vec<u32>,
    split_faces: Vec<u32>,
    edges: Vec<u32>,
    clusters: Vec<u32>,
}

impl SplitMesh {
    pub fn new(triangles: Vec<[u32; 3]>, welded: Vec<u32>) -> Self {
        Self {
            beside: beside(welded.len(), &triangles),
            triangles,
            welded,
        }
    }
}

impl RestSkin {
    /// The skin of `triangles` over its rest `points`. Consecutive triangles are near each other.
    pub fn new(points: &[Vec3A], triangles: &[[u32; 3]], split: Option<SplitMesh>) -> Self {
        let beside = beside(points.len(), triangles);
        let low = points.iter().copied().fold(Vec3A::INFINITY, Vec3A::min);
        let high = points.iter().copied().fold(Vec3A::NEG_INFINITY, Vec3A::max);
        let size_m = (high - low).max_element();
        let ends = (0..points.len() as u32).flat_map(|start| {
            let later = beside.row(start as usize).iter().filter(move |&&end| end > start);
            later.map(move |&end| [start, end])
        });
        let edges = ends.map(|[a, b]| ([a, b], points[a as usize].distance(points[b as usize])));
        let edges = edges.filter(|&(_, length_m)| length_m > SHORTEST_OF_SIZE * size_m);
        let clusters = TriangleClusters::new(triangles.to_vec());
        let all: Vec<u32> = (0..clusters.len() as u32).collect();
        Self {
            crossing_at_rest: clusters.crossings(&all, points),
            edges: edges.collect(),
            points: points.to_vec(),
            beside,
            clusters,
            split,
            size_m,
        }
    }

    /// In what two states of the skin differ.
    pub fn difference(&self, one: &[Vec3A], other: &[Vec3A]) -> Difference {
        let least_m = MOVED_OF_SIZE * self.size_m;
        let mut is_moved = FixedBitSet::with_capacity(one.len());
        for (vertex, (one, other)) in one.iter().zip(other).enumerate() {
            is_moved.set(vertex, one.distance_squared(*other) > least_m * least_m);
        }
        let has_moved = |corners: [u32; 3]| corners.iter().any(|&corner| is_moved.contains(corner as usize));
        let triangles = self.clusters.triangles();
        let of_moved = |(face, corners): (usize, &[u32; 3])| has_moved(*corners).then_some(face as u32);
        let faces: Vec<u32> = triangles.iter().enumerate().filter_map(of_moved).collect();
        let mut is_near = FixedBitSet::with_capacity(one.len());
        let corners = faces.iter().flat_map(|&face| triangles[face as usize]);
        is_near.extend(corners.map(|corner| corner as usize));
        let near_edge = |(edge, (ends, _)): (usize, &([u32; 2], f32))| {
            let is_near = ends.iter().any(|&end| is_near.contains(end as usize));
            is_near.then_some(edge as u32)
        };
        let split_faces = self.split.iter().flat_map(|split| {
            let faces = split.triangles.iter().enumerate();
            let welded = |corners: &[u32; 3]| corners.map(|corner| split.welded[corner as usize]);
            faces.filter_map(move |(face, corners)| has_moved(welded(corners)).then_some(face as u32))
        });
        Difference {
            moved: is_moved.ones().map(|vertex| vertex as u32).collect(),
            split_faces: split_faces.collect(),
            edges: self.edges.iter().enumerate().filter_map(near_edge).collect(),
            clusters: self.clusters.of(faces.iter().copied()),
            faces,
        }
    }

    /// The 99th percentile of the stretch of the stretched edges of a part; 1 without any.
    pub fn stretch(&self, part: &Difference, posed: Posed) -> f64 {
        let edges = part.edges.par_iter().with_min_len(2048);
        let mut stretches: Vec<f64> = edges
            .map(|&edge| self.stretch_of(edge, posed))
            .filter(|&stretch| stretch > STRETCHED)
            .collect();
        percentile(&mut stretches, 99.0).unwrap_or(1.0)
    }

    /// The number of inverted faces of a part: in the welded mesh, and in the split one.
    pub fn inverted(&self, part: &Difference, posed: Posed) -> [usize; 2] {
        let mut is_bent = FixedBitSet::with_capacity(self.points.len());
        for &edge in &part.edges {
            if self.stretch_of(edge, posed) > BENT {
                is_bent.extend(self.edges[edge as usize].0.map(|end| end as usize));
            }
        }
        let wide = |positions: &[Vec3A], vertex: u32| positions[vertex as usize].as_dvec3();
        let count = |faces: &[u32],
                     triangles: &[[u32; 3]],
                     beside: &Rows<u32>,
                     welded: &(dyn Fn(u32) -> u32 + Sync)| {
            let is_suspect = |face: &&u32| {
                let corners = triangles[**face as usize].map(welded);
                corners.iter().any(|&corner| is_bent.contains(corner as usize))
                    && self.is_suspect(corners, posed)
            };
            let suspects: Vec<u32> = faces
                .par_iter()
                .with_min_len(512)
                .filter(is_suspect)
                .copied()
                .collect();
            if suspects.is_empty() {
                return 0;
            }
            let rest = |vertex: u32| -> DVec3 { wide(&self.points, welded(vertex)) };
            let now = |vertex: u32| -> DVec3 { wide(posed.positions, welded(vertex)) };
            let inverted = Neighbourhoods::new(suspects, triangles, beside).inverted(rest, now, triangles);
            inverted.into_iter().filter(|&is_inverted| is_inverted).count()
        };
        let of_split = |split: &SplitMesh| {
            let welded = |vertex: u32| split.welded[vertex as usize];
            count(&part.split_faces, &split.triangles, &split.beside, &welded)
        };
        [
            count(&part.faces, self.clusters.triangles(), &self.beside, &|vertex| {
                vertex
            }),
            self.split.as_ref().map_or(0, of_split),
        ]
    }

    /// The number of pairs of faces, one of them of a part, that intersect and do not at rest.
    pub fn crossing(&self, part: &Difference, posed: Posed) -> usize {
        let crossings = self.clusters.crossings(&part.clusters, posed.positions);
        let is_new = |pair: &&[u32; 2]| self.crossing_at_rest.binary_search(pair).is_err();
        crossings.iter().filter(is_new).count()
    }

    fn stretch_of(&self, edge: u32, posed: Posed) -> f64 {
        let ([a, b], rest_m) = self.edges[edge as usize];
        let length_m = posed.positions[a as usize].distance(posed.positions[b as usize]);
        either_way(f64::from(length_m.max(f32::MIN_POSITIVE)) / f64::from(rest_m))
    }

    fn is_suspect(&self, corners: [u32; 3], posed: Posed) -> bool {
        let normal = |points: &[Vec3A]| {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            (b - a).cross(c - a)
        };
        let map = corners
            .map(|corner| posed.maps[corner as usize])
            .into_iter()
            .fold(Mat3A::ZERO, |sum, map| sum + map);
        let (expected, found) = (map * normal(&self.points), normal(posed.positions));
        let size = (expected.length_squared() * found.length_squared()).sqrt();
        expected.dot(found) <= SUSPECT * size
    }
}

/// Neighbours of each of some vertices along the edges of triangles.
fn beside(vertices: usize, triangles: &[[u32; 3]]) -> Rows<u32> {
    let ends = |&[a, b, c]: &[u32; 3]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)];
    Rows::from_set(vertices, triangles.iter().flat_map(ends).collect())
}
