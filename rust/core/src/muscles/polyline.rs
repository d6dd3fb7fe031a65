//! The path of a muscle in one pose: a fine polyline from origin to insertion, parameterised by arc length.

use glam::DVec3;

use crate::math::segment::nearest_on_segment;
use crate::math::smoothstep::smooth_step;

/// Segments per cubic.
const PIECE_SEGMENTS: usize = 12;

/// Fraction of the path over which the direction at an end is measured. The direction of a single short
/// segment may be rounding.
const END_SHARE: f64 = 0.01;

/// Shortest segment whose direction is not rounding, as a fraction of the path's length.
const SHORTEST_SHARE: f64 = 1e-6;

/// A polyline with its arc length. It keeps its memory when it is cleared.
#[derive(Debug, Clone, Default)]
pub struct Polyline {
    points: Vec<DVec3>,
    /// Arc length from the start to each point, m.
    lengths: Vec<f64>,
}

impl Polyline {
    /// Removes all points.
    pub fn clear(&mut self) {
        self.points.clear();
        self.lengths.clear();
    }

    /// The points, armature space, m.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The arc length, m.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Adds a straight line to `point`.
    pub fn line_to(&mut self, point: DVec3) {
        let length = match self.points.last() {
            Some(last) => self.length() + last.distance(point),
            None => 0.0,
        };
        self.points.push(point);
        self.lengths.push(length);
    }

    /// Adds a cubic Hermite curve to `end` with these tangents at its ends, m. Each of its points but the
    /// last is mapped by `keep`.
    pub fn cubic_to(
        &mut self,
        end: DVec3,
        start_tangent: DVec3,
        end_tangent: DVec3,
        keep: impl Fn(DVec3) -> DVec3,
    ) {
        let Some(&start) = self.points.last() else {
            return self.line_to(end);
        };
        for step in 1..PIECE_SEGMENTS {
            let t = step as f64 / PIECE_SEGMENTS as f64;
            let rise = smooth_step(t);
            let point = start
                + (end - start) * rise
                + start_tangent * (t * (1.0 - t) * (1.0 - t))
                + end_tangent * (t * t * (t - 1.0));
            self.line_to(keep(point));
        }
        self.line_to(end);
    }

    /// The point at arc length `at`, m. Beyond the ends, the path continues straight.
    pub fn at(&self, at: f64) -> DVec3 {
        let after = self.lengths.partition_point(|&length| length <= at);
        let last = self.points.len().saturating_sub(1);
        if after == 0 {
            let start = self.points.first().copied().unwrap_or(DVec3::ZERO);
            return start + self.start_direction() * at;
        }
        if after > last {
            return self.points[last] + self.end_direction() * (at - self.length());
        }
        let (low, high) = (self.lengths[after - 1], self.lengths[after]);
        self.points[after - 1].lerp(self.points[after], (at - low) / (high - low))
    }

    /// The arc length at which the path is nearest to `point`, m; the first of several. 0 for fewer than two
    /// points.
    pub fn nearest_length(&self, point: DVec3) -> f64 {
        let mut best = (f64::INFINITY, 0.0);
        for (points, lengths) in self.points.windows(2).zip(self.lengths.windows(2)) {
            let (nearest, fraction) = nearest_on_segment(point, points[0], points[1]);
            let distance_m = nearest.distance(point);
            if distance_m < best.0 {
                best = (distance_m, lengths[0] + fraction * (lengths[1] - lengths[0]));
            }
        }
        best.1
    }

    /// The segments that have a direction: arc length at start and end, m, and unit direction.
    pub fn segments(&self) -> impl DoubleEndedIterator<Item = (f64, f64, DVec3)> {
        let shortest_m = SHORTEST_SHARE * self.length();
        let pairs = self.points.windows(2).zip(self.lengths.windows(2));
        pairs
            .filter(move |(_, lengths)| lengths[1] - lengths[0] > shortest_m)
            .map(|(points, lengths)| {
                (
                    lengths[0],
                    lengths[1],
                    (points[1] - points[0]).normalize_or_zero(),
                )
            })
    }

    /// Unit direction at the start; 0 for a path without length.
    pub fn start_direction(&self) -> DVec3 {
        let near_m = END_SHARE * self.length();
        match self.points.first() {
            Some(&start) if near_m > 0.0 => (self.at(near_m) - start).normalize_or_zero(),
            _ => DVec3::ZERO,
        }
    }

    /// Unit direction at the end; 0 for a path without length.
    pub fn end_direction(&self) -> DVec3 {
        let near_m = END_SHARE * self.length();
        match self.points.last() {
            Some(&end) if near_m > 0.0 => (end - self.at(self.length() - near_m)).normalize_or_zero(),
            _ => DVec3::ZERO,
        }
    }
}
