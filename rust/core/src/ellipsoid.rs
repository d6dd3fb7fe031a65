//! An ellipsoid, and the nearest point on its surface (mathematics/binding.md, Nearest point on an
//! ellipsoid).
//!
//! The method is D. Eberly's, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid"
//! (2013): the surface point of `q` is `r_i² q_i / (t + r_i²)`, where `t` is the largest root of `Σ (r_i q_i
//! / (t + r_i²))² = 1`. The thesis (eq. 3.15) and Wilhelms (1997) use Newton's method without bounds. With a
//! bracketed root the method also converges for points inside and on the axes, and for extreme ratios of the
//! semi-axes.

use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// More iterations than necessary: halving the bracket on a logarithmic scale reaches neighbouring floats in
/// about 64.
const ITERATION_LIMIT: usize = 200;
/// Coordinates below this fraction of the longest semi-axis count as 0, and shorter semi-axes as long as this, since
/// their squares underflow.
const SMALLEST_RELATIVE: f64 = 1e-140;
/// Coordinates above this multiple of the longest semi-axis are scaled down to it, since their squares
/// overflow.
const LARGEST_RELATIVE: f64 = 1e60;
/// Relative step of the root below which it has converged.
const ROOT_TOLERANCE: f64 = 4.0 * f64::EPSILON;

/// An ellipsoid in any position. All semi-axes are above 0.
///
/// ```
/// use glam::{DMat3, DVec3};
/// use sinew_core::ellipsoid::Ellipsoid;
///
/// let belly = Ellipsoid {
///     centre: DVec3::new(0.0, 0.0, 1.2),
///     axes: DMat3::IDENTITY,
///     semi_axes: DVec3::new(0.03, 0.04, 0.1),
/// };
/// let nearest = belly.nearest(DVec3::new(0.05, 0.0, 1.2));
/// assert!((nearest.distance_m - 0.02).abs() < 1e-12);
/// assert!(nearest.surface.distance(DVec3::new(0.03, 0.0, 1.2)) < 1e-12);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Ellipsoid {
    /// Centre, m.
    pub centre: DVec3,
    /// Orthonormal axes, as columns.
    pub axes: DMat3,
    /// Semi-axes along `axes`, m.
    pub semi_axes: DVec3,
}

/// The volume of an ellipsoid with these semi-axes, m³.
pub fn volume_m3(semi_axes: DVec3) -> f64 {
    4.0 / 3.0 * PI * semi_axes.element_product()
}

/// The surface point nearest to a given point, and its distance.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// The nearest point on the surface, m, in the same space as the ellipsoid's centre.
    pub surface: DVec3,
    /// The distance from the surface, m; negative inside.
    pub distance_m: f64,
}

impl Ellipsoid {
    /// Volume, m³.
    pub fn volume(&self) -> f64 {
        volume_m3(self.semi_axes)
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

    /// The unit outward normal at the surface point nearest to `point`.
    pub fn normal_towards(&self, point: DVec3) -> DVec3 {
        let local = self.axes.transpose() * (point - self.centre);
        let scaled = nearest_on_ellipsoid(self.semi_axes, local) / self.semi_axes;
        self.axes * (scaled / self.semi_axes).normalize()
    }

    /// A lower bound, m, of the distance of `point` from the ellipsoid: its distance from the bounding box; 0
    /// inside the box.
    pub fn distance_bound(&self, point: DVec3) -> f64 {
        let local = self.axes.transpose() * (point - self.centre);
        (local.abs() - self.semi_axes).max(DVec3::ZERO).length()
    }
}

/// The point nearest to `point` on the ellipsoid at the origin with `semi_axes` along x, y, z (above 0, in
/// any order).
///
/// Valid for all points: outside, inside, on axes and planes of symmetry. For the centre it is the end of the
/// shortest axis.
///
/// ```
/// use glam::DVec3;
/// use sinew_core::nearest_on_ellipsoid;
///
/// let nearest = nearest_on_ellipsoid(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.0, 5.0));
/// assert_eq!(nearest, DVec3::new(0.0, 0.0, 3.0));
/// ```
pub fn nearest_on_ellipsoid(semi_axes: DVec3, point: DVec3) -> DVec3 {
    let shortest = SMALLEST_RELATIVE * semi_axes.max_element();
    let radii = semi_axes.max(DVec3::splat(shortest)).to_array();
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

/// `point` mirrored to the positive octant and limited so that squares neither overflow nor underflow: tiny
/// coordinates become 0, and a distant point moves towards the origin along its direction.
fn within_range(semi_axes: DVec3, point: DVec3) -> DVec3 {
    let point = point.abs();
    let farthest = point.max_element() / (LARGEST_RELATIVE * semi_axes.max_element());
    let point = point / farthest.max(1.0);
    let smallest = SMALLEST_RELATIVE * semi_axes.max_element();
    DVec3::select(point.cmplt(DVec3::splat(smallest)), DVec3::ZERO, point)
}

/// The nearest point for semi-axes in decreasing order and a point without negative coordinates.
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
    let cosine = |radius: f64, at: f64| {
        let (numerator, denominator) = (radius * at, (radius - c) * (radius + c));
        (numerator < denominator).then(|| numerator / denominator)
    };
    let along = |radius: f64, at: f64| if at > 0.0 { cosine(radius, at) } else { Some(0.0) };
    if let (Some(u), Some(v)) = (along(a, x), along(b, y)) {
        let rest = 1.0 - u * u - v * v;
        if rest > 0.0 {
            return [a * u, b * v, c * rest.sqrt()];
        }
    }
    let [x, y] = nearest_in_quadrant([a, b], [x, y]);
    [x, y, 0.0]
}

/// The nearest point on an ellipse, for semi-axes in decreasing order and a point without negative
/// coordinates.
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
    let coordinate = |radius: f64, at: f64| (radius / c) * (radius / c) * at / (root + gap(radius));
    [coordinate(a, x), coordinate(b, y), z / root]
}

/// The positive root of `Σ (n_i / (u + g_i))² = 1`. At least one `g_i` is 0 and has a positive `n_i`.
///
/// The sum is decreasing and convex in `u`, so Newton steps from the left never overshoot. Where they are
/// slow (near the pole) the bracket is split at its geometric mean instead.
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
    // No term of the sum can exceed 1.
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
