//! How objects show posed tissues: by what they add to a transform of their own.
//!
//! Such an object hangs on the tissue's origin bone, and its own transform is the tissue in the rest pose, which a person
//! edits; so the pose must not touch it. Blender has a second transform for that, the *delta*: locations add up, rotations
//! and scales multiply (`BKE_object_to_mat3`, `BKE_object_to_mat4`).

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, EulerRot};

use crate::error::Result;
use crate::pose::{ColumnMajor, affine, inverse};

/// An object that shows a tissue.
#[derive(Debug, Clone)]
pub struct ShownTissue {
    /// Index of the bone that it hangs on.
    bone: usize,
    /// Space of that bone to the one that the object's own transform is in.
    from_bone: DAffine3,
    own: Transform,
    order: AngleOrder,
}

/// Location, rotation and scale of an object.
#[derive(Debug, Clone, Copy)]
pub struct Transform {
    /// m.
    pub location: DVec3,
    /// Unit.
    pub rotation: DQuat,
    /// Of the unit sphere: semi-axes, m.
    pub scale: DVec3,
}

/// What an object adds to its own transform.
#[derive(Debug, Clone, Copy)]
pub struct Delta {
    /// Added to the location, m.
    pub location: DVec3,
    /// Comes after the rotation; unit.
    pub rotation: DQuat,
    /// The same as angles about x, y and z, rad, in the object's order.
    pub angles: DVec3,
    /// Multiplies the scale.
    pub scale: DVec3,
}

/// In which order three angles turn about fixed axes, the first named first.
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
    /// An object on bone `bone` with a transform of its `own`; `to_bone` is the space of that transform in the bone's own
    /// axes, from its head.
    ///
    /// # Errors
    /// A matrix that is not affine or can't be inverted, called `name`.
    pub fn new(
        bone: usize,
        to_bone: &ColumnMajor,
        own: Transform,
        order: AngleOrder,
        name: &str,
    ) -> Result<Self> {
        let thing = || format!("the parent's matrix of {name}");
        let to_bone = affine(to_bone, thing)?;
        Ok(Self {
            bone,
            from_bone: inverse(&to_bone, thing)?,
            own,
            order,
        })
    }

    /// The bone that it hangs on.
    pub fn bone(&self) -> usize {
        self.bone
    }

    /// What shows the unit sphere as `posed` says, on its bone as `bone` says (both armature space); nothing where the
    /// bone, or the object by itself, has no size.
    pub fn delta(&self, bone: &ColumnMajor, posed: &ColumnMajor) -> Delta {
        let [bone, posed] =
            [bone, posed].map(|matrix| DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from))));
        let shown = self.from_bone * bone.inverse() * posed;
        let (rotation, size) = turn_and_size(shown.matrix3);
        let scale = size / self.own.scale;
        if !(shown.is_finite() && scale.is_finite()) {
            return Delta::NOTHING;
        }
        let rotation = rotation * self.own.rotation.inverse();
        Delta {
            location: shown.translation - self.own.location,
            rotation,
            angles: self.order.angles(rotation),
            scale,
        }
    }
}

impl Delta {
    /// Leaves an object as it is by itself.
    pub const NOTHING: Self = Self {
        location: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        angles: DVec3::ZERO,
        scale: DVec3::ONE,
    };
}

impl AngleOrder {
    /// The angles about x, y and z that turn as `rotation` does.
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

/// A map as a rotation after a scale, as near as shear lets it be; a mirror image is scaled by negative numbers.
fn turn_and_size(map: DMat3) -> (DQuat, DVec3) {
    let side = map.determinant().signum();
    let axes = [map.x_axis, map.y_axis, map.z_axis];
    let [x, y, z] = axes.map(|axis| side * axis.normalize_or_zero());
    let turn = DQuat::from_mat3(&DMat3::from_cols(x, y, z)).normalize();
    (turn, side * DVec3::from_array(axes.map(DVec3::length)))
}
