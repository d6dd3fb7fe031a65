//! The correction: what to add to a rest position before the Armature modifier, so that the modifier's
//! result is the skin's (mathematics/correction.md).
//!
//! It needs the inverse of the modifier's map, which is singular at a twist of 180° (linear blending) and
//! for a flat bone. Near that the inverse is damped continuously, and its result is bounded.

use glam::{Mat3A, Vec3A, Vec4};

use crate::math::norm::frobenius_squared;
use crate::math::vec3x4::{LANES, Vec3x4};

/// Fullness (determinant over that of a rotation of the same size) below which an inverse is damped. Maps
/// of ordinary poses are well above.
const DAMPED_BELOW: f32 = 0.05;
/// Damping at fullness 0, over the size of the map. A damped inverse lengthens by at most half its
/// reciprocal, 4, the same as [`EXACT_LENGTHENING`].
const STRONGEST_DAMPING: f32 = 0.125;
/// Size of a map (1 for a rotation) below which it is damped as a whole: a bone scaled to nothing.
const SMALL_SIZE: f32 = 0.01;
/// Lengthening, over that of a rotation of the same size, up to which an inverse is exact. Ordinary poses
/// need less.
const EXACT_LENGTHENING: f32 = 4.0;
/// Bound of the lengthening. It is approached with the slope 1 at [`EXACT_LENGTHENING`].
const LARGEST_LENGTHENING: f32 = 8.0;
/// Relative distance from each limit within which the fast exact inverse is not taken, because f32 rounds
/// differently there.
const ROUNDING_MARGIN: f32 = 1e-4;

/// An offset after the modifier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PosedOffset {
    /// The caller's index of the offset.
    pub key: usize,
    /// Linear part of the modifier's map.
    pub linear: Mat3A,
    /// The offset, m.
    pub offset: Vec3A,
}

/// An offset before the modifier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RestOffset {
    /// The offset, m.
    pub offset: Vec3A,
    /// Whether it was damped or bounded, so that its vertex does not land exactly.
    pub is_damped: bool,
}

/// Calls `take` with the key and the inverted offset of each of `all`, four at a time.
pub(crate) fn invert_each(all: impl Iterator<Item = PosedOffset>, mut take: impl FnMut(usize, RestOffset)) {
    let none = PosedOffset {
        key: 0,
        linear: Mat3A::IDENTITY,
        offset: Vec3A::ZERO,
    };
    let (mut batch, mut count) = ([none; LANES], 0);
    for wanted in all {
        batch[count] = wanted;
        count += 1;
        if count == LANES {
            invert_batch(&batch, LANES, &mut take);
            count = 0;
        }
    }
    invert_batch(&batch, count, &mut take);
}

/// Inverts the first `count` of a batch. The others are padding.
fn invert_batch(all: &[PosedOffset; LANES], count: usize, take: &mut impl FnMut(usize, RestOffset)) {
    if let Some(offsets) = exact(all) {
        for (wanted, offset) in all.iter().zip(offsets).take(count) {
            let is_damped = false;
            take(wanted.key, RestOffset { offset, is_damped });
        }
    } else {
        for wanted in &all[..count] {
            take(wanted.key, invert(wanted.linear, wanted.offset));
        }
    }
}

/// The results of [`invert`] if it neither damps nor bounds any of them; `None` if it might.
fn exact(all: &[PosedOffset; LANES]) -> Option<[Vec3A; LANES]> {
    let x = Vec3x4::new(all.each_ref().map(|wanted| wanted.linear.x_axis));
    let y = Vec3x4::new(all.each_ref().map(|wanted| wanted.linear.y_axis));
    let z = Vec3x4::new(all.each_ref().map(|wanted| wanted.linear.z_axis));
    let wanted = Vec3x4::new(all.each_ref().map(|wanted| wanted.offset));
    let crossed = y.cross(z);
    let determinant = x.dot(crossed);
    let inverse = 1.0 / determinant;
    let offset = Vec3x4 {
        x: wanted.dot(crossed) * inverse,
        y: wanted.dot(z.cross(x)) * inverse,
        z: wanted.dot(x.cross(y)) * inverse,
    };
    // the same limits, squared, so that no root is needed
    let size_squared = (x.dot(x) + y.dot(y) + z.dot(z)) * (1.0 / 3.0);
    let least =
        size_squared * size_squared * size_squared * (DAMPED_BELOW * DAMPED_BELOW * (1.0 + ROUNDING_MARGIN));
    let most = wanted.dot(wanted) * (EXACT_LENGTHENING * EXACT_LENGTHENING * (1.0 - ROUNDING_MARGIN));
    let is_exact = (determinant * determinant).cmpgt(least)
        & size_squared.cmpgt(Vec4::splat(SMALL_SIZE * SMALL_SIZE * (1.0 + ROUNDING_MARGIN)))
        & (offset.dot(offset) * size_squared).cmple(most.min(Vec4::MAX));
    is_exact.all().then(|| offset.apart())
}

/// The offset that `linear` maps to `wanted`, damped and bounded.
pub(crate) fn invert(linear: Mat3A, wanted: Vec3A) -> RestOffset {
    let size = (frobenius_squared(&linear) / 3.0).sqrt();
    let crossed = linear.y_axis.cross(linear.z_axis);
    let determinant = linear.x_axis.dot(crossed);
    let fullness = determinant.abs() / (size * size * size);
    let flatness = rising_below(fullness, DAMPED_BELOW);
    let smallness = rising_below(size, SMALL_SIZE);
    let is_singular = flatness > 0.0 || smallness > 0.0;
    let offset = if is_singular {
        let damping = STRONGEST_DAMPING * (size * flatness).max(0.0);
        let floor = SMALL_SIZE * smallness;
        damped(linear, wanted, damping * damping + floor * floor)
    } else {
        // Cramer's rule
        let others = Vec3A::new(
            wanted.dot(crossed),
            wanted.dot(linear.z_axis.cross(linear.x_axis)),
            wanted.dot(linear.x_axis.cross(linear.y_axis)),
        );
        others * (1.0 / determinant)
    };
    let (offset, is_bounded) = bounded(offset, wanted.length() / size.max(SMALL_SIZE));
    if offset.is_finite() {
        RestOffset {
            offset,
            is_damped: is_singular || is_bounded,
        }
    } else {
        RestOffset {
            offset: Vec3A::ZERO,
            is_damped: true,
        }
    }
}

/// 0 from `limit` on, rising to 1 at 0.
fn rising_below(value: f32, limit: f32) -> f32 {
    (1.0 - value / limit).max(0.0)
}

/// `(MᵀM + λ)⁻¹ Mᵀ wanted`. With λ the symmetric matrix is never singular.
fn damped(linear: Mat3A, wanted: Vec3A, lambda: f32) -> Vec3A {
    // f64, since squares of small sizes are below the range of f32
    let wide = glam::DMat3::from_cols_array(&linear.to_cols_array().map(f64::from));
    let transposed = wide.transpose();
    let normal = transposed * wide + glam::DMat3::from_diagonal(glam::DVec3::splat(f64::from(lambda)));
    if normal.determinant() == 0.0 {
        return Vec3A::ZERO;
    }
    (normal.inverse() * (transposed * wanted.as_dvec3())).as_vec3a()
}

/// `offset`, bounded smoothly between [`EXACT_LENGTHENING`] and [`LARGEST_LENGTHENING`] times `unit_m`;
/// and whether it was.
fn bounded(offset: Vec3A, unit_m: f32) -> (Vec3A, bool) {
    let exact_m = EXACT_LENGTHENING * unit_m;
    if offset.length_squared() <= exact_m * exact_m {
        return (offset, false);
    }
    let length_m = offset.length();
    let room = LARGEST_LENGTHENING - EXACT_LENGTHENING;
    let over = (length_m / unit_m - EXACT_LENGTHENING) / room;
    let lengthening = EXACT_LENGTHENING + room * (1.0 - (-over).exp());
    (offset * (lengthening * unit_m / length_m), true)
}
