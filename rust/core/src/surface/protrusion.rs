//! How far the anatomy protrudes from the grown skin.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::f64::consts::PI;

use super::extract::QuadMesh;
use super::lattice::Lattice;
use super::neighbours::quads_around;
use super::smoothing::FieldSampler;
use crate::ellipsoid::Ellipsoid;
use crate::math::rows::Rows;

/// Points tested on each ellipsoid.
const POINTS: usize = 100;
/// Depth, in voxels, below which no point can be outside a surface that follows the field.
const DEEP: f64 = 0.6;
/// Difference of distances, voxels, that counts as rounding.
const SAME: f64 = 1e-9;
/// Search radius for faces around a point, voxels; the second if the first finds none.
const AROUND: [i32; 2] = [1, 3];

/// The largest distance, m, of a point of an ellipsoid outside the surface, and the ellipsoid's index; 0 if
/// none is outside.
pub(super) fn largest(
    ellipsoids: &[Ellipsoid],
    mesh: &QuadMesh,
    lattice: Lattice,
    sampler: FieldSampler,
) -> (f64, Option<usize>) {
    let vertices: FxHashMap<IVec3, usize> = mesh.cells.iter().copied().zip(0..).collect();
    let quads = quads_around(mesh);
    let outside_m = |point: DVec3| {
        let position = lattice.in_voxels(point);
        if sampler.sample(position).0 > DEEP {
            return 0.0;
        }
        lattice.voxel_m * outside(position, mesh, &vertices, &quads)
    };
    let of_ellipsoid = |ellipsoid: &Ellipsoid| {
        sphere()
            .map(|unit| outside_m(on(ellipsoid, unit)))
            .fold(0.0, f64::max)
    };
    let farthest: Vec<f64> = ellipsoids.par_iter().map(of_ellipsoid).collect();
    let all = farthest.into_iter().zip(0..).filter(|found| found.0 > 0.0);
    all.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))
        .map_or((0.0, None), |(distance_m, index)| (distance_m, Some(index)))
}

fn on(ellipsoid: &Ellipsoid, unit: DVec3) -> DVec3 {
    ellipsoid.centre + ellipsoid.axes * (unit * ellipsoid.semi_axes)
}

/// Points on the unit sphere along a golden spiral.
fn sphere() -> impl Iterator<Item = DVec3> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..POINTS).map(move |index| {
        let z = 1.0 - (2 * index + 1) as f64 / POINTS as f64;
        let (sin, cos) = (golden * index as f64).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    })
}

/// The distance of `position` outside the surface, voxels; 0 inside, or if no face is near.
fn outside(position: DVec3, mesh: &QuadMesh, vertices: &FxHashMap<IVec3, usize>, quads: &Rows<u32>) -> f64 {
    // distance from the nearest face, and height over it: of faces that share the nearest edge or corner, the
    // one with the largest height decides the side
    let mut nearest = (f64::INFINITY, 0.0_f64);
    for quad in faces_near(position, vertices, quads) {
        let [a, b, c, d] = mesh.quads[quad as usize].map(|corner| mesh.positions[corner as usize]);
        for triangle in [[a, b, c], [a, c, d]] {
            let on_it = nearest_on_triangle(position, triangle);
            let normal = (triangle[1] - triangle[0])
                .cross(triangle[2] - triangle[0])
                .normalize_or_zero();
            let (distance, over) = (position.distance(on_it), (position - on_it).dot(normal));
            let is_same = (distance - nearest.0).abs() < SAME;
            if (is_same && over.abs() > nearest.1.abs()) || (!is_same && distance < nearest.0) {
                nearest = (distance, over);
            }
        }
    }
    if nearest.1 > 0.0 { nearest.0 } else { 0.0 }
}

/// The faces around the vertices near a position.
fn faces_near(position: DVec3, vertices: &FxHashMap<IVec3, usize>, quads: &Rows<u32>) -> Vec<u32> {
    let cell = position.floor().as_ivec3();
    for span in AROUND {
        let steps = || -span..=span;
        let mut faces = vec![];
        for (z, y) in steps().flat_map(|z| steps().map(move |y| (z, y))) {
            for vertex in steps().filter_map(|x| vertices.get(&(cell + IVec3::new(x, y, z)))) {
                faces.extend_from_slice(quads.row(*vertex));
            }
        }
        if !faces.is_empty() {
            faces.sort_unstable();
            faces.dedup();
            return faces;
        }
    }
    vec![]
}

/// The nearest point of a triangle (C. Ericson, "Real-Time Collision Detection", 5.1.5).
fn nearest_on_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2] = [ab, ac].map(|side| side.dot(point - a));
    let [d3, d4] = [ab, ac].map(|side| side.dot(point - b));
    let [d5, d6] = [ab, ac].map(|side| side.dot(point - c));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    a + ab * (vb / sum) + ac * (vc / sum)
}
