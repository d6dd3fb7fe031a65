//! How well-shaped faces are.

use glam::DVec3;

/// The worse of the two triangles of a quad, cut along the better of its diagonals; a triangle counts 4√3 · area over its
/// squared edges: 1 for an equilateral one, 0 for a sliver, below 0 for one that looks the other way than the quad.
pub(super) fn of_quad([a, b, c, d]: [DVec3; 4]) -> f64 {
    let normal = (c - a).cross(d - b);
    let worse =
        |first: [DVec3; 3], second: [DVec3; 3]| of_triangle(first, normal).min(of_triangle(second, normal));
    worse([a, b, c], [a, c, d]).max(worse([a, b, d], [b, c, d]))
}

fn of_triangle([a, b, c]: [DVec3; 3], normal: DVec3) -> f64 {
    let area = (b - a).cross(c - a);
    let squares = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
    if squares == 0.0 {
        return 0.0;
    }
    let size = 2.0 * 3.0_f64.sqrt() * area.length() / squares;
    if area.dot(normal) > 0.0 { size } else { -size }
}
