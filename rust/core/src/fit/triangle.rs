//! The hit of a ray on a triangle, and the nearest point of a triangle.
//! (docs/mathematics/fitting.md, Fit under the skin)

use glam::DVec3;

use crate::math::segment::nearest_on_segment;

/// A ray, prepared for triangles and boxes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    /// One over each coordinate of the direction; a huge number for 0, so that no product with it is NaN.
    pub(super) inverse: DVec3,
    /// The axes; the last is the one along which the direction is longest.
    axes: [usize; 3],
    /// Shears and scales the direction to the unit vector along the last axis.
    shear: DVec3,
}

/// The hit of a ray on a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hit {
    /// Distance from the ray's origin, in lengths of its direction, 0 or more.
    pub(super) distance: f64,
    /// Whether the ray leaves the surface there: the triangle's normal points along the ray.
    pub(super) leaves: bool,
}

impl Ray {
    /// A ray from `origin` along `direction`, which is not 0.
    pub(super) fn new(origin: DVec3, direction: DVec3) -> Self {
        let length = direction.abs();
        let z = if length.x >= length.y && length.x >= length.z {
            0
        } else if length.y >= length.z {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            (x, y) = (y, x); // preserves the winding of triangles
        }
        Self {
            origin,
            inverse: direction.recip().clamp(DVec3::MIN, DVec3::MAX),
            axes: [x, y, z],
            shear: DVec3::new(direction[x], direction[y], 1.0) / direction[z],
        }
    }

    /// A point in ray space, where the ray starts at 0 and runs along z.
    pub(super) fn to_ray_space(self, point: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        let from = point - self.origin;
        DVec3::new(
            from[x] - self.shear.x * from[z],
            from[y] - self.shear.y * from[z],
            self.shear.z * from[z],
        )
    }

    /// The hit of a ray, edges included; a ray never passes between two triangles with a common edge. Corners are in ray space
    /// (S. Woop, C. Benthin and I. Wald, "Watertight Ray/Triangle Intersection", 2013).
    pub(super) fn hit([a, b, c]: [DVec3; 3]) -> Option<Hit> {
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let twice_area = u + v + w;
        if twice_area == 0.0 {
            return None; // parallel to the ray
        }
        let distance = (u * a.z + v * b.z + w * c.z) / twice_area;
        (distance >= 0.0).then_some(Hit {
            distance,
            leaves: twice_area < 0.0,
        })
    }
}

/// The barycentric coordinates, 0 to 1, of the point of a triangle nearest to `position`. The triangle may be degenerate
/// (C. Ericson, "Real-Time Collision Detection", 2005, 5.1.5).
pub(super) fn nearest_weights(position: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    if ab.cross(ac) == DVec3::ZERO {
        return nearest_edge_weights(position, [a, b, c]);
    }
    let ap = position - a;
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = position - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let fraction = d1 / (d1 - d3);
        return [1.0 - fraction, fraction, 0.0];
    }
    let cp = position - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let fraction = d2 / (d2 - d6);
        return [1.0 - fraction, 0.0, fraction];
    }
    let va = d3 * d6 - d5 * d4;
    let (along, back) = (d4 - d3, d5 - d6);
    if va <= 0.0 && along >= 0.0 && back >= 0.0 {
        let fraction = along / (along + back);
        return [0.0, 1.0 - fraction, fraction];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

/// The same for a degenerate triangle, by its three edges.
fn nearest_edge_weights(position: DVec3, corners: [DVec3; 3]) -> [f64; 3] {
    let mut best = (f64::INFINITY, [0.0; 3]);
    for edge in 0..3 {
        let next = (edge + 1) % 3;
        let (point, fraction) = nearest_on_segment(position, corners[edge], corners[next]);
        let squared = point.distance_squared(position);
        if squared < best.0 {
            best = (squared, [0.0; 3]);
            best.1[edge] = 1.0 - fraction;
            best.1[next] += fraction;
        }
    }
    best.1
}

/// The point of a triangle with these barycentric coordinates; exact for a corner.
pub(super) fn point_of(weights: [f64; 3], corners: [DVec3; 3]) -> DVec3 {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}
