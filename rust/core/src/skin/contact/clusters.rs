//! The parts that a body is looked at in: patches of skin on one segment, each in a ball that moves with a bone.

use std::ops::Range;

use glam::{Affine3A, DMat4, DVec3, Vec3A};
use rayon::prelude::*;

use super::super::frobenius::frobenius_squared;
use super::super::order;
use super::meeting::FACING;
use super::{Contact, ContactMesh};
use crate::pose::Palette;

/// Approach, over the size of the two balls, below which a pair counts as standing as at rest.
const SMALLEST_APPROACH: f32 = 0.01;

/// Angle by which skin may turn otherwise than the bone that moves it most, radians: half of a bent joint, roughly.
const LOOSENESS: f32 = 0.4;

/// All clusters of a bone, in a ball that holds them.
#[derive(Debug)]
pub(super) struct BoneClusters {
    bone: usize,
    segment: i32,
    clusters: Range<usize>,
    /// Centre at rest, m.
    centre: Vec3A,
    radius_m: f32,
    /// Radius of its smallest cluster, m.
    smallest_m: f32,
}

/// A patch of skin.
#[derive(Debug)]
pub(super) struct Cluster {
    /// The bone that it moves with, nearly.
    bone: usize,
    segment: i32,
    /// Centre at rest, m.
    centre: Vec3A,
    pub radius_m: f32,
    /// Mean of its normals at rest.
    facing: Vec3A,
    spread: Spread,
    /// Cosine of its facing and a normal below which skin with that normal may face some of it.
    faces_below: f32,
    pub vertices: Range<usize>,
    /// Those, and the corners of the triangles around them.
    with_corners: Vec<u32>,
    /// The longest edge at its vertices, m.
    pub longest_edge_m: f32,
}

/// Largest angle of a cluster's normals from its facing in any pose, nearly; radians, with its sine and cosine, which a frame
/// needs for thousands of pairs.
#[derive(Debug, Clone, Copy)]
struct Spread {
    angle: f32,
    sin: f32,
    cos: f32,
}

impl Spread {
    fn new(angle: f32) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { angle, sin, cos }
    }

    /// The spread of the angles between the normals of two clusters.
    fn and(self, other: Self) -> Self {
        Self {
            angle: self.angle + other.angle,
            sin: self.sin * other.cos + self.cos * other.sin,
            cos: self.cos * other.cos - self.sin * other.sin,
        }
    }

    /// Cosine of two directions, each within the spread, below which they may be as far apart as those of skin that faces skin:
    /// `cos(acos FACING - angle)`.
    fn faces_below(self) -> f32 {
        if self.angle >= FACING.acos() {
            f32::INFINITY
        } else {
            FACING * self.cos + (1.0 - FACING * FACING).sqrt() * self.sin
        }
    }
}

/// Two clusters that may meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    pub one: u32,
    pub other: u32,
}

/// The clusters of a mesh, of all that bones move.
pub(super) fn clusters(mesh: &ContactMesh, normals: &[Vec3A]) -> Vec<Cluster> {
    let around = around(mesh);
    let found = mesh.clusters.iter();
    found
        .map(|own| Cluster::new(mesh, normals, own, &around))
        .collect()
}

/// The clusters, which come bone by bone, with a ball for each bone.
pub(super) fn by_bone(clusters: &[Cluster]) -> Vec<BoneClusters> {
    let mut first = 0;
    let balls = clusters.chunk_by(|a, b| a.bone == b.bone).map(|own| {
        let centre = own.iter().map(|cluster| cluster.centre).sum::<Vec3A>() / own.len() as f32;
        let reach = |cluster: &Cluster| cluster.centre.distance(centre) + cluster.radius_m;
        first += own.len();
        BoneClusters {
            bone: own[0].bone,
            segment: own[0].segment,
            clusters: first - own.len()..first,
            centre,
            radius_m: own.iter().map(reach).fold(0.0, f32::max),
            smallest_m: own
                .iter()
                .map(|cluster| cluster.radius_m)
                .fold(f32::INFINITY, f32::min),
        }
    });
    balls.collect()
}

/// The cluster of each vertex, `u32::MAX` where it is in none.
pub(super) fn cluster_of(clusters: &[Cluster], vertices: usize) -> Vec<u32> {
    let mut cluster_of = vec![u32::MAX; vertices];
    for (index, cluster) in clusters.iter().enumerate() {
        cluster_of[cluster.vertices.clone()].fill(index as u32);
    }
    cluster_of
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

impl Cluster {
    /// Its vertices, and the corners of the triangles around them.
    pub fn with_corners(&self) -> impl Iterator<Item = usize> {
        self.with_corners.iter().map(|&vertex| vertex as usize)
    }

    /// Whether a vertex of it may lie within `reach_m` of a place at rest.
    pub fn may_reach(&self, place: Vec3A, reach_m: f32) -> bool {
        self.centre.distance(place) < self.radius_m + reach_m
    }

    fn new(mesh: &ContactMesh, normals: &[Vec3A], own: &order::Cluster, around: &[Vec<u32>]) -> Self {
        let order::Cluster { bone, ref vertices } = *own;
        let points = &mesh.points[vertices.clone()];
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let radius = points
            .iter()
            .map(|point| point.distance(centre))
            .fold(0.0, f64::max);
        let normals = &normals[vertices.clone()];
        let facing = normals.iter().sum::<Vec3A>().normalize_or(Vec3A::Z);
        let angles = normals.iter().map(|normal| normal.angle_between(facing));
        let spread = Spread::new(angles.fold(0.0, f32::max) + LOOSENESS);
        let mut with_corners: Vec<u32> = vertices
            .clone()
            .flat_map(|vertex| around[vertex].iter().copied().chain([vertex as u32]))
            .collect();
        with_corners.sort_unstable();
        with_corners.dedup();
        let lengths = vertices.clone().flat_map(|vertex| {
            let place = mesh.points[vertex];
            let around = around[vertex].iter();
            around.map(move |&corner| mesh.points[corner as usize].distance(place))
        });
        let longest_edge = lengths.fold(0.0, f64::max);
        Self {
            bone,
            segment: mesh.segments.of_bone[bone],
            centre: centre.as_vec3a(),
            radius_m: radius as f32,
            spread,
            faces_below: spread.faces_below(),
            facing,
            vertices: vertices.clone(),
            with_corners,
            longest_edge_m: longest_edge as f32,
        }
    }
}

/// The pairs of clusters of one segment whose skin faces each other across a narrow gap at rest, as the buttocks' does: they
/// move with one bone, and may be pressed together all the same.
pub(super) fn facing(mesh: &ContactMesh, clusters: &[Cluster], normals: &[Vec3A], gap_m: f32) -> Vec<Pair> {
    let place = |vertex: usize| mesh.points[vertex].as_vec3a();
    let is_facing = |one: usize, other: usize| {
        let (way, normal) = (place(other) - place(one), normals[one]);
        way.length_squared() < gap_m * gap_m && normal.dot(normals[other]) < FACING && way.dot(normal) > 0.0
    };
    let pairs = (0..clusters.len()).into_par_iter().flat_map_iter(|index| {
        let one = &clusters[index];
        let others = (index..clusters.len()).filter(move |&other_index| {
            let other = &clusters[other_index];
            one.segment == other.segment
                && one.centre.distance(other.centre) < one.radius_m + other.radius_m + gap_m
                && one
                    .vertices
                    .clone()
                    .any(|a| other.vertices.clone().any(|b| is_facing(a, b)))
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
    /// rest, and those that face each other where the skin is relaxed; in a fixed order. `relaxed` is for whether any of a cluster is.
    pub(super) fn find_pairs(
        &self,
        palette: &Palette,
        is_relaxed: impl Fn(usize) -> bool,
        relaxed: &mut [bool],
        posed: &mut [PosedCluster],
        bones: &mut Vec<PosedBone>,
        pairs: &mut Vec<Pair>,
    ) {
        pairs.clear();
        for &cluster in &self.faced {
            let mut vertices = self.clusters[cluster as usize].vertices.clone();
            relaxed[cluster as usize] = vertices.any(&is_relaxed);
        }
        let any_relaxed = |pair: &Pair| relaxed[pair.one as usize] || relaxed[pair.other as usize];
        pairs.extend(self.facing.iter().copied().filter(any_relaxed));
        let carry = |bone: usize| Affine3A::from_mat4(DMat4::from(palette.carries()[bone]).as_mat4());
        for bone in &self.bones {
            let carry = carry(bone.bone);
            for index in bone.clusters.clone() {
                let cluster = &self.clusters[index];
                posed[index] = PosedCluster {
                    centre: carry.transform_point3a(cluster.centre),
                    facing: carry.transform_vector3a(cluster.facing).normalize_or_zero(),
                    scale: palette.scales()[bone.bone] as f32,
                };
            }
        }
        bones.clear();
        bones.extend(self.bones.iter().map(|bone| PosedBone::new(bone, palette)));
        for (index, (one, here)) in self.bones.iter().zip(&*bones).enumerate() {
            for (other, there) in self.bones.iter().zip(&*bones).skip(index + 1) {
                if one.segment != other.segment
                    && here.may_meet(there, self.reach_m)
                    && here.has_moved_against(there)
                {
                    self.find_pairs_of((one, here), (other, there), posed, pairs);
                }
            }
        }
    }

    fn find_pairs_of(
        &self,
        (one, one_posed): (&BoneClusters, &PosedBone),
        (other, other_posed): (&BoneClusters, &PosedBone),
        posed: &[PosedCluster],
        pairs: &mut Vec<Pair>,
    ) {
        let scale = one_posed.scale.max(other_posed.scale);
        let reach_m = self.reach_m * scale;
        let near = |centre: Vec3A, radius_m: f32, to: Vec3A, to_radius_m: f32| {
            let near_m = (radius_m + to_radius_m) * scale + reach_m;
            centre.distance_squared(to) <= near_m * near_m
        };
        for index in one.clusters.clone() {
            let (own, here) = (&self.clusters[index], &posed[index]);
            if !near(here.centre, own.radius_m, other_posed.centre, other.radius_m) {
                continue;
            }
            for other_index in other.clusters.clone() {
                let (others, there) = (&self.clusters[other_index], &posed[other_index]);
                if !near(here.centre, own.radius_m, there.centre, others.radius_m)
                    || here.facing.dot(there.facing) >= own.spread.and(others.spread).faces_below()
                {
                    continue;
                }
                let approach_m =
                    own.centre.distance(others.centre) * scale - here.centre.distance(there.centre);
                if approach_m > SMALLEST_APPROACH * (own.radius_m + others.radius_m) * scale {
                    pairs.push(Pair {
                        one: index as u32,
                        other: other_index as u32,
                    });
                }
            }
        }
    }

    /// Whether skin with this normal may face some of a posed cluster.
    pub(super) fn may_face(&self, normal: Vec3A, cluster: u32, posed: &PosedCluster) -> bool {
        normal.dot(posed.facing) < self.clusters[cluster as usize].faces_below
    }
}

/// All clusters of a bone in a pose.
#[derive(Debug)]
pub(super) struct PosedBone {
    carry: Affine3A,
    rest_centre: Vec3A,
    centre: Vec3A,
    /// Radius of the ball that holds them, and of the smallest of them, posed, m.
    radius_m: f32,
    smallest_m: f32,
    /// Uniform scale of the bone.
    scale: f32,
}

impl PosedBone {
    fn new(bone: &BoneClusters, palette: &Palette) -> Self {
        let carry = Affine3A::from_mat4(DMat4::from(palette.carries()[bone.bone]).as_mat4());
        let scale = palette.scales()[bone.bone] as f32;
        Self {
            carry,
            rest_centre: bone.centre,
            centre: carry.transform_point3a(bone.centre),
            radius_m: bone.radius_m * scale,
            smallest_m: bone.smallest_m * scale,
            scale,
        }
    }

    fn may_meet(&self, other: &Self, reach_m: f32) -> bool {
        let near_m = self.radius_m + other.radius_m + reach_m * self.scale.max(other.scale);
        self.centre.distance_squared(other.centre) < near_m * near_m
    }

    /// Whether any of its clusters may have come nearer to one of the other's than at rest: not where both bones moved as one.
    fn has_moved_against(&self, other: &Self) -> bool {
        let apart = self.carry.matrix3 - other.carry.matrix3;
        let shifted_m = self
            .centre
            .distance(other.carry.transform_point3a(self.rest_centre));
        shifted_m + frobenius_squared(&apart).sqrt() * self.radius_m
            > SMALLEST_APPROACH * (self.smallest_m + other.smallest_m)
    }
}

/// A cluster in a pose.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PosedCluster {
    pub centre: Vec3A,
    pub facing: Vec3A,
    /// Uniform scale of its bone.
    pub scale: f32,
}
