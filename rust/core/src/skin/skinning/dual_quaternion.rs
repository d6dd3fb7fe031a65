//! A bone's matrix as a dual quaternion, as Blender converts it. The rotation keeps the y axis of the
//! posed bone. What remains of the matrix is scale and shear, which act before the rotation
//! (mathematics/skinning.md, Dual quaternions).

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec4};

use crate::pose::any_perpendicular;
use crate::skin::skinning::displacement::Displacement;

/// Largest deviation from an orthonormal matrix with which a bone counts as rigid, as in Blender.
pub(crate) const BLENDERS_TOLERANCE: f64 = 1e-5;
/// The same for anchors, which need not match Blender. Measured: rounding of f32 alone gives 1.1e-5 at
/// the thighs of a walking body, and bones that stretch cost twice the time. The tolerance moves skin
/// half a metre away by a hundredth of a millimetre.
pub(crate) const WIDE_TOLERANCE: f64 = 5e-5;
/// Largest deviation of a bone's size from 1 with which it counts as unscaled, as in Blender.
const SCALE_TOLERANCE: f64 = 1e-4;

/// The rigid part of a bone: the real and the dual quaternion as x, y, z, w.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DualQuaternion {
    pub real: Vec4,
    pub dual: Vec4,
}

impl DualQuaternion {
    pub const IDENTITY: Self = Self {
        real: Vec4::W,
        dual: Vec4::ZERO,
    };

    /// The rigid part of the skinning matrix `matrix` of a bone with this `rest` matrix, and the rest of
    /// it as a displacement that acts before; `None` if it is rigid.
    pub fn of(matrix: &DAffine3, rest: &DAffine3, tolerance: f64) -> (Self, Option<Displacement>) {
        let posed = *matrix * *rest;
        if is_rotation(matrix.matrix3, posed.matrix3, tolerance) {
            return (Self::rigid(matrix), None);
        }
        let rotation = DMat3::from_quat(DQuat::from_mat3(&rotation_keeping_y(posed.matrix3)));
        let rigid = DAffine3 {
            matrix3: rotation,
            translation: posed.translation,
        } * rest.inverse();
        let quaternion = DQuat::from_mat3(&orthonormalised(rigid.matrix3));
        let rigid = DAffine3 {
            matrix3: DMat3::from_quat(quaternion),
            translation: rigid.translation,
        };
        let stretch = Displacement::of(&(rigid.inverse() * *matrix));
        (Self::rigid(&rigid), Some(stretch))
    }

    fn rigid(map: &DAffine3) -> Self {
        let real = DQuat::from_mat3(&map.matrix3).normalize();
        let dual = (pure(map.translation) * real) * 0.5;
        Self {
            real: real.as_quat().into(),
            dual: dual.as_quat().into(),
        }
    }

    /// The same map with the other sign.
    pub fn flipped(self) -> Self {
        Self {
            real: -self.real,
            dual: -self.dual,
        }
    }
}

fn pure(v: DVec3) -> DQuat {
    DQuat::from_xyzw(v.x, v.y, v.z, 0.0)
}

/// Whether a bone counts as a rotation without scale, up to `tolerance`.
fn is_rotation(matrix: DMat3, posed: DMat3, tolerance: f64) -> bool {
    let gram = matrix.transpose() * matrix - DMat3::IDENTITY;
    let is_orthonormal = gram.to_cols_array().iter().all(|entry| entry.abs() <= tolerance);
    let sizes = DVec3::new(
        posed.x_axis.length(),
        posed.y_axis.length(),
        posed.z_axis.length(),
    );
    is_orthonormal && matrix.determinant() >= 0.0 && (sizes - DVec3::ONE).length() <= SCALE_TOLERANCE
}

/// The rotation of a posed bone: its y axis is kept, the others are made perpendicular to it,
/// right-handed. Where columns vanish, the axes are those that Blender takes.
fn rotation_keeping_y(posed: DMat3) -> DMat3 {
    let y = posed.y_axis.try_normalize().unwrap_or_else(|| any_y_axis(posed));
    let from_x = y.dot(posed.x_axis) < 1.0;
    let by_x = || posed.x_axis.cross(y).try_normalize();
    let by_z = || y.cross(posed.z_axis).try_normalize().map(|x| x.cross(y));
    let z = if from_x {
        by_x().or_else(by_z)
    } else {
        by_z().or_else(by_x)
    };
    let z = z.unwrap_or_else(|| any_perpendicular(y));
    DMat3::from_cols(y.cross(z), y, z)
}

fn any_y_axis(posed: DMat3) -> DVec3 {
    posed
        .z_axis
        .cross(posed.x_axis)
        .try_normalize()
        .unwrap_or(DVec3::Y)
}

fn orthonormalised(linear: DMat3) -> DMat3 {
    rotation_keeping_y(linear)
}
