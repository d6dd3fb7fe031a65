//! Length of the segment in which two triangles intersect (T. Möller, "A Fast Triangle-Triangle
//! Intersection Test", 1997).

use glam::Vec3A;

/// Length of the segment in which two triangles intersect; 0 if they do not or are coplanar.
pub(crate) fn crossing_m(one: &[Vec3A; 3], other: &[Vec3A; 3]) -> f32 {
    let (Some(a), Some(b)) = (Side::of(one, other), Side::of(other, one)) else {
        return 0.0;
    };
    let line = a.normal.cross(b.normal);
    let length = line.length();
    if length == 0.0 {
        return 0.0;
    }
    let line = line / length;
    // relative to a corner, because of the precision of f32
    let from = one[0];
    let ((a_low, a_high), (b_low, b_high)) = (a.interval(other, from, line), b.interval(one, from, line));
    (a_high.min(b_high) - a_low.max(b_low)).max(0.0)
}

/// The normal of a triangle's plane, and the heights of another triangle's corners above the plane, both
/// scaled by twice the triangle's area.
struct Side {
    normal: Vec3A,
    heights: [f32; 3],
}

impl Side {
    /// `None` if the other triangle is on one side of the plane.
    fn of(plane: &[Vec3A; 3], other: &[Vec3A; 3]) -> Option<Self> {
        let normal = (plane[1] - plane[0]).cross(plane[2] - plane[0]);
        let heights = other.map(|corner| normal.dot(corner - plane[0]));
        let [a, b, c] = heights;
        let is_cut = a.min(b).min(c) < 0.0 && a.max(b).max(c) > 0.0;
        is_cut.then_some(Self { normal, heights })
    }

    /// The interval, along `line` from `from`, in which `other` intersects the plane.
    fn interval(&self, other: &[Vec3A; 3], from: Vec3A, line: Vec3A) -> (f32, f32) {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (self.heights[i], self.heights[j]);
            if (a < 0.0) != (b < 0.0) {
                let position = other[i] + (other[j] - other[i]) * (a / (a - b));
                let along = (position - from).dot(line);
                (low, high) = (low.min(along), high.max(along));
            }
        }
        (low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_cross_in_a_segment() {
        let flat = [Vec3A::ZERO, Vec3A::X * 4.0, Vec3A::Y * 4.0];
        let upright = |depth: f32| {
            let at = Vec3A::new(1.0, 1.0, -depth);
            [
                at,
                at + Vec3A::new(-0.5, 0.0, 1.0),
                at + Vec3A::new(0.5, 0.0, 1.0),
            ]
        };
        assert_eq!(crossing_m(&flat, &upright(-0.1)), 0.0);
        for depth in [0.1, 0.5, 0.9] {
            assert!((crossing_m(&flat, &upright(depth)) - depth).abs() < 1e-6);
            assert!((crossing_m(&upright(depth), &flat) - depth).abs() < 1e-6);
        }
    }
}
