//! A joint sphere that a muscle goes round (ALGORITHM 2).
//!
//! A ball alone has no sides: a straight line that sinks through it would leave on any of them. So the path goes round
//! the ball's cylinder, whose axis the bone before it carries: there the taut path is a straight line, an arc of a helix and a
//! straight line, it winds about the axis the one way that it winds at rest, and it changes continuously with the pose,
//! also where it begins and ceases to touch. A path that leaves the joint's plane finds the ball's smaller section, and
//! far outside that plane nothing. (B. Garner and M. Pandy, "The obstacle-set method", 2000, wrap the shortest way, which
//! jumps.)

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DMat3, DQuat, DVec2, DVec3};

use crate::math::smoothstep::smooth_step;
use crate::muscles::muscle::handedness;
use crate::pose::{Palette, any_perpendicular};

/// Segments that stand for the arc.
pub const ARC_SEGMENTS: usize = 16;
/// Height over the joint's plane, in radii, from which the ball's section no longer follows its circle but its tangent
/// cone: a path that slides off sideways keeps a bounded speed.
const CAP_HEIGHT: f64 = 0.8;
/// Smallest section, in radii: what turns round less than that would have a kink.
const SMALLEST_SECTION: f64 = 0.25;
/// Heights, in radii, between which a path beside the ball becomes straight.
const FADE_HEIGHTS: [f64; 2] = [1.25, 2.0];

/// The rest data of a wrap.
#[derive(Debug, Clone)]
pub struct Wrap {
    /// Bone of the sphere.
    pub bone: usize,
    /// Centre of the sphere at rest, armature space, m.
    pub centre: DVec3,
    /// Radius of the sphere at rest, m.
    pub radius_m: f64,
    /// Distance that the path keeps from the sphere, m, at the muscle's own scale.
    pub clearance_m: f64,
    /// Bones of what the path comes from and goes to.
    pub between: [usize; 2],
    /// Unit direction at rest from the centre to the side on which the path passes.
    pub side: DVec3,
    /// Unit axis at rest about which the path winds, counterclockwise.
    pub axis: DVec3,
}

/// A wrap in one pose.
#[derive(Debug, Clone, Copy)]
pub struct Obstacle {
    /// Centre, m.
    pub centre: DVec3,
    /// Distance from the centre that the path keeps, m.
    pub radius_m: f64,
    side: DVec3,
    axis: DVec3,
}

/// How a path goes round an obstacle.
#[derive(Debug, Clone, Copy)]
pub struct WrapArc {
    /// False where the straight path is free; all else is then the place of it that is nearest.
    pub is_touching: bool,
    /// Where the path reaches the obstacle, m.
    pub entry: DVec3,
    /// Where it leaves it, m.
    pub exit: DVec3,
    /// Unit directions at entry and exit.
    pub directions: [DVec3; 2],
    /// Corners of a polyline round the obstacle between entry and exit, m.
    pub corners: [DVec3; ARC_SEGMENTS],
}

/// The side on which the line from `from` to `to` passes `centre`, and the axis about which it winds there; `fallback` tells
/// the side where the line goes through the centre.
pub fn side_and_axis(centre: DVec3, from: DVec3, to: DVec3, fallback: DVec3) -> (DVec3, DVec3) {
    let along = (to - from).try_normalize().unwrap_or(DVec3::Z);
    let square = |direction: DVec3| direction - along * along.dot(direction);
    let off = square(from - centre);
    let smallest = 1e-6 * from.distance(centre).max(to.distance(centre));
    let side = (off.length() > smallest)
        .then_some(off)
        .and_then(DVec3::try_normalize)
        .or_else(|| square(fallback).try_normalize())
        .unwrap_or_else(|| any_perpendicular(along));
    (side, side.cross(along))
}

impl Wrap {
    /// The wrap in a pose, for a muscle that the pose scales by `scale`.
    pub fn posed(&self, palette: &Palette, scale: f64) -> Obstacle {
        let carries = palette.skinning_matrices();
        let [before, after] = self.between.map(|bone| carries[bone].matrix3);
        // One bone alone carries the axis, which no twist of the other turns over; it turns over in a mirror.
        let axis = (before * self.axis).normalize_or(self.axis) * handedness(before);
        // The middle of what the joint has turned about that axis: the path passes there however far the joint bends.
        let relative = rotation_of(before).inverse() * rotation_of(after);
        let sign = if relative.w < 0.0 { -1.0 } else { 1.0 };
        let half_turn = (sign * relative.xyz().dot(self.axis)).atan2(sign * relative.w);
        let side = DQuat::from_axis_angle(axis, half_turn) * (before * self.side);
        Obstacle {
            centre: carries[self.bone].transform_point3(self.centre),
            radius_m: self.radius_m * palette.scales()[self.bone] + self.clearance_m * scale,
            side: (side - axis * axis.dot(side))
                .try_normalize()
                .unwrap_or_else(|| any_perpendicular(axis)),
            axis,
        }
    }
}

/// A path round an obstacle, unrolled: a line, an arc, a line.
struct UnrolledPath {
    from: DVec3,
    to: DVec3,
    /// Of both ends over the joint's plane, m.
    heights: [f64; 2],
    radius: f64,
    /// Angle at which the arc begins, and by which it turns.
    touch: f64,
    turn: f64,
    /// Lengths of the lines in the joint's plane, m.
    tangent_lengths: [f64; 2],
    /// 0 for this path, 1 for the straight one.
    fade: f64,
}

impl Obstacle {
    /// The taut path from `from` to `to` round it.
    ///
    /// The ball ends in a flat face through an end that is inside it, so that such an end is on its border, too; two such
    /// ends make it smaller.
    pub fn bend(&self, from: DVec3, to: DVec3) -> WrapArc {
        let [start, end] = [from, to].map(|point| self.local(point));
        if self.radius_m <= 0.0 {
            return self.free(from, to, start, end);
        }
        let height = if start.z * end.z <= 0.0 {
            0.0
        } else {
            start.z.abs().min(end.z.abs())
        };
        let [near, far] = [start, end].map(|point| point.truncate().length());
        let radius = self.section(height).min(near.max(far));
        // The angles leave out the directions that a path on the right side never comes from or goes to.
        let [begin, finish] = [angle(start, -5.0 * FRAC_PI_4), angle(end, -3.0 * FRAC_PI_4)];
        // From an end outside to where its tangent touches, from one inside to the edge of its face.
        let opening = |distance: f64| (radius.min(distance) / radius.max(distance)).min(1.0).acos();
        let [touch, leave] = if radius > 0.0 {
            [begin + opening(near), finish - opening(far)]
        } else {
            [begin, finish]
        };
        let [low, high] = FADE_HEIGHTS.map(|share| share * self.radius_m);
        let fade = smooth_step((height - low) / (high - low));
        let round = UnrolledPath {
            from,
            to,
            heights: [start.z, end.z],
            radius,
            touch,
            turn: (leave - touch).max(0.0),
            tangent_lengths: [near, far].map(|distance| (distance * distance - radius * radius).abs().sqrt()),
            fade,
        };
        if fade >= 1.0 {
            return self.free(from, to, start, end);
        }
        if leave > touch {
            return self.round(&round);
        }
        // Nothing of the ball is between, but the edge of a face may be.
        let edge = if far < radius && leave > begin {
            leave
        } else if near < radius && touch < finish {
            touch
        } else {
            return self.free(from, to, start, end);
        };
        let corner = DVec2::from_angle(edge) * radius;
        let [start_2d, end_2d] = [start, end].map(DVec3::truncate);
        if (end_2d - start_2d).perp_dot(corner - start_2d) >= 0.0 {
            return self.free(from, to, start, end);
        }
        let tangent_lengths = [corner.distance(start_2d), corner.distance(end_2d)];
        let bend = self.round(&UnrolledPath {
            touch: edge,
            tangent_lengths,
            ..round
        });
        let way = if far < radius {
            bend.entry - from
        } else {
            to - bend.entry
        };
        WrapArc {
            directions: [way.normalize_or_zero(); 2],
            ..bend
        }
    }

    fn round(&self, round: &UnrolledPath) -> WrapArc {
        let &UnrolledPath {
            from,
            to,
            heights: [start_m, end_m],
            radius,
            touch,
            turn,
            tangent_lengths,
            fade,
        } = round;
        let unrolled_m = tangent_lengths[0] + radius * turn + tangent_lengths[1];
        let per_length = |value: f64| if unrolled_m > 0.0 { value / unrolled_m } else { 0.0 };
        let climb = per_length(end_m - start_m);
        let chord = to - from;
        let place = |turned: f64, radius_there: f64| {
            let run = tangent_lengths[0] + radius * turned;
            let around = DVec2::from_angle(touch + turned) * radius_there;
            let place = self.world(around.extend(start_m + climb * run));
            place.lerp(from + chord * per_length(run), fade)
        };
        let direction = |turned: f64| {
            let ahead = DVec2::from_angle(touch + turned).perp();
            let round = self.turned(ahead.extend(climb)).normalize_or_zero();
            round.lerp(chord.normalize_or_zero(), fade).normalize_or_zero()
        };
        let step = turn / ARC_SEGMENTS as f64;
        // Corners of the polygon round the arc, so that its sides touch the arc and none cuts it.
        let outside = radius / (0.5 * step).cos();
        WrapArc {
            is_touching: true,
            entry: place(0.0, radius),
            exit: place(turn, radius),
            directions: [direction(0.0), direction(turn)],
            corners: std::array::from_fn(|corner| place((corner as f64 + 0.5) * step, outside)),
        }
    }

    /// A straight path, and the place on it where it passes nearest to the axis.
    fn free(&self, from: DVec3, to: DVec3, start: DVec3, end: DVec3) -> WrapArc {
        let (start, across) = (start.truncate(), (end - start).truncate());
        let square = across.length_squared();
        let share = if square > 0.0 {
            (-start.dot(across) / square).clamp(0.0, 1.0)
        } else {
            0.5
        };
        let place = from.lerp(to, share);
        WrapArc {
            is_touching: false,
            entry: place,
            exit: place,
            directions: [(to - from).normalize_or_zero(); 2],
            corners: [place; ARC_SEGMENTS],
        }
    }

    /// `point` itself outside; inside a ball of `radius_m` round the centre, the nearest point on that.
    pub fn pushed_out(&self, point: DVec3, radius_m: f64) -> DVec3 {
        let off = point - self.centre;
        if off.length_squared() >= radius_m * radius_m {
            return point;
        }
        self.centre + off.try_normalize().unwrap_or(self.side) * radius_m
    }

    /// Radius of the ball's section at a height over its centre, with cones for poles.
    fn section(&self, height: f64) -> f64 {
        let height = height / self.radius_m;
        let circle = |height: f64| (1.0 - height * height).sqrt();
        let share = if height < CAP_HEIGHT {
            circle(height)
        } else {
            let slope = CAP_HEIGHT / circle(CAP_HEIGHT);
            circle(CAP_HEIGHT) - slope * (height - CAP_HEIGHT)
        };
        self.radius_m * share.max(SMALLEST_SECTION)
    }

    /// A place in the axes side, forward, axis.
    fn local(&self, point: DVec3) -> DVec3 {
        self.axes().transpose() * (point - self.centre)
    }

    fn world(&self, local: DVec3) -> DVec3 {
        self.centre + self.turned(local)
    }

    fn turned(&self, local: DVec3) -> DVec3 {
        self.axes() * local
    }

    fn axes(&self) -> DMat3 {
        DMat3::from_cols(self.side, self.axis.cross(self.side), self.axis)
    }
}

/// The rotation in a map, with its mirroring and the lengths of its axes taken out.
fn rotation_of(linear: DMat3) -> DQuat {
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis].map(DVec3::normalize_or_zero);
    DQuat::from_mat3(&(DMat3::from_cols(x, y, z) * handedness(linear)))
}

/// The angle of a place about the axis, from the side, between `lowest` and a turn more.
fn angle(local: DVec3, lowest: f64) -> f64 {
    let angle = local.y.atan2(local.x);
    let lifted = if angle < lowest { angle + TAU } else { angle };
    if lifted >= lowest + TAU {
        lifted - TAU
    } else {
        lifted
    }
}
