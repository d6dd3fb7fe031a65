//! A muscle: a belly between two tendons. It shortens, lengthens and bulges at constant volume
//! (mathematics/muscles.md, Muscle; thesis, sec. 3.3; Wilhelms 1997, sec. 4).
//!
//! A posed belly depends on the rest data and the pose only, never on the frame before.

use glam::{DMat3, DVec3};

use crate::pose::{Palette, any_perpendicular};

/// Minimum stretch: a belly is never shorter than this fraction of its rest length.
pub const STRETCH_FLOOR: f64 = 0.1;
/// Stretch below which the approach to the minimum begins, and the muscle is reported as clamped.
pub const STRETCH_CLAMPED: f64 = 0.2;
/// Fraction of its length that a belly loses to its tendons at full tension.
pub const TENSION_SHORTENING: f64 = 0.3;
/// Path length over rest length below which the path has no direction.
const SMALLEST_RELATIVE_PATH: f64 = 1e-9;
/// Sine of the angle between the belly and an axis below which that axis does not determine the twist.
const SMALLEST_SINE: f64 = 1e-6;

/// A point that is fixed to a bone.
#[derive(Debug, Clone, Copy)]
pub struct Attachment {
    /// Index of the bone.
    pub bone: usize,
    /// The point in the rest pose, armature space, m.
    pub point: DVec3,
}

impl Attachment {
    /// The point in a pose, armature space, m.
    pub fn posed(&self, palette: &Palette) -> DVec3 {
        palette.skinning_matrices()[self.bone].transform_point3(self.point)
    }
}

/// The rest data of a muscle.
///
/// ```
/// use glam::{DMat3, DVec3};
/// use sinew_core::muscles::muscle::{Attachment, Muscle};
/// use sinew_core::{Palette, Skeleton};
///
/// # fn main() -> sinew_core::Result<()> {
/// let at = |z: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., z, 1.];
/// let names = vec!["upper".to_owned(), "lower".to_owned()];
/// let skeleton = Skeleton::new(names, &[-1, 0], &[at(0.0), at(0.3)])?;
/// let muscle = Muscle {
///     origin: Attachment { bone: 0, point: DVec3::new(0.0, 0.0, 0.05) },
///     insertion: Attachment { bone: 1, point: DVec3::new(0.0, 0.0, 0.35) },
///     axes: DMat3::IDENTITY,
///     belly_m: 0.2,
///     origin_tendon_m: 0.05,
///     insertion_tendon_m: 0.05,
///     volume_keeping: 1.0,
/// };
///
/// // the lower bone moves 10 cm towards the upper one: the belly has half of its length
/// let belly = muscle.posed(&Palette::new(&skeleton, &[at(0.0), at(0.2)])?, 0.0);
/// assert!((belly.shape.z - 0.5).abs() < 1e-6);
/// assert!((belly.shape.element_product() - 1.0).abs() < 1e-12); // the same volume
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Muscle {
    /// The attachment on the bone that the muscle starts from.
    pub origin: Attachment,
    /// The attachment on the bone that the muscle moves.
    pub insertion: Attachment,
    /// Axes of the belly at rest; z points from origin to insertion.
    pub axes: DMat3,
    /// Length of the belly at rest, m.
    pub belly_m: f64,
    /// Length of the tendon at the origin, m.
    pub origin_tendon_m: f64,
    /// Length of the tendon at the insertion, m.
    pub insertion_tendon_m: f64,
    /// Exponent p of the change of width: 1 keeps volume and width ratio exactly, 0 keeps the widths.
    pub volume_keeping: f64,
}

/// The belly of a muscle in one pose.
#[derive(Debug, Clone, Copy)]
pub struct Belly {
    /// Centre, m.
    pub centre: DVec3,
    /// Orthonormal axes; left-handed if the origin bone is mirrored.
    pub axes: DMat3,
    /// Uniform scale from the scales of the two bones.
    pub scale: f64,
    /// Posed semi-axes over scaled rest semi-axes; z is the stretch.
    pub shape: DVec3,
    /// True if the belly is close to its minimum length.
    pub is_clamped: bool,
}

impl Muscle {
    /// The belly in a pose with `tension` 0..1.
    pub fn posed(&self, palette: &Palette, tension: f64) -> Belly {
        let matrices = palette.skinning_matrices();
        let (by_origin_bone, by_insertion_bone) = (matrices[self.origin.bone], matrices[self.insertion.bone]);
        let origin = by_origin_bone.transform_point3(self.origin.point);
        let insertion = by_insertion_bone.transform_point3(self.insertion.point);
        let scale = self.scale(palette);
        let path = insertion - origin;
        let path_m = path.length();
        let (stretch, is_clamped) = self.stretch(path_m, scale);
        let rest_m = self.origin_tendon_m + self.belly_m + self.insertion_tendon_m;
        let along = if path_m > SMALLEST_RELATIVE_PATH * rest_m {
            path / path_m
        } else {
            (by_origin_bone.matrix3 * self.axes.z_axis)
                .try_normalize()
                .unwrap_or(self.axes.z_axis)
        };
        let centre = origin + path * ((self.origin_tendon_m + 0.5 * self.belly_m) / rest_m);
        let across = self.across(by_origin_bone.matrix3, by_insertion_bone.matrix3, along);
        let hand = handedness(by_origin_bone.matrix3);
        let axes = DMat3::from_cols(across, along.cross(across) * hand, along);
        Belly {
            centre,
            axes,
            scale,
            shape: self.shape(stretch, tension),
            is_clamped,
        }
    }

    /// Uniform scale from the scales of the two bones.
    pub(crate) fn scale(&self, palette: &Palette) -> f64 {
        let scales = palette.scales();
        (scales[self.origin.bone] * scales[self.insertion.bone]).sqrt()
    }

    /// Belly length over rest belly length for a path of `path_m` at `scale`, kept above the minimum; and
    /// whether it is clamped.
    pub(crate) fn stretch(&self, path_m: f64, scale: f64) -> (f64, bool) {
        let belly_m = path_m - scale * (self.origin_tendon_m + self.insertion_tendon_m);
        let rest_m = scale * self.belly_m;
        let raw = if rest_m > 0.0 { belly_m / rest_m } else { 1.0 };
        (floored(raw), raw < STRETCH_CLAMPED)
    }

    /// Posed over rest semi-axes at constant volume (mathematics/muscles.md, Volume keeping; thesis,
    /// equations for rx, ry, rz; Wilhelms 1997, sec. 4). Tension thickens the belly, also at constant volume.
    pub(crate) fn shape(&self, stretch: f64, tension: f64) -> DVec3 {
        let shortening = 1.0 - TENSION_SHORTENING * tension;
        let width = stretch.powf(-0.5 * self.volume_keeping) / shortening.sqrt();
        DVec3::new(width, width, stretch * shortening)
    }

    /// The x axis: the mean of the rest x axis as moved by the two bones, made perpendicular to the belly. If
    /// the two cancel, the origin bone's alone; if that is along the belly, any perpendicular.
    fn across(&self, by_origin_bone: DMat3, by_insertion_bone: DMat3, along: DVec3) -> DVec3 {
        let origin_across = (by_origin_bone * self.axes.x_axis).normalize_or_zero();
        let insertion_across = (by_insertion_bone * self.axes.x_axis).normalize_or_zero();
        perpendicular_part(along, 0.5 * (origin_across + insertion_across))
            .or_else(|| perpendicular_part(along, origin_across))
            .unwrap_or_else(|| any_perpendicular(along))
    }
}

/// The unit vector perpendicular to `along` (unit) that is nearest to `direction`; `None` if `direction` is
/// along it.
pub(crate) fn perpendicular_part(along: DVec3, direction: DVec3) -> Option<DVec3> {
    let rejected = direction - along * along.dot(direction);
    (rejected.length() > SMALLEST_SINE).then(|| rejected.normalize())
}

/// 1, or -1 for a map that mirrors.
pub(crate) fn handedness(linear: DMat3) -> f64 {
    if linear.determinant() < 0.0 { -1.0 } else { 1.0 }
}

/// `stretch` above [`STRETCH_CLAMPED`]; below, it approaches [`STRETCH_FLOOR`] with a continuous slope.
pub fn floored(stretch: f64) -> f64 {
    if stretch >= STRETCH_CLAMPED {
        return stretch;
    }
    let room = STRETCH_CLAMPED - STRETCH_FLOOR;
    STRETCH_FLOOR + room * ((stretch - STRETCH_CLAMPED) / room).exp()
}
