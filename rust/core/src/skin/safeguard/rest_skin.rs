//! A skin at rest, against which the faults of its poses are found.

use fixedbitset::FixedBitSet;
use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::faults::inverted::Neighbourhoods;
use crate::faults::percentile::percentile;
use crate::faults::stretch::either_way;
use crate::faults::triangle_clusters::TriangleClusters;
use crate::math::rows::Rows;
use crate::skin::safeguard::touching::doubtful_pairs;

/// Length of an edge, over the size of the mesh, up to which its stretch is ignored.
const SHORTEST_OF_SIZE: f32 = 1e-4;
/// Stretch of an edge from which it counts as stretched, and from which the faces at it count as bent. Only
/// bent faces count as inverted: one that moves rigidly is not at fault if the skin around it is.
const STRETCHED: f64 = 1.02;
const BENT: f64 = 1.001;
/// Cosine between the normal of a face and its rest normal, moved by the modifier's map, up to which the face
/// may be inverted, if more than [`MANY`] faces move. On so dense a skin three rings are small beside a joint, and
/// their fit, which decides, is near the map. On a coarse one they can be a whole limb.
const SUSPECT: f32 = 0.8;
const MANY: usize = 4096;

/// A skin at rest: the mesh as its file has it, where vertices may be split along seams. Positions are in armature
/// space, m.
#[derive(Debug)]
pub(crate) struct RestSkin {
    points: Vec<Vec3A>,
    /// The welded vertex of each vertex, by sorted index.
    welded: Vec<u32>,
    neighbourhoods: Neighbourhoods,
    /// The edges whose stretch counts, and their lengths, m.
    edges: Vec<([u32; 2], f32)>,
    /// The faces at each welded vertex, and at each vertex.
    faces_at: Rows<u32>,
    faces_at_file: Rows<u32>,
    clusters: TriangleClusters,
    /// Pairs of faces that intersect at rest, rising.
    crossing_at_rest: Vec<[u32; 2]>,
    /// Pairs of faces of which rounding decides whether they intersect, rising.
    doubtful: Vec<[u32; 2]>,
    /// The longest side of the bounding box, m.
    pub size_m: f32,
}

/// A state of the welded skin in a pose, by sorted index.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Posed<'a> {
    pub positions: &'a [Vec3A],
    /// The linear part of the modifier's map at each vertex.
    pub maps: &'a [Mat3A],
}

/// The part of a skin that two states of it differ in.
#[derive(Debug, Clone)]
pub(crate) struct Difference {
    /// The welded vertices that differ, rising.
    pub moved: Vec<u32>,
    /// The faces at them, and all faces that may be inverted in one state only: what surrounds a face decides.
    faces: Vec<u32>,
    faces_around: Vec<u32>,
    clusters: Vec<u32>,
}

/// How much each edge of a skin is stretched in a pose, either way, at least 1.
#[derive(Debug)]
pub(crate) struct Stretches(Vec<f64>);

impl Stretches {
    /// The 99th percentile of the stretched edges; 1 without any.
    pub fn percentile(&self) -> f64 {
        let mut stretched: Vec<f64> = self
            .0
            .iter()
            .copied()
            .filter(|&stretch| stretch > STRETCHED)
            .collect();
        percentile(&mut stretched, 99.0).unwrap_or(1.0)
    }
}

impl RestSkin {
    /// The skin of `triangles` over `points` as the file has them. `welded` is the welded vertex of each.
    pub fn new(points: &[Vec3A], mut triangles: Vec<[u32; 3]>, welded: Vec<u32>) -> Self {
        // near triangles one after another, as clusters need them
        triangles.sort_by_key(|corners| corners.iter().map(|&corner| welded[corner as usize]).min());
        let ends = |&[a, b, c]: &[u32; 3]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)];
        let beside = Rows::from_set(points.len(), triangles.iter().flat_map(ends).collect());
        let low = points.iter().copied().fold(Vec3A::INFINITY, Vec3A::min);
        let high = points.iter().copied().fold(Vec3A::NEG_INFINITY, Vec3A::max);
        let size_m = (high - low).max_element();
        let ends = (0..points.len() as u32).flat_map(|start| {
            let later = beside.row(start as usize).iter().filter(move |&&end| end > start);
            later.map(move |&end| [start, end])
        });
        let edges = ends.map(|[a, b]| ([a, b], points[a as usize].distance(points[b as usize])));
        let edges: Vec<([u32; 2], f32)> = edges
            .filter(|&(_, length_m)| length_m > SHORTEST_OF_SIZE * size_m)
            .collect();
        let at_corners = (0..).zip(&triangles);
        let at_corners: Vec<(u32, u32)> = at_corners
            .flat_map(|(face, corners)| corners.map(|corner| (corner, face)))
            .collect();
        let at_welded = |&(corner, face): &(u32, u32)| (welded[corner as usize], face);
        let mut welded_points = vec![Vec3A::ZERO; welded.iter().max().map_or(0, |&last| last as usize + 1)];
        for (&vertex, &point) in welded.iter().zip(points) {
            welded_points[vertex as usize] = point;
        }
        let faces_at = Rows::from_set(welded_points.len(), at_corners.iter().map(at_welded).collect());
        let clusters = TriangleClusters::new(triangles, |corner| welded[corner as usize]);
        let all: Vec<u32> = (0..clusters.len() as u32).collect();
        Self {
            doubtful: doubtful_pairs(points, clusters.triangles(), &welded, &faces_at),
            crossing_at_rest: clusters.crossings(&all, |vertex| welded_points[vertex as usize]),
            faces_at_file: Rows::from_set(points.len(), at_corners),
            faces_at,
            edges,
            points: points.to_vec(),
            welded,
            neighbourhoods: Neighbourhoods::new(beside),
            clusters,
            size_m,
        }
    }

    /// In what two states of the skin differ.
    pub fn difference(&self, one: &[Vec3A], other: &[Vec3A]) -> Difference {
        let pairs = (0..).zip(one.iter().zip(other));
        let moved: Vec<u32> = pairs
            .filter(|(_, (one, other))| one != other)
            .map(|(vertex, _)| vertex)
            .collect();
        let triangles = self.clusters.triangles();
        let mut has_moved = FixedBitSet::with_capacity(triangles.len());
        for &face in moved
            .iter()
            .flat_map(|&vertex| self.faces_at.row(vertex as usize))
        {
            has_moved.insert(face as usize);
        }
        let faces: Vec<u32> = has_moved.ones().map(|face| face as u32).collect();
        let corners = faces.iter().flat_map(|&face| triangles[face as usize]);
        let mut is_around = FixedBitSet::with_capacity(self.points.len());
        is_around.extend(corners.map(|corner| corner as usize));
        self.neighbourhoods.grow(&mut is_around);
        let mut has_around = FixedBitSet::with_capacity(triangles.len());
        for vertex in is_around.ones() {
            has_around.extend(self.faces_at_file.row(vertex).iter().map(|&face| face as usize));
        }
        Difference {
            moved,
            faces_around: has_around.ones().map(|face| face as u32).collect(),
            clusters: self.clusters.of(faces.iter().copied()),
            faces,
        }
    }

    /// The stretch of each edge of the skin.
    pub fn stretches(&self, posed: Posed) -> Stretches {
        let stretch = |&([a, b], rest_m): &([u32; 2], f32)| {
            let length_m = self.at(a, posed).distance(self.at(b, posed));
            either_way(f64::from(length_m.max(f32::MIN_POSITIVE)) / f64::from(rest_m))
        };
        Stretches(self.edges.par_iter().with_min_len(2048).map(stretch).collect())
    }

    /// The number of inverted faces in and around a part, in a pose with these `stretches`.
    pub fn inverted(&self, part: &Difference, posed: Posed, stretches: &Stretches) -> usize {
        let mut is_bent = FixedBitSet::with_capacity(self.points.len());
        for ((ends, _), _) in self
            .edges
            .iter()
            .zip(&stretches.0)
            .filter(|(_, stretch)| **stretch > BENT)
        {
            is_bent.extend(ends.map(|end| end as usize));
        }
        let triangles = self.clusters.triangles();
        let is_suspect = |face: &&u32| {
            let corners = triangles[**face as usize];
            let is_bent = corners.iter().any(|&corner| is_bent.contains(corner as usize));
            is_bent && (part.faces_around.len() <= MANY || self.is_suspect(corners, posed))
        };
        let faces = part.faces_around.par_iter().with_min_len(512);
        let suspects: Vec<u32> = faces.filter(is_suspect).copied().collect();
        if suspects.is_empty() {
            return 0;
        }
        let rest = |vertex: u32| self.points[vertex as usize].as_dvec3();
        let now = |vertex: u32| self.at(vertex, posed).as_dvec3();
        let found = self.neighbourhoods.inverted(&suspects, triangles, rest, now);
        found.into_iter().filter(|&is_inverted| is_inverted).count()
    }

    /// The number of pairs of faces, one of them of a part, that intersect and do not at rest. Pairs of which
    /// rounding decides are not counted.
    pub fn crossing(&self, part: &Difference, posed: Posed) -> usize {
        let crossings = self
            .clusters
            .crossings(&part.clusters, |vertex| posed.positions[vertex as usize]);
        let is_new = |pair: &&[u32; 2]| {
            self.crossing_at_rest.binary_search(pair).is_err() && self.doubtful.binary_search(pair).is_err()
        };
        crossings.iter().filter(is_new).count()
    }

    /// The number of pairs of faces, one of them of a part, of which rounding decides whether they intersect.
    pub fn doubtful(&self, part: &Difference) -> usize {
        let is_of_part = |face: &u32| part.faces.binary_search(face).is_ok();
        self.doubtful
            .iter()
            .filter(|pair| pair.iter().any(is_of_part))
            .count()
    }

    fn at(&self, vertex: u32, posed: Posed) -> Vec3A {
        posed.positions[self.welded[vertex as usize] as usize]
    }

    fn is_suspect(&self, corners: [u32; 3], posed: Posed) -> bool {
        let normal = |[a, b, c]: [Vec3A; 3]| (b - a).cross(c - a);
        let maps = corners.map(|corner| posed.maps[self.welded[corner as usize] as usize]);
        let map = maps[0] + maps[1] + maps[2];
        let expected = map * normal(corners.map(|corner| self.points[corner as usize]));
        let found = normal(corners.map(|corner| self.at(corner, posed)));
        let size = (expected.length_squared() * found.length_squared()).sqrt();
        expected.dot(found) <= SUSPECT * size
    }
}
