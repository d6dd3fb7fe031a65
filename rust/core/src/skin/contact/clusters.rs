//! The parts that a body is looked at in: patches of skin on one segment, each in a ball that moves with a bone.

use glam::{Affine3A, DMat4, DVec3, Vec3A};
use rayon::prelude::*;

use super::meeting::FACING;
use super::{Contact, ContactMesh};
use crate::pose::Palette;

/// Most vertices of a cluster.
const LARGEST: usize = 96;
/// Approach, over the size of the two balls, below which a pair counts as standing as at rest.
const SMALLEST_APPROACH: f32 = 0.01;

/// A patch of skin.
#[derive(Debug)]
pub(super) struct Cluster {
    /// The bone that it moves with, nearly.
    pub bone: usize,
    segment: i32,
    /// Centre at rest, m.
    centre: Vec3A,
    pub radius_m: f32,
    pub vertices: Vec<u32>,
    /// Those, and the corners of the triangles around them.
    pub with_corners: Vec<u32>,
}

/// Two clusters that may meet.
#[derive(Debug, Clone, Copy)]
pub(in crate::skin) struct Pair {
    pub one: u32,
    pub other: u32,
}

/// The clusters of a mesh, of all that bones move.
pub(super) fn clusters(mesh: &ContactMesh) -> Vec<Cluster> {
    let mut by_bone: Vec<Vec<u32>> = vec![vec![]; mesh.skeleton.len()];
    for vertex in 0..mesh.points.len() {
        if let Some(bone) = mesh.strongest_bone(vertex) {
            by_bone[bone].push(vertex as u32);
        }
    }
    let around = around(mesh);
    let mut found = vec![];
    for (bone, vertices) in by_bone.into_iter().enumerate() {
        halve(mesh.points, vertices, &mut |vertices| {
            found.push(Cluster::new(mesh, bone, vertices, &around));
        });
    }
    found
}

/// The vertices that share a triangle with each.
fn around(mesh: &ContactMesh) -> Vec<Vec<u32>> {
    let mut around = vec![vec![]; mesh.points.len()];
    for triangle in mesh.triangles {
        for &vertex in triangle {
            around[vertex as usize].extend_from_slice(triangle);
        }
    }
    around
}

/// Halves a set of vertices across its longest side until it is small enough.
fn halve(points: &[DVec3], mut vertices: Vec<u32>, take: &mut impl FnMut(Vec<u32>)) {
    if vertices.is_empty() {
        return;
    }
    if vertices.len() <= LARGEST {
        vertices.sort_unstable();
        take(vertices);
        return;
    }
    let place = |vertex: &u32| points[*vertex as usize];
    let low = vertices.iter().map(place).reduce(DVec3::min).unwrap_or_default();
    let high = vertices.iter().map(place).reduce(DVec3::max).unwrap_or_default();
    let longest = (high - low).max_position();
    vertices.sort_unstable_by(|a, b| place(a)[longest].total_cmp(&place(b)[longest]).then(a.cmp(b)));
    let rest = vertices.split_off(vertices.len() / 2);
    halve(points, vertices, take);
    halve(points, rest, take);
}

impl Cluster {
    /// Whether a vertex of it may lie within `reach_m` of a place at rest.
    pub fn may_reach(&self, place: Vec3A, reach_m: f32) -> bool {
        self.centre.distance(place) < self.radius_m + reach_m
    }

    fn new(mesh: &ContactMesh, bone: usize, vertices: Vec<u32>, around: &[Vec<u32>]) -> Self {
        let place = |vertex: &u32| mesh.points[*vertex as usize];
        let centre = vertices.iter().map(place).sum::<DVec3>() / vertices.len() as f64;
        let radius = vertices
            .iter()
            .map(|vertex| place(vertex).distance(centre))
            .fold(0.0, f64::max);
        let mut with_corners: Vec<u32> = vertices
            .iter()
            .flat_map(|&vertex| around[vertex as usize].iter().copied().chain([vertex]))
            .collect();
        with_corners.sort_unstable();
        with_corners.dedup();
        Self {
            bone,
            segment: mesh.segments.of_bone[bone],
            centre: centre.as_vec3a(),
            radius_m: radius as f32,
            vertices,
            with_corners,
        }
    }
}

/// The pairs of clusters of one segment whose skin faces each other across a narrow gap at rest, as the buttocks' does: they
/// move with one bone, and may be pressed together all the same.
pub(super) fn facing(mesh: &ContactMesh, clusters: &[Cluster], normals: &[Vec3A], gap_m: f32) -> Vec<Pair> {
    let place = |vertex: u32| mesh.points[vertex as usize].as_vec3a();
    let is_facing = |one: u32, other: u32| {
        let (way, normal) = (place(other) - place(one), normals[one as usize]);
        way.length_squared() < gap_m * gap_m
            && normal.dot(normals[other as usize]) < FACING
            && way.dot(normal) > 0.0
    };
    let pairs = (0..clusters.len()).into_par_iter().flat_map_iter(|index| {
        let one = &clusters[index];
        let others = (index..clusters.len()).filter(move |&other_index| {
            let other = &clusters[other_index];
            one.segment == other.segment
                && one.centre.distance(other.centre) < one.radius_m + other.radius_m + gap_m
                && one
                    .vertices
                    .iter()
                    .any(|&a| other.vertices.iter().any(|&b| is_facing(a, b)))
        });
        others.map(move |other| Pair {
            one: index as u32,
            other: other as u32,
        })
    });
    pairs.collect()
}

impl Contact {
    /// Finds the pairs of clusters that may meet: those of different segments that came near each other, nearer than they are at
    /// rest, and those that face each other where the skin is relaxed; in a fixed order.
    pub fn find_pairs(
        &self,
        palette: &Palette,
        is_relaxed: impl Fn(usize) -> bool,
        centres: &mut [Vec3A],
        pairs: &mut Vec<Pair>,
    ) {
        pairs.clear();
        let any_relaxed = |cluster: u32| {
            let mut vertices = self.clusters[cluster as usize].vertices.iter();
            vertices.any(|&vertex| is_relaxed(vertex as usize))
        };
        let facing = self.facing.iter().copied();
        pairs.extend(facing.filter(|pair| any_relaxed(pair.one) || any_relaxed(pair.other)));
        for (cluster, centre) in self.clusters.iter().zip(&mut *centres) {
            let carry = DMat4::from(palette.carries()[cluster.bone]).as_mat4();
            *centre = Affine3A::from_mat4(carry).transform_point3a(cluster.centre);
        }
        for (index, one) in self.clusters.iter().enumerate() {
            for (other_index, other) in self.clusters.iter().enumerate().skip(index + 1) {
                if one.segment == other.segment {
                    continue;
                }
                let size_m = one.radius_m + other.radius_m;
                let near_m = size_m + self.reach_m;
                let now = centres[index].distance_squared(centres[other_index]);
                if now > near_m * near_m {
                    continue;
                }
                let rest_m = one.centre.distance(other.centre);
                if rest_m - now.sqrt() > SMALLEST_APPROACH * size_m {
                    pairs.push(Pair {
                        one: index as u32,
                        other: other_index as u32,
                    });
                }
            }
        }
    }
}
