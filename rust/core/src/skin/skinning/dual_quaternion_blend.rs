//! Blended dual quaternions (ALGORITHM 6): L. Kavan et al., "Geometric Skinning with Approximate Dual Quaternion Blending", 2008.

use fixedbitset::FixedBitSet;
use glam::{Mat3A, Quat, Vec3A, Vec4, Vec4Swizzles};

use crate::pose::{Palette, Skeleton};
use crate::skin::mesh::bone_weights::BoneWeight;
use crate::skin::skinning::displacement::Displacement;
use crate::skin::skinning::dual_quaternion::DualQuaternion;

/// Square of the diagonal of a box in which any two unit quaternions lie on one side of each other: less than 2, that of two at 90°.
const ON_ONE_SIDE: f32 = 1.99;

/// What a modifier does to a vertex, and how it is turned and scaled by that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlendedMotion {
    pub map: Displacement,
    /// Uniform scale of the same volume.
    pub scale: f32,
    /// The turn and the scale.
    pub axes: Mat3A,
}

impl BlendedMotion {
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

/// What a bone adds to the blend of dual quaternions.
#[derive(Debug, Clone, Copy)]
struct BoneQuaternion {
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

/// Dual quaternions of all bones.
#[derive(Debug, Clone)]
pub(crate) struct PreserveVolume {
    quaternions: Vec<BoneQuaternion>,
    /// What those bones add that stretch; nothing where one does not.
    stretches: Vec<Stretch>,
    /// Deviation from an orthonormal matrix up to which a bone counts as only rotated.
    tolerance: f64,
}

impl PreserveVolume {
    /// The maps of the rest pose, for bones that count as only rotated up to a deviation of `tolerance`.
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

    /// Takes on the pose of the bones that `moved`, allocating nothing.
    pub fn set(&mut self, skeleton: &Skeleton, palette: &Palette, moved: &FixedBitSet) {
        for bone in moved.ones() {
            let (carry, rest) = (&palette.skinning_matrices()[bone], &skeleton.rest()[bone]);
            let (rigid, stretch) = DualQuaternion::of(carry, rest, self.tolerance);
            // on its parent's side, where it can be: so that hardly a sum has to flip it
            let parent = skeleton.parents()[bone].map(|parent| self.quaternions[parent].rigid.real);
            let is_apart = parent.is_some_and(|parent| parent.dot(rigid.real) < 0.0);
            let rigid = if is_apart { rigid.flipped() } else { rigid };
            self.quaternions[bone] = BoneQuaternion {
                rigid,
                stretches: stretch.is_some(),
            };
            self.stretches[bone] =
                stretch.map_or(Stretch::default(), |stretch| Stretch::new(rigid.real, &stretch));
        }
    }

    /// What the bones do to a vertex of `weights`, which sum to 1; nothing where there are none.
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

    /// Whether any bone stretches.
    pub fn any_stretches(&self) -> bool {
        self.quaternions.iter().any(|turn| turn.stretches)
    }

    /// What the bones do to the place of a vertex of `weights`, which sum to 1; nothing where there are none.
    pub fn displacement(&self, weights: &[BoneWeight]) -> Displacement {
        self.blend(weights).0
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

    /// The weighted sum of the bones' dual quaternions, each flipped where it lies on the other side of the sum before it; and whether
    /// any of the bones stretches.
    fn summed(&self, weights: &[BoneWeight]) -> (DualQuaternion, bool) {
        let (mut real, mut dual) = (Vec4::ZERO, Vec4::ZERO);
        let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        let mut is_stretched = false;
        for own in weights {
            let BoneQuaternion { rigid, stretches } = &self.quaternions[own.bone as usize];
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
            let bone = &self.quaternions[own.bone as usize].rigid;
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
            let BoneQuaternion { rigid, stretches } = &self.quaternions[own.bone as usize];
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
fn rotation_minus_identity(q: Vec4, double_inverse: f32) -> Mat3A {
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
fn times_conjugate(e: Vec4, q: Vec4) -> Vec3A {
    let (e_vector, q_vector) = (Vec3A::from_vec4(e), Vec3A::from_vec4(q));
    e_vector * q.w - q_vector * e.w - e_vector.cross(q_vector)
}
