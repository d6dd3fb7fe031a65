//! Finds the triangles of a surface that intersect each other in a pose. Clusters of triangles that are near
//! each other are tested first, by their bounding boxes.

use std::ops::Range;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use crate::faults::crossing::cut;

/// Triangles per cluster.
const TRIANGLES_PER_CLUSTER: usize = 16;

/// The clusters of a surface's triangles: each has [`TRIANGLES_PER_CLUSTER`] consecutive triangles.
#[derive(Debug)]
pub(crate) struct TriangleClusters {
    triangles: Vec<[u32; 3]>,
}

/// The bounding box of a cluster in a pose.
#[derive(Debug, Clone, Copy)]
struct PosedCluster {
    cluster: u32,
    low: Vec3A,
    high: Vec3A,
}

impl PosedCluster {
    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

impl TriangleClusters {
    /// The clusters of `triangles`. The search is fast if consecutive triangles are near each other.
    pub fn new(triangles: Vec<[u32; 3]>) -> Self {
        Self { triangles }
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of clusters.
    pub fn len(&self) -> usize {
        self.triangles.len().div_ceil(TRIANGLES_PER_CLUSTER)
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

    /// The pairs of triangles that intersect and share no vertex, one of them in the `active` clusters
    /// (rising); sorted, the lower index first. `at` gives the position of a vertex.
    pub fn crossings(&self, active: &[u32], at: impl Fn(u32) -> Vec3A + Sync) -> Vec<[u32; 2]> {
        let all: Vec<PosedCluster> = (0..self.len() as u32)
            .into_par_iter()
            .with_min_len(64)
            .map(|cluster| self.posed(cluster, &at))
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
        let mut crossings: Vec<[u32; 2]> = pairs
            .par_iter()
            .with_min_len(64)
            .flat_map_iter(|&(one, other)| self.crossings_of(&all[one as usize], &all[other as usize], &at))
            .collect();
        crossings.sort_unstable();
        crossings
    }

    fn range(&self, cluster: u32) -> Range<usize> {
        let first = cluster as usize * TRIANGLES_PER_CLUSTER;
        first..(first + TRIANGLES_PER_CLUSTER).min(self.triangles.len())
    }

    fn corners(&self, triangle: usize, at: impl Fn(u32) -> Vec3A) -> [Vec3A; 3] {
        self.triangles[triangle].map(at)
    }

    fn posed(&self, cluster: u32, at: impl Fn(u32) -> Vec3A) -> PosedCluster {
        let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for triangle in self.range(cluster) {
            for corner in self.corners(triangle, &at) {
                (low, high) = (low.min(corner), high.max(corner));
            }
        }
        PosedCluster { cluster, low, high }
    }

    /// The intersections of the triangles of two clusters, or within one.
    fn crossings_of(
        &self,
        one: &PosedCluster,
        other: &PosedCluster,
        at: impl Fn(u32) -> Vec3A,
    ) -> Vec<[u32; 2]> {
        let (low, high) = (one.low.max(other.low), one.high.min(other.high));
        let within = |cluster: u32| {
            let boxes = self.range(cluster).map(|triangle| {
                let corners = self.corners(triangle, &at);
                let [a, b, c] = corners;
                (triangle, corners, a.min(b).min(c), a.max(b).max(c))
            });
            boxes.filter(|&(_, _, its_low, its_high)| its_low.cmple(high).all() && low.cmple(its_high).all())
        };
        let others: Vec<_> = within(other.cluster).collect();
        let mut crossings = vec![];
        if others.is_empty() {
            return crossings;
        }
        for (index, corners, low, high) in within(one.cluster) {
            let vertices = &self.triangles[index];
            for (other_index, other_corners, other_low, other_high) in &others {
                let is_new = one.cluster != other.cluster || *other_index > index;
                if !(is_new && low.cmple(*other_high).all() && other_low.cmple(high).all()) {
                    continue;
                }
                let theirs = &self.triangles[*other_index];
                let shares_vertex = theirs.iter().any(|vertex| vertices.contains(vertex));
                if !shares_vertex && cut(corners.map(wide), other_corners.map(wide)) {
                    crossings.push([index as u32, *other_index as u32]);
                }
            }
        }
        crossings
    }
}

fn wide(corner: Vec3A) -> DVec3 {
    corner.as_dvec3()
}

/// The pairs of clusters, one of them active, whose boxes overlap, the lower index first: a sweep along the
/// longest axis.
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
    let is_active = |posed: &PosedCluster| is_active[posed.cluster as usize];
    let work = posed.par_iter().enumerate().with_min_len(64);
    work.flat_map_iter(|(index, one)| {
        let after = posed[index..].iter();
        let after = after.take_while(|other| other.low[axis] <= one.high[axis]);
        let paired = after.filter(|other| (is_active(one) || is_active(other)) && one.overlaps(other));
        paired
            .map(|other| (one.cluster.min(other.cluster), one.cluster.max(other.cluster)))
            .collect::<Vec<_>>()
    })
    .collect()
}
