//! A tissue placed on a body, before or after the fit under the skin.
//! (docs/mathematics/fitting.md, Fit under the skin)

use glam::{DMat3, DQuat, DVec3};

use crate::ellipsoid::volume_m3;
use crate::error::{Result, require};
use crate::muscles::polyline::Polyline;
use crate::muscles::tissue::TissueKind;

/// Fraction of its length by which a belly is shortened in one step.
const CUT_OF_BELLY: f64 = 0.08;
/// Largest difference between two tissues that are placed as mirror images, over the half length of the right one.
const MIRRORED_OF_SIZE: f64 = 1e-3;

/// Position, size and via points of a tissue, unchecked.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Its kind.
    pub kind: TissueKind,
    /// Centre of its ellipsoid, armature space, m.
    pub centre: DVec3,
    /// Rotation of its ellipsoid; local z runs from origin to insertion.
    pub rotation: DQuat,
    /// Semi-axes, m, above 0.
    pub semi_axes: DVec3,
    /// Length of the tendon at the origin, m, 0 or more.
    pub origin_tendon_m: f64,
    /// Length of the tendon at the insertion, m, 0 or more.
    pub insertion_tendon_m: f64,
    /// Points that a muscle's path passes, from origin to insertion, armature space, m.
    pub via_points: Vec<DVec3>,
}

/// A tissue placed on a body: an ellipsoid, tendons and via points, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedTissue {
    pub(super) at: Placement,
}

impl PlacedTissue {
    /// The tissue with this placement. `name` is its name in messages.
    ///
    /// # Errors
    /// [`crate::Error::Value`] for a number that is not finite, a rotation of length 0, a semi-axis of 0 or less, or a
    /// negative tendon length.
    pub fn new(at: Placement, name: impl Fn() -> String) -> Result<Self> {
        let points = at.via_points.iter().chain([&at.centre]);
        for number in points
            .flat_map(|point| point.to_array())
            .chain(at.rotation.to_array())
        {
            require(number.is_finite(), &name, "coordinate", number, "finite")?;
        }
        let length = at.rotation.length();
        require(length > 0.0, &name, "length of the rotation", length, "above 0")?;
        for number in at.semi_axes.to_array() {
            let is_valid = number.is_finite() && number > 0.0;
            require(is_valid, &name, "semi-axis (m)", number, "finite and above 0")?;
        }
        for number in [at.origin_tendon_m, at.insertion_tendon_m] {
            let is_valid = number.is_finite() && number >= 0.0;
            require(is_valid, &name, "tendon (m)", number, "finite and 0 or more")?;
        }
        Ok(Self { at })
    }

    /// Its position, size and via points.
    pub fn placement(&self) -> &Placement {
        &self.at
    }

    /// Local x, y and z axes as columns.
    pub(super) fn axes(&self) -> DMat3 {
        DMat3::from_quat(self.at.rotation.normalize())
    }

    /// Origin of a muscle, armature space, m.
    pub(super) fn origin(&self) -> DVec3 {
        self.at.centre - self.axes().z_axis * (self.at.semi_axes.z + self.at.origin_tendon_m)
    }

    /// Insertion of a muscle, armature space, m.
    pub(super) fn insertion(&self) -> DVec3 {
        self.at.centre + self.axes().z_axis * (self.at.semi_axes.z + self.at.insertion_tendon_m)
    }

    /// The polyline from origin to insertion through the via points.
    pub(super) fn path(&self) -> Polyline {
        let mut path = Polyline::default();
        path.line_to(self.origin());
        for &point in &self.at.via_points {
            path.line_to(point);
        }
        path.line_to(self.insertion());
        path
    }

    /// The smaller of the semi-axes along local x and y, m.
    pub(super) fn thickness_m(&self) -> f64 {
        self.at.semi_axes.x.min(self.at.semi_axes.y)
    }

    /// Volume of its ellipsoid, m³.
    pub(super) fn volume_m3(&self) -> f64 {
        volume_m3(self.at.semi_axes)
    }

    /// The same tissue with its centre moved by `step`, m.
    pub(super) fn moved(&self, step: DVec3) -> Self {
        let mut moved = self.clone();
        moved.at.centre += step;
        moved
    }

    /// The same tissue with its semi-axes along local x and y multiplied by these factors.
    pub(super) fn widened(&self, x: f64, y: f64) -> Self {
        let mut widened = self.clone();
        widened.at.semi_axes *= DVec3::new(x, y, 1.0);
        widened
    }

    /// The same tissue with a belly that is shorter at the end nearest to `station`. The tendon of a muscle becomes longer by as
    /// much, so that origin and insertion stay.
    pub(super) fn shortened(&self, station: f64) -> Self {
        let mut shortened = self.clone();
        let cut_m = CUT_OF_BELLY * 2.0 * self.at.semi_axes.z;
        shortened.at.centre -= self.axes().z_axis * (cut_m / 2.0).copysign(station);
        shortened.at.semi_axes.z -= cut_m / 2.0;
        if self.at.kind == TissueKind::Muscle {
            if station > 0.0 {
                shortened.at.insertion_tendon_m += cut_m;
            } else {
                shortened.at.origin_tendon_m += cut_m;
            }
        }
        shortened
    }

    /// Whether this is placed as the mirror image of `left`. If not, the two sides differ on purpose.
    pub(super) fn is_image_of(&self, left: &Self) -> bool {
        let apart_m = mirrored(left.at.centre).distance(self.at.centre);
        let larger_m = left.at.semi_axes.distance(self.at.semi_axes);
        self.at.kind == left.at.kind && apart_m.max(larger_m) < MIRRORED_OF_SIZE * self.at.semi_axes.z
    }

    /// The mirror image of `fitted` across the plane x = 0, with at most as many via points as this tissue has.
    pub(super) fn as_image_of(&self, fitted: &Self) -> Self {
        let axes = fitted.axes();
        let (x, z) = (mirrored(axes.x_axis), mirrored(axes.z_axis));
        let via_points = fitted.at.via_points.iter().take(self.at.via_points.len());
        Self {
            at: Placement {
                centre: mirrored(fitted.at.centre),
                rotation: DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)),
                via_points: via_points.copied().map(mirrored).collect(),
                ..fitted.at
            },
        }
    }
}

/// The mirror image of a point or direction across the plane x = 0.
fn mirrored(vector: DVec3) -> DVec3 {
    DVec3::new(-vector.x, vector.y, vector.z)
}
