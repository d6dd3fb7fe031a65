//! Geometry of one triangle: where a ray meets it, and its point nearest to a place.

use glam::DVec3;

use crate::math::segment::nearest_on_segment;

/// A ray, prepared for triangles and boxes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    /// One over each coordinate of the direction; where that is 0 huge, so that nothing times it is not a number.
    pub(super) inverse: DVec3,
    /// The axes, the one that the direction is longest along last.
    axes: [usize; 3],
    /// Takes the direction to the last axis.
    shear: DVec3,
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hit {
    /// From the ray's origin, in lengths of its direction, 0 or more.
    pub(super) distance: f64,
    /// Whether the ray leaves there: the triangle's normal looks along it.
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
            (x, y) = (y, x); // keeps the sense in which triangles turn
        }
        Self {
            origin,
            inverse: direction.recip().clamp(DVec3::MIN, DVec3::MAX),
            axes: [x, y, z],
            shear: DVec3::new(direction[x], direction[y], 1.0) / direction[z],
        }
    }

    /// Where the ray meets a triangle, its rim counted in: of two triangles that share an edge it never slips between
    /// (S. Woop, C. Benthin and I. Wald, "Watertight Ray/Triangle Intersection", 2013).
    pub(super) fn hit(&self, triangle: [DVec3; 3]) -> Option<Hit> {
        let [x, y, z] = self.axes;
        let [a, b, c] = triangle.map(|corner| {
            let from = corner - self.origin;
            DVec3::new(
                from[x] - self.shear.x * from[z],
                from[y] - self.shear.y * from[z],
                self.shear.z * from[z],
            )
        });
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let twice_area = u + v + w;
        if twice_area == 0.0 {
            return None; // seen from its edge
        }
        let distance = (u * a.z + v * b.z + w * c.z) / twice_area;
        (distance >= 0.0).then_some(Hit {
            distance,
            leaves: twice_area < 0.0,
        })
    }
}

/// The point of a triangle, which may be a line or a point, nearest to a place (C. Ericson, "Real-Time Collision
/// Detection", 2005, 5.1.5).
pub(super) fn nearest_on_triangle(place: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    if ab.cross(ac) == DVec3::ZERO {
        let sides = [[a, b], [b, c], [c, a]].map(|[from, to]| nearest_on_segment(place, from, to).0);
        let nearer = |best: DVec3, side: DVec3| {
            if side.distance_squared(place) < best.distance_squared(place) {
                side
            } else {
                best
            }
        };
        return sides.into_iter().fold(sides[0], nearer);
    }
    let ap = place - a;
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = place - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = place - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (along, back) = (d4 - d3, d5 - d6);
    if va <= 0.0 && along >= 0.0 && back >= 0.0 {
        return b + (c - b) * (along / (along + back));
    }
    let sum = va + vb + vc;
    a + ab * (vb / sum) + ac * (vc / sum)
}
