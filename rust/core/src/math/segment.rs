//! A straight segment.

use glam::DVec3;

/// The point of a segment nearest to a place, and how far along it that is, 0 to 1; of a segment without length its start.
pub fn nearest_on_segment(place: DVec3, from: DVec3, to: DVec3) -> (DVec3, f64) {
    let along = to - from;
    let length_squared = along.length_squared();
    if length_squared == 0.0 {
        return (from, 0.0);
    }
    let share = ((place - from).dot(along) / length_squared).clamp(0.0, 1.0);
    (from.lerp(to, share), share)
}
