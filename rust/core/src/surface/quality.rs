//! The shape of faces.

use glam::DVec3;

/// The quality of the worse of the two triangles of a quad, split along its better diagonal. The quality of a
/// triangle is 4√3 · area over the sum of its squared edges: 1 if equilateral, 0 if degenerate, negative if
/// its normal opposes that of the quad.
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
