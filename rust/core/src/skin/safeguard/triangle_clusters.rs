//! Finds the triangles of a skin that intersect each other in a pose. Clusters of triangles that are near
//! each other are tested first, by their bounding boxes and normals. Clusters that touch and whose normals
//! are all in one half-space do not intersect (P. Volino, N. Magnenat-Thalmann, "Efficient self-collision
//! detection on smoothly discretized surface animations", 1994). This excludes nearly all pairs.

use std::ops::Range;

use glam::Vec3A;
use rayon::prelude::*;

use crate::skin::safeguard::crossing::crossing_m;

/// Triangles per cluster.
const TRIANGLES_PER_CLUSTER: usize = 16;
/// Least cosine between the normals of two touching clusters and their mean for which the clusters do not
/// intersect.
const HALF_SPACE: f32 = 0.1;
/// Largest angle between any two normals of two touching clusters for which the clusters do not intersect,
/// rad. It is less than pi, because a fold of few triangles can hide between the normals.
const LARGEST_ANGLE: f32 = 2.6;

/// Cosine between the normals of two triangles of touching clusters below which the skin between them may be
/// folded so that they intersect.
const FOLDED: f32 = 0.8;

/// Two triangles that intersect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    pub one: u32,
    pub other: u32,
    /// Length of the segment in which they intersect, m.
    pub length_m: f32,
}

/// The clusters of a mesh's triangles.
#[derive(Debug)]
pub(crate) struct TriangleClusters {
    triangles: Vec<[u32; 3]>,
    /// The clusters that share a vertex with each cluster, including itself; rising.
    touching: Vec<Vec<u32>>,
}

/// The bounding box of a cluster in a pose.
#[derive(Debug, Clone, Copy)]
struct PosedCluster {
    cluster: u32,
    low: Vec3A,
    high: Vec3A,
}

/// A cone that contains the normals of a cluster: they are within `angle`, rad, of `axis`.
#[derive(Debug, Clone, Copy, Default)]
struct NormalCone {
    axis: Vec3A,
    angle: f32,
}

impl NormalCone {
    fn new(normals: &[Vec3A]) -> Self {
        let axis = normals.iter().sum::<Vec3A>().normalize_or_zero();
        let sized = normals.iter().filter(|normal| **normal != Vec3A::ZERO);
        let least = sized.map(|normal| normal.dot(axis)).fold(1.0, f32::min);
        Self {
            axis,
            angle: least.clamp(-1.0, 1.0).acos(),
        }
    }

    fn is_within_half_space(&self, other: &Self) -> bool {
        let between = self.axis.dot(other.axis).clamp(-1.0, 1.0).acos();
        self.angle + between + other.angle < LARGEST_ANGLE
    }
}

impl TriangleClusters {
    /// The clusters of `triangles`. Consecutive triangles are near each other.
    pub fn new(triangles: Vec<[u32; 3]>, vertices: usize) -> Self {
        let mut clusters_of: Vec<Vec<u32>> = vec![vec![]; vertices];
        for (index, triangle) in triangles.iter().enumerate() {
            for &vertex in triangle {
                let cluster = (index / TRIANGLES_PER_CLUSTER) as u32;
                if clusters_of[vertex as usize].last() != Some(&cluster) {
                    clusters_of[vertex as usize].push(cluster);
                }
            }
        }
        let touching = triangles.chunks(TRIANGLES_PER_CLUSTER).map(|cluster| {
            let corners = cluster.iter().flatten();
            let mut touching: Vec<u32> = corners
                .flat_map(|&vertex| &clusters_of[vertex as usize])
                .copied()
                .collect();
            touching.sort_unstable();
            touching.dedup();
            touching
        });
        Self {
            touching: touching.collect(),
            triangles,
        }
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The clusters of some triangles, rising.
    pub fn of(&self, triangles: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut clusters: Vec<u32> = triangles
            .map(|triangle| triangle / TRIANGLES_PER_CLUSTER as u32)
            .collect();
        clusters.sort_unstable();
        clusters.dedup();
        clusters
    }

    /// The intersections of triangles of the `active` clusters (rising) with any triangle, sorted. `positions`
    /// are the positions of the vertices.
    pub fn crossings(&self, active: &[u32], positions: &[Vec3A]) -> Vec<Crossing> {
        let all: Vec<PosedCluster> = (0..self.touching.len() as u32)
            .into_par_iter()
            .with_min_len(64)
            .map(|cluster| self.posed(cluster, positions))
            .collect();
        let mut is_active = vec![false; all.len()];
        active
            .iter()
            .for_each(|&cluster| is_active[cluster as usize] = true);
        let active_boxes = active.iter().map(|&cluster| &all[cluster as usize]);
        let low = active_boxes
            .clone()
            .map(|posed| posed.low)
            .fold(Vec3A::INFINITY, Vec3A::min);
        let high = active_boxes
            .map(|posed| posed.high)
            .fold(Vec3A::NEG_INFINITY, Vec3A::max);
        let is_near = |cluster: &PosedCluster| cluster.low.cmple(high).all() && low.cmple(cluster.high).all();
        let near: Vec<PosedCluster> = all.iter().copied().filter(is_near).collect();
        let pairs = pairs(near, &is_active);
        let (normals, cones) = self.normals(&pairs, positions);
        let mut all_crossings: Vec<Crossing> = pairs
            .par_iter()
            .with_min_len(64)
            .flat_map_iter(|&(one, other)| {
                let mut crossings = vec![];
                let touches = self.touching[one as usize].binary_search(&other).is_ok();
                let is_within_half_space = || {
                    cones[one as usize].is_within_half_space(&cones[other as usize])
                        || is_within_half_space(&normals[self.range(one)], &normals[self.range(other)])
                };
                if !(touches && is_within_half_space()) {
                    let pair = (&all[one as usize], &all[other as usize]);
                    let most = if touches { FOLDED } else { 2.0 };
                    let may_cross = |a: usize, b: usize| normals[a].dot(normals[b]) < most;
                    self.find_crossings(pair, positions, may_cross, &mut crossings);
                }
                crossings
            })
            .collect();
        all_crossings.sort_unstable_by_key(|crossing| (crossing.one, crossing.other));
        all_crossings
    }

    fn range(&self, cluster: u32) -> Range<usize> {
        let first = cluster as usize * TRIANGLES_PER_CLUSTER;
        first..(first + TRIANGLES_PER_CLUSTER).min(self.triangles.len())
    }

    fn corners(&self, triangle: usize, positions: &[Vec3A]) -> [Vec3A; 3] {
        self.triangles[triangle].map(|vertex| positions[vertex as usize])
    }

    fn posed(&self, cluster: u32, positions: &[Vec3A]) -> PosedCluster {
        let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for triangle in self.range(cluster) {
            for corner in self.corners(triangle, positions) {
                (low, high) = (low.min(corner), high.max(corner));
            }
        }
        PosedCluster { cluster, low, high }
    }

    /// The unit normals of the triangles of the clusters in some pairs, and the cones that contain them. The
    /// entries of all other clusters are 0.
    fn normals(&self, pairs: &[(u32, u32)], positions: &[Vec3A]) -> (Vec<Vec3A>, Vec<NormalCone>) {
        let mut is_paired = vec![false; self.touching.len()];
        for &(one, other) in pairs {
            (is_paired[one as usize], is_paired[other as usize]) = (true, true);
        }
        let mut normals = vec![Vec3A::ZERO; self.triangles.len()];
        let mut cones = vec![NormalCone::default(); self.touching.len()];
        let work = normals
            .par_chunks_mut(TRIANGLES_PER_CLUSTER)
            .zip(&mut cones)
            .zip(is_paired)
            .enumerate();
        work.with_min_len(16)
            .filter(|(_, (_, is_paired))| *is_paired)
            .for_each(|(cluster, ((normals, cone), _))| {
                for (triangle, normal) in self.range(cluster as u32).zip(&mut *normals) {
                    let [a, b, c] = self.corners(triangle, positions);
                    *normal = (b - a).cross(c - a).normalize_or_zero();
                }
                *cone = NormalCone::new(normals);
            });
        (normals, cones)
    }

    fn find_crossings(
        &self,
        (one, other): (&PosedCluster, &PosedCluster),
        positions: &[Vec3A],
        may_cross: impl Fn(usize, usize) -> bool,
        crossings: &mut Vec<Crossing>,
    ) {
        let (low, high) = (one.low.max(other.low), one.high.min(other.high));
        let within = |cluster: u32| {
            let boxes = self.range(cluster).map(|triangle| {
                let [a, b, c] = self.corners(triangle, positions);
                (triangle, a.min(b).min(c), a.max(b).max(c))
            });
            boxes.filter(|entry| entry.1.cmple(high).all() && low.cmple(entry.2).all())
        };
        let mut others = [(0, Vec3A::ZERO, Vec3A::ZERO); TRIANGLES_PER_CLUSTER];
        let mut count = 0;
        for (slot, entry) in others.iter_mut().zip(within(other.cluster)) {
            *slot = entry;
            count += 1;
        }
        if count == 0 {
            return;
        }
        for (index, low, high) in within(one.cluster) {
            let vertices = self.triangles[index];
            for &(other_index, other_low, other_high) in &others[..count] {
                let is_new = one.cluster != other.cluster || other_index > index;
                let overlaps = low.cmple(other_high).all() && other_low.cmple(high).all();
                if !(is_new && overlaps && may_cross(index, other_index)) {
                    continue;
                }
                let is_common = |vertex: &u32| vertices.contains(vertex);
                if self.triangles[other_index].iter().any(is_common) {
                    continue;
                }
                let (corners, others) = (
                    self.corners(index, positions),
                    self.corners(other_index, positions),
                );
                let length_m = crossing_m(&corners, &others);
                if length_m > 0.0 {
                    crossings.push(Crossing {
                        one: index as u32,
                        other: other_index as u32,
                        length_m,
                    });
                }
            }
        }
    }
}

/// Whether all normals are in one half-space around their mean.
fn is_within_half_space(one: &[Vec3A], other: &[Vec3A]) -> bool {
    let mean = (one.iter().sum::<Vec3A>() + other.iter().sum::<Vec3A>()).normalize_or_zero();
    let mut all = one.iter().chain(other);
    all.all(|&normal| normal == Vec3A::ZERO || normal.dot(mean) > HALF_SPACE)
}

/// The pairs of clusters, one of them active, whose boxes overlap: a sweep along the longest axis.
fn pairs(mut posed: Vec<PosedCluster>, is_active: &[bool]) -> Vec<(u32, u32)> {
    let low = posed
        .iter()
        .map(|posed| posed.low)
        .fold(Vec3A::INFINITY, Vec3A::min);
    let high = posed
        .iter()
        .map(|posed| posed.high)
        .fold(Vec3A::NEG_INFINITY, Vec3A::max);
    let axis = (high - low).max_position();
    posed.sort_unstable_by(|a, b| {
        a.low[axis]
            .total_cmp(&b.low[axis])
            .then(a.cluster.cmp(&b.cluster))
    });
    let active: Vec<&PosedCluster> = posed
        .iter()
        .filter(|posed| is_active[posed.cluster as usize])
        .collect();
    let overlaps = |one: &PosedCluster, other: &PosedCluster| {
        one.low.cmple(other.high).all() && other.low.cmple(one.high).all()
    };
    let pair = |one: &PosedCluster, other: &PosedCluster| {
        (one.cluster.min(other.cluster), one.cluster.max(other.cluster))
    };
    let work = posed.par_iter().enumerate().with_min_len(64);
    work.flat_map_iter(|(index, one)| {
        let mut pairs = vec![];
        if is_active[one.cluster as usize] {
            let after = posed[index..].iter();
            let after = after.take_while(|other| other.low[axis] <= one.high[axis]);
            pairs.extend(
                after
                    .filter(|other| overlaps(one, other))
                    .map(|other| pair(one, other)),
            );
        } else {
            let key = (one.low[axis], one.cluster);
            let first = active.partition_point(|other| (other.low[axis], other.cluster) < key);
            let after = active[first..].iter();
            let after = after.take_while(|other| other.low[axis] <= one.high[axis]);
            pairs.extend(
                after
                    .filter(|other| overlaps(one, other))
                    .map(|other| pair(one, other)),
            );
        }
        pairs
    })
    .collect()
}
