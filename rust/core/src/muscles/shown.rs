//! How Blender objects show posed tissues: by a delta transform on top of their rest transform.
//!
//! Such an object is a child of the tissue's origin bone. Its own transform is the tissue in the rest pose,
//! which the user edits, so the pose must not change it. Blender has a second transform for this, the
//! *delta*: locations are added, rotations and scales are multiplied (`BKE_object_to_mat3`,
//! `BKE_object_to_mat4`).

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, EulerRot};

use crate::error::Result;
use crate::pose::{ColumnMajor, affine, inverse};

/// An object that shows a tissue.
#[derive(Debug, Clone)]
pub struct ShownTissue {
    /// Index of its parent bone.
    bone: usize,
    /// From the space of that bone to the space of the object's own transform.
    from_bone: DAffine3,
    rest: Transform,
    order: AngleOrder,
}

/// Location, rotation and scale of an object.
#[derive(Debug, Clone, Copy)]
pub struct Transform {
    /// Location, m.
    pub location: DVec3,
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Scale of the unit sphere: semi-axes, m.
    pub scale: DVec3,
}

/// The delta transform of an object.
#[derive(Debug, Clone, Copy)]
pub struct Delta {
    /// Added to the location, m.
    pub location: DVec3,
    /// Applied after the rotation; unit quaternion.
    pub rotation: DQuat,
    /// The same rotation as angles about x, y and z, rad, in the object's order.
    pub angles: DVec3,
    /// Multiplies the scale, per axis.
    pub scale: DVec3,
}

/// The order in which three rotations about fixed axes are applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AngleOrder {
    /// About x, then y, then z.
    Xyz,
    /// About x, then z, then y.
    Xzy,
    /// About y, then x, then z.
    Yxz,
    /// About y, then z, then x.
    Yzx,
    /// About z, then x, then y.
    Zxy,
    /// About z, then y, then x.
    Zyx,
}

impl ShownTissue {
    /// An object whose parent is bone `bone` and whose own transform is `rest`. `to_bone` maps the space of
    /// that transform to the axes of the bone, from its head.
    ///
    /// # Errors
    /// [`crate::Error::Projective`] or [`crate::Error::Singular`], which call the object `name`.
    pub fn new(
        bone: usize,
        to_bone: &ColumnMajor,
        rest: Transform,
        order: AngleOrder,
        name: &str,
    ) -> Result<Self> {
        let thing = || format!("Parent matrix of {name}");
        let to_bone = affine(to_bone, thing)?;
        Ok(Self {
            bone,
            from_bone: inverse(&to_bone, thing)?,
            rest,
            order,
        })
    }

    /// Index of the parent bone.
    pub fn bone(&self) -> usize {
        self.bone
    }

    /// The delta that maps the unit sphere to `posed`, with the parent bone at `bone` (both armature space).
    /// [`Delta::IDENTITY`] if the bone or the object has no size.
    pub fn delta(&self, bone: &ColumnMajor, posed: &ColumnMajor) -> Delta {
        let [bone, posed] =
            [bone, posed].map(|matrix| DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from))));
        let shown = self.from_bone * bone.inverse() * posed;
        let (rotation, size) = rotation_and_scale(shown.matrix3);
        let scale = size / self.rest.scale;
        if !(shown.is_finite() && scale.is_finite()) {
            return Delta::IDENTITY;
        }
        let rotation = rotation * self.rest.rotation.inverse();
        Delta {
            location: shown.translation - self.rest.location,
            rotation,
            angles: self.order.angles(rotation),
            scale,
        }
    }
}

impl Delta {
    /// No change.
    pub const IDENTITY: Self = Self {
        location: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        angles: DVec3::ZERO,
        scale: DVec3::ONE,
    };
}

impl AngleOrder {
    /// The angles about x, y and z of `rotation`.
    pub fn angles(self, rotation: DQuat) -> DVec3 {
        let about = |order| rotation.to_euler(order);
        match self {
            Self::Xyz => about(EulerRot::XYZEx).into(),
            Self::Xzy => {
                let (x, z, y) = about(EulerRot::XZYEx);
                DVec3::new(x, y, z)
            }
            Self::Yxz => {
                let (y, x, z) = about(EulerRot::YXZEx);
                DVec3::new(x, y, z)
            }
            Self::Yzx => {
                let (y, z, x) = about(EulerRot::YZXEx);
                DVec3::new(x, y, z)
            }
            Self::Zxy => {
                let (z, x, y) = about(EulerRot::ZXYEx);
                DVec3::new(x, y, z)
            }
            Self::Zyx => {
                let (z, y, x) = about(EulerRot::ZYXEx);
                DVec3::new(x, y, z)
            }
        }
    }
}

/// The rotation and the scale of a map, in the sense rotation after scale; shear is dropped. A mirrored map
/// has negative scales.
fn rotation_and_scale(map: DMat3) -> (DQuat, DVec3) {
    let side = map.determinant().signum();
    let axes = [map.x_axis, map.y_axis, map.z_axis];
    let [x, y, z] = axes.map(|axis| side * axis.normalize_or_zero());
    let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, z)).normalize();
    (rotation, side * DVec3::from_array(axes.map(DVec3::length)))
}
