//! A wrapping sphere of a muscle path (mathematics/paths.md, Wrapping spheres).
//!
//! A sphere alone has no sides: a straight line that sinks into it could leave on any of them. So the path
//! wraps around a cylinder, whose axis moves with the bone before the sphere. There the taut path is a
//! straight line, an arc of a helix and a straight line. It winds about the axis in the direction in which it
//! winds at rest, and it changes continuously with the pose, also where contact begins and ends. A path that
//! leaves the joint's plane meets a smaller section of the sphere, and far from that plane none. (The
//! obstacle-set method of B. Garner and M. Pandy, 2000, takes the shortest way around, which jumps.)

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DMat3, DQuat, DVec2, DVec3};

use crate::math::smoothstep::smooth_step;
use crate::muscles::muscle::handedness;
use crate::pose::{Palette, any_perpendicular};

/// Segments of the polyline along the arc.
pub const ARC_SEGMENTS: usize = 16;
/// Height over the joint's plane, in radii, above which the section follows the tangent cone instead of the
/// circle, so that a path that slides off sideways has a bounded speed.
const CAP_HEIGHT: f64 = 0.8;
/// Smallest section, in radii. A path around a smaller one would have a kink.
const SMALLEST_SECTION: f64 = 0.25;
/// Heights, in radii, between which a path beside the sphere becomes straight.
const FADE_HEIGHTS: [f64; 2] = [1.25, 2.0];

/// A wrap at rest.
#[derive(Debug, Clone)]
pub struct Wrap {
    /// Index of the sphere's bone.
    pub bone: usize,
    /// Centre of the sphere at rest, armature space, m.
    pub centre: DVec3,
    /// Radius of the sphere at rest, m.
    pub radius_m: f64,
    /// Distance of the path from the sphere's surface, m, in the scale of the muscle.
    pub clearance_m: f64,
    /// The bones of the previous and the next point of the path.
    pub between: [usize; 2],
    /// Unit direction at rest from the centre to the side on which the path passes.
    pub side: DVec3,
    /// Unit axis at rest about which the path winds, counterclockwise.
    pub axis: DVec3,
}

/// A wrapping sphere in one pose.
#[derive(Debug, Clone, Copy)]
pub struct PosedSphere {
    /// Centre, m.
    pub centre: DVec3,
    /// Distance of the path from the centre, m.
    pub radius_m: f64,
    side: DVec3,
    axis: DVec3,
}

/// The part of a path at a wrapping sphere.
#[derive(Debug, Clone, Copy)]
pub struct WrapArc {
    /// False if the straight line does not touch; then all points are the nearest point of that line.
    pub is_touching: bool,
    /// Where the path reaches the sphere, m.
    pub entry: DVec3,
    /// Where the path leaves the sphere, m.
    pub exit: DVec3,
    /// Unit tangents at entry and exit.
    pub directions: [DVec3; 2],
    /// Corners of a polyline around the sphere from entry to exit, m.
    pub corners: [DVec3; ARC_SEGMENTS],
}

/// The side on which the line from `from` to `to` passes `centre`, and the axis about which it winds there.
/// `fallback` points to the side if the line passes through the centre.
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
    /// The sphere in a pose. `scale` is the scale of the muscle in the pose.
    pub fn posed(&self, palette: &Palette, scale: f64) -> PosedSphere {
        let matrices = palette.skinning_matrices();
        let [before, after] = self.between.map(|bone| matrices[bone].matrix3);
        // The axis follows one bone only, so that twist of the other does not invert it. A mirrored bone
        // does.
        let axis = (before * self.axis).normalize_or(self.axis) * handedness(before);
        // Half of the joint's rotation about that axis: the path passes there however far the joint bends.
        let relative = rotation_of(before).inverse() * rotation_of(after);
        let sign = if relative.w < 0.0 { -1.0 } else { 1.0 };
        let half_angle = (sign * relative.xyz().dot(self.axis)).atan2(sign * relative.w);
        let side = DQuat::from_axis_angle(axis, half_angle) * (before * self.side);
        PosedSphere {
            centre: matrices[self.bone].transform_point3(self.centre),
            radius_m: self.radius_m * palette.scales()[self.bone] + self.clearance_m * scale,
            side: (side - axis * axis.dot(side))
                .try_normalize()
                .unwrap_or_else(|| any_perpendicular(axis)),
            axis,
        }
    }
}

/// A path around a sphere, unrolled: a line, an arc, a line.
struct UnrolledPath {
    from: DVec3,
    to: DVec3,
    /// Heights of both ends over the joint's plane, m.
    heights: [f64; 2],
    radius: f64,
    /// Angle where the arc begins, and the angle of the arc.
    start_angle: f64,
    swept_angle: f64,
    /// Lengths of the lines in the joint's plane, m.
    tangent_lengths: [f64; 2],
    /// 0 for this path, 1 for the straight line.
    fade: f64,
}

impl PosedSphere {
    /// The taut path from `from` to `to` around the sphere.
    ///
    /// If an end is inside the sphere, the sphere ends in a flat face through that end, so that the end is on
    /// its surface. If both ends are inside, the sphere is smaller.
    pub fn wrap(&self, from: DVec3, to: DVec3) -> WrapArc {
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
        // The angles exclude directions that a path on the correct side never comes from or goes to.
        let [begin, finish] = [angle(start, -5.0 * FRAC_PI_4), angle(end, -3.0 * FRAC_PI_4)];
        // From an end outside to its tangent point; from an end inside to the edge of the flat face.
        let opening = |distance: f64| (radius.min(distance) / radius.max(distance)).min(1.0).acos();
        let [start_angle, end_angle] = if radius > 0.0 {
            [begin + opening(near), finish - opening(far)]
        } else {
            [begin, finish]
        };
        let [low, high] = FADE_HEIGHTS.map(|fraction| fraction * self.radius_m);
        let fade = smooth_step((height - low) / (high - low));
        let unrolled = UnrolledPath {
            from,
            to,
            heights: [start.z, end.z],
            radius,
            start_angle,
            swept_angle: (end_angle - start_angle).max(0.0),
            tangent_lengths: [near, far].map(|distance| (distance * distance - radius * radius).abs().sqrt()),
            fade,
        };
        if fade >= 1.0 {
            return self.free(from, to, start, end);
        }
        if end_angle > start_angle {
            return self.arc(&unrolled);
        }
        // The sphere is not between the ends, but the edge of a face may be.
        let edge = if far < radius && end_angle > begin {
            end_angle
        } else if near < radius && start_angle < finish {
            start_angle
        } else {
            return self.free(from, to, start, end);
        };
        let corner = DVec2::from_angle(edge) * radius;
        let [start_2d, end_2d] = [start, end].map(DVec3::truncate);
        if (end_2d - start_2d).perp_dot(corner - start_2d) >= 0.0 {
            return self.free(from, to, start, end);
        }
        let tangent_lengths = [corner.distance(start_2d), corner.distance(end_2d)];
        let arc = self.arc(&UnrolledPath {
            start_angle: edge,
            tangent_lengths,
            ..unrolled
        });
        let direction = if far < radius {
            arc.entry - from
        } else {
            to - arc.entry
        };
        WrapArc {
            directions: [direction.normalize_or_zero(); 2],
            ..arc
        }
    }

    fn arc(&self, unrolled: &UnrolledPath) -> WrapArc {
        let &UnrolledPath {
            from,
            to,
            heights: [start_m, end_m],
            radius,
            start_angle,
            swept_angle,
            tangent_lengths,
            fade,
        } = unrolled;
        let unrolled_m = tangent_lengths[0] + radius * swept_angle + tangent_lengths[1];
        let per_length = |value: f64| if unrolled_m > 0.0 { value / unrolled_m } else { 0.0 };
        let climb = per_length(end_m - start_m);
        let chord = to - from;
        let point = |rotated: f64, radius_there: f64| {
            let run = tangent_lengths[0] + radius * rotated;
            let around = DVec2::from_angle(start_angle + rotated) * radius_there;
            let point = self.world(around.extend(start_m + climb * run));
            point.lerp(from + chord * per_length(run), fade)
        };
        let direction = |rotated: f64| {
            let ahead = DVec2::from_angle(start_angle + rotated).perp();
            let round = self.rotated(ahead.extend(climb)).normalize_or_zero();
            round.lerp(chord.normalize_or_zero(), fade).normalize_or_zero()
        };
        let step = swept_angle / ARC_SEGMENTS as f64;
        // Corners of the polygon around the arc: its sides touch the arc and none intersects it.
        let outside = radius / (0.5 * step).cos();
        WrapArc {
            is_touching: true,
            entry: point(0.0, radius),
            exit: point(swept_angle, radius),
            directions: [direction(0.0), direction(swept_angle)],
            corners: std::array::from_fn(|corner| point((corner as f64 + 0.5) * step, outside)),
        }
    }

    /// The straight line, and its point nearest to the axis.
    fn free(&self, from: DVec3, to: DVec3, start: DVec3, end: DVec3) -> WrapArc {
        let (start, across) = (start.truncate(), (end - start).truncate());
        let square = across.length_squared();
        let fraction = if square > 0.0 {
            (-start.dot(across) / square).clamp(0.0, 1.0)
        } else {
            0.5
        };
        let point = from.lerp(to, fraction);
        WrapArc {
            is_touching: false,
            entry: point,
            exit: point,
            directions: [(to - from).normalize_or_zero(); 2],
            corners: [point; ARC_SEGMENTS],
        }
    }

    /// `point` if it is at least `radius_m` from the centre; otherwise the nearest point at that distance.
    pub fn pushed_out(&self, point: DVec3, radius_m: f64) -> DVec3 {
        let off = point - self.centre;
        if off.length_squared() >= radius_m * radius_m {
            return point;
        }
        self.centre + off.try_normalize().unwrap_or(self.side) * radius_m
    }

    /// Radius of the sphere's section at a height over its centre, with cones at the poles.
    fn section(&self, height: f64) -> f64 {
        let height = height / self.radius_m;
        let circle = |height: f64| (1.0 - height * height).sqrt();
        let fraction = if height < CAP_HEIGHT {
            circle(height)
        } else {
            let slope = CAP_HEIGHT / circle(CAP_HEIGHT);
            circle(CAP_HEIGHT) - slope * (height - CAP_HEIGHT)
        };
        self.radius_m * fraction.max(SMALLEST_SECTION)
    }

    /// A point in the coordinates side, forward, axis.
    fn local(&self, point: DVec3) -> DVec3 {
        self.axes().transpose() * (point - self.centre)
    }

    fn world(&self, local: DVec3) -> DVec3 {
        self.centre + self.rotated(local)
    }

    fn rotated(&self, local: DVec3) -> DVec3 {
        self.axes() * local
    }

    fn axes(&self) -> DMat3 {
        DMat3::from_cols(self.side, self.axis.cross(self.side), self.axis)
    }
}

/// The rotation of a map, without mirroring and scale.
fn rotation_of(linear: DMat3) -> DQuat {
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis].map(DVec3::normalize_or_zero);
    DQuat::from_mat3(&(DMat3::from_cols(x, y, z) * handedness(linear)))
}

/// The angle of a point about the axis, from `side`, in `lowest..lowest + 2π`.
fn angle(local: DVec3, lowest: f64) -> f64 {
    let angle = local.y.atan2(local.x);
    let lifted = if angle < lowest { angle + TAU } else { angle };
    if lifted >= lowest + TAU {
        lifted - TAU
    } else {
        lifted
    }
}
