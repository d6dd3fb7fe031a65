//! The belly of a curved muscle: a chain of ellipsoids along its course (ALGORITHM 2).
//!
//! The links lie in the one ellipsoid that a straight muscle of the same length would be, each touching it from within, so
//! that a chain drawn straight looks like it. All links change shape by the belly's one law: each keeps its share of the
//! volume.

use glam::{DMat3, DQuat, DVec3};

use crate::ellipsoid::Ellipsoid;
use crate::muscles::muscle::{Muscle, handedness, square_to};
use crate::muscles::muscle_path::{MusclePath, PathBuffers};
use crate::pose::{Palette, any_perpendicular};

/// Number of links.
pub const LINKS: usize = 5;
/// The link that stands for the whole belly.
const MIDDLE: usize = LINKS / 2;
/// Centre of each link along the belly, -1..1. These with these lengths fill the one ellipsoid best: from nine tenths of
/// its width on, over nine tenths of its length.
const PLACES: [f64; LINKS] = [-0.64, -0.33, 0.0, 0.33, 0.64];
/// Half length of each link over the belly's.
const LENGTHS: [f64; LINKS] = [0.33, 0.45, 0.45, 0.45, 0.33];

/// A curved muscle at rest.
#[derive(Debug, Clone)]
pub struct BellyChain {
    course: MusclePath,
    /// The law of shape, with the length of the curved belly.
    muscle: Muscle,
    /// Widths of the belly in its middle, m.
    widths_m: [f64; 2],
    /// What the muscle's Empty shows.
    envelope: Ellipsoid,
    /// The x axis carried along the path to origin and insertion.
    across: [DVec3; 2],
    /// Centre and axes of each link.
    rest: [Frame; LINKS],
}

/// Where a link stands.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Centre, m.
    pub centre: DVec3,
    /// Orthonormal axes, z along the path.
    pub axes: DMat3,
}

/// A curved muscle in one pose.
#[derive(Debug, Clone, Copy)]
pub struct PosedBellyChain {
    /// The links.
    pub frames: [Frame; LINKS],
    /// Uniform scale by which the two bones scale the muscle.
    pub scale: f64,
    /// Posed semi-axes over scaled rest semi-axes; z is the stretch. The same for all links.
    pub shape: DVec3,
    /// True where the belly came near its floor.
    pub is_clamped: bool,
}

impl BellyChain {
    /// The chain of `muscle`, whose belly would be `envelope` if it were straight, on `course`.
    pub fn new(course: MusclePath, muscle: &Muscle, envelope: Ellipsoid, at_rest: &Palette) -> Self {
        let mut tracing = PathBuffers::default();
        course.trace(at_rest, 1.0, &mut tracing);
        let tendons_m = muscle.origin_tendon_m + muscle.insertion_tendon_m;
        let mut chain = Self {
            course,
            muscle: Muscle {
                belly_m: tracing.path.length() - tendons_m,
                ..muscle.clone()
            },
            widths_m: [envelope.semi_axes.x, envelope.semi_axes.y],
            envelope,
            across: [DVec3::ZERO; 2],
            rest: [Frame {
                centre: envelope.centre,
                axes: envelope.axes,
            }; LINKS],
        };
        let ways = chain.ways(&tracing, 0.5 * chain.muscle.belly_m, envelope.axes.z_axis);
        let middle = ways.links[MIDDLE];
        let own = square_to(middle, envelope.axes.x_axis).unwrap_or_else(|| any_perpendicular(middle));
        let middle_m = ways.places_m[MIDDLE];
        let mut back = ParallelTransport::new(middle, own);
        let before = tracing.path.segments().rev();
        before
            .filter(|(start_m, ..)| *start_m < middle_m)
            .for_each(|(.., way)| back.turn(way));
        let mut forth = ParallelTransport::new(middle, own);
        let after = tracing.path.segments();
        after
            .filter(|(_, end_m, _)| *end_m > middle_m)
            .for_each(|(.., way)| forth.turn(way));
        chain.across = [back.towards(ways.start), forth.towards(ways.end)];
        chain.rest = chain.posed(at_rest, 0.0, &mut tracing).frames;
        chain
    }

    /// Leaves the path of a pose in `tracing`.
    pub fn trace(&self, palette: &Palette, tracing: &mut PathBuffers) {
        self.course.trace(palette, self.muscle.scale(palette), tracing);
    }

    /// Volume of the belly at rest, m³: of the one ellipsoid as long as the path, of which each link keeps a fixed share.
    pub fn volume(&self) -> f64 {
        self.belly().volume()
    }

    /// The links at rest, armature space.
    pub fn links(&self) -> [Ellipsoid; LINKS] {
        std::array::from_fn(|link| {
            let Frame { centre, axes } = self.rest[link];
            Ellipsoid {
                centre,
                axes,
                semi_axes: self.semi_axes(link),
            }
        })
    }

    /// Semi-axes of a link at rest, m.
    pub fn semi_axes(&self, link: usize) -> DVec3 {
        let (place, length) = (PLACES[link], LENGTHS[link]);
        let width = inscribed_width(place, length);
        self.belly().semi_axes * DVec3::new(width, width, length)
    }

    /// The chain in a pose, under `tension` 0..1; leaves its path in `tracing`.
    pub fn posed(&self, palette: &Palette, tension: f64, tracing: &mut PathBuffers) -> PosedBellyChain {
        let [origin, insertion] = [self.muscle.origin.bone, self.muscle.insertion.bone];
        let (carries, scale) = (palette.skinning_matrices(), self.muscle.scale(palette));
        let [carry_o, carry_i] = [origin, insertion].map(|bone| carries[bone].matrix3);
        self.course.trace(palette, scale, tracing);
        let (stretch, is_clamped) = self.muscle.stretch(tracing.path.length(), scale);
        let shape = self.muscle.shape(stretch, tension);
        let fallback = (carry_o * self.envelope.axes.z_axis)
            .try_normalize()
            .unwrap_or(self.envelope.axes.z_axis);
        let half_m = 0.5 * self.muscle.belly_m * scale * shape.z;
        let ways = self.ways(tracing, half_m, fallback);
        let across = self.across_links([carry_o, carry_i], &ways, tracing);
        let hand = handedness(carry_o);
        let frames = std::array::from_fn(|link| {
            let (along, across) = (ways.links[link], across[link]);
            Frame {
                centre: tracing.path.at(ways.places_m[link]),
                axes: DMat3::from_cols(across, along.cross(across) * hand, along),
            }
        });
        PosedBellyChain {
            frames,
            scale,
            shape,
            is_clamped,
        }
    }

    /// The ellipsoid that shows a posed chain: the muscle's own of the rest pose, changed in shape, moved as the middle
    /// link moved.
    pub fn shown(&self, posed: &PosedBellyChain) -> Ellipsoid {
        let (rest, now) = (&self.rest[MIDDLE], &posed.frames[MIDDLE]);
        let turn = now.axes * rest.axes.transpose();
        Ellipsoid {
            centre: now.centre + turn * (self.envelope.centre - rest.centre) * posed.scale,
            axes: turn * self.envelope.axes,
            semi_axes: self.envelope.semi_axes * posed.shape * posed.scale,
        }
    }

    /// The one ellipsoid that a straight belly of this length would be.
    fn belly(&self) -> Ellipsoid {
        let [x, y] = self.widths_m;
        Ellipsoid {
            semi_axes: DVec3::new(x, y, 0.5 * self.muscle.belly_m),
            ..self.envelope
        }
    }

    /// Where along the path the middle of the belly is, 0..1.
    fn middle_share(&self) -> f64 {
        let Muscle {
            belly_m,
            origin_tendon_m,
            insertion_tendon_m,
            ..
        } = self.muscle;
        (origin_tendon_m + 0.5 * belly_m) / (origin_tendon_m + belly_m + insertion_tendon_m)
    }

    /// Directions of the path where it starts, at each link of a belly of half length `half_m`, and where it ends;
    /// `fallback` for a path of no length.
    fn ways(&self, tracing: &PathBuffers, half_m: f64, fallback: DVec3) -> Tangents {
        let path = &tracing.path;
        let or_fallback = |way: DVec3| way.try_normalize().unwrap_or(fallback);
        let middle_m = self.middle_share() * path.length();
        let places_m = PLACES.map(|place| middle_m + place * half_m);
        Tangents {
            places_m,
            start: or_fallback(path.start_direction()),
            // Over half of the link's length, so that no corner of the path shows in its turn.
            links: std::array::from_fn(|link| {
                let (centre_m, reach_m) = (places_m[link], 0.5 * LENGTHS[link] * half_m);
                or_fallback(path.at(centre_m + reach_m) - path.at(centre_m - reach_m))
            }),
            end: or_fallback(path.end_direction()),
        }
    }

    /// The x axis of each link: the mean of what origin and insertion carry along the path to it, as a straight muscle's
    /// is of what its bones carry.
    fn across_links(&self, carries: [DMat3; 2], ways: &Tangents, tracing: &PathBuffers) -> [DVec3; LINKS] {
        let [by_origin, by_insertion] =
            [0, 1].map(|end| (carries[end] * self.across[end]).normalize_or_zero());
        let mut from_origin = [DVec3::ZERO; LINKS];
        let mut carried = ParallelTransport::new(ways.start, rejected(ways.start, by_origin));
        let mut link = 0;
        for (_, end_m, way) in tracing.path.segments() {
            carried.turn(way);
            while link < LINKS && ways.places_m[link] <= end_m {
                from_origin[link] = carried.towards(ways.links[link]);
                link += 1;
            }
        }
        while link < LINKS {
            from_origin[link] = carried.towards(ways.links[link]);
            link += 1;
        }
        let mut from_insertion = [DVec3::ZERO; LINKS];
        let mut carried = ParallelTransport::new(ways.end, rejected(ways.end, by_insertion));
        let mut left = LINKS;
        for (start_m, _, way) in tracing.path.segments().rev() {
            carried.turn(way);
            while left > 0 && ways.places_m[left - 1] >= start_m {
                left -= 1;
                from_insertion[left] = carried.towards(ways.links[left]);
            }
        }
        while left > 0 {
            left -= 1;
            from_insertion[left] = carried.towards(ways.links[left]);
        }
        std::array::from_fn(|link| {
            let way = ways.links[link];
            square_to(way, 0.5 * (from_origin[link] + from_insertion[link]))
                .or_else(|| square_to(way, from_origin[link]))
                .unwrap_or_else(|| any_perpendicular(way))
        })
    }
}

/// Unit directions along a path.
struct Tangents {
    /// Arc length at each link's centre, m.
    places_m: [f64; LINKS],
    start: DVec3,
    links: [DVec3; LINKS],
    end: DVec3,
}

/// A direction carried along a path without twist.
#[derive(Debug, Clone, Copy)]
struct ParallelTransport {
    way: DVec3,
    across: DVec3,
}

impl ParallelTransport {
    fn new(way: DVec3, across: DVec3) -> Self {
        Self { way, across }
    }

    /// Goes on where the path turns to `way` (unit).
    fn turn(&mut self, way: DVec3) {
        self.across = self.towards(way);
        self.way = way;
    }

    /// The direction as it would be where the path turns to `way` (unit).
    fn towards(&self, way: DVec3) -> DVec3 {
        DQuat::from_rotation_arc(self.way, way) * self.across
    }
}

fn rejected(along: DVec3, direction: DVec3) -> DVec3 {
    direction - along * along.dot(direction)
}

/// Half width of the widest ellipse with this centre and half length on the axis of the unit circle that stays within it.
///
/// Where they touch, `c² B/(B - a²) + B = 1` for `B` the half width squared; the larger root is the one within.
fn inscribed_width(centre: f64, length: f64) -> f64 {
    let sum = 1.0 + length * length - centre * centre;
    (0.5 * (sum + (sum * sum - 4.0 * length * length).sqrt())).sqrt()
}
