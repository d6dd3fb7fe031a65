//! Vectors of four vertices in SIMD lanes (structure of arrays), so that four chains of dependent operations
//! run at once.

use glam::{Mat4, Vec3A, Vec4};

/// Vertices that are computed together.
pub(crate) const LANES: usize = 4;

/// Four vectors, one per lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vec3x4 {
    pub x: Vec4,
    pub y: Vec4,
    pub z: Vec4,
}

impl Vec3x4 {
    /// The lanes of `vectors`.
    pub fn new(vectors: [Vec3A; LANES]) -> Self {
        let [a, b, c, d] = vectors.map(|vector| vector.extend(0.0));
        let rows = Mat4::from_cols(a, b, c, d).transpose();
        Self {
            x: rows.x_axis,
            y: rows.y_axis,
            z: rows.z_axis,
        }
    }

    /// The vector of each lane.
    pub fn apart(self) -> [Vec3A; LANES] {
        let columns = Mat4::from_cols(self.x, self.y, self.z, Vec4::ZERO).transpose();
        [columns.x_axis, columns.y_axis, columns.z_axis, columns.w_axis].map(Vec3A::from_vec4)
    }

    /// The squared distance of each vector, as a position, from `from`.
    pub fn distances_squared(self, from: Vec3A) -> Vec4 {
        let away = Self {
            x: self.x - from.x,
            y: self.y - from.y,
            z: self.z - from.z,
        };
        away.dot(away)
    }

    pub fn dot(self, other: Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    pub fn plus(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }

    /// Each vector times the lane of `factor`.
    pub fn scaled(self, factor: Vec4) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }

    /// The vectors, with 0 in lanes that are not finite.
    pub fn finite(self) -> Self {
        let is_finite = self.dot(self).is_finite_mask();
        let of = |lanes: Vec4| Vec4::select(is_finite, lanes, Vec4::ZERO);
        Self {
            x: of(self.x),
            y: of(self.y),
            z: of(self.z),
        }
    }
}
