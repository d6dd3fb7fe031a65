//! Finds the clusters that are near a cluster at rest, so that a bind does not compare all of them.

use glam::Vec3A;

use crate::math::aabb::Aabb;
use crate::skin::contact::cluster::Cluster;

/// Boxes around the clusters. Neighbours in the list of clusters are mostly neighbours in space, because the clusters
/// were made by halving (`vertex_order.rs`), so a node of the tree is a pair of nodes in a row.
#[derive(Debug)]
pub(crate) struct ClusterTree {
    /// Boxes of 1, 2, 4, ... clusters in a row.
    levels: Vec<Vec<Aabb>>,
}

/// A box around a cluster and a distance beyond it.
fn around(cluster: &Cluster, distance_m: f32) -> Aabb {
    let reach = Vec3A::splat(cluster.radius_m + distance_m);
    Aabb {
        low: cluster.centre - reach,
        high: cluster.centre + reach,
    }
}

impl ClusterTree {
    pub fn new(clusters: &[Cluster]) -> Self {
        let mut levels: Vec<Vec<Aabb>> = vec![clusters.iter().map(|cluster| around(cluster, 0.0)).collect()];
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            levels.push(below.chunks(2).map(Aabb::joined).collect());
        }
        Self { levels }
    }

    /// Calls `visit` with the clusters, rising, whose spheres may be within `distance_m` of that of `cluster`.
    pub fn each_near(&self, cluster: &Cluster, distance_m: f32, visit: &mut impl FnMut(usize)) {
        let around = around(cluster, distance_m * (1.0 + f32::EPSILON));
        self.visit(self.levels.len() - 1, 0, &around, visit);
    }

    fn visit(&self, level: usize, node: usize, around: &Aabb, visit: &mut impl FnMut(usize)) {
        if !self.levels[level]
            .get(node)
            .is_some_and(|bounds| bounds.overlaps(around))
        {
            return;
        }
        if level == 0 {
            visit(node);
            return;
        }
        self.visit(level - 1, 2 * node, around, visit);
        self.visit(level - 1, 2 * node + 1, around, visit);
    }
}
