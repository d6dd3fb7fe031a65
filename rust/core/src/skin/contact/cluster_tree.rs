//! Finds the clusters that are near a cluster at rest, so that a bind does not compare all of them.

use glam::Vec3A;

use crate::skin::contact::cluster::Cluster;

/// Boxes around the clusters. Neighbours in the list of clusters are mostly neighbours in space, because the clusters
/// were made by halving (`vertex_order.rs`), so a node of the tree is a pair of nodes in a row.
#[derive(Debug)]
pub(crate) struct ClusterTree {
    /// Boxes of 1, 2, 4, ... clusters in a row.
    levels: Vec<Vec<Aabb>>,
}

/// A box parallel to the axes, m.
#[derive(Debug, Clone, Copy)]
struct Aabb {
    low: Vec3A,
    high: Vec3A,
}

impl Aabb {
    fn around(cluster: &Cluster, distance_m: f32) -> Self {
        let reach = Vec3A::splat(cluster.radius_m + distance_m);
        Self {
            low: cluster.centre - reach,
            high: cluster.centre + reach,
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        (self.low.cmple(other.high) & other.low.cmple(self.high)).all()
    }
}

impl ClusterTree {
    pub fn new(clusters: &[Cluster]) -> Self {
        let mut levels: Vec<Vec<Aabb>> = vec![
            clusters
                .iter()
                .map(|cluster| Aabb::around(cluster, 0.0))
                .collect(),
        ];
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            let joined = |pair: &[Aabb]| Aabb {
                low: pair.iter().map(|part| part.low).fold(pair[0].low, Vec3A::min),
                high: pair.iter().map(|part| part.high).fold(pair[0].high, Vec3A::max),
            };
            levels.push(below.chunks(2).map(joined).collect());
        }
        Self { levels }
    }

    /// Calls `visit` with the clusters, rising, whose spheres may be within `distance_m` of that of `cluster`.
    pub fn each_near(&self, cluster: &Cluster, distance_m: f32, visit: &mut impl FnMut(usize)) {
        let around = Aabb::around(cluster, distance_m * (1.0 + f32::EPSILON));
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
