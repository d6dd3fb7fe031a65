//! A box parallel to the axes, in f32.

use glam::Vec3A;

/// A box parallel to the axes, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Aabb {
    /// The corner with the smallest coordinates.
    pub low: Vec3A,
    /// The corner with the largest coordinates.
    pub high: Vec3A,
}

impl Aabb {
    /// The box without a point.
    pub const EMPTY: Self = Self {
        low: Vec3A::INFINITY,
        high: Vec3A::NEG_INFINITY,
    };

    /// The smallest box around points.
    pub fn of(points: impl Iterator<Item = Vec3A>) -> Self {
        points.fold(Self::EMPTY, |bounds, point| Self {
            low: bounds.low.min(point),
            high: bounds.high.max(point),
        })
    }

    /// The smallest box around boxes.
    pub fn joined(boxes: &[Self]) -> Self {
        boxes.iter().fold(Self::EMPTY, |all, part| Self {
            low: all.low.min(part.low),
            high: all.high.max(part.high),
        })
    }

    /// Whether the boxes have a point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        (self.low.cmple(other.high) & other.low.cmple(self.high)).all()
    }

    /// What is in both boxes, if they overlap.
    pub fn common(&self, other: &Self) -> Self {
        Self {
            low: self.low.max(other.low),
            high: self.high.min(other.high),
        }
    }
}
