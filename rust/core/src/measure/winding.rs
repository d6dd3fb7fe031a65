//! Volume by winding number: what skin occupies, occupies twice, and turns inside out.

use glam::DVec3;
use rayon::prelude::*;

use super::volume::Closed;

/// Rays along each side of the grid.
const RAYS: usize = 200;
/// Position of a ray in its cell, chosen so that no ray of a regular mesh hits an edge.
const RAY_OFFSET: [f64; 2] = [0.5 + 0.002_718_28, 0.5 + 0.003_141_59];

/// The volumes of a closed surface, m³. The signed volume is `union + overlap - inside_out`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WindingVolumes {
    /// Volume inside the surface at least once.
    pub union: f64,
    /// Volume inside twice, plus twice the volume inside three times, and so on.
    pub overlap: f64,
    /// Volume inside a surface that is turned inside out.
    pub inside_out: f64,
    /// Fraction, 0..1, of the rays whose crossings do not cancel, as at a hole. These rays are left out.
    pub unreadable: f64,
}

#[derive(Debug, Clone, Copy)]
struct Crossing {
    column: usize,
    z: f64,
    /// 1 where a ray in the direction of z enters.
    winding: i32,
}

/// Sums over the rays of one row, or of all.
#[derive(Debug, Clone, Copy, Default)]
struct RayTotals {
    union_m: f64,
    overlap_m: f64,
    inside_out_m: f64,
    hit: usize,
    unreadable: usize,
}

/// The volumes of a closed surface, summed along rays in z on a grid over its bounding box.
pub(super) fn winding_volumes(closed: &Closed) -> WindingVolumes {
    let (low, high) = closed.bounds();
    let cell = (high - low) / RAYS as f64;
    let xs: Vec<f64> = (0..RAYS)
        .map(|row| low.x + (row as f64 + RAY_OFFSET[0]) * cell.x)
        .collect();
    let ys: Vec<f64> = (0..RAYS)
        .map(|column| low.y + (column as f64 + RAY_OFFSET[1]) * cell.y)
        .collect();
    let mut triangles_of_row = vec![vec![]; RAYS];
    for triangle in &closed.triangles {
        let corners = triangle.map(|vertex| closed.points[vertex as usize]);
        for row in covered(&xs, corners.map(|corner| corner.x)) {
            triangles_of_row[row].push(corners);
        }
    }
    let rows: Vec<RayTotals> = triangles_of_row
        .par_iter()
        .zip(&xs)
        .map(|(triangles, &x)| row_of(triangles, x, &ys))
        .collect();
    // in the order of the rows, so that the sum has the same bits on any number of threads
    let total = rows.iter().fold(RayTotals::default(), |sum, row| RayTotals {
        union_m: sum.union_m + row.union_m,
        overlap_m: sum.overlap_m + row.overlap_m,
        inside_out_m: sum.inside_out_m + row.inside_out_m,
        hit: sum.hit + row.hit,
        unreadable: sum.unreadable + row.unreadable,
    });
    let area = cell.x * cell.y;
    WindingVolumes {
        union: total.union_m * area,
        overlap: total.overlap_m * area,
        inside_out: total.inside_out_m * area,
        unreadable: total.unreadable as f64 / total.hit.max(1) as f64,
    }
}

/// The indices of those of the sorted `rising` between the smallest and the largest of three numbers.
fn covered(rising: &[f64], [a, b, c]: [f64; 3]) -> std::ops::Range<usize> {
    let (least, greatest) = (a.min(b).min(c), a.max(b).max(c));
    rising.partition_point(|&ray| ray < least)..rising.partition_point(|&ray| ray < greatest)
}

fn row_of(triangles: &[[DVec3; 3]], x: f64, ys: &[f64]) -> RayTotals {
    let mut crossings = vec![];
    for &[a, b, c] in triangles {
        let (ab, ac) = (b - a, c - a);
        let twice_area = ab.x * ac.y - ab.y * ac.x;
        if twice_area == 0.0 {
            continue; // seen edge-on
        }
        for column in covered(ys, [a.y, b.y, c.y]) {
            let (along_x, along_y) = (x - a.x, ys[column] - a.y);
            let to_b = (along_x * ac.y - along_y * ac.x) / twice_area;
            let to_c = (ab.x * along_y - ab.y * along_x) / twice_area;
            if to_b >= 0.0 && to_c >= 0.0 && to_b + to_c <= 1.0 {
                crossings.push(Crossing {
                    column,
                    z: a.z + to_b * ab.z + to_c * ac.z,
                    winding: if twice_area > 0.0 { -1 } else { 1 },
                });
            }
        }
    }
    crossings.sort_by(|a, b| a.column.cmp(&b.column).then(a.z.total_cmp(&b.z)));
    let mut totals = RayTotals::default();
    for ray in crossings.chunk_by(|a, b| a.column == b.column) {
        totals.hit += 1;
        if ray.iter().map(|crossing| crossing.winding).sum::<i32>() == 0 {
            add_ray(ray, &mut totals);
        } else {
            totals.unreadable += 1;
        }
    }
    totals
}

fn add_ray(ray: &[Crossing], totals: &mut RayTotals) {
    let mut winding = 0;
    for step in ray.windows(2) {
        winding += step[0].winding;
        let length_m = step[1].z - step[0].z;
        if winding > 0 {
            totals.union_m += length_m;
            totals.overlap_m += f64::from(winding - 1) * length_m;
        } else {
            totals.inside_out_m += f64::from(-winding) * length_m;
        }
    }
}
