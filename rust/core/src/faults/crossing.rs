//! Whether two triangles intersect.

use glam::DVec3;

/// Distance outside a triangle or an edge, as a fraction of it, that still counts as on it.
const TOLERANCE: f64 = 1e-9;
/// Volume spanned by an edge and a triangle, as a fraction of a box with these sides, below which they count
/// as parallel.
const PARALLEL: f64 = 1e-12;

/// Whether two triangles intersect: an edge of either passes through the other.
pub(crate) fn cut(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    let through = |edges: [DVec3; 3], triangle: [DVec3; 3]| {
        (0..3).any(|corner| goes_through(edges[corner], edges[(corner + 1) % 3], triangle))
    };
    through(a, b) || through(b, a)
}

/// Whether the segment from `start` to `end` intersects a triangle (Möller and Trumbore 1997).
fn goes_through(start: DVec3, end: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let (line, to_b, to_c) = (end - start, b - a, c - a);
    let across = line.cross(to_c);
    let determinant = to_b.dot(across);
    let squared = line.length_squared() * to_b.length_squared() * to_c.length_squared();
    if determinant * determinant <= PARALLEL * PARALLEL * squared {
        return false;
    }
    let from_a = start - a;
    let u = from_a.dot(across) / determinant;
    if !(-TOLERANCE..=1.0 + TOLERANCE).contains(&u) {
        return false;
    }
    let around = from_a.cross(to_b);
    let v = line.dot(around) / determinant;
    let along = to_c.dot(around) / determinant;
    v >= -TOLERANCE && u + v <= 1.0 + TOLERANCE && (-TOLERANCE..=1.0 + TOLERANCE).contains(&along)
}
