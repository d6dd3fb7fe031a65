//! The course of a curved muscle: from its origin through via points and round wraps to its insertion (ALGORITHM 2; via
//! points and wraps as in S. Delp's lower limb model, 1990; cubics as in F. Scheepers, "Anatomy-based modeling", 1997).
//!
//! Between two via points the path is taut: straight, or round the wraps of that span. At a via point it turns in cubics
//! without a kink. It depends on the rest data and the pose alone.

use glam::DVec3;

use crate::muscles::muscle::Attachment;
use crate::muscles::path::Path;
use crate::muscles::wrap::{Obstacle, Wrap, WrapArc, side_and_axis};
use crate::pose::Palette;

/// Rounds in which the wraps of one span find their common taut path.
const ROUNDS: usize = 12;

/// A joint sphere at rest.
#[derive(Debug, Clone, Copy)]
pub struct WrapSphere {
    /// Its bone.
    pub bone: usize,
    /// Its centre, armature space, m.
    pub centre: DVec3,
    /// Its radius, m.
    pub radius_m: f64,
}

/// The rest data of a course.
#[derive(Debug, Clone)]
pub struct MusclePath {
    /// Origin, via points, insertion.
    nodes: Vec<Attachment>,
    /// The wraps of each span between two nodes, in the order in which the path meets them.
    spans: Vec<Vec<Wrap>>,
}

/// Buffers for tracing courses, to keep from one to the next.
#[derive(Debug, Clone, Default)]
pub struct PathBuffers {
    /// The path traced last.
    pub path: Path,
    nodes: Vec<DVec3>,
    obstacles: Vec<Obstacle>,
    bends: Vec<WrapArc>,
    knots: Vec<Knot>,
}

/// A place that the path passes.
#[derive(Debug, Clone, Copy)]
struct Knot {
    point: DVec3,
    direction: Direction,
    /// Radius of the obstacle that it lies on, m; infinite for none.
    radius_m: f64,
    /// The bend that leads from here to the next knot.
    bend: Option<usize>,
}

/// The tangent of the path at a knot.
#[derive(Debug, Clone, Copy)]
enum Direction {
    /// An end: the cubic bends least.
    Free,
    /// A via point: between the directions to its neighbours.
    Between,
    /// On an obstacle: this unit vector.
    Along(DVec3),
}

impl MusclePath {
    /// The course through `nodes` (origin, via points, insertion), round each of `balls` with `clearance_m` to spare, on
    /// the side where it passes at rest; `fallback` tells that side where a line goes through the centre.
    pub fn new(nodes: Vec<Attachment>, balls: &[WrapSphere], clearance_m: f64, fallback: DVec3) -> Self {
        let mut spans: Vec<Vec<(f64, WrapSphere)>> = vec![vec![]; nodes.len() - 1];
        for &ball in balls {
            for (span, share) in spans_of(&nodes, ball, ball.radius_m + clearance_m) {
                spans[span].push((share, ball));
            }
        }
        let wraps_of = |(span, mut balls): (usize, Vec<(f64, WrapSphere)>)| -> Vec<Wrap> {
            balls.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (from, to) = (nodes[span], nodes[span + 1]);
            let bone_of = |place: usize| balls.get(place).map(|(_, ball)| ball.bone);
            let wrap = |(place, (_, ball)): (usize, &(f64, WrapSphere))| {
                let (side, axis) = side_and_axis(ball.centre, from.point, to.point, fallback);
                let before = place.checked_sub(1).and_then(bone_of);
                Wrap {
                    bone: ball.bone,
                    centre: ball.centre,
                    radius_m: ball.radius_m,
                    clearance_m,
                    between: [before.unwrap_or(from.bone), bone_of(place + 1).unwrap_or(to.bone)],
                    side,
                    axis,
                }
            };
            balls.iter().enumerate().map(wrap).collect()
        };
        let spans = spans.into_iter().enumerate().map(wraps_of).collect();
        Self { nodes, spans }
    }

    /// Traces the path in a pose into `tracing.path`, for a muscle that the pose scales by `scale`.
    pub fn trace(&self, palette: &Palette, scale: f64, tracing: &mut PathBuffers) {
        tracing.start(self.nodes.iter().map(|node| node.posed(palette)));
        for (span, wraps) in self.spans.iter().enumerate() {
            tracing.cross(span, wraps.iter().map(|wrap| wrap.posed(palette, scale)));
        }
        tracing.finish();
    }
}

impl PathBuffers {
    fn start(&mut self, nodes: impl Iterator<Item = DVec3>) {
        self.nodes.clear();
        self.nodes.extend(nodes);
        self.obstacles.clear();
        self.bends.clear();
        self.knots.clear();
        self.knots.push(Knot::free(self.nodes[0]));
    }

    /// Adds the knots of one span: two for an obstacle that its taut path touches, one for one that it passes (so that
    /// nothing changes at the touch), and its end.
    fn cross(&mut self, span: usize, obstacles: impl Iterator<Item = Obstacle>) {
        let (from, to) = (self.nodes[span], self.nodes[span + 1]);
        let first = self.bends.len();
        self.obstacles.extend(obstacles);
        for obstacle in &self.obstacles[first..] {
            self.bends.push(obstacle.bend(from, to));
        }
        let count = self.bends.len();
        let rounds = if count > first + 1 { ROUNDS } else { 0 };
        for _ in 0..rounds {
            for place in first..count {
                let before = if place > first {
                    self.bends[place - 1].exit
                } else {
                    from
                };
                let after = if place + 1 < count {
                    self.bends[place + 1].entry
                } else {
                    to
                };
                self.bends[place] = self.obstacles[place].bend(before, after);
            }
        }
        for place in first..count {
            let bend = &self.bends[place];
            let on = |point, direction, bend| Knot {
                point,
                direction: Direction::Along(direction),
                radius_m: self.obstacles[place].radius_m,
                bend,
            };
            if bend.is_touching {
                self.knots.push(on(bend.entry, bend.directions[0], Some(place)));
            }
            self.knots.push(on(bend.exit, bend.directions[1], None));
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
            obstacles,
            bends,
            knots,
        } = self;
        // What a via point's cubic bulges into an obstacle is pushed out, but never an attachment.
        let keep = |point: DVec3| {
            obstacles.iter().fold(point, |point, obstacle| {
                let distances = nodes.iter().map(|node| node.distance(obstacle.centre));
                obstacle.pushed_out(point, distances.fold(obstacle.radius_m, f64::min))
            })
        };
        path.clear();
        path.line_to(knots[0].point);
        for place in 1..knots.len() {
            let (from, to) = (&knots[place - 1], &knots[place]);
            if let Some(bend) = from.bend {
                bends[bend]
                    .corners
                    .iter()
                    .for_each(|&corner| path.line_to(corner));
                path.line_to(to.point);
                continue;
            }
            let chord = to.point - from.point;
            let (start, end) = (tangent(knots, place - 1, to), tangent(knots, place, from));
            match (start, end) {
                (None, None) => path.line_to(to.point),
                (Some(start), None) => path.cubic_to(to.point, start, 1.5 * chord - 0.5 * start, keep),
                (None, Some(end)) => path.cubic_to(to.point, 1.5 * chord - 0.5 * end, end, keep),
                (Some(start), Some(end)) => path.cubic_to(to.point, start, end, keep),
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
            bend: None,
        }
    }
}

/// The tangent at knot `place`, m, for the piece between it and `other`; `None` where it is free.
fn tangent(knots: &[Knot], place: usize, other: &Knot) -> Option<DVec3> {
    let own = &knots[place];
    let length_m = own.point.distance(other.point);
    match own.direction {
        Direction::Free => None,
        Direction::Along(direction) => Some(direction * length_m),
        Direction::Between => {
            let (before, after) = (&knots[place - 1], &knots[place + 1]);
            let (before_m, after_m) = (before.point.distance(own.point), own.point.distance(after.point));
            let both_m = before_m + after_m;
            if both_m == 0.0 {
                return Some(DVec3::ZERO);
            }
            // The parabola's through the three: the nearer neighbour counts more. So long, it would cut into an obstacle
            // that begins close by; no longer than this it cannot: its bulge stays below the ball's own fall.
            let mean = way(before, own, before) * after_m + way(own, after, after) * before_m;
            let longest = (length_m / (2.0 * other.radius_m)).min(1.0);
            let share = if other.radius_m.is_finite() { longest } else { 1.0 };
            Some(mean / both_m * (length_m * share))
        }
    }
}

/// Unit direction in which the path would go straight from one knot to the next. On an obstacle, `known` of the two, it is
/// the path's own there: a chord to a via point that touches the obstacle has no length to tell.
fn way(from: &Knot, to: &Knot, known: &Knot) -> DVec3 {
    match known.direction {
        Direction::Along(direction) => direction,
        Direction::Free | Direction::Between => (to.point - from.point).normalize_or_zero(),
    }
}

/// A span as it lies beside a ball at rest.
struct Passage {
    span: usize,
    /// Where along the span it is nearest, 0..1.
    share: f64,
    distance_m: f64,
    /// True where its ends are on different bones, so that it turns about a joint.
    is_across: bool,
}

impl Passage {
    /// True where it is nearest between its ends.
    fn passes(&self) -> bool {
        self.share > 0.0 && self.share < 1.0
    }
}

/// The spans that go round a ball, and where along each it is at rest.
///
/// Spans across bones turn about a joint: those that pass the ball, or else the nearest. A span along one bone stands still
/// beside it: one that touches at rest, or the nearest where none is across.
fn spans_of(nodes: &[Attachment], ball: WrapSphere, clear_m: f64) -> Vec<(usize, f64)> {
    let passage = |(span, pair): (usize, &[Attachment])| {
        let (share, distance_m) = share_and_distance(pair[0].point, pair[1].point, ball.centre);
        Passage {
            span,
            share,
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
    let goes_round = |passage: &&Passage| match passage.is_across {
        true if any_passes => passage.passes(),
        true => Some(passage.span) == nearest,
        false => passage.distance_m < clear_m || Some(passage.span) == nearest,
    };
    let chosen = all.iter().filter(goes_round);
    chosen.map(|passage| (passage.span, passage.share)).collect()
}

/// Where along the line from `from` to `to` (0..1) it is nearest to `point`, and how far that is, m.
fn share_and_distance(from: DVec3, to: DVec3, point: DVec3) -> (f64, f64) {
    let chord = to - from;
    let square = chord.length_squared();
    let share = if square > 0.0 {
        ((point - from).dot(chord) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (share, from.lerp(to, share).distance(point))
}
