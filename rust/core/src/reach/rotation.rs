//! Rotation vectors: the exponential map and its derivative (Grassia 1998, sec. 3).

use glam::{DMat3, DQuat, DVec3};

use crate::math::outer::outer;

/// Angle, rad, below which series replace quotients that would lose all digits.
const SMALL_RAD: f64 = 1e-4;

/// The rotation about `vector` by its length, rad.
pub fn exponential(vector: DVec3) -> DQuat {
    DQuat::from_scaled_axis(vector)
}

/// The shortest rotation vector of a unit quaternion, of length 0..π.
pub fn logarithm(rotation: DQuat) -> DVec3 {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    let axis = rotation.xyz();
    let sine = axis.length();
    if sine < 1e-12 {
        2.0 * axis
    } else {
        axis * (2.0 * sine.atan2(rotation.w) / sine)
    }
}

/// The left Jacobian of the exponential map: if `vector` changes by `d`, the rotation changes by the rotation
/// vector `jacobian * d` in the axes before the rotation. It is singular only at lengths 2π, 4π, ...
pub fn exponential_jacobian(vector: DVec3) -> DMat3 {
    let squared = vector.length_squared();
    let angle = squared.sqrt();
    let (cross, square) = if angle < SMALL_RAD {
        (0.5 - squared / 24.0, 1.0 / 6.0 - squared / 120.0)
    } else {
        (
            (1.0 - angle.cos()) / squared,
            (angle - angle.sin()) / (squared * angle),
        )
    };
    let along = outer(vector, vector);
    DMat3::from_diagonal(DVec3::splat(1.0 - square * squared)) + cross_matrix(vector) * cross + along * square
}

/// `cross_matrix(a) * b` is the cross product of `a` and `b`.
fn cross_matrix(a: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, a.z, -a.y),
        DVec3::new(-a.z, 0.0, a.x),
        DVec3::new(a.y, -a.x, 0.0),
    )
}
