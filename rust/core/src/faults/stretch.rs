//! How much longer or shorter edges, and larger or smaller faces, are than at rest.

use glam::DVec3;

use crate::faults::percentile::percentile;

/// Smallest lengths, m, and areas, m², so that ratios stay finite.
const SHORTEST_M: f64 = 1e-12;
const SMALLEST_M2: f64 = 1e-14;

/// `max(l / l0, l0 / l)` over edges of length l; 1 is no stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeStretch {
    /// The median.
    pub p50: f64,
    /// The 99th percentile.
    pub p99: f64,
    /// The maximum.
    pub max: f64,
}

/// Stretch of `edges` between two states of the points; 1 without edges.
pub(crate) fn edge_stretch(rest: &[DVec3], posed: &[DVec3], edges: &[[u32; 2]]) -> EdgeStretch {
    let mut stretches: Vec<f64> = edges
        .iter()
        .map(|&edge| either_way(edge_ratio(rest, posed, edge)))
        .collect();
    EdgeStretch {
        p50: percentile(&mut stretches, 50.0).unwrap_or(1.0),
        p99: percentile(&mut stretches, 99.0).unwrap_or(1.0),
        max: percentile(&mut stretches, 100.0).unwrap_or(1.0),
    }
}

/// 99th percentile of `max(A / A0, A0 / A)` over triangles of area A; 1 without triangles.
pub(crate) fn area_stretch_p99(rest: &[DVec3], posed: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let area = |points: &[DVec3], triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
        (0.5 * (b - a).cross(c - a).length()).max(SMALLEST_M2)
    };
    let ratio = |triangle| area(posed, triangle) / area(rest, triangle);
    let mut stretches: Vec<f64> = triangles
        .iter()
        .map(|triangle| either_way(ratio(triangle)))
        .collect();
    percentile(&mut stretches, 99.0).unwrap_or(1.0)
}

/// For each vertex, length over rest length of the edge at it that changed most; 1 without edges.
pub(crate) fn vertex_stretch(rest: &[DVec3], posed: &[DVec3], edges: &[[u32; 2]]) -> Vec<f32> {
    let mut worst = vec![1.0_f64; rest.len()];
    for &edge in edges {
        let ratio = edge_ratio(rest, posed, edge);
        for vertex in edge {
            let known = &mut worst[vertex as usize];
            if either_way(ratio) > either_way(*known) {
                *known = ratio;
            }
        }
    }
    worst.into_iter().map(|ratio| ratio as f32).collect()
}

fn edge_ratio(rest: &[DVec3], posed: &[DVec3], [a, b]: [u32; 2]) -> f64 {
    let length = |points: &[DVec3]| points[a as usize].distance(points[b as usize]).max(SHORTEST_M);
    length(posed) / length(rest)
}

/// The stretch of an edge whose length over its rest length is `ratio`.
pub(crate) fn either_way(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio)
}
