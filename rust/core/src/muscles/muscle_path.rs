//! The path of a curved muscle: from its origin through via points and around wrapping spheres to its
//! insertion (mathematics/paths.md, Via points; via points and wraps as in S. Delp's lower limb model, 1990;
//! cubics as in F. Scheepers, "Anatomy-based modeling", 1997).
//!
//! Between two via points the path is taut: straight, or around the spheres of that span. At a via point it
//! turns in cubics with a continuous tangent. It depends on the rest data and the pose only.

use glam::DVec3;

use crate::math::segment::nearest_on_segment;
use crate::muscles::muscle::Attachment;
use crate::muscles::polyline::Polyline;
use crate::muscles::wrap::{PosedSphere, Wrap, WrapArc, side_and_axis};
use crate::pose::Palette;

/// Iterations in which the spheres of one span find their common taut path.
const ITERATIONS: usize = 12;

/// A wrapping sphere at rest.
#[derive(Debug, Clone, Copy)]
pub struct WrapSphere {
    /// Index of its bone.
    pub bone: usize,
    /// Its centre, armature space, m.
    pub centre: DVec3,
    /// Its radius, m.
    pub radius_m: f64,
}

/// The rest data of a muscle path.
#[derive(Debug, Clone)]
pub struct MusclePath {
    /// Origin, via points, insertion.
    nodes: Vec<Attachment>,
    /// The wraps of each span between two nodes, in the order in which the path reaches them.
    spans: Vec<Vec<Wrap>>,
}

/// Buffers for [`MusclePath::trace`], reused from one path to the next.
#[derive(Debug, Clone, Default)]
pub struct PathBuffers {
    /// The path traced last.
    pub path: Polyline,
    nodes: Vec<DVec3>,
    posed_spheres: Vec<PosedSphere>,
    arcs: Vec<WrapArc>,
    knots: Vec<Knot>,
}

/// A point of the path where pieces meet.
#[derive(Debug, Clone, Copy)]
struct Knot {
    point: DVec3,
    direction: Direction,
    /// Radius of the sphere that it is on, m; infinite if it is on none.
    radius_m: f64,
    /// The arc from here to the next knot.
    arc: Option<usize>,
}

/// The tangent of the path at a knot.
#[derive(Debug, Clone, Copy)]
enum Direction {
    /// At an end of the path: the tangent with which the cubic bends least.
    Free,
    /// At a via point: between the directions to its neighbours.
    Between,
    /// On a sphere: this unit vector.
    Along(DVec3),
}

impl MusclePath {
    /// The path through `nodes` (origin, via points, insertion) and around each of `spheres`, `clearance_m`
    /// from its surface, on the side where the path passes at rest. `fallback` points to that side if the
    /// line passes through the centre.
    pub fn new(nodes: Vec<Attachment>, spheres: &[WrapSphere], clearance_m: f64, fallback: DVec3) -> Self {
        let mut spans: Vec<Vec<(f64, WrapSphere)>> = vec![vec![]; nodes.len() - 1];
        for &sphere in spheres {
            for (span, fraction) in spans_of(&nodes, sphere, sphere.radius_m + clearance_m) {
                spans[span].push((fraction, sphere));
            }
        }
        let wraps_of = |(span, mut spheres): (usize, Vec<(f64, WrapSphere)>)| -> Vec<Wrap> {
            spheres.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (from, to) = (nodes[span], nodes[span + 1]);
            let bone_of = |index: usize| spheres.get(index).map(|(_, sphere)| sphere.bone);
            let wrap = |(index, (_, sphere)): (usize, &(f64, WrapSphere))| {
                let (side, axis) = side_and_axis(sphere.centre, from.point, to.point, fallback);
                let before = index.checked_sub(1).and_then(bone_of);
                Wrap {
                    bone: sphere.bone,
                    centre: sphere.centre,
                    radius_m: sphere.radius_m,
                    clearance_m,
                    between: [before.unwrap_or(from.bone), bone_of(index + 1).unwrap_or(to.bone)],
                    side,
                    axis,
                }
            };
            spheres.iter().enumerate().map(wrap).collect()
        };
        let spans = spans.into_iter().enumerate().map(wraps_of).collect();
        Self { nodes, spans }
    }

    /// Writes the path in a pose to `buffers.path`. `scale` is the scale of the muscle in the pose.
    pub fn trace(&self, palette: &Palette, scale: f64, buffers: &mut PathBuffers) {
        buffers.start(self.nodes.iter().map(|node| node.posed(palette)));
        for (span, wraps) in self.spans.iter().enumerate() {
            buffers.cross(span, wraps.iter().map(|wrap| wrap.posed(palette, scale)));
        }
        buffers.finish();
    }
}

impl PathBuffers {
    fn start(&mut self, nodes: impl Iterator<Item = DVec3>) {
        self.nodes.clear();
        self.nodes.extend(nodes);
        self.posed_spheres.clear();
        self.arcs.clear();
        self.knots.clear();
        self.knots.push(Knot::free(self.nodes[0]));
    }

    /// Adds the knots of one span: two for a sphere that the taut path touches; one for a sphere that it
    /// passes, so that nothing changes at the first touch; and the end of the span.
    fn cross(&mut self, span: usize, posed_spheres: impl Iterator<Item = PosedSphere>) {
        let (from, to) = (self.nodes[span], self.nodes[span + 1]);
        let first = self.arcs.len();
        self.posed_spheres.extend(posed_spheres);
        for sphere in &self.posed_spheres[first..] {
            self.arcs.push(sphere.wrap(from, to));
        }
        let count = self.arcs.len();
        let iterations = if count > first + 1 { ITERATIONS } else { 0 };
        for _ in 0..iterations {
            for index in first..count {
                let before = if index > first {
                    self.arcs[index - 1].exit
                } else {
                    from
                };
                let after = if index + 1 < count {
                    self.arcs[index + 1].entry
                } else {
                    to
                };
                self.arcs[index] = self.posed_spheres[index].wrap(before, after);
            }
        }
        for index in first..count {
            let arc = &self.arcs[index];
            let on = |point, direction, arc| Knot {
                point,
                direction: Direction::Along(direction),
                radius_m: self.posed_spheres[index].radius_m,
                arc,
            };
            if arc.is_touching {
                self.knots.push(on(arc.entry, arc.directions[0], Some(index)));
            }
            self.knots.push(on(arc.exit, arc.directions[1], None));
        }
        let is_last = span + 2 == self.nodes.len();
        self.knots.push(Knot {
            direction: if is_last {
                Direction::Free
            } else {
                Direction::Between
            },
            ..Knot::free(to)
        });
    }

    /// Joins the knots to a path.
    fn finish(&mut self) {
        let Self {
            path,
            nodes,
            posed_spheres,
            arcs,
            knots,
        } = self;
        // Where the cubic at a via point enters a sphere, its points are pushed out. Attachments are not.
        let outside = |point: DVec3| {
            posed_spheres.iter().fold(point, |point, sphere| {
                let distances = nodes.iter().map(|node| node.distance(sphere.centre));
                sphere.pushed_out(point, distances.fold(sphere.radius_m, f64::min))
            })
        };
        path.clear();
        path.line_to(knots[0].point);
        for index in 1..knots.len() {
            let (from, to) = (&knots[index - 1], &knots[index]);
            if let Some(arc) = from.arc {
                arcs[arc].corners.iter().for_each(|&corner| path.line_to(corner));
                path.line_to(to.point);
                continue;
            }
            let chord = to.point - from.point;
            let (start, end) = (tangent(knots, index - 1, to), tangent(knots, index, from));
            match (start, end) {
                (None, None) => path.line_to(to.point),
                (Some(start), None) => path.cubic_to(to.point, start, 1.5 * chord - 0.5 * start, outside),
                (None, Some(end)) => path.cubic_to(to.point, 1.5 * chord - 0.5 * end, end, outside),
                (Some(start), Some(end)) => path.cubic_to(to.point, start, end, outside),
            }
        }
    }
}

impl Knot {
    fn free(point: DVec3) -> Self {
        Self {
            point,
            direction: Direction::Free,
            radius_m: f64::INFINITY,
            arc: None,
        }
    }
}

/// The tangent, m, at knot `index` of the piece between it and `other`; `None` if it is free.
fn tangent(knots: &[Knot], index: usize, other: &Knot) -> Option<DVec3> {
    let knot = &knots[index];
    let length_m = knot.point.distance(other.point);
    match knot.direction {
        Direction::Free => None,
        Direction::Along(direction) => Some(direction * length_m),
        Direction::Between => {
            let (before, after) = (&knots[index - 1], &knots[index + 1]);
            let (before_m, after_m) = (
                before.point.distance(knot.point),
                knot.point.distance(after.point),
            );
            let both_m = before_m + after_m;
            if both_m == 0.0 {
                return Some(DVec3::ZERO);
            }
            // The tangent of the parabola through the three points: the nearer neighbour counts more. At full
            // length it would enter a sphere that begins close by. With this limit the bulge of the cubic
            // stays below the curvature of the sphere.
            let mean = direction_between(before, knot, before) * after_m
                + direction_between(knot, after, after) * before_m;
            let longest = (length_m / (2.0 * other.radius_m)).min(1.0);
            let fraction = if other.radius_m.is_finite() { longest } else { 1.0 };
            Some(mean / both_m * (length_m * fraction))
        }
    }
}

/// Unit direction of the straight line from one knot to the next. If `known`, one of the two, is on a sphere,
/// it is the path's direction there, because a chord to a via point that touches the sphere has no length.
fn direction_between(from: &Knot, to: &Knot, known: &Knot) -> DVec3 {
    match known.direction {
        Direction::Along(direction) => direction,
        Direction::Free | Direction::Between => (to.point - from.point).normalize_or_zero(),
    }
}

/// A span and its position relative to a sphere at rest.
struct Passage {
    span: usize,
    /// Where the span is nearest to the centre, 0..1 along it.
    fraction: f64,
    distance_m: f64,
    /// True if its ends are on different bones, so that it moves about a joint.
    is_across: bool,
}

impl Passage {
    /// True if it is nearest between its ends.
    fn passes(&self) -> bool {
        self.fraction > 0.0 && self.fraction < 1.0
    }
}

/// The spans that wrap around a sphere, and where along each it is at rest.
///
/// Of spans between different bones: all that pass the sphere, or else the nearest. A span along one bone
/// does not move relative to the sphere: it counts if it touches at rest, or if it is the nearest and no span
/// is between different bones.
fn spans_of(nodes: &[Attachment], sphere: WrapSphere, clear_m: f64) -> Vec<(usize, f64)> {
    let passage = |(span, pair): (usize, &[Attachment])| {
        let (nearest, fraction) = nearest_on_segment(sphere.centre, pair[0].point, pair[1].point);
        let distance_m = nearest.distance(sphere.centre);
        Passage {
            span,
            fraction,
            distance_m,
            is_across: pair[0].bone != pair[1].bone,
        }
    };
    let all: Vec<_> = nodes.windows(2).enumerate().map(passage).collect();
    let any_across = all.iter().any(|passage| passage.is_across);
    let any_passes = all.iter().any(|passage| passage.is_across && passage.passes());
    let alike = all.iter().filter(|passage| passage.is_across == any_across);
    let nearest = alike.min_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    let nearest = nearest.map(|passage| passage.span);
    let wraps = |passage: &&Passage| match passage.is_across {
        true if any_passes => passage.passes(),
        true => Some(passage.span) == nearest,
        false => passage.distance_m < clear_m || Some(passage.span) == nearest,
    };
    let chosen = all.iter().filter(wraps);
    chosen.map(|passage| (passage.span, passage.fraction)).collect()
}
