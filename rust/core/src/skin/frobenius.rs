//! The size of a matrix.

use glam::Mat3A;

/// The square of the Frobenius norm: the sum of the squares of all entries.
pub(super) fn frobenius_squared(matrix: &Mat3A) -> f32 {
    matrix.x_axis.length_squared() + matrix.y_axis.length_squared() + matrix.z_axis.length_squared()
}
