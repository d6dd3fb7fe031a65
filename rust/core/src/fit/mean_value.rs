//! Mean value coordinates: how much of each corner of a polygon a point on it has (M. S. Floater, "Mean value coordinates",
//! 2003). In a triangle they are the barycentric coordinates.

use glam::DVec3;

use crate::math::segment::nearest_on_segment;

/// A point this near to an edge, over the size of the polygon, is on it.
const ON_EDGE: f64 = 1e-6;

/// Writes to `shares` how much of each of `corners` the point `place` on their polygon has, 0 to 1; they sum to 1.
pub(super) fn mean_value_shares(place: DVec3, corners: &[DVec3], shares: &mut [f64]) {
    shares.fill(0.0);
    let count = corners.len();
    let size = corners
        .iter()
        .map(|corner| corner.distance(place))
        .fold(0.0, f64::max);
    for own in 0..count {
        let next = (own + 1) % count;
        let (on_edge, along) = nearest_on_segment(place, corners[own], corners[next]);
        if on_edge.distance(place) <= ON_EDGE * size {
            shares[own] = 1.0 - along;
            shares[next] += along;
            return;
        }
    }
    let half_tangents = |own: usize| {
        let (a, b) = (corners[own] - place, corners[(own + 1) % count] - place);
        let (sine, cosine) = (a.cross(b).length(), a.dot(b));
        if sine > 0.0 {
            (a.length() * b.length() - cosine) / sine
        } else {
            0.0
        }
    };
    let mut before = half_tangents(count - 1);
    let mut sum = 0.0;
    for own in 0..count {
        let after = half_tangents(own);
        shares[own] = (before + after) / corners[own].distance(place);
        sum += shares[own];
        before = after;
    }
    shares.iter_mut().for_each(|share| *share /= sum);
}
