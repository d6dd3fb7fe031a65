//! The belly of a curved muscle: a chain of ellipsoids along its path (mathematics/paths.md, Belly chain).
//!
//! The ellipsoids ("links") are inscribed in the one ellipsoid that a straight muscle of the same length
//! would have, so that a straight chain looks like that ellipsoid. All links change shape by the same factors
//! as the belly: each keeps its fraction of the volume.

use glam::{DMat3, DQuat, DVec3};

use crate::ellipsoid::Ellipsoid;
use crate::muscles::muscle::{Muscle, handedness, perpendicular_part};
use crate::muscles::muscle_path::{MusclePath, PathBuffers};
use crate::pose::{Palette, any_perpendicular};

/// Number of links.
pub const LINKS: usize = 5;
/// The middle link, which represents the whole belly.
const MIDDLE: usize = LINKS / 2;
/// Centre of each link along the belly, -1..1. With [`LENGTHS`] these fill the ellipsoid best: to at least
/// nine tenths of its width, over nine tenths of its length.
pub(crate) const POSITIONS: [f64; LINKS] = [-0.64, -0.33, 0.0, 0.33, 0.64];
/// Half length of each link over the half length of the belly.
pub(crate) const LENGTHS: [f64; LINKS] = [0.33, 0.45, 0.45, 0.45, 0.33];

/// A curved muscle at rest.
#[derive(Debug, Clone)]
pub struct BellyChain {
    muscle_path: MusclePath,
    /// The muscle, with the length of the curved belly.
    muscle: Muscle,
    /// Semi-axes of the belly across its length, m.
    widths_m: [f64; 2],
    /// The ellipsoid that the muscle's Empty shows at rest.
    envelope: Ellipsoid,
    /// The x axis of the middle link, transported along the path to origin and insertion.
    across: [DVec3; 2],
    /// The pose of each link at rest.
    rest: [LinkPose; LINKS],
}

/// The centre and axes of a link.
#[derive(Debug, Clone, Copy)]
pub struct LinkPose {
    /// Centre, m.
    pub centre: DVec3,
    /// Orthonormal axes; z is along the path.
    pub axes: DMat3,
}

/// A curved muscle in one pose.
#[derive(Debug, Clone, Copy)]
pub struct PosedBellyChain {
    /// The links.
    pub links: [LinkPose; LINKS],
    /// Uniform scale by which the two bones scale the muscle.
    pub scale: f64,
    /// Posed semi-axes over scaled rest semi-axes, the same for all links; z is the stretch.
    pub shape: DVec3,
    /// True if the belly is close to its minimum length.
    pub is_clamped: bool,
}

impl BellyChain {
    /// The chain of `muscle` on `muscle_path`. `envelope` is the belly's ellipsoid if the muscle were
    /// straight.
    pub fn new(muscle_path: MusclePath, muscle: &Muscle, envelope: Ellipsoid, at_rest: &Palette) -> Self {
        let mut buffers = PathBuffers::default();
        muscle_path.trace(at_rest, 1.0, &mut buffers);
        let tendons_m = muscle.origin_tendon_m + muscle.insertion_tendon_m;
        let mut chain = Self {
            muscle_path,
            muscle: Muscle {
                belly_m: buffers.path.length() - tendons_m,
                ..muscle.clone()
            },
            widths_m: [envelope.semi_axes.x, envelope.semi_axes.y],
            envelope,
            across: [DVec3::ZERO; 2],
            rest: [LinkPose {
                centre: envelope.centre,
                axes: envelope.axes,
            }; LINKS],
        };
        let tangents = chain.tangents(&buffers, 0.5 * chain.muscle.belly_m, envelope.axes.z_axis);
        let middle = tangents.links[MIDDLE];
        let middle_across =
            perpendicular_part(middle, envelope.axes.x_axis).unwrap_or_else(|| any_perpendicular(middle));
        let middle_m = tangents.positions_m[MIDDLE];
        let mut back = ParallelTransport::new(middle, middle_across);
        let before = buffers.path.segments().rev();
        before
            .filter(|(start_m, ..)| *start_m < middle_m)
            .for_each(|(.., tangent)| back.follow(tangent));
        let mut forth = ParallelTransport::new(middle, middle_across);
        let after = buffers.path.segments();
        after
            .filter(|(_, end_m, _)| *end_m > middle_m)
            .for_each(|(.., tangent)| forth.follow(tangent));
        chain.across = [back.transported(tangents.start), forth.transported(tangents.end)];
        chain.rest = chain.posed(at_rest, 0.0, &mut buffers).links;
        chain
    }

    /// Writes the path of a pose to `buffers`.
    pub fn trace(&self, palette: &Palette, buffers: &mut PathBuffers) {
        self.muscle_path
            .trace(palette, self.muscle.scale(palette), buffers);
    }

    /// Rest volume of the belly, m³: of one ellipsoid as long as the path. Each link keeps a fixed fraction
    /// of it.
    pub fn volume(&self) -> f64 {
        self.belly().volume()
    }

    /// The links at rest, armature space, m.
    pub fn links(&self) -> [Ellipsoid; LINKS] {
        std::array::from_fn(|link| {
            let LinkPose { centre, axes } = self.rest[link];
            Ellipsoid {
                centre,
                axes,
                semi_axes: self.semi_axes(link),
            }
        })
    }

    /// Semi-axes of a link at rest, m.
    pub fn semi_axes(&self, link: usize) -> DVec3 {
        let (position, length) = (POSITIONS[link], LENGTHS[link]);
        let width = inscribed_width(position, length);
        self.belly().semi_axes * DVec3::new(width, width, length)
    }

    /// The chain in a pose with `tension` 0..1. Writes its path to `buffers`.
    pub fn posed(&self, palette: &Palette, tension: f64, buffers: &mut PathBuffers) -> PosedBellyChain {
        let [origin, insertion] = [self.muscle.origin.bone, self.muscle.insertion.bone];
        let (matrices, scale) = (palette.skinning_matrices(), self.muscle.scale(palette));
        let [by_origin_bone, by_insertion_bone] = [origin, insertion].map(|bone| matrices[bone].matrix3);
        self.muscle_path.trace(palette, scale, buffers);
        let (stretch, is_clamped) = self.muscle.stretch(buffers.path.length(), scale);
        let shape = self.muscle.shape(stretch, tension);
        let fallback = (by_origin_bone * self.envelope.axes.z_axis)
            .try_normalize()
            .unwrap_or(self.envelope.axes.z_axis);
        let half_m = 0.5 * self.muscle.belly_m * scale * shape.z;
        let tangents = self.tangents(buffers, half_m, fallback);
        let across = self.across_links([by_origin_bone, by_insertion_bone], &tangents, buffers);
        let hand = handedness(by_origin_bone);
        let links = std::array::from_fn(|link| {
            let (along, across) = (tangents.links[link], across[link]);
            LinkPose {
                centre: buffers.path.at(tangents.positions_m[link]),
                axes: DMat3::from_cols(across, along.cross(across) * hand, along),
            }
        });
        PosedBellyChain {
            links,
            scale,
            shape,
            is_clamped,
        }
    }

    /// The ellipsoid that shows a posed chain: the envelope of the rest pose with the chain's shape, moved as
    /// the middle link is.
    pub fn shown(&self, posed: &PosedBellyChain) -> Ellipsoid {
        let (rest, now) = (&self.rest[MIDDLE], &posed.links[MIDDLE]);
        let rotation = now.axes * rest.axes.transpose();
        Ellipsoid {
            centre: now.centre + rotation * (self.envelope.centre - rest.centre) * posed.scale,
            axes: rotation * self.envelope.axes,
            semi_axes: self.envelope.semi_axes * posed.shape * posed.scale,
        }
    }

    /// The ellipsoid of a straight belly of the same length and widths.
    fn belly(&self) -> Ellipsoid {
        let [x, y] = self.widths_m;
        Ellipsoid {
            semi_axes: DVec3::new(x, y, 0.5 * self.muscle.belly_m),
            ..self.envelope
        }
    }

    /// Where the middle of the belly is along the path, 0..1.
    fn middle_fraction(&self) -> f64 {
        let Muscle {
            belly_m,
            origin_tendon_m,
            insertion_tendon_m,
            ..
        } = self.muscle;
        (origin_tendon_m + 0.5 * belly_m) / (origin_tendon_m + belly_m + insertion_tendon_m)
    }

    /// Path tangents at the start, at each link of a belly with half length `half_m`, and at the end.
    /// `fallback` is the tangent of a path without length.
    fn tangents(&self, buffers: &PathBuffers, half_m: f64, fallback: DVec3) -> Tangents {
        let path = &buffers.path;
        let or_fallback = |tangent: DVec3| tangent.try_normalize().unwrap_or(fallback);
        let middle_m = self.middle_fraction() * path.length();
        let positions_m = POSITIONS.map(|position| middle_m + position * half_m);
        Tangents {
            positions_m,
            start: or_fallback(path.start_direction()),
            // Over half of the link's length, so that a corner of the path does not show in the link's
            // rotation.
            links: std::array::from_fn(|link| {
                let (centre_m, reach_m) = (positions_m[link], 0.5 * LENGTHS[link] * half_m);
                or_fallback(path.at(centre_m + reach_m) - path.at(centre_m - reach_m))
            }),
            end: or_fallback(path.end_direction()),
        }
    }

    /// The x axis of each link: the mean of the axes that are transported along the path from origin and
    /// insertion. A straight muscle takes the mean of the axes of its two bones in the same way.
    fn across_links(
        &self,
        matrices: [DMat3; 2],
        tangents: &Tangents,
        buffers: &PathBuffers,
    ) -> [DVec3; LINKS] {
        let [origin_across, insertion_across] =
            [0, 1].map(|end| (matrices[end] * self.across[end]).normalize_or_zero());
        let mut from_origin = [DVec3::ZERO; LINKS];
        let mut transport = ParallelTransport::new(tangents.start, rejected(tangents.start, origin_across));
        let mut link = 0;
        for (_, end_m, tangent) in buffers.path.segments() {
            transport.follow(tangent);
            while link < LINKS && tangents.positions_m[link] <= end_m {
                from_origin[link] = transport.transported(tangents.links[link]);
                link += 1;
            }
        }
        while link < LINKS {
            from_origin[link] = transport.transported(tangents.links[link]);
            link += 1;
        }
        let mut from_insertion = [DVec3::ZERO; LINKS];
        let mut transport = ParallelTransport::new(tangents.end, rejected(tangents.end, insertion_across));
        let mut left = LINKS;
        for (start_m, _, tangent) in buffers.path.segments().rev() {
            transport.follow(tangent);
            while left > 0 && tangents.positions_m[left - 1] >= start_m {
                left -= 1;
                from_insertion[left] = transport.transported(tangents.links[left]);
            }
        }
        while left > 0 {
            left -= 1;
            from_insertion[left] = transport.transported(tangents.links[left]);
        }
        std::array::from_fn(|link| {
            let tangent = tangents.links[link];
            perpendicular_part(tangent, 0.5 * (from_origin[link] + from_insertion[link]))
                .or_else(|| perpendicular_part(tangent, from_origin[link]))
                .unwrap_or_else(|| any_perpendicular(tangent))
        })
    }
}

/// Unit tangents of a path.
struct Tangents {
    /// Arc length at each link's centre, m.
    positions_m: [f64; LINKS],
    start: DVec3,
    links: [DVec3; LINKS],
    end: DVec3,
}

/// A direction that is moved along a path without twist (mathematics/paths.md, Parallel transport).
#[derive(Debug, Clone, Copy)]
struct ParallelTransport {
    tangent: DVec3,
    across: DVec3,
}

impl ParallelTransport {
    fn new(tangent: DVec3, across: DVec3) -> Self {
        Self { tangent, across }
    }

    /// Moves on to where the path has `tangent` (unit).
    fn follow(&mut self, tangent: DVec3) {
        self.across = self.transported(tangent);
        self.tangent = tangent;
    }

    /// The direction moved to where the path has `tangent` (unit).
    fn transported(&self, tangent: DVec3) -> DVec3 {
        DQuat::from_rotation_arc(self.tangent, tangent) * self.across
    }
}

fn rejected(along: DVec3, direction: DVec3) -> DVec3 {
    direction - along * along.dot(direction)
}

/// Half width of the widest ellipse inscribed in the unit circle with this centre and half length along the
/// axis.
///
/// The curves touch where `c² B/(B - a²) + B = 1`, with `B` the squared half width. The larger root is the
/// inscribed one.
pub(crate) fn inscribed_width(centre: f64, length: f64) -> f64 {
    let sum = 1.0 + length * length - centre * centre;
    (0.5 * (sum + (sum * sum - 4.0 * length * length).sqrt())).sqrt()
}
