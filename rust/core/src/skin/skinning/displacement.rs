//! Affine maps, stored as displacements.

use glam::{DAffine3, DMat3, Mat3A, Vec3A};

/// The displacement `x -> linear · x + shift` of an affine map, to be added to x. It vanishes at rest,
/// where f32 is exact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Displacement {
    pub linear: Mat3A,
    pub shift: Vec3A,
}

impl Displacement {
    pub const NONE: Self = Self {
        linear: Mat3A::ZERO,
        shift: Vec3A::ZERO,
    };

    pub fn of(map: &DAffine3) -> Self {
        let linear = map.matrix3 - DMat3::IDENTITY;
        Self {
            linear: Mat3A::from(linear.as_mat3()),
            shift: Vec3A::from(map.translation.as_vec3()),
        }
    }

    pub fn at(&self, point: Vec3A) -> Vec3A {
        self.linear * point + self.shift
    }
}
