//! What the mesh's Armature modifier does to a vertex, as an affine map of its place (ALGORITHM 6).
//!
//! Linear: `Σ w B` of normalised weights. Preserve Volume: blended dual quaternions (L. Kavan et al., "Geometric Skinning
//! with Approximate Dual Quaternion Blending", 2008) as Blender blends them: a bone's scale and shear (what is left of
//! `B` without its rotation, taken from the posed bone with its y axis kept) acts on the vertex before its rotation is
//! blended in. The quaternions' weights do not depend on the vertex, so the map is affine in it, and exact.
//!
//! Maps are kept as displacements, `x -> M x - x`: at rest they vanish to the last bit.

use fixedbitset::FixedBitSet;
use glam::{DAffine3, DMat3, DQuat, DVec3, Mat3A, Quat, Vec3A, Vec4, Vec4Swizzles};

use super::Skinning;
use super::frobenius::frobenius_squared;
use super::weights::BoneWeight;
use crate::pose::{Palette, Skeleton, any_perpendicular};

/// Deviation from an orthonormal matrix up to which a bone counts as only rotated, as in Blender.
const ORTHONORMAL_TOLERANCE: f64 = 1e-5;
/// Deviation of its size from 1 up to which a bone counts as unscaled, as in Blender.
const SCALE_TOLERANCE: f64 = 1e-4;

/// Square of the diagonal of a box in which any two unit quaternions lie on one side of each other: less than 2, that of two at 90°.
const ON_ONE_SIDE: f32 = 1.99;

/// The displacement of an affine map: `x -> linear · x + shift`, to be added to x.
#[derive(Debug, Clone, Copy)]
pub(super) struct Displacement {
    pub linear: Mat3A,
    pub shift: Vec3A,
}

impl Displacement {
    pub const NONE: Self = Self {
        linear: Mat3A::ZERO,
        shift: Vec3A::ZERO,
    };

    fn of(map: &DAffine3) -> Self {
        let linear = map.matrix3 - DMat3::IDENTITY;
        Self {
            linear: Mat3A::from(linear.as_mat3()),
            shift: Vec3A::from(map.translation.as_vec3()),
        }
    }

    pub fn at(&self, point: Vec3A) -> Vec3A {
        self.linear * point + self.shift
    }
}

/// What a modifier does to a vertex, and how it is turned and scaled by that.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turned {
    pub map: Displacement,
    /// Uniform scale of the same volume.
    pub scale: f32,
    /// The turn and the scale.
    pub axes: Mat3A,
}

impl Turned {
    /// Of a map that scales or shears: its turn near enough for the relaxation to begin with.
    fn of(map: Displacement) -> Self {
        let linear = map.linear + Mat3A::IDENTITY;
        let x = linear.x_axis.normalize_or(Vec3A::X);
        let y = linear
            .y_axis
            .reject_from_normalized(x)
            .normalize_or(x.any_orthonormal_vector());
        let scale = linear.determinant().abs().cbrt().max(f32::MIN_POSITIVE);
        Self {
            map,
            scale,
            axes: Mat3A::from_cols(x, y, x.cross(y)) * scale,
        }
    }
}

/// A bone's rigid part: the real and the dual quaternion as x, y, z, w.
#[derive(Debug, Clone, Copy)]
struct DualQuaternion {
    real: Vec4,
    dual: Vec4,
}

impl DualQuaternion {
    const IDENTITY: Self = Self {
        real: Vec4::W,
        dual: Vec4::ZERO,
    };

    /// The rigid part of what carries a bone, and the rest of it as a displacement before that, `None` where it is rigid.
    fn of(carry: &DAffine3, rest: &DAffine3) -> (Self, Option<Displacement>) {
        let posed = *carry * *rest;
        if is_rotation(carry.matrix3, posed.matrix3) {
            return (Self::rigid(carry), None);
        }
        let rotation = DMat3::from_quat(DQuat::from_mat3(&rotation_keeping_y(posed.matrix3)));
        let rigid = DAffine3 {
            matrix3: rotation,
            translation: posed.translation,
        } * rest.inverse();
        let turn = DQuat::from_mat3(&orthonormalised(rigid.matrix3));
        let rigid = DAffine3 {
            matrix3: DMat3::from_quat(turn),
            translation: rigid.translation,
        };
        let stretch = Displacement::of(&(rigid.inverse() * *carry));
        (Self::rigid(&rigid), Some(stretch))
    }

    fn rigid(map: &DAffine3) -> Self {
        let real = DQuat::from_mat3(&map.matrix3).normalize();
        let dual = (pure(map.translation) * real) * 0.5;
        Self {
            real: real.as_quat().into(),
            dual: dual.as_quat().into(),
        }
    }

    /// The same map by the other sign.
    fn flipped(self) -> Self {
        Self {
            real: -self.real,
            dual: -self.dual,
        }
    }
}

/// What a bone adds to the blend of dual quaternions.
#[derive(Debug, Clone, Copy)]
struct Turn {
    rigid: DualQuaternion,
    stretches: bool,
}

/// A bone's stretch, turned by its real quaternion q: `q d` of each displacement d, three columns and the shift.
#[derive(Debug, Clone, Copy, Default)]
struct Stretch([Vec4; 4]);

impl Stretch {
    fn new(real: Vec4, stretch: &Displacement) -> Self {
        let turned = |d: Vec3A| Vec4::from(Quat::from_vec4(real) * Quat::from_vec4(d.extend(0.0)));
        let Displacement {
            linear:
                Mat3A {
                    x_axis,
                    y_axis,
                    z_axis,
                },
            shift,
        } = *stretch;
        Self([x_axis, y_axis, z_axis, shift].map(turned))
    }
}

/// The maps of all bones in one pose.
#[derive(Debug, Clone)]
pub(super) enum BoneMaps {
    None,
    Linear(Vec<Displacement>),
    PreserveVolume(PreserveVolume),
}

/// Dual quaternions of all bones.
#[derive(Debug, Clone)]
pub(super) struct PreserveVolume {
    turns: Vec<Turn>,
    /// What those bones add that stretch; nothing where one does not.
    stretches: Vec<Stretch>,
}

impl BoneMaps {
    /// The maps of the rest pose.
    pub fn at_rest(skinning: Skinning, bones: usize) -> Self {
        match skinning {
            Skinning::None => Self::None,
            Skinning::Linear => Self::Linear(vec![Displacement::NONE; bones]),
            Skinning::PreserveVolume => Self::PreserveVolume(PreserveVolume::at_rest(bones)),
        }
    }

    /// Takes on the pose of the bones that `moved`, allocating nothing.
    pub fn set(&mut self, skeleton: &Skeleton, palette: &Palette, moved: &FixedBitSet) {
        match self {
            Self::None => {}
            Self::Linear(maps) => {
                for bone in moved.ones() {
                    maps[bone] = Displacement::of(&palette.carries()[bone]);
                }
            }
            Self::PreserveVolume(maps) => maps.set(skeleton, palette, moved),
        }
    }

    /// What no vector becomes longer than, over its own length; infinite where bones that stretch are blended as dual quaternions.
    pub fn longest(&self) -> f32 {
        let of_linear = |map: &Displacement| {
            // the Frobenius norm of a matrix is at least its largest stretch
            frobenius_squared(&(map.linear + Mat3A::IDENTITY)).sqrt()
        };
        match self {
            Self::None => 1.0,
            Self::Linear(maps) => maps.iter().map(of_linear).fold(1.0, f32::max),
            Self::PreserveVolume(maps) if maps.turns.iter().any(|turn| turn.stretches) => f32::INFINITY,
            Self::PreserveVolume(_) => 1.0,
        }
    }

    /// What the modifier does to a vertex of `weights`, which sum to 1; nothing where there are none.
    pub fn blend(&self, weights: &[BoneWeight]) -> Displacement {
        match self {
            Self::None => Displacement::NONE,
            Self::Linear(maps) => {
                let mut blended = Displacement::NONE;
                for own in weights {
                    let map = &maps[own.bone as usize];
                    blended.linear += map.linear * own.weight;
                    blended.shift += map.shift * own.weight;
                }
                blended
            }
            Self::PreserveVolume(_) if weights.is_empty() => Displacement::NONE,
            Self::PreserveVolume(maps) => maps.blend(weights).0,
        }
    }
}

impl PreserveVolume {
    /// The maps of the rest pose.
    pub fn at_rest(bones: usize) -> Self {
        Self {
            turns: vec![
                Turn {
                    rigid: DualQuaternion::IDENTITY,
                    stretches: false,
                };
                bones
            ],
            stretches: vec![Stretch::default(); bones],
        }
    }

    /// Takes on the pose of the bones that `moved`, allocating nothing.
    pub fn set(&mut self, skeleton: &Skeleton, palette: &Palette, moved: &FixedBitSet) {
        for bone in moved.ones() {
            let (rigid, stretch) = DualQuaternion::of(&palette.carries()[bone], &skeleton.rest()[bone]);
            // on its parent's side, where it can be: so that hardly a sum has to flip it
            let parent = skeleton.parents()[bone].map(|parent| self.turns[parent].rigid.real);
            let is_apart = parent.is_some_and(|parent| parent.dot(rigid.real) < 0.0);
            let rigid = if is_apart { rigid.flipped() } else { rigid };
            self.turns[bone] = Turn {
                rigid,
                stretches: stretch.is_some(),
            };
            self.stretches[bone] =
                stretch.map_or(Stretch::default(), |stretch| Stretch::new(rigid.real, &stretch));
        }
    }

    /// What the bones do to a vertex of `weights`, which sum to 1; nothing where there are none.
    pub fn turned(&self, weights: &[BoneWeight]) -> Turned {
        let (map, is_stretched) = self.blend(weights);
        if is_stretched {
            return Turned::of(map);
        }
        Turned {
            map,
            scale: 1.0,
            axes: map.linear + Mat3A::IDENTITY,
        }
    }

    /// The blended map, and whether any of the bones stretches; where not, it is nothing but a turn about some axis.
    fn blend(&self, weights: &[BoneWeight]) -> (Displacement, bool) {
        let (rigid, is_stretched) = self.summed(weights);
        let square = rigid.real.length_squared();
        if square == 0.0 {
            return (Displacement::NONE, false);
        }
        let factor = 1.0 / square;
        let mut map = Displacement {
            linear: turning(rigid.real, 2.0 * factor),
            shift: turned_back(rigid.dual, rigid.real) * (2.0 * factor),
        };
        if is_stretched {
            let [x, y, z, shift] = self.stretch(weights).0;
            let added = |column: Vec4| turned_back(column, rigid.real) * factor;
            map.linear += Mat3A::from_cols(added(x), added(y), added(z));
            map.shift += added(shift);
        }
        (map, is_stretched)
    }

    /// The weighted sum of the bones' dual quaternions, each flipped where it lies on the other side of the sum before it; and whether
    /// any of the bones stretches.
    fn summed(&self, weights: &[BoneWeight]) -> (DualQuaternion, bool) {
        let (mut real, mut dual) = (Vec4::ZERO, Vec4::ZERO);
        let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        let mut is_stretched = false;
        for own in weights {
            let Turn { rigid, stretches } = &self.turns[own.bone as usize];
            (low, high) = (low.min(rigid.real), high.max(rigid.real));
            real += rigid.real * own.weight;
            dual += rigid.dual * own.weight;
            is_stretched |= stretches;
        }
        if (high - low).length_squared() < ON_ONE_SIDE {
            // none would be flipped, and none had to wait for the sum before it
            return (DualQuaternion { real, dual }, is_stretched);
        }
        (real, dual) = (Vec4::ZERO, Vec4::ZERO);
        for own in weights {
            let bone = &self.turns[own.bone as usize].rigid;
            let signed = own.weight * direction(bone.real, real);
            real += bone.real * signed;
            dual += bone.dual * signed;
        }
        (DualQuaternion { real, dual }, is_stretched)
    }

    /// The weighted sum of the bones' stretches, with the signs of [`PreserveVolume::summed`].
    fn stretch(&self, weights: &[BoneWeight]) -> Stretch {
        let (mut sum, mut running) = (Stretch::default(), Vec4::ZERO);
        for own in weights {
            let Turn { rigid, stretches } = &self.turns[own.bone as usize];
            let signed = own.weight * direction(rigid.real, running);
            running += rigid.real * signed;
            if *stretches {
                for (sum, column) in sum.0.iter_mut().zip(self.stretches[own.bone as usize].0) {
                    *sum += column * signed;
                }
            }
        }
        sum
    }
}

/// -1 where a quaternion must be flipped to lie on the side of the sum so far.
fn direction(real: Vec4, sum: Vec4) -> f32 {
    if real.dot(sum) < 0.0 { -1.0 } else { 1.0 }
}

/// `R - 1` for the rotation R of a quaternion of any length, `double_inverse` 2 over the square of that.
fn turning(q: Vec4, double_inverse: f32) -> Mat3A {
    let scaled = q * double_inverse;
    let squares = scaled * q;
    let pairs = scaled * q.yzxw(); // xy, yz, zx
    let spins = scaled.zxyw() * q.w;
    let (plus, minus) = (pairs + spins, pairs - spins);
    let own = -(squares.yxxw() + squares.zzyw());
    Mat3A::from_cols(
        Vec3A::new(own.x, plus.x, minus.z),
        Vec3A::new(minus.x, own.y, plus.y),
        Vec3A::new(plus.z, minus.y, own.z),
    )
}

/// The vector of `e q*`.
fn turned_back(e: Vec4, q: Vec4) -> Vec3A {
    let (e_vector, q_vector) = (Vec3A::from_vec4(e), Vec3A::from_vec4(q));
    e_vector * q.w - q_vector * e.w - e_vector.cross(q_vector)
}

fn pure(v: DVec3) -> DQuat {
    DQuat::from_xyzw(v.x, v.y, v.z, 0.0)
}

/// True where Blender takes a bone for a rotation without scale.
fn is_rotation(carry: DMat3, posed: DMat3) -> bool {
    let gram = carry.transpose() * carry - DMat3::IDENTITY;
    let is_orthonormal = gram
        .to_cols_array()
        .iter()
        .all(|entry| entry.abs() <= ORTHONORMAL_TOLERANCE);
    let sizes = DVec3::new(
        posed.x_axis.length(),
        posed.y_axis.length(),
        posed.z_axis.length(),
    );
    is_orthonormal && carry.determinant() >= 0.0 && (sizes - DVec3::ONE).length() <= SCALE_TOLERANCE
}

/// The rotation of a posed bone: its y axis kept, the others made square to it, right-handed; as Blender does it, with the
/// identity's axes where columns vanish.
fn rotation_keeping_y(posed: DMat3) -> DMat3 {
    let y = posed.y_axis.try_normalize().unwrap_or_else(|| any_square(posed));
    let from_x = y.dot(posed.x_axis) < 1.0;
    let by_x = || posed.x_axis.cross(y).try_normalize();
    let by_z = || y.cross(posed.z_axis).try_normalize().map(|x| x.cross(y));
    let z = if from_x {
        by_x().or_else(by_z)
    } else {
        by_z().or_else(by_x)
    };
    let z = z.unwrap_or_else(|| any_perpendicular(y));
    DMat3::from_cols(y.cross(z), y, z)
}

fn any_square(posed: DMat3) -> DVec3 {
    posed
        .z_axis
        .cross(posed.x_axis)
        .try_normalize()
        .unwrap_or(DVec3::Y)
}

fn orthonormalised(linear: DMat3) -> DMat3 {
    rotation_keeping_y(linear)
}
