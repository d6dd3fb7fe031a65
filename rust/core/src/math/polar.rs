//! Warm-started polar decomposition: one step from a rotation towards the rotational part of a matrix (M.
//! Müller et al., "A Robust Method to Extract the Rotational Part of Deformations", 2016;
//! mathematics/relaxation.md, Rotations).
//!
//! Four vertices are computed at a time, one per SIMD lane, because each rotation is a chain of dependent
//! operations.

use glam::{Mat3A, Vec4};

use crate::math::vec3x4::{LANES, Vec3x4};

/// Smallest inertia of a fit that counts, as a fraction of the largest possible inertia. If the edges of a
/// vertex fit two rotations almost equally well, as in an extreme twist, rounding errors would rotate it. In
/// 1,000 random poses the largest such motion was 16 mm without this limit and 2.5 mm with it.
const LEAST_INERTIA: f32 = 0.17;
/// Tangent of half the largest rotation of one step.
const LARGEST_HALF_TURN: f32 = 0.5;

/// Each of `axes` (of any scale) rotated one step towards its matrix in `fits`. Axes whose matrix determines
/// no rotation stay the same.
pub(crate) fn rotate_towards_fit(axes: [Mat3A; LANES], fits: [Mat3A; LANES]) -> [Mat3A; LANES] {
    let axes = Axes::new(axes);
    let half = half_turns(&axes, &Axes::new(fits));
    // Cayley transform: a rotation to the last digit for any length of `half`, so no orthonormalisation is
    // needed
    let across = half.scaled(2.0 / (1.0 + half.dot(half)));
    let turned = axes
        .0
        .map(|axis| axis.plus(across.cross(axis.plus(half.cross(axis)))));
    Axes(turned).apart()
}

/// Rotation vectors with the tangent of half the angle as their length.
fn half_turns(axes: &Axes, fits: &Axes) -> Vec3x4 {
    let [x, y, z] = [0, 1, 2].map(|axis| axes.0[axis].cross(fits.0[axis]));
    let inertia = axes.dot(fits);
    let largest = (axes.dot(axes) * fits.dot(fits)).sqrt();
    let least = (largest * LEAST_INERTIA).max(Vec4::splat(f32::MIN_POSITIVE));
    let half = x.plus(y).plus(z).scaled(0.5 / inertia.abs().max(least));
    let square = half.dot(half);
    let longest = LARGEST_HALF_TURN * LARGEST_HALF_TURN;
    if square.cmple(Vec4::splat(longest)).all() {
        return half;
    }
    half.scaled((LARGEST_HALF_TURN / square.sqrt()).min(Vec4::ONE))
        .finite()
}

/// Four matrices in lanes: the three columns of each.
#[derive(Debug, Clone, Copy)]
struct Axes([Vec3x4; 3]);

impl Axes {
    fn new(matrices: [Mat3A; LANES]) -> Self {
        Self([
            Vec3x4::new(matrices.map(|matrix| matrix.x_axis)),
            Vec3x4::new(matrices.map(|matrix| matrix.y_axis)),
            Vec3x4::new(matrices.map(|matrix| matrix.z_axis)),
        ])
    }

    fn apart(self) -> [Mat3A; LANES] {
        let [x, y, z] = self.0.map(Vec3x4::apart);
        std::array::from_fn(|lane| Mat3A::from_cols(x[lane], y[lane], z[lane]))
    }

    /// The sum of the products of all entries.
    fn dot(&self, other: &Self) -> Vec4 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.0[axis].dot(other.0[axis]));
        x + y + z
    }
}
