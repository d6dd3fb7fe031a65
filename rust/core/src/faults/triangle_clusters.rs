//! Finds the triangles of a surface that intersect each other in a pose. Clusters of triangles that are near
//! each other are tested first, by their bounding boxes.

use std::ops::Range;

use fixedbitset::FixedBitSet;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use crate::faults::crossing::cut;
use crate::math::rows::Rows;

/// Triangles per cluster, and clusters per group. Boxes of groups are tested before those of their clusters.
const TRIANGLES_PER_CLUSTER: usize = 16;
const CLUSTERS_PER_GROUP: usize = 16;

/// The clusters of a surface's triangles: each has [`TRIANGLES_PER_CLUSTER`] consecutive triangles.
#[derive(Debug)]
pub(crate) struct TriangleClusters {
    triangles: Vec<[u32; 3]>,
    /// The points at the corners of each triangle. Corners may be different vertices at one point.
    corners: Vec<[u32; 3]>,
    /// The points of each cluster, each once.
    points_of: Rows<u32>,
}

/// A bounding box.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: Vec3A,
    high: Vec3A,
}

impl Bounds {
    const EMPTY: Self = Self {
        low: Vec3A::INFINITY,
        high: Vec3A::NEG_INFINITY,
    };

    fn of(points: impl Iterator<Item = Vec3A>) -> Self {
        points.fold(Self::EMPTY, |bounds, point| Self {
            low: bounds.low.min(point),
            high: bounds.high.max(point),
        })
    }

    fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    fn common(&self, other: &Self) -> Self {
        Self {
            low: self.low.max(other.low),
            high: self.high.min(other.high),
        }
    }
}

impl TriangleClusters {
    /// The clusters of `triangles`. `point_of` gives the point of a vertex. The search is fast if consecutive
    /// triangles are near each other.
    pub fn new(triangles: Vec<[u32; 3]>, point_of: impl Fn(u32) -> u32) -> Self {
        let corners: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(&point_of)).collect();
        let points_of = corners.chunks(TRIANGLES_PER_CLUSTER).map(|corners| {
            let mut points = corners.as_flattened().to_vec();
            points.sort_unstable();
            points.dedup();
            points
        });
        Self {
            points_of: Rows::from_rows(points_of),
            corners,
            triangles,
        }
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of clusters.
    pub fn len(&self) -> usize {
        self.points_of.len()
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
        let of_points = |points: &[u32]| Bounds::of(points.iter().map(|&point| at(point)));
        let clusters: Vec<Bounds> = (0..self.len())
            .into_par_iter()
            .with_min_len(256)
            .map(|cluster| of_points(self.points_of.row(cluster)))
            .collect();
        let mut is_active = FixedBitSet::with_capacity(clusters.len());
        is_active.extend(active.iter().map(|&cluster| cluster as usize));
        let mut crossings: Vec<[u32; 2]> = pairs(&clusters, &is_active)
            .par_iter()
            .with_min_len(64)
            .flat_map_iter(|&(one, other)| {
                let common = clusters[one as usize].common(&clusters[other as usize]);
                self.crossings_of(one, other, &common, &at)
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
        common: &Bounds,
        at: impl Fn(u32) -> Vec3A,
    ) -> Vec<[u32; 2]> {
        let within = |cluster: u32| {
            let boxes = self.range(cluster).map(|triangle| {
                let corners = self.corners[triangle].map(&at);
                (triangle, corners, Bounds::of(corners.into_iter()))
            });
            boxes.filter(|(_, _, bounds)| bounds.overlaps(common))
        };
        let others: Vec<_> = within(other).collect();
        let mut crossings = vec![];
        if others.is_empty() {
            return crossings;
        }
        for (index, corners, bounds) in within(one) {
            let vertices = &self.triangles[index];
            for (other_index, other_corners, other_bounds) in &others {
                let is_new = one != other || *other_index > index;
                if !(is_new && bounds.overlaps(other_bounds)) {
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

/// The pairs of clusters, one of them active, whose boxes overlap, the lower index first. A cluster is paired
/// with itself.
fn pairs(clusters: &[Bounds], is_active: &FixedBitSet) -> Vec<(u32, u32)> {
    let range = |group: usize| {
        let first = group * CLUSTERS_PER_GROUP;
        first..(first + CLUSTERS_PER_GROUP).min(clusters.len())
    };
    let groups: Vec<(Bounds, bool)> = (0..clusters.len().div_ceil(CLUSTERS_PER_GROUP))
        .map(|group| {
            let bounds = clusters[range(group)]
                .iter()
                .copied()
                .fold(Bounds::EMPTY, Bounds::with);
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
