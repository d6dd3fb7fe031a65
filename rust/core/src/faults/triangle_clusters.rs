//! Finds the triangles of a surface that intersect each other in a pose. Clusters of triangles that are near
//! each other are tested first, by their bounding boxes.

use std::ops::Range;

use fixedbitset::FixedBitSet;
use glam::Vec3A;
use rayon::prelude::*;

use crate::faults::crossing::cut;
use crate::math::aabb::Aabb;

/// Triangles per cluster, and clusters per group. Boxes of groups are tested before those of their clusters.
const TRIANGLES_PER_CLUSTER: usize = 16;
const CLUSTERS_PER_GROUP: usize = 16;

/// The clusters of a surface's triangles: each has [`TRIANGLES_PER_CLUSTER`] consecutive triangles.
#[derive(Debug)]
pub(crate) struct TriangleClusters {
    triangles: Vec<[u32; 3]>,
    /// The points at the corners of each triangle. Corners may be different vertices at one point.
    corners: Vec<[u32; 3]>,
}

impl TriangleClusters {
    /// The clusters of `triangles`. `point_of` gives the point of a vertex. The search is fast if consecutive
    /// triangles are near each other.
    pub fn new(triangles: Vec<[u32; 3]>, point_of: impl Fn(u32) -> u32) -> Self {
        let corners: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(&point_of)).collect();
        Self { triangles, corners }
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

    /// The pairs of triangles that intersect and share no vertex, one of them in the `active` clusters;
    /// sorted, the lower index first. `at` gives the position of a point.
    pub fn crossings(&self, active: &[u32], at: impl Fn(u32) -> Vec3A + Sync) -> Vec<[u32; 2]> {
        let triangles: Vec<Aabb> = self
            .corners
            .par_iter()
            .with_min_len(1024)
            .map(|corners| Aabb::of(corners.iter().map(|&point| at(point))))
            .collect();
        let clusters: Vec<Aabb> = triangles
            .chunks(TRIANGLES_PER_CLUSTER)
            .map(Aabb::joined)
            .collect();
        let mut is_active = FixedBitSet::with_capacity(clusters.len());
        is_active.extend(active.iter().map(|&cluster| cluster as usize));
        let mut crossings: Vec<[u32; 2]> = pairs(&clusters, &is_active)
            .par_iter()
            .with_min_len(64)
            .flat_map_iter(|&(one, other)| {
                let common = clusters[one as usize].common(&clusters[other as usize]);
                self.crossings_of(one, other, &common, &triangles, &at)
            })
            .collect();
        crossings.sort_unstable();
        crossings
    }

    fn range(&self, cluster: u32) -> Range<usize> {
        let first = cluster as usize * TRIANGLES_PER_CLUSTER;
        first..(first + TRIANGLES_PER_CLUSTER).min(self.triangles.len())
    }

    /// The intersections of the triangles of two clusters, or within one. `common` is in the boxes of both.
    fn crossings_of(
        &self,
        one: u32,
        other: u32,
        common: &Aabb,
        bounds: &[Aabb],
        at: impl Fn(u32) -> Vec3A,
    ) -> Vec<[u32; 2]> {
        let mut crossings = vec![];
        let near = |&triangle: &usize| bounds[triangle].overlaps(common);
        let (mut others, mut count) = ([0; TRIANGLES_PER_CLUSTER], 0);
        for triangle in self.range(other).filter(near) {
            others[count] = triangle;
            count += 1;
        }
        for index in self.range(one).filter(near) {
            for &other_index in &others[..count] {
                let is_new = one != other || other_index > index;
                if !(is_new && bounds[index].overlaps(&bounds[other_index])) {
                    continue;
                }
                let (vertices, theirs) = (&self.triangles[index], &self.triangles[other_index]);
                let shares_vertex = theirs.iter().any(|vertex| vertices.contains(vertex));
                let corners = |triangle: usize| self.corners[triangle].map(|point| at(point).as_dvec3());
                if !shares_vertex && cut(corners(index), corners(other_index)) {
                    crossings.push([index as u32, other_index as u32]);
                }
            }
        }
        crossings
    }
}

/// The pairs of clusters, one of them active, whose boxes overlap, the lower index first. A cluster is paired
/// with itself.
fn pairs(clusters: &[Aabb], is_active: &FixedBitSet) -> Vec<(u32, u32)> {
    let range = |group: usize| {
        let first = group * CLUSTERS_PER_GROUP;
        first..(first + CLUSTERS_PER_GROUP).min(clusters.len())
    };
    let groups: Vec<(Aabb, bool)> = (0..clusters.len().div_ceil(CLUSTERS_PER_GROUP))
        .map(|group| {
            let bounds = Aabb::joined(&clusters[range(group)]);
            (bounds, is_active.contains_any_in_range(range(group)))
        })
        .collect();
    let of_group = |group: usize| {
        let mut found = vec![];
        let (here, is_here_active) = groups[group];
        for (other_group, (there, is_there_active)) in groups.iter().enumerate().skip(group) {
            if !((is_here_active || *is_there_active) && here.overlaps(there)) {
                continue;
            }
            for one in range(group).filter(|&one| clusters[one].overlaps(there)) {
                let is_paired = |other: &usize| {
                    (is_active.contains(one) || is_active.contains(*other))
                        && clusters[one].overlaps(&clusters[*other])
                };
                let others = range(other_group).filter(|&other| other >= one).filter(is_paired);
                found.extend(others.map(|other| (one as u32, other as u32)));
            }
        }
        found
    };
    (0..groups.len())
        .into_par_iter()
        .with_min_len(8)
        .flat_map_iter(of_group)
        .collect()
}
