//! An ellipsoid, and the nearest point on its surface.
//!
//! Nearest points after D. Eberly, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid" (2013): the
//! surface point of `q` is `r_i² q_i / (t + r_i²)` with `t` the largest root of `Σ (r_i q_i / (t + r_i²))² = 1`. The
//! thesis (eq. 3.15) and Wilhelms use plain Newton; a root kept between bounds also converges inside, on the axes and for
//! needles and pancakes.

use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// Iterations that more than suffice: a bracket halved in logarithm reaches neighbouring floats in about 64.
const ITERATION_LIMIT: usize = 200;
/// Coordinates below this share of the longest semi-axis are 0: their squares have left f64.
const SMALLEST_RELATIVE: f64 = 1e-140;
/// Coordinates beyond this many longest semi-axes are brought back to it.
const LARGEST_RELATIVE: f64 = 1e60;
/// Relative step of the root under which it has converged.
const ROOT_TOLERANCE: f64 = 4.0 * f64::EPSILON;

/// An ellipsoid anywhere: centre, rotation and semi-axes in metres, all semi-axes above 0.
#[derive(Debug, Clone, Copy)]
pub struct Ellipsoid {
    /// Centre, m.
    pub centre: DVec3,
    /// Orthonormal axes as columns.
    pub axes: DMat3,
    /// Semi-axes along those axes, m.
    pub semi_axes: DVec3,
}

/// The surface point nearest to a point, and how far that is.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// Nearest point on the surface, m, in the space of the ellipsoid's centre.
    pub surface: DVec3,
    /// Distance from the surface, m; below 0 inside.
    pub distance_m: f64,
}

impl Ellipsoid {
    /// Volume, m³.
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.semi_axes.element_product()
    }

    /// The surface point nearest to `point`.
    pub fn nearest(&self, point: DVec3) -> Nearest {
        let local = self.axes.transpose() * (point - self.centre);
        let surface = nearest_on_ellipsoid(self.semi_axes, local);
        let distance = surface.distance(local);
        let inside = (local / self.semi_axes).length_squared() < 1.0;
        Nearest {
            surface: self.centre + self.axes * surface,
            distance_m: if inside { -distance } else { distance },
        }
    }

    /// A distance, m, that the true distance of `point` from the ellipsoid is never below (from its bounding box); 0
    /// inside the box.
    pub fn distance_bound(&self, point: DVec3) -> f64 {
        let local = self.axes.transpose() * (point - self.centre);
        (local.abs() - self.semi_axes).max(DVec3::ZERO).length()
    }
}

/// The point nearest to `point` on the ellipsoid at the origin with `semi_axes` (> 0, any order) along x, y, z.
///
/// Right everywhere: outside, inside, on axes and planes of symmetry; at the centre it is the end of the shortest axis.
pub fn nearest_on_ellipsoid(semi_axes: DVec3, point: DVec3) -> DVec3 {
    let radii = semi_axes.to_array();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| radii[b].total_cmp(&radii[a]));
    let sorted = |values: [f64; 3]| order.map(|axis| values[axis]);
    let octant = nearest_in_octant(sorted(radii), sorted(within_range(semi_axes, point).to_array()));
    let mut nearest = [0.0; 3];
    for (value, axis) in octant.into_iter().zip(order) {
        nearest[axis] = value.copysign(point.to_array()[axis]);
    }
    DVec3::from_array(nearest)
}

/// `point` mirrored to the positive octant and kept where its square neither overflows nor vanishes: so near to a plane of
/// symmetry is on it, and from so far all lies in one direction.
fn within_range(semi_axes: DVec3, point: DVec3) -> DVec3 {
    let point = point.abs();
    let farthest = point.max_element() / (LARGEST_RELATIVE * semi_axes.max_element());
    let point = point / farthest.max(1.0);
    let smallest = SMALLEST_RELATIVE * semi_axes.max_element();
    DVec3::select(point.cmplt(DVec3::splat(smallest)), DVec3::ZERO, point)
}

/// Nearest point for falling radii and a point with no negative coordinate.
fn nearest_in_octant(radii: [f64; 3], point: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = radii;
    let [x, y, z] = point;
    if z > 0.0 {
        return match (x > 0.0, y > 0.0) {
            (true, true) => on_all_axes(radii, point),
            (false, true) => {
                let [y, z] = nearest_in_quadrant([b, c], [y, z]);
                [0.0, y, z]
            }
            (true, false) => {
                let [x, z] = nearest_in_quadrant([a, c], [x, z]);
                [x, 0.0, z]
            }
            (false, false) => [0.0, 0.0, c],
        };
    }
    let share = |radius: f64, at: f64| {
        let (numerator, denominator) = (radius * at, (radius - c) * (radius + c));
        (numerator < denominator).then(|| numerator / denominator)
    };
    let along = |radius: f64, at: f64| if at > 0.0 { share(radius, at) } else { Some(0.0) };
    if let (Some(u), Some(v)) = (along(a, x), along(b, y)) {
        let rest = 1.0 - u * u - v * v;
        if rest > 0.0 {
            return [a * u, b * v, c * rest.sqrt()];
        }
    }
    let [x, y] = nearest_in_quadrant([a, b], [x, y]);
    [x, y, 0.0]
}

/// The same on an ellipse.
fn nearest_in_quadrant([a, b]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    if y > 0.0 {
        if x > 0.0 {
            let gap = (a - b) * (a + b) / (b * b);
            let root = largest_root([(a / b) * (x / b), y / b, 0.0], [gap, 0.0, 0.0]);
            let stretch = (a / b) * (a / b);
            return [stretch * x / (root + gap), y / root];
        }
        return [0.0, b];
    }
    let (numerator, denominator) = (a * x, (a - b) * (a + b));
    if numerator < denominator {
        let u = numerator / denominator;
        return [a * u, b * ((1.0 - u) * (1.0 + u)).sqrt()];
    }
    [a, 0.0]
}

fn on_all_axes([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    let gap = |radius: f64| (radius - c) * (radius + c) / (c * c);
    let root = largest_root(
        [(a / c) * (x / c), (b / c) * (y / c), z / c],
        [gap(a), gap(b), 0.0],
    );
    let place = |radius: f64, at: f64| (radius / c) * (radius / c) * at / (root + gap(radius));
    [place(a, x), place(b, y), z / root]
}

/// The root above 0 of `Σ (n_i / (u + g_i))² = 1`, with at least one `g_i = 0` under a positive `n_i`.
///
/// The sum falls and is convex in `u`, so Newton's steps from the left never overshoot; where they crawl (near the pole)
/// the bracket is split at its geometric mean instead.
fn largest_root(numerators: [f64; 3], gaps: [f64; 3]) -> f64 {
    let excess = |u: f64| {
        let (mut sum, mut slope) = (-1.0, 0.0);
        for (n, g) in numerators.iter().zip(gaps) {
            let inverse = 1.0 / (u + g);
            let square = (n * inverse) * (n * inverse);
            sum += square;
            slope -= 2.0 * square * inverse;
        }
        (sum, slope)
    };
    let pole = numerators
        .iter()
        .zip(gaps)
        .filter(|(_, g)| *g == 0.0)
        .map(|(n, _)| n * n)
        .sum::<f64>()
        .sqrt();
    // No term of the sum may exceed 1.
    let floors = numerators.iter().zip(gaps).map(|(n, g)| n - g);
    let mut low = floors.fold(pole, f64::max).max(f64::MIN_POSITIVE);
    let mut high = numerators.iter().map(|n| n * n).sum::<f64>().sqrt().max(low);
    let mut root = low;
    for _ in 0..ITERATION_LIMIT {
        let (sum, slope) = excess(root);
        if sum == 0.0 {
            break;
        }
        if sum > 0.0 {
            low = root;
        } else {
            high = root;
        }
        let newton = root - sum / slope;
        let crawls = newton > 1.3 * root && newton < 2.0 * root && high > 16.0 * root;
        let next = if newton > low && newton < high && !crawls {
            newton
        } else {
            low.sqrt() * high.sqrt()
        };
        let step = (next - root).abs();
        root = next.clamp(low, high);
        if step <= ROOT_TOLERANCE * root {
            break;
        }
    }
    root
}
