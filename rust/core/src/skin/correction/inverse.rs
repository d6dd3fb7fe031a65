//! The correction: what to add to a rest point before the Armature modifier, so that it lands where the muscles want it
//! (ALGORITHM 6).
//!
//! That takes the inverse of what the modifier does, which a twist near 180° (linear) or a flattened bone takes away. There
//! the inverse is damped, continuously, and what comes out is bounded.

use glam::{Mat3A, Vec3A, Vec4};

use crate::math::norm::frobenius_squared;
use crate::math::vec3x4::{LANES, Vec3x4};

/// Determinant over that of a rotation of the same size, below which an inverse is damped.
const DAMPED_BELOW: f32 = 0.05;
/// Damping at determinant 0, over the matrix's size; nothing is lengthened to more than the half inverse of this.
const STRONGEST_DAMPING: f32 = 0.125;
/// Size of a matrix (1 for a rotation) below which it is damped as a whole.
const SMALL_SIZE: f32 = 0.01;
/// Lengthening (over that of a rotation of the same size) up to which an inverse is exact.
const EXACT_LENGTHENING: f32 = 4.0;
/// Lengthening that no inverse exceeds.
const LARGEST_LENGTHENING: f32 = 8.0;
/// Share of each limit by which a map must stay within it to be taken for exact at first sight, for what f32 rounds off.
const MARGIN: f32 = 1e-4;

/// An offset after the modifier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PosedOffset {
    /// What it is called by.
    pub key: usize,
    /// The modifier's map.
    pub linear: Mat3A,
    /// The offset, m.
    pub offset: Vec3A,
}

/// An offset before the modifier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RestOffset {
    /// The offset, m.
    pub offset: Vec3A,
    /// True where it was damped or bounded, so that it does not land exactly.
    pub is_damped: bool,
}

/// Gives `take` the offset that each of `all` wants, by its key.
pub(crate) fn invert_each(all: impl Iterator<Item = PosedOffset>, mut take: impl FnMut(usize, RestOffset)) {
    let nothing = PosedOffset {
        key: 0,
        linear: Mat3A::IDENTITY,
        offset: Vec3A::ZERO,
    };
    let (mut together, mut count) = ([nothing; LANES], 0);
    for wanted in all {
        together[count] = wanted;
        count += 1;
        if count == LANES {
            invert_together(&together, LANES, &mut take);
            count = 0;
        }
    }
    invert_together(&together, count, &mut take);
}

/// Undoes the first `count` of them; what is beyond these is computed along, and not looked at.
fn invert_together(all: &[PosedOffset; LANES], count: usize, take: &mut impl FnMut(usize, RestOffset)) {
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

/// What [`invert`] finds where it neither damps nor bounds anything; `None` where it might.
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
    // the same limits by their squares: nothing has to be rooted
    let size_squared = (x.dot(x) + y.dot(y) + z.dot(z)) * (1.0 / 3.0);
    let least = size_squared * size_squared * size_squared * (DAMPED_BELOW * DAMPED_BELOW * (1.0 + MARGIN));
    let most = wanted.dot(wanted) * (EXACT_LENGTHENING * EXACT_LENGTHENING * (1.0 - MARGIN));
    let is_exact = (determinant * determinant).cmpgt(least)
        & size_squared.cmpgt(Vec4::splat(SMALL_SIZE * SMALL_SIZE * (1.0 + MARGIN)))
        & (offset.dot(offset) * size_squared).cmple(most.min(Vec4::MAX));
    is_exact.all().then(|| offset.apart())
}

/// The offset that `linear` takes to `wanted`.
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

/// `(MᵀM + λ)⁻¹ Mᵀ wanted`, with MᵀM + λ symmetric and, by its λ, never singular.
fn damped(linear: Mat3A, wanted: Vec3A, lambda: f32) -> Vec3A {
    // Wide: squares of small sizes lie below f32's reach.
    let wide = glam::DMat3::from_cols_array(&linear.to_cols_array().map(f64::from));
    let transposed = wide.transpose();
    let normal = transposed * wide + glam::DMat3::from_diagonal(glam::DVec3::splat(f64::from(lambda)));
    if normal.determinant() == 0.0 {
        return Vec3A::ZERO;
    }
    (normal.inverse() * (transposed * wanted.as_dvec3())).as_vec3a()
}

/// `offset`, bounded smoothly from [`EXACT_LENGTHENING`] on to [`LARGEST_LENGTHENING`] times `unit_m`.
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
