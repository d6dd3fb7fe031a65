//! Dual quaternion blending (Kavan et al. 2007 and 2008; mathematics/skinning.md, Dual quaternions).

use fixedbitset::FixedBitSet;
use glam::{Mat3A, Quat, Vec3A, Vec4, Vec4Swizzles};

use crate::pose::{Palette, Skeleton};
use crate::skin::mesh::bone_weights::BoneWeight;
use crate::skin::skinning::displacement::Displacement;
use crate::skin::skinning::dual_quaternion::DualQuaternion;

/// Squared diagonal of a box of unit quaternions below which no two of them are on opposite sides:
/// slightly less than 2, the squared distance of perpendicular ones.
const ON_ONE_SIDE: f32 = 1.99;

/// The blended map of a vertex's bones, with its rotation and scale.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlendedMotion {
    pub map: Displacement,
    /// Uniform scale of the same volume.
    pub scale: f32,
    /// The rotation times the scale.
    pub axes: Mat3A,
}

impl BlendedMotion {
    /// Of a map that scales or shears. The rotation is approximate: the relaxation only starts from it.
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

/// The part of a bone in the blend.
#[derive(Debug, Clone, Copy)]
struct BoneQuaternion {
    rigid: DualQuaternion,
    stretches: bool,
}

/// A bone's scale and shear, rotated by its real quaternion q: `q d` of the displacement's three columns
/// and its shift.
#[derive(Debug, Clone, Copy, Default)]
struct Stretch([Vec4; 4]);

impl Stretch {
    fn new(real: Vec4, stretch: &Displacement) -> Self {
        let rotated = |d: Vec3A| Vec4::from(Quat::from_vec4(real) * Quat::from_vec4(d.extend(0.0)));
        let Displacement {
            linear:
                Mat3A {
                    x_axis,
                    y_axis,
                    z_axis,
                },
            shift,
        } = *stretch;
        Self([x_axis, y_axis, z_axis, shift].map(rotated))
    }
}

/// The dual quaternions of all bones.
#[derive(Debug, Clone)]
pub(crate) struct PreserveVolume {
    quaternions: Vec<BoneQuaternion>,
    /// The scale and shear of each bone; 0 for a rigid bone.
    stretches: Vec<Stretch>,
    /// Largest deviation from an orthonormal matrix with which a bone counts as rigid.
    tolerance: f64,
}

impl PreserveVolume {
    /// The maps of the rest pose. Bones count as rigid up to `tolerance`.
    pub fn at_rest(bones: usize, tolerance: f64) -> Self {
        Self {
            quaternions: vec![
                BoneQuaternion {
                    rigid: DualQuaternion::IDENTITY,
                    stretches: false,
                };
                bones
            ],
            stretches: vec![Stretch::default(); bones],
            tolerance,
        }
    }

    /// Sets the pose of the bones that are `dirty`. Allocates nothing.
    pub fn set(&mut self, skeleton: &Skeleton, palette: &Palette, dirty: &FixedBitSet) {
        for bone in dirty.ones() {
            let (matrix, rest) = (&palette.skinning_matrices()[bone], &skeleton.rest()[bone]);
            let (rigid, stretch) = DualQuaternion::of(matrix, rest, self.tolerance);
            // on its parent's side if possible, so that hardly any sum has to flip it
            let parent = skeleton.parents()[bone].map(|parent| self.quaternions[parent].rigid.real);
            let is_flipped = parent.is_some_and(|parent| parent.dot(rigid.real) < 0.0);
            let rigid = if is_flipped { rigid.flipped() } else { rigid };
            self.quaternions[bone] = BoneQuaternion {
                rigid,
                stretches: stretch.is_some(),
            };
            self.stretches[bone] =
                stretch.map_or(Stretch::default(), |stretch| Stretch::new(rigid.real, &stretch));
        }
    }

    /// The blended map for `weights`, which sum to 1, with its rotation and scale; the identity without
    /// weights.
    pub fn motion(&self, weights: &[BoneWeight]) -> BlendedMotion {
        let (map, is_stretched) = self.blend(weights);
        if is_stretched {
            return BlendedMotion::of(map);
        }
        BlendedMotion {
            map,
            scale: 1.0,
            axes: map.linear + Mat3A::IDENTITY,
        }
    }

    /// Whether any bone scales or shears.
    pub fn any_stretches(&self) -> bool {
        self.quaternions.iter().any(|bone| bone.stretches)
    }

    /// The blended map for `weights`, which sum to 1; no displacement without weights.
    pub fn displacement(&self, weights: &[BoneWeight]) -> Displacement {
        self.blend(weights).0
    }

    /// The blended map, and whether any of the bones scales or shears. If none does, the map is rigid.
    fn blend(&self, weights: &[BoneWeight]) -> (Displacement, bool) {
        let (rigid, is_stretched) = self.summed(weights);
        let square = rigid.real.length_squared();
        if square == 0.0 {
            return (Displacement::NONE, false);
        }
        let factor = 1.0 / square;
        let mut map = Displacement {
            linear: rotation_minus_identity(rigid.real, 2.0 * factor),
            shift: times_conjugate(rigid.dual, rigid.real) * (2.0 * factor),
        };
        if is_stretched {
            let [x, y, z, shift] = self.stretch(weights).0;
            let added = |column: Vec4| times_conjugate(column, rigid.real) * factor;
            map.linear += Mat3A::from_cols(added(x), added(y), added(z));
            map.shift += added(shift);
        }
        (map, is_stretched)
    }

    /// The weighted sum of the bones' dual quaternions. Each is flipped if it is on the other side of the
    /// sum before it. Also whether any of the bones scales or shears.
    fn summed(&self, weights: &[BoneWeight]) -> (DualQuaternion, bool) {
        let (mut real, mut dual) = (Vec4::ZERO, Vec4::ZERO);
        let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        let mut is_stretched = false;
        for entry in weights {
            let BoneQuaternion { rigid, stretches } = &self.quaternions[entry.bone as usize];
            (low, high) = (low.min(rigid.real), high.max(rigid.real));
            real += rigid.real * entry.weight;
            dual += rigid.dual * entry.weight;
            is_stretched |= stretches;
        }
        if (high - low).length_squared() < ON_ONE_SIDE {
            // no quaternion is flipped, so the sums do not depend on each other
            return (DualQuaternion { real, dual }, is_stretched);
        }
        (real, dual) = (Vec4::ZERO, Vec4::ZERO);
        for entry in weights {
            let bone = &self.quaternions[entry.bone as usize].rigid;
            let signed = entry.weight * sign(bone.real, real);
            real += bone.real * signed;
            dual += bone.dual * signed;
        }
        (DualQuaternion { real, dual }, is_stretched)
    }

    /// The weighted sum of the bones' scale and shear, with the signs of [`PreserveVolume::summed`].
    fn stretch(&self, weights: &[BoneWeight]) -> Stretch {
        let (mut sum, mut running) = (Stretch::default(), Vec4::ZERO);
        for entry in weights {
            let BoneQuaternion { rigid, stretches } = &self.quaternions[entry.bone as usize];
            let signed = entry.weight * sign(rigid.real, running);
            running += rigid.real * signed;
            if *stretches {
                for (sum, column) in sum.0.iter_mut().zip(self.stretches[entry.bone as usize].0) {
                    *sum += column * signed;
                }
            }
        }
        sum
    }
}

/// -1 if a quaternion must be flipped to be on the side of the sum so far, else 1.
fn sign(real: Vec4, sum: Vec4) -> f32 {
    if real.dot(sum) < 0.0 { -1.0 } else { 1.0 }
}

/// `R - 1` of the rotation R of a quaternion of any length. `double_inverse` is 2 over its squared
/// length.
fn rotation_minus_identity(q: Vec4, double_inverse: f32) -> Mat3A {
    let scaled = q * double_inverse;
    let squares = scaled * q;
    let pairs = scaled * q.yzxw(); // xy, yz, zx
    let spins = scaled.zxyw() * q.w;
    let (plus, minus) = (pairs + spins, pairs - spins);
    let diagonal = -(squares.yxxw() + squares.zzyw());
    Mat3A::from_cols(
        Vec3A::new(diagonal.x, plus.x, minus.z),
        Vec3A::new(minus.x, diagonal.y, plus.y),
        Vec3A::new(plus.z, minus.y, diagonal.z),
    )
}

/// The vector part of `e q*`.
fn times_conjugate(e: Vec4, q: Vec4) -> Vec3A {
    let (e_vector, q_vector) = (Vec3A::from_vec4(e), Vec3A::from_vec4(q));
    e_vector * q.w - q_vector * e.w - e_vector.cross(q_vector)
}
