//! Areas and normals at the vertices of a mesh.

use glam::{DVec3, Vec3A};

/// A third of the area of the triangles at each vertex, m².
pub(crate) fn areas(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
    let mut areas = vec![0.0; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        triangle
            .iter()
            .for_each(|&vertex| areas[vertex as usize] += third);
    }
    areas
}

/// The unit normal at each vertex, weighted by area; 0 at a vertex without faces.
pub(crate) fn normals(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Vec3A> {
    let mut normals = vec![DVec3::ZERO; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
        let normal = (b - a).cross(c - a);
        triangle
            .iter()
            .for_each(|&vertex| normals[vertex as usize] += normal);
    }
    normals
        .into_iter()
        .map(|normal| normal.normalize_or_zero().as_vec3a())
        .collect()
}
