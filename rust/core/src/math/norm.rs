//! The norm of a matrix.

use glam::Mat3A;

/// The square of the Frobenius norm: the sum of the squares of all entries.
pub(crate) fn frobenius_squared(matrix: &Mat3A) -> f32 {
    let Mat3A {
        x_axis: x,
        y_axis: y,
        z_axis: z,
    } = *matrix;
    (x * x + y * y + z * z).element_sum()
}
