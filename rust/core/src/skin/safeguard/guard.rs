//! Bind data of the safeguard: the joints that it guards, and the samples that are known of each.

use std::sync::OnceLock;

use fixedbitset::FixedBitSet;
use glam::{DMat3, DQuat, Vec3A};

use crate::math::rows::Rows;
use crate::pose::{Palette, Skeleton};
use crate::skin::safeguard::rest_skin::RestSkin;
use crate::skin::safeguard::sampled_rotations::SAMPLES;

/// Length of an offset after the modifier, over the size of the mesh, up to which the vertex keeps the modifier's
/// position to the bit: 2 µm on a body. Where faces touch, rounding alone makes them intersect.
const LEAST_OFFSET_OF_SIZE: f32 = 1e-6;

/// The bind data of the safeguard.
#[derive(Debug)]
pub(crate) struct Guard {
    /// The vertices, armature space, m, and triangles as the mesh's file has them.
    pub points: Vec<Vec3A>,
    pub triangles: Vec<[u32; 3]>,
    /// Length of an offset up to which it does not count, m.
    pub least_offset_m: f32,
    pub bones: Vec<GuardedBone>,
    /// Made when the first sample is needed.
    rest_skin: OnceLock<RestSkin>,
    /// Made when the first sample is worse.
    beside: OnceLock<Rows<u32>>,
    /// [`SAMPLES`] for each guarded bone.
    samples: Vec<OnceLock<Sample>>,
}

/// A bone whose rotation against its parent moves skin, or a tissue that influences skin.
#[derive(Debug)]
pub(crate) struct GuardedBone {
    pub bone: usize,
    pub parent: usize,
    /// Its axes at rest, armature space.
    axes: DQuat,
}

/// What is known of one joint in one rotation: how much of Sinew's skin is not worse than the modifier's.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sample {
    /// Strength of the crease plane, 0 to 1.
    pub crease: f32,
    /// How far the skin returns to the modifier's, 0 to 1.
    pub returning: f32,
    /// The vertices that return, and how far each returns with the others, 0 to 1.
    pub field: Vec<(u32, f32)>,
}

impl Sample {
    /// A skin that is nowhere worse.
    pub const HARMLESS: Self = Self {
        crease: 1.0,
        returning: 0.0,
        field: vec![],
    };
}

impl Guard {
    /// The guard of a skin of `triangles` over `points`, armature space, m, as its file has them. `moving` are the
    /// bones that move it: a muscle that ends at another bone than those that carry the skin moves it, too.
    pub fn new(
        skeleton: &Skeleton,
        moving: &FixedBitSet,
        points: Vec<Vec3A>,
        triangles: Vec<[u32; 3]>,
    ) -> Self {
        let mut carries = vec![false; skeleton.len()];
        for bone in moving.ones() {
            let mut above = Some(bone);
            while let Some(bone) = above.filter(|&bone| !carries[bone]) {
                carries[bone] = true;
                above = skeleton.parents()[bone];
            }
        }
        let guarded = |bone: usize| {
            let parent = skeleton.parents()[bone].filter(|_| carries[bone])?;
            let axes = rotation_of(skeleton.rest()[bone].matrix3);
            Some(GuardedBone { bone, parent, axes })
        };
        let bones: Vec<GuardedBone> = (0..skeleton.len()).filter_map(guarded).collect();
        let low = points.iter().copied().fold(Vec3A::INFINITY, Vec3A::min);
        let high = points.iter().copied().fold(Vec3A::NEG_INFINITY, Vec3A::max);
        Self {
            least_offset_m: LEAST_OFFSET_OF_SIZE * (high - low).max_element(),
            points,
            triangles,
            rest_skin: OnceLock::new(),
            beside: OnceLock::new(),
            samples: (0..bones.len() * SAMPLES).map(|_| OnceLock::new()).collect(),
            bones,
        }
    }

    /// The skin at rest, by `make` if it is not made yet.
    pub fn rest_skin(&self, make: impl FnOnce() -> RestSkin) -> &RestSkin {
        made_once(&self.rest_skin, make)
    }

    /// The neighbours of each welded vertex, by `make` if they are not known yet.
    pub fn beside(&self, make: impl FnOnce() -> Rows<u32>) -> &Rows<u32> {
        made_once(&self.beside, make)
    }

    /// A sample of a guarded bone, if it is known.
    pub fn sample(&self, index: usize, sample: u32) -> Option<&Sample> {
        self.samples[index * SAMPLES + sample as usize].get()
    }

    /// Stores a sample. A sample that is known has the same value.
    pub fn store(&self, index: usize, sample: u32, value: Sample) {
        self.samples[index * SAMPLES + sample as usize].get_or_init(|| value);
    }
}

impl GuardedBone {
    /// Rotation of the bone against its parent from rest, in its own axes.
    pub fn rotation(&self, palette: &Palette) -> DQuat {
        let of = |bone: usize| rotation_of(palette.skinning_matrices()[bone].matrix3);
        (self.axes.inverse() * of(self.parent).inverse() * of(self.bone) * self.axes).normalize()
    }

    /// The rotation of armature space that rotates the bone by `rotation` in its own axes.
    pub fn in_armature(&self, rotation: DQuat) -> DQuat {
        self.axes * rotation * self.axes.inverse()
    }
}

/// The value of a cell, by `make` if it has none. Two threads may both make it: a thread that waits for another
/// inside the pool could wait for itself.
fn made_once<T>(cell: &OnceLock<T>, make: impl FnOnce() -> T) -> &T {
    if let Some(made) = cell.get() {
        return made;
    }
    let made = make();
    cell.get_or_init(|| made)
}

/// The rotation of a map, without scale. Of a reflection it is the rotation of its negative.
fn rotation_of(linear: DMat3) -> DQuat {
    let linear = if linear.determinant() < 0.0 {
        -linear
    } else {
        linear
    };
    let x = linear.x_axis.normalize_or(glam::DVec3::X);
    let y = linear.y_axis.reject_from_normalized(x);
    let y = if y.length_squared() > 0.0 {
        y.normalize()
    } else {
        x.any_orthonormal_vector()
    };
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)))
}
