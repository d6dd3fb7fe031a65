//! A tissue: anything that moves skin, as a short list of ellipsoids in the rest pose
//! (mathematics/muscles.md, Tissues; thesis, sec. 3.3; Wilhelms 1997, sec. 3-4).

use glam::{DMat3, DQuat, DVec3};

use crate::ellipsoid::Ellipsoid;
use crate::error::{Error, Result, require};
use crate::muscles::muscle::{Attachment, Muscle};

/// Widths of a bone's shaft over the widths of its ends (Wilhelms 1997).
const SHAFT_WIDTH: f64 = 0.6;
/// Longest end of a bone, as a fraction of its half length.
const LONGEST_END: f64 = 0.5;
/// Largest volume keeping.
const LARGEST_VOLUME_KEEPING: f64 = 1.5;

/// The kinds of tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TissueKind {
    /// A belly between two tendons.
    Muscle,
    /// A shaft with two ends, rigid with its bone.
    Bone,
    /// One ellipsoid, rigid with its bone.
    Stuffing,
    /// One ellipsoid at a joint; muscles can wrap around it.
    Sphere,
}

/// The input of [`Tissue::new`], unchecked.
#[derive(Debug, Clone)]
pub struct TissueDescription {
    /// Name, unique in a musculature.
    pub name: String,
    /// Kind.
    pub kind: TissueKind,
    /// Index of the origin bone; for a rigid kind, the bone that it moves with.
    pub origin_bone: i64,
    /// Index of the insertion bone; for a rigid kind, the origin bone.
    pub insertion_bone: i64,
    /// Centre of the ellipsoid at rest, armature space, m.
    pub centre: [f64; 3],
    /// Rotation at rest, (w, x, y, z); local z points from origin to insertion. It is normalised.
    pub rotation: [f64; 4],
    /// Semi-axes, m, above 0.
    pub semi_axes: [f64; 3],
    /// Length of the tendon at the origin, m, 0 or more.
    pub origin_tendon_m: f64,
    /// Length of the tendon at the insertion, m, 0 or more.
    pub insertion_tendon_m: f64,
    /// Volume keeping, 0..1.5 (mathematics/muscles.md, Volume keeping).
    pub volume_keeping: f64,
    /// Via points of a muscle, from origin to insertion: index of the bone, and the point at rest, armature
    /// space, m.
    pub via_points: Vec<(i64, [f64; 3])>,
    /// Names of the spheres that a muscle wraps around.
    pub wraps: Vec<String>,
}

/// A tissue in the rest pose, checked.
#[derive(Debug, Clone)]
pub struct Tissue {
    name: String,
    kind: TissueKind,
    origin_bone: usize,
    insertion_bone: usize,
    envelope: Ellipsoid,
    ellipsoids: Vec<Ellipsoid>,
    muscle: Option<Muscle>,
    via_points: Vec<Attachment>,
    wraps: Vec<String>,
}

impl Tissue {
    /// Checks a description.
    ///
    /// # Errors
    /// [`Error::Value`] for a number outside its limits or a negative bone index; [`Error::RigidAcrossBones`]
    /// or [`Error::RigidAndCurved`] for a rigid kind.
    pub fn new(description: TissueDescription) -> Result<Self> {
        let TissueDescription {
            name,
            kind,
            origin_bone,
            insertion_bone,
            ..
        } = description.clone();
        let origin_bone = bone_of(&name, "its origin bone", origin_bone)?;
        let insertion_bone = bone_of(&name, "its insertion bone", insertion_bone)?;
        if kind != TissueKind::Muscle && origin_bone != insertion_bone {
            return Err(Error::RigidAcrossBones {
                tissue: name,
                origin: origin_bone,
                insertion: insertion_bone,
            });
        }
        let via_points = via_points_of(&description)?;
        let wraps = description.wraps.clone();
        if kind != TissueKind::Muscle && !(via_points.is_empty() && wraps.is_empty()) {
            return Err(Error::RigidAndCurved { tissue: name });
        }
        let envelope = envelope_of(&description)?;
        let muscle = muscle_of(&description, &envelope, origin_bone, insertion_bone)?;
        let ellipsoids = if kind == TissueKind::Bone {
            shaft_and_ends(&envelope).to_vec()
        } else {
            vec![envelope]
        };
        Ok(Self {
            name,
            kind,
            origin_bone,
            insertion_bone,
            envelope,
            ellipsoids,
            muscle: (kind == TissueKind::Muscle).then_some(muscle),
            via_points,
            wraps,
        })
    }

    /// Name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Kind.
    pub fn kind(&self) -> TissueKind {
        self.kind
    }

    /// Index of the origin bone.
    pub fn origin_bone(&self) -> usize {
        self.origin_bone
    }

    /// Index of the insertion bone.
    pub fn insertion_bone(&self) -> usize {
        self.insertion_bone
    }

    /// The ellipsoid that the user sees and edits: the belly of a muscle, the envelope of a bone; armature
    /// space, m.
    pub fn envelope(&self) -> &Ellipsoid {
        &self.envelope
    }

    /// The ellipsoids of the tissue, armature space, m. For a curved muscle, the ellipsoid that it would have
    /// if it were straight, because its chain depends on the spheres of its musculature.
    pub fn ellipsoids(&self) -> &[Ellipsoid] {
        &self.ellipsoids
    }

    /// The muscle; `None` for rigid kinds.
    pub fn muscle(&self) -> Option<&Muscle> {
        self.muscle.as_ref()
    }

    /// Via points of a muscle, from origin to insertion.
    pub fn via_points(&self) -> &[Attachment] {
        &self.via_points
    }

    /// Names of the spheres that a muscle wraps around.
    pub fn wraps(&self) -> &[String] {
        &self.wraps
    }

    /// True for a muscle with via points or wraps.
    pub fn is_curved(&self) -> bool {
        !(self.via_points.is_empty() && self.wraps.is_empty())
    }

    /// Rest volume of [`Tissue::ellipsoids`], m³.
    pub fn volume(&self) -> f64 {
        self.ellipsoids.iter().map(Ellipsoid::volume).sum()
    }
}

/// The shaft over the whole length with 0.6 of the widths, and an end with the full widths on each side.
pub(crate) fn shaft_and_ends(envelope: &Ellipsoid) -> [Ellipsoid; 3] {
    let DVec3 { x, y, z } = envelope.semi_axes;
    let end = x.max(y).min(LONGEST_END * z);
    let at = |offset: f64, semi_axes: DVec3| Ellipsoid {
        centre: envelope.centre + envelope.axes.z_axis * offset,
        axes: envelope.axes,
        semi_axes,
    };
    [
        at(0.0, DVec3::new(SHAFT_WIDTH * x, SHAFT_WIDTH * y, z)),
        at(end - z, DVec3::new(x, y, end)),
        at(z - end, DVec3::new(x, y, end)),
    ]
}

fn bone_of(tissue: &str, end: &'static str, found: i64) -> Result<usize> {
    let thing = || format!("Tissue \"{tissue}\"");
    require(
        found >= 0,
        thing,
        end,
        found as f64,
        "the index of a bone, 0 or more",
    )
    .map(|_| found as usize)
}

fn via_points_of(description: &TissueDescription) -> Result<Vec<Attachment>> {
    let thing = || format!("Tissue \"{}\"", description.name);
    let checked = |&(bone, point): &(i64, [f64; 3])| {
        for found in point {
            let quantity = "a coordinate of a via point (m)";
            require(found.is_finite(), thing, quantity, found, "finite")?;
        }
        let bone = bone_of(&description.name, "the bone of a via point", bone)?;
        let point = point.into();
        Ok(Attachment { bone, point })
    };
    description.via_points.iter().map(checked).collect()
}

fn envelope_of(description: &TissueDescription) -> Result<Ellipsoid> {
    let thing = || format!("Tissue \"{}\"", description.name);
    for found in description.centre {
        require(
            found.is_finite(),
            thing,
            "a coordinate of its centre (m)",
            found,
            "finite",
        )?;
    }
    for found in description.semi_axes {
        let allowed = found.is_finite() && found > 0.0;
        require(allowed, thing, "a semi-axis (m)", found, "finite and above 0")?;
    }
    let [w, x, y, z] = description.rotation;
    let rotation = DQuat::from_xyzw(x, y, z, w);
    let length = rotation.length();
    let allowed = length.is_finite() && length > 1e-6;
    require(
        allowed,
        thing,
        "the length of its rotation quaternion",
        length,
        "finite and above 0",
    )?;
    Ok(Ellipsoid {
        centre: description.centre.into(),
        axes: DMat3::from_quat(rotation.normalize()),
        semi_axes: description.semi_axes.into(),
    })
}

fn muscle_of(
    description: &TissueDescription,
    belly: &Ellipsoid,
    origin_bone: usize,
    insertion_bone: usize,
) -> Result<Muscle> {
    let thing = || format!("Tissue \"{}\"", description.name);
    let tendon = |found: f64, quantity| {
        require(
            found.is_finite() && found >= 0.0,
            thing,
            quantity,
            found,
            "finite and 0 or more",
        )
    };
    let origin_tendon_m = tendon(description.origin_tendon_m, "its origin tendon (m)")?;
    let insertion_tendon_m = tendon(description.insertion_tendon_m, "its insertion tendon (m)")?;
    let found = description.volume_keeping;
    let allowed = (0.0..=LARGEST_VOLUME_KEEPING).contains(&found);
    let volume_keeping = require(allowed, thing, "its volume keeping", found, "0 to 1.5")?;
    let along = |distance: f64| belly.centre + belly.axes.z_axis * distance;
    Ok(Muscle {
        origin: Attachment {
            bone: origin_bone,
            point: along(-belly.semi_axes.z - origin_tendon_m),
        },
        insertion: Attachment {
            bone: insertion_bone,
            point: along(belly.semi_axes.z + insertion_tendon_m),
        },
        axes: belly.axes,
        belly_m: 2.0 * belly.semi_axes.z,
        origin_tendon_m,
        insertion_tendon_m,
        volume_keeping,
    })
}
