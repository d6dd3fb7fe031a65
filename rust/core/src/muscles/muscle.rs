//! A muscle: a belly between two tendons, that shortens, lengthens and bulges at constant volume (ALGORITHM 2; thesis 3.3;
//! Wilhelms 1997, sec. 4).
//!
//! A posed belly depends on the rest data and the pose alone, never on the frame before.

use glam::{DMat3, DVec3};

use crate::pose::{Palette, any_perpendicular};

/// Floor of the stretch: a belly never gets shorter than this share of its rest length.
pub const STRETCH_FLOOR: f64 = 0.1;
/// Stretch under which the floor begins to be felt, and the muscle is reported as clamped.
pub const STRETCH_CLAMPED: f64 = 0.2;
/// Share of its length that a belly gives to the tendons at full tension.
pub const TENSION_SHORTENING: f64 = 0.3;
/// Length of the path, relative to the rest length, under which its direction means nothing.
const SMALLEST_RELATIVE_PATH: f64 = 1e-9;
/// Sine of the angle between belly and carried x axis under which that axis says nothing about the twist.
const SMALLEST_SINE: f64 = 1e-6;

/// A place on a bone.
#[derive(Debug, Clone, Copy)]
pub struct Attachment {
    /// Index of the bone.
    pub bone: usize,
    /// The place in the rest pose, armature space, m.
    pub point: DVec3,
}

impl Attachment {
    /// Where a pose carries it, armature space, m.
    pub fn posed(&self, palette: &Palette) -> DVec3 {
        palette.skinning_matrices()[self.bone].transform_point3(self.point)
    }
}

/// The rest data of a muscle.
#[derive(Debug, Clone)]
pub struct Muscle {
    /// Where it rises.
    pub origin: Attachment,
    /// Where it ends.
    pub insertion: Attachment,
    /// Axes of the belly at rest, z from origin to insertion.
    pub axes: DMat3,
    /// Length of the belly at rest, m.
    pub belly_m: f64,
    /// Length of the tendon at the origin, m.
    pub origin_tendon_m: f64,
    /// Length of the tendon at the insertion, m.
    pub insertion_tendon_m: f64,
    /// p: 1 keeps the volume and the ratio of the widths exactly, 0 keeps the widths.
    pub volume_keeping: f64,
}

/// How the belly of a muscle stands in one pose.
#[derive(Debug, Clone, Copy)]
pub struct Belly {
    /// Centre, m.
    pub centre: DVec3,
    /// Orthonormal axes; mirrored (left-handed) where the origin bone mirrors.
    pub axes: DMat3,
    /// Uniform scale by which the two bones scale the muscle.
    pub scale: f64,
    /// Posed semi-axes over scaled rest semi-axes; z is the stretch.
    pub shape: DVec3,
    /// True where the belly came near its floor.
    pub is_clamped: bool,
}

impl Muscle {
    /// The belly in a pose, under `tension` 0..1.
    pub fn posed(&self, palette: &Palette, tension: f64) -> Belly {
        let carries = palette.skinning_matrices();
        let (carry_o, carry_i) = (carries[self.origin.bone], carries[self.insertion.bone]);
        let origin = carry_o.transform_point3(self.origin.point);
        let insertion = carry_i.transform_point3(self.insertion.point);
        let scale = self.scale(palette);
        let path = insertion - origin;
        let path_m = path.length();
        let (stretch, is_clamped) = self.stretch(path_m, scale);
        let rest_m = self.origin_tendon_m + self.belly_m + self.insertion_tendon_m;
        let along = if path_m > SMALLEST_RELATIVE_PATH * rest_m {
            path / path_m
        } else {
            (carry_o.matrix3 * self.axes.z_axis)
                .try_normalize()
                .unwrap_or(self.axes.z_axis)
        };
        let centre = origin + path * ((self.origin_tendon_m + 0.5 * self.belly_m) / rest_m);
        let across = self.across(carry_o.matrix3, carry_i.matrix3, along);
        let hand = handedness(carry_o.matrix3);
        let axes = DMat3::from_cols(across, along.cross(across) * hand, along);
        Belly {
            centre,
            axes,
            scale,
            shape: self.shape(stretch, tension),
            is_clamped,
        }
    }

    /// Uniform scale by which the two bones scale the muscle.
    pub(crate) fn scale(&self, palette: &Palette) -> f64 {
        let scales = palette.scales();
        (scales[self.origin.bone] * scales[self.insertion.bone]).sqrt()
    }

    /// Belly length over rest belly length for a path of `path_m` at `scale`, kept above the floor, and whether it had
    /// to be kept.
    pub(crate) fn stretch(&self, path_m: f64, scale: f64) -> (f64, bool) {
        let belly_m = path_m - scale * (self.origin_tendon_m + self.insertion_tendon_m);
        let rest_m = scale * self.belly_m;
        let raw = if rest_m > 0.0 { belly_m / rest_m } else { 1.0 };
        (floored(raw), raw < STRETCH_CLAMPED)
    }

    /// Posed over rest semi-axes: the law of constant volume (thesis, eq. for rz, ry, rx; Wilhelms 1997, sec. 4), and an
    /// isometric contraction that thickens at constant volume.
    pub(crate) fn shape(&self, stretch: f64, tension: f64) -> DVec3 {
        let shortening = 1.0 - TENSION_SHORTENING * tension;
        let width = stretch.powf(-0.5 * self.volume_keeping) / shortening.sqrt();
        DVec3::new(width, width, stretch * shortening)
    }

    /// The x axis: the mean of where the two bones carry the rest x axis, made square to the belly; the origin bone's
    /// alone where they oppose, any perpendicular where that runs along the belly.
    fn across(&self, carry_o: DMat3, carry_i: DMat3, along: DVec3) -> DVec3 {
        let by_origin = (carry_o * self.axes.x_axis).normalize_or_zero();
        let by_insertion = (carry_i * self.axes.x_axis).normalize_or_zero();
        square_to(along, 0.5 * (by_origin + by_insertion))
            .or_else(|| square_to(along, by_origin))
            .unwrap_or_else(|| any_perpendicular(along))
    }
}

/// The unit direction square to `along` (unit) that is nearest to `direction`; `None` where that runs along it.
pub(crate) fn square_to(along: DVec3, direction: DVec3) -> Option<DVec3> {
    let rejected = direction - along * along.dot(direction);
    (rejected.length() > SMALLEST_SINE).then(|| rejected.normalize())
}

/// 1, or -1 for a map that mirrors.
pub(crate) fn handedness(linear: DMat3) -> f64 {
    if linear.determinant() < 0.0 { -1.0 } else { 1.0 }
}

/// `stretch` itself above [`STRETCH_CLAMPED`]; below, falling to [`STRETCH_FLOOR`] without a kink.
pub fn floored(stretch: f64) -> f64 {
    if stretch >= STRETCH_CLAMPED {
        return stretch;
    }
    let room = STRETCH_CLAMPED - STRETCH_FLOOR;
    STRETCH_FLOOR + room * ((stretch - STRETCH_CLAMPED) / room).exp()
}
