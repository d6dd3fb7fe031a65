//! How a vertex's frame is turned towards what its edges fit best: one step of M. Müller et al., "A Robust Method to Extract the
//! Rotational Part of Deformations", 2016, from the turn before.
//!
//! Four vertices at a time, one a lane: each turn is a chain of operations that wait for one another.

use glam::{Mat3A, Vec4};

use crate::math::vec3x4::{LANES, Vec3x4};

/// Least inertia of a fit that counts, over the largest that it could have: edges that fit two turns nearly alike, as those of a far
/// twist do, would else turn a vertex by what f32 rounds off (of 1,000 random poses the worst swayed by 16 mm, with this by 2.5).
const LEAST_INERTIA: f32 = 0.17;
/// Tangent of half of the largest turn of one fit.
const LARGEST_HALF_TURN: f32 = 0.5;

/// The `axes`, of any scale, each turned a step towards its fit; as they are where the fit says nothing.
pub(crate) fn rotate_towards_fit(axes: [Mat3A; LANES], fits: [Mat3A; LANES]) -> [Mat3A; LANES] {
    let axes = Axes::new(axes);
    let half = half_turns(&axes, &Axes::new(fits));
    // Cayley's map of the small turn, a rotation to the last digit for any length: nothing has to be made square again
    let across = half.scaled(2.0 / (1.0 + half.dot(half)));
    let turned = axes
        .0
        .map(|axis| axis.plus(across.cross(axis.plus(half.cross(axis)))));
    Axes(turned).apart()
}

/// The axes that the turns go about, as long as the tangents of their halves.
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

/// The axes of a matrix a lane.
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

    /// Sum of the products of all entries.
    fn dot(&self, other: &Self) -> Vec4 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.0[axis].dot(other.0[axis]));
        x + y + z
    }
}
