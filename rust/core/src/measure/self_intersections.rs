//! Self-hits: pairs of triangles of one mesh that cut each other.

use glam::DVec3;
use rayon::prelude::*;

/// How far outside a triangle or an edge, as a share of it, still counts as on it.
const TOLERANCE: f64 = 1e-9;
/// Volume that an edge spans with a triangle, as a share of that of a box of such sides, below which both count as parallel.
const PARALLEL: f64 = 1e-12;

struct Boxed {
    low: DVec3,
    high: DVec3,
    triangle: u32,
}

/// The pairs of triangles that cut each other and share no vertex, lower place first, rising. Two that lie in one plane
/// do not cut each other.
///
/// Candidates come from sweeping along the longest side of the box around the mesh: of the MakeHuman
/// body's 26,756 triangles each meets 290 others there on average; with its inverted faces a pose takes about 50 ms on
/// 2 cores.
pub(super) fn self_hits(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
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
    let hits_of = |(place, own): (usize, &Boxed)| {
        let reached = boxes[place + 1..]
            .iter()
            .take_while(|other| other.low[axis] <= own.high[axis]);
        let near = reached.filter(|other| own.low.cmple(other.high).all() && other.low.cmple(own.high).all());
        let hit = near.filter(|other| {
            !shares_vertex(own.triangle, other.triangle)
                && cut(corners(own.triangle as usize), corners(other.triangle as usize))
        });
        hit.map(|other| [own.triangle.min(other.triangle), own.triangle.max(other.triangle)])
            .collect::<Vec<_>>()
    };
    let mut hits: Vec<_> = boxes.par_iter().enumerate().flat_map_iter(hits_of).collect();
    hits.sort_unstable();
    hits
}

fn longest_side(boxes: &[Boxed]) -> usize {
    let low = boxes.iter().fold(DVec3::INFINITY, |low, own| low.min(own.low));
    let high = boxes
        .iter()
        .fold(DVec3::NEG_INFINITY, |high, own| high.max(own.high));
    let side = high - low;
    (0..3).max_by(|&a, &b| side[a].total_cmp(&side[b])).unwrap_or(0)
}

/// Whether two triangles cut each other: an edge of either goes through the other.
fn cut(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    let through = |edges: [DVec3; 3], triangle: [DVec3; 3]| {
        (0..3).any(|corner| goes_through(edges[corner], edges[(corner + 1) % 3], triangle))
    };
    through(a, b) || through(b, a)
}

/// Whether the line from `start` to `end` meets a triangle (Möller and Trumbore 1997).
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

/// Those of `hits` that are not among `known`; both rising.
pub(super) fn new_hits(hits: &[[u32; 2]], known: &[[u32; 2]]) -> Vec<[u32; 2]> {
    hits.iter()
        .filter(|hit| known.binary_search(hit).is_err())
        .copied()
        .collect()
}
