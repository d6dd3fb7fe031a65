//! The skin on either side of a joint stays on its side: a plane through the joint, between the two bones' turns of one rest
//! normal, folds the crook into a crease (ALGORITHM 5, contact plane).

use std::f64::consts::PI;

use glam::{Affine3A, DMat3, DVec3, Vec3A};

use crate::math::smoothstep::{smooth_step, smooth_step_single};
use crate::pose::Palette;
use crate::skin::relaxation::elastic_mesh::ElasticMesh;
use crate::skin::relaxation::joint::{Joint, JointSkin};

/// Rise of the margin over the distance of a vertex's child_weight from one half.
const MARGIN_SLOPE: f64 = 0.1;
/// Distance from the middle, over the radius, below which a vertex may lie on either side.
const SLACK_OF_RADIUS: f64 = 0.032;
/// Largest margin over the radius, on either side: an elbow closes to half a millimetre, a knee to one. At 0.016 they kept 4 and
/// 7 mm open.
const LARGEST_MARGIN_OF_RADIUS: f64 = 0.002;
/// Way that the bone of a vertex takes it from where its side of the joint would, over the radius, at which the plane lets it go.
const RELEASE_OF_RADIUS: f64 = 0.4;
/// The plane ends between these many radii from the joint.
const RADIAL_FADE: std::ops::Range<f64> = 1.2..1.6;
/// Share of a joint's skin that lies on its own side of the plane at rest, from which the plane acts, and acts fully: all limbs
/// lie above (a man's shoulder 0.89, his elbow 0.97), a head, a collar bone and most of a spine below, whose weights no plane
/// divides.
const SEPARABILITY: std::ops::Range<f64> = 0.75..0.88;
/// Most of a joint's turn that its plane goes with. Half for all let an ankle's plane press on the toes of a raised foot (60°: 261
/// new cuts, with this none).
const LARGEST_BLEND: f64 = 0.62;
/// Distance from the child bone's line, over that of the skin between the two bones, at which the plane lets the child's skin go: an
/// arm that hangs beside a trunk is no part of its waist.
const LATERAL_FADE: std::ops::Range<f64> = 1.5..2.0;
/// Least angle between a limb and the plane at rest that counts, radians: a pelvis or a shoulder blade is no limb.
const SMALLEST_LIMB_ANGLE: f64 = 0.6;
/// Distance of a vertex's anchor from the plane, over the joint's radius, up to which it is held in every round; the rest hardly ever
/// comes there, and is looked at in the last.
const NEAR_OF_RADIUS: f32 = 0.25;
/// Swing of the child bone over which the plane comes to act, radians.
const SWING_FADE: std::ops::Range<f64> = 0.0..PI / 6.0;

/// A vertex that the plane holds.
#[derive(Debug, Clone, Copy)]
struct HeldVertex {
    vertex: u32,
    /// +1 on the child's side, -1 on the parent's.
    side: f32,
    /// How far from the plane it must stay, m; negative where it may pass. Never farther than it is at rest: weights are no planes,
    /// and some skin lies on the other side.
    margin_m: f32,
    /// How firmly, 0..1.
    firmness: f32,
    /// Which of the crease's other bones it mostly hangs on, on its side of the joint; `None` for the joint's own bone there.
    other: Option<u32>,
    /// Where it is at rest, m.
    rest: Vec3A,
}

/// A bone from_middle the joint's own two that skin of one side hangs on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OtherBone {
    bone: usize,
    is_child: bool,
}

/// A joint's plane.
#[derive(Debug, Clone)]
pub(crate) struct Crease {
    normal: DVec3,
    /// How far the plane goes with the child, 0..1: by as much as the parent's part of the angle between the two limbs is of the
    /// whole, so that both close on it together.
    blend: f64,
    held: Vec<HeldVertex>,
    other_bones: Vec<OtherBone>,
}

/// The plane in one pose, and what it holds.
#[derive(Debug)]
pub(crate) struct PosedCrease {
    through: Vec3A,
    normal: Vec3A,
    /// What each of the other bones does to a place at rest, less what the joint's own bone on that side does.
    relative: Vec<Affine3A>,
    /// What lies so near to the plane that any round may bring it there, and the rest.
    near: Vec<PosedConstraint>,
    far: Vec<PosedConstraint>,
}

/// A vertex that a posed plane holds.
#[derive(Debug, Clone, Copy)]
struct PosedConstraint {
    vertex: u32,
    side: f32,
    /// How far its displacement must at least lead away from the plane, on its side, m; negative where its swollen anchor lies clear of it.
    least_m: f32,
    firmness: f32,
}

impl Crease {
    /// The crease of a joint; `areas` weigh the vertices. `None` where the weights say nothing of a direction.
    pub fn new(found: &JointSkin, mesh: &ElasticMesh, areas: &[f64]) -> Option<Self> {
        let points = mesh.points;
        let joint = &found.joint;
        let normal = weight_gradient(found, points, areas)?;
        let strength = smooth(SEPARABILITY, separability(found, points, areas, normal));
        if strength == 0.0 {
            return None;
        }
        let from_line = |point: DVec3| {
            (point - joint.centre)
                .reject_from_normalized(joint.direction)
                .length()
        };
        let transition_m = transition_m(found, points, areas, from_line);
        let mut other_bones = vec![];
        let held = found
            .patch
            .iter()
            .filter_map(|&vertex| {
                let at = vertex as usize;
                let distance = joint.radii_to(points[at]);
                let from_middle = f64::from(found.child_weight[at]) - 0.5;
                let is_child = from_middle > 0.0;
                let mut firmness =
                    strength * ((RADIAL_FADE.end - distance) / (RADIAL_FADE.end - RADIAL_FADE.start)).clamp(0.0, 1.0);
                if is_child {
                    firmness *= 1.0 - smooth(LATERAL_FADE, from_line(points[at]) / transition_m);
                }
                let side = if is_child { 1.0 } else { -1.0 };
                let own = mesh
                    .weights
                    .of(at)
                    .iter()
                    .filter(|own| found.is_below[own.bone as usize] == is_child);
                let bone = own
                    .max_by(|a, b| a.weight.total_cmp(&b.weight).then(b.bone.cmp(&a.bone)))?
                    .bone as usize;
                let other = OtherBone { bone, is_child };
                let margin = MARGIN_SLOPE * (from_middle.abs() - SLACK_OF_RADIUS);
                let margin_m = margin.min(LARGEST_MARGIN_OF_RADIUS) * joint.radius_m;
                let at_rest_m = side * (points[at] - joint.centre).dot(normal);
                (firmness > 0.0).then(|| HeldVertex {
                    other: (bone != if is_child { joint.child } else { joint.parent })
                        .then(|| index_in(&mut other_bones, other)),
                    rest: points[at].as_vec3a(),
                    vertex,
                    side: side as f32,
                    margin_m: margin_m.min(at_rest_m) as f32,
                    firmness: firmness as f32,
                })
            })
            .collect();
        let angle = |limb: DVec3| {
            limb.normalize_or_zero()
                .dot(normal)
                .clamp(-1.0, 1.0)
                .asin()
                .max(SMALLEST_LIMB_ANGLE)
        };
        let (of_child, of_parent) = (angle(joint.direction), angle(joint.from_parent));
        let blend = (of_parent / (of_child + of_parent)).clamp(1.0 - LARGEST_BLEND, LARGEST_BLEND);
        Some(Self {
            normal,
            blend,
            held,
            other_bones,
        })
    }

    /// Takes on a pose in which the vertices hang on `swollen_anchors`; the plane is `strength` firm,
    /// 0..1. A pure twist needs none, and what moves on its own against its side of the joint is not held: another finger, the other
    /// leg, a fingertip that comes back to the palm.
    pub fn pose(
        &self,
        joint: &Joint,
        palette: &Palette,
        strength: f32,
        swollen_anchors: &[Vec3A],
        posed: &mut PosedCrease,
    ) {
        let (child, parent) = (
            palette.skinning_matrices()[joint.child],
            palette.skinning_matrices()[joint.parent],
        );
        let turned = |linear: DMat3, direction: DVec3| (linear * direction).normalize_or_zero();
        let swing =
            turned(parent.matrix3, joint.direction).angle_between(turned(child.matrix3, joint.direction));
        let normal = turned(parent.matrix3, self.normal).lerp(turned(child.matrix3, self.normal), self.blend);
        posed.through = parent.transform_point3(joint.centre).as_vec3a();
        posed.normal = normal.normalize_or_zero().as_vec3a();
        posed.relative.clear();
        posed.near.clear();
        posed.far.clear();
        if normal.length() <= 1e-6 {
            return; // folded agreeing back on itself: no plane lies between
        }
        posed.relative.extend(self.other_bones.iter().map(|other| {
            let own = if other.is_child { child } else { parent };
            let carry = palette.skinning_matrices()[other.bone];
            Affine3A {
                matrix3: (carry.matrix3 - own.matrix3).as_mat3().into(),
                translation: (carry.translation - own.translation).as_vec3a(),
            }
        }));
        let scale = palette.scales()[joint.parent] as f32;
        let firmness = strength * smooth(SWING_FADE, swing) as f32;
        let release_m = (RELEASE_OF_RADIUS * joint.radius_m) as f32 * scale;
        let near_m = NEAR_OF_RADIUS * joint.radius_m as f32 * scale;
        for held in &self.held {
            let mut firmness = held.firmness * firmness;
            if let Some(other) = held.other {
                let relative_m = posed.relative[other as usize].transform_point3a(held.rest).length();
                firmness *= 1.0 - smooth_step_single(relative_m / release_m);
            }
            if firmness == 0.0 {
                continue;
            }
            let height_m =
                held.side * (swollen_anchors[held.vertex as usize] - posed.through).dot(posed.normal);
            let least_m = held.margin_m * scale - height_m;
            let list = if least_m > -near_m {
                &mut posed.near
            } else {
                &mut posed.far
            };
            list.push(PosedConstraint {
                vertex: held.vertex,
                side: held.side,
                least_m,
                firmness,
            });
        }
    }
}

impl PosedCrease {
    /// The buffers for a crease.
    pub fn new(crease: &Crease) -> Self {
        Self {
            through: Vec3A::ZERO,
            normal: Vec3A::ZERO,
            relative: Vec::with_capacity(crease.other_bones.len()),
            near: Vec::with_capacity(crease.held.len()),
            far: Vec::with_capacity(crease.held.len()),
        }
    }

    /// Moves what is on the wrong side of the plane back, each vertex as firmly as it is held: what lay near to it, or all. `displacements` are
    /// those of the vertices from their anchors.
    pub fn project(&self, displacements: &mut [Vec3A], all: bool) {
        let far: &[PosedConstraint] = if all { &self.far } else { &[] };
        for constraint in self.near.iter().chain(far) {
            let displacement = &mut displacements[constraint.vertex as usize];
            let penetration_m = constraint.least_m - constraint.side * displacement.dot(self.normal);
            if penetration_m > 0.0 {
                *displacement += self.normal * (constraint.side * penetration_m * constraint.firmness);
            }
        }
    }
}

/// The place of `other` in `other_bones`, at their end where it was not one of them.
fn index_in(other_bones: &mut Vec<OtherBone>, other: OtherBone) -> u32 {
    let place = other_bones
        .iter()
        .position(|known| *known == other)
        .unwrap_or_else(|| {
            other_bones.push(other);
            other_bones.len() - 1
        });
    place as u32
}

/// Share of the skin around a joint that lies on that side of the plane at rest which its weights give it.
fn separability(found: &JointSkin, points: &[DVec3], areas: &[f64], normal: DVec3) -> f64 {
    let (mut agreeing, mut all) = (0.0, 0.0);
    for vertex in found.patch.iter().map(|&vertex| vertex as usize) {
        if found.joint.radii_to(points[vertex]) < 1.0 {
            let is_child = found.child_weight[vertex] > 0.5;
            let is_on_child_side = (points[vertex] - found.joint.centre).dot(normal) > 0.0;
            all += areas[vertex];
            agreeing += if is_child == is_on_child_side { areas[vertex] } else { 0.0 };
        }
    }
    agreeing / f64::max(all, f64::MIN_POSITIVE)
}

/// Mean distance of the skin between the two bones from the child's line, m.
fn transition_m(found: &JointSkin, points: &[DVec3], areas: &[f64], from_line: impl Fn(DVec3) -> f64) -> f64 {
    let (mut sum, mut all) = (0.0, f64::MIN_POSITIVE);
    for vertex in found.patch.iter().map(|&vertex| vertex as usize) {
        let child_weight = f64::from(found.child_weight[vertex]);
        let weight = areas[vertex] * child_weight * (1.0 - child_weight);
        sum += weight * from_line(points[vertex]);
        all += weight;
    }
    sum / all
}

/// The direction in which the child_weight of the child grows: the gradient of a weighted linear fit.
fn weight_gradient(found: &JointSkin, points: &[DVec3], areas: &[f64]) -> Option<DVec3> {
    let near = || {
        let near = found.patch.iter().map(|&vertex| vertex as usize);
        near.filter(|&vertex| found.joint.radii_to(points[vertex]) < 1.0)
            .map(|vertex| (points[vertex], f64::from(found.child_weight[vertex]), areas[vertex]))
    };
    let total: f64 = near().map(|(_, _, area)| area).sum();
    if total <= 0.0 {
        return None;
    }
    let middle = near().map(|(point, _, area)| point * area).sum::<DVec3>() / total;
    let mean = near().map(|(_, child_weight, area)| child_weight * area).sum::<f64>() / total;
    let (mut spread, mut slope) = (DMat3::ZERO, DVec3::ZERO);
    for (point, child_weight, area) in near() {
        let offset = point - middle;
        spread += DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z) * area;
        slope += offset * (area * (child_weight - mean));
    }
    let size = spread
        .x_axis
        .length()
        .max(spread.y_axis.length())
        .max(spread.z_axis.length());
    if spread.determinant().abs() < 1e-9 * size.powi(3) {
        return None;
    }
    (spread.inverse() * slope).try_normalize()
}

/// 0 before `range`, 1 behind it, smooth between.
fn smooth(range: std::ops::Range<f64>, value: f64) -> f64 {
    smooth_step((value - range.start) / (range.end - range.start))
}
