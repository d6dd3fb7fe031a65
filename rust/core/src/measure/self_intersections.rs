//! Self-intersections: pairs of triangles of one mesh that intersect.

use glam::DVec3;
use rayon::prelude::*;

/// Distance outside a triangle or an edge, as a fraction of it, that still counts as on it.
const TOLERANCE: f64 = 1e-9;
/// Volume spanned by an edge and a triangle, as a fraction of a box with these sides, below which they count
/// as parallel.
const PARALLEL: f64 = 1e-12;

struct Boxed {
    low: DVec3,
    high: DVec3,
    triangle: u32,
}

/// The pairs of triangles that intersect and share no vertex, sorted, the lower index first. Coplanar
/// triangles do not intersect.
///
/// Candidates come from a sweep along the longest side of the bounding box. In the MakeHuman body each of
/// 26,756 triangles has 290 candidates on average. One pose, with its inverted faces, takes about 50 ms on 2
/// cores.
pub(super) fn self_intersections(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let corners = |triangle: usize| triangles[triangle].map(|vertex| points[vertex as usize]);
    let mut boxes: Vec<Boxed> = (0..triangles.len())
        .map(|triangle| {
            let [a, b, c] = corners(triangle);
            Boxed {
                low: a.min(b).min(c),
                high: a.max(b).max(c),
                triangle: triangle as u32,
            }
        })
        .collect();
    let axis = longest_side(&boxes);
    boxes.sort_by(|a, b| a.low[axis].total_cmp(&b.low[axis]));
    let shares_vertex = |a: u32, b: u32| {
        let theirs = &triangles[b as usize];
        triangles[a as usize].iter().any(|vertex| theirs.contains(vertex))
    };
    let intersections_of = |(index, first): (usize, &Boxed)| {
        let reached = boxes[index + 1..]
            .iter()
            .take_while(|second| second.low[axis] <= first.high[axis]);
        let near =
            reached.filter(|second| first.low.cmple(second.high).all() && second.low.cmple(first.high).all());
        let intersecting = near.filter(|second| {
            !shares_vertex(first.triangle, second.triangle)
                && cut(
                    corners(first.triangle as usize),
                    corners(second.triangle as usize),
                )
        });
        intersecting
            .map(|second| {
                [
                    first.triangle.min(second.triangle),
                    first.triangle.max(second.triangle),
                ]
            })
            .collect::<Vec<_>>()
    };
    let mut intersections: Vec<_> = boxes
        .par_iter()
        .enumerate()
        .flat_map_iter(intersections_of)
        .collect();
    intersections.sort_unstable();
    intersections
}

fn longest_side(boxes: &[Boxed]) -> usize {
    let low = boxes
        .iter()
        .fold(DVec3::INFINITY, |low, bounds| low.min(bounds.low));
    let high = boxes
        .iter()
        .fold(DVec3::NEG_INFINITY, |high, bounds| high.max(bounds.high));
    let side = high - low;
    (0..3).max_by(|&a, &b| side[a].total_cmp(&side[b])).unwrap_or(0)
}

/// Whether two triangles intersect: an edge of either passes through the other.
fn cut(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
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

/// Those of `intersections` that are not in `known`; both are sorted.
pub(super) fn new_intersections(intersections: &[[u32; 2]], known: &[[u32; 2]]) -> Vec<[u32; 2]> {
    intersections
        .iter()
        .filter(|pair| known.binary_search(pair).is_err())
        .copied()
        .collect()
}
