//! The positions of clusters' vertices as structure of arrays, so that four distances are computed at a
//! time (mathematics/skinning.md, Structure of arrays).

use std::ops::Range;

use glam::{Vec3A, Vec4};

use crate::math::vec3x4::{LANES, Vec3x4};
use crate::skin::contact::cluster::Cluster;

/// Padding of a cluster's last row: infinitely far from everything.
const INFINITELY_FAR: Vec3x4 = Vec3x4 {
    x: Vec4::INFINITY,
    y: Vec4::INFINITY,
    z: Vec4::INFINITY,
};

/// The positions of all clusters, m. Each cluster starts a new row.
#[derive(Debug)]
pub(crate) struct PointsSoa {
    /// Where the rows of each cluster start; one more than clusters.
    offsets: Vec<usize>,
    rows: Vec<Vec3x4>,
}

impl PointsSoa {
    pub fn new(clusters: &[Cluster]) -> Self {
        let mut offsets = vec![0];
        for cluster in clusters {
            offsets.push(offsets[offsets.len() - 1] + cluster.vertices.len().div_ceil(LANES));
        }
        let rows = vec![INFINITELY_FAR; offsets[clusters.len()]];
        Self { offsets, rows }
    }

    fn rows_of(&self, cluster: u32) -> Range<usize> {
        self.offsets[cluster as usize]..self.offsets[cluster as usize + 1]
    }

    /// Sets the positions of a cluster's vertices.
    pub fn set(&mut self, cluster: u32, positions: &[Vec3A]) {
        let rows = self.rows_of(cluster);
        for (row, positions) in self.rows[rows].iter_mut().zip(positions.chunks(LANES)) {
            for (lane, position) in positions.iter().enumerate() {
                (row.x[lane], row.y[lane], row.z[lane]) = (position.x, position.y, position.z);
            }
        }
    }

    /// The positions of a cluster's vertices, in their order, with padding.
    pub fn of(&self, cluster: u32) -> &[Vec3x4] {
        &self.rows[self.rows_of(cluster)]
    }
}
