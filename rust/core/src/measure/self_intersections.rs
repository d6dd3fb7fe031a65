//! Self-intersections: pairs of triangles of one mesh that intersect.

use glam::DVec3;

use crate::faults::triangle_clusters::TriangleClusters;

/// The pairs of triangles that intersect and share no vertex, sorted, the lower index first. Coplanar
/// triangles do not intersect. The points have the precision of f32.
pub(super) fn self_intersections(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let clusters = TriangleClusters::new(triangles.to_vec(), |vertex| vertex);
    let all: Vec<u32> = (0..clusters.len() as u32).collect();
    clusters.crossings(&all, |vertex| points[vertex as usize].as_vec3a())
}

/// Those of `intersections` that are not in `known`; both are sorted.
pub(super) fn new_intersections(intersections: &[[u32; 2]], known: &[[u32; 2]]) -> Vec<[u32; 2]> {
    intersections
        .iter()
        .filter(|pair| known.binary_search(pair).is_err())
        .copied()
        .collect()
}
