//! A straight segment.

use glam::DVec3;

/// The point of a segment nearest to `point`, and its fraction along the segment, 0 to 1. For a segment of length 0, its start
/// and 0.
pub fn nearest_on_segment(point: DVec3, from: DVec3, to: DVec3) -> (DVec3, f64) {
    let along = to - from;
    let length_squared = along.length_squared();
    if length_squared == 0.0 {
        return (from, 0.0);
    }
    let fraction = ((point - from).dot(along) / length_squared).clamp(0.0, 1.0);
    (from.lerp(to, fraction), fraction)
}
