//! How much the angle between neighbouring faces changed. Smooth skin bends a little everywhere; a sharp fold
//! bends in one place.

use glam::DVec3;

use super::topology::InnerEdge;
use crate::faults::inverted::normal;
use crate::faults::percentile::percentile;

/// 99th percentile of the change of the angle at inner edges, degrees 0..180; 0 without inner edges.
pub(super) fn bend_p99(
    rest_degrees: &[f64],
    posed: &[DVec3],
    triangles: &[[u32; 3]],
    inner_edges: &[InnerEdge],
) -> f64 {
    let change = |(now, then): (f64, &f64)| ((now - then + 180.0).rem_euclid(360.0) - 180.0).abs();
    let now = dihedrals(posed, triangles, inner_edges);
    let mut changes: Vec<f64> = now.into_iter().zip(rest_degrees).map(change).collect();
    percentile(&mut changes, 99.0).unwrap_or(0.0)
}

/// The angle between the two faces of each edge, degrees -180..180: 0 is flat, positive is convex.
pub(super) fn dihedrals(points: &[DVec3], triangles: &[[u32; 3]], inner_edges: &[InnerEdge]) -> Vec<f64> {
    let normals: Vec<DVec3> = triangles
        .iter()
        .map(|triangle| normal(triangle.map(|vertex| points[vertex as usize])))
        .collect();
    let angle = |edge: &InnerEdge| {
        let [start, end] = edge.ends.map(|vertex| points[vertex as usize]);
        let [a, b] = edge.faces.map(|face| normals[face as usize]);
        let along = (end - start).normalize_or_zero();
        a.cross(b).dot(along).atan2(a.dot(b)).to_degrees()
    };
    inner_edges.iter().map(angle).collect()
}
