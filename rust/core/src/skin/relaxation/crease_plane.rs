//! The crease plane of a joint: a plane through the joint that keeps the skin of its two bones on their
//! sides, so that a bend folds into a crease (mathematics/contact.md, Crease plane). Its normal is a
//! blend of one rest normal, rotated with both bones.

use std::f64::consts::PI;

use glam::{Affine3A, DMat3, DVec3, Vec3A};

use crate::math::smoothstep::{smooth_step, smooth_step_single};
use crate::pose::Palette;
use crate::skin::relaxation::elastic_mesh::ElasticMesh;
use crate::skin::relaxation::joint::{Joint, JointSkin};

/// Margin of a vertex over the distance of its child weight from one half, in radii of the joint: skin
/// near the crease may come nearer to the plane than skin of the limbs.
const MARGIN_SLOPE: f64 = 0.1;
/// Distance of a child weight from one half below which the vertex may be on either side of the plane.
/// The weights do not decide there.
const SLACK: f64 = 0.032;
/// Largest margin, in radii of the joint. Measured: an elbow closes to 0.5 mm and a knee to 1 mm; with
/// 0.016 they stayed 4 and 7 mm open.
const LARGEST_MARGIN_OF_RADIUS: f64 = 0.002;
/// Distance, in radii of the joint, between where a vertex's strongest bone and the joint's bone on that
/// side take it, at which the plane releases the vertex.
const RELEASE_OF_RADIUS: f64 = 0.4;
/// Distances from the joint, in its radii, between which the plane fades out. It must reach beyond the
/// patch's fade, so that no step shows.
const RADIAL_FADE: std::ops::Range<f64> = 1.2..1.6;
/// Fraction of a joint's skin that is on its side of the plane at rest, between which the plane fades in.
/// Measured on one body: shoulder 0.89, elbow 0.97; a head, a collar bone and most of a spine are below,
/// because no plane separates their weights.
const SEPARABILITY: std::ops::Range<f64> = 0.75..0.88;
/// Largest blend of the normal towards one of the bones. Measured: with one half for all joints the plane
/// of an ankle pressed on the toes of a raised foot (60°: 261 new self-intersections, none with this
/// rule).
const LARGEST_BLEND: f64 = 0.62;
/// Distances from the line of the child bone, over the mean distance of the transition from it, between
/// which the plane releases skin of the child's side: an arm that hangs beside a trunk is not part of its
/// waist.
const LATERAL_FADE: std::ops::Range<f64> = 1.5..2.0;
/// Smallest angle between a limb and the plane at rest, rad: the directions of a pelvis or a shoulder
/// blade are not those of limbs.
const SMALLEST_LIMB_ANGLE: f64 = 0.6;
/// Distance of a vertex's anchor from the plane, in radii of the joint, up to which the vertex is
/// projected in every iteration. Others rarely reach the plane and are projected after the last iteration.
const NEAR_OF_RADIUS: f32 = 0.25;
/// Swings of the child bone between which the plane fades in, rad. A pure twist needs no plane.
const SWING_FADE: std::ops::Range<f64> = 0.0..PI / 6.0;

/// A vertex that the plane constrains, at rest.
#[derive(Debug, Clone, Copy)]
struct HeldVertex {
    vertex: u32,
    /// +1 on the child's side, -1 on the parent's.
    side: f32,
    /// Smallest height above the plane on its side, m; negative if it may pass the plane. Not more than
    /// its height at rest: the plane does not separate the weights exactly.
    margin_m: f32,
    /// Fraction of the penetration that is corrected, 0 to 1.
    firmness: f32,
    /// Its strongest bone on its side, as an index into the other bones of the crease; `None` if that is
    /// the joint's bone.
    other: Option<u32>,
    /// Position at rest, m.
    rest: Vec3A,
}

/// A bone, other than the two of the joint, that moves skin of one side.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OtherBone {
    bone: usize,
    is_child: bool,
}

/// The crease plane of a joint, at rest.
#[derive(Debug, Clone)]
pub(crate) struct Crease {
    normal: DVec3,
    /// Blend of the normal from the parent to the child, 0 to 1: the parent limb's part of the angle
    /// between the limbs, so that both reach the plane at the same time.
    blend: f64,
    held: Vec<HeldVertex>,
    other_bones: Vec<OtherBone>,
}

/// The crease plane in one pose, and the vertices that it constrains.
#[derive(Debug)]
pub(crate) struct PosedCrease {
    through: Vec3A,
    normal: Vec3A,
    /// For each of the other bones, its map less the map of the joint's bone on that side.
    relative: Vec<Affine3A>,
    /// The vertices near the plane, and the others.
    near: Vec<PosedConstraint>,
    far: Vec<PosedConstraint>,
}

/// A vertex that the plane constrains in a pose.
#[derive(Debug, Clone, Copy)]
struct PosedConstraint {
    vertex: u32,
    side: f32,
    /// Smallest displacement away from the plane, on its side, m; negative if the swollen anchor is clear
    /// of the plane.
    least_m: f32,
    firmness: f32,
}

impl Crease {
    /// The crease plane of a joint; `areas` are the weights of the vertices, m². `None` if the bone
    /// weights determine no direction, or no plane separates them.
    pub fn new(skin: &JointSkin, mesh: &ElasticMesh, areas: &[f64]) -> Option<Self> {
        let points = mesh.points;
        let joint = &skin.joint;
        let normal = weight_gradient(skin, points, areas)?;
        let strength = smooth(SEPARABILITY, separability(skin, points, areas, normal));
        if strength == 0.0 {
            return None;
        }
        let from_line = |point: DVec3| {
            (point - joint.centre)
                .reject_from_normalized(joint.direction)
                .length()
        };
        let transition_m = transition_m(skin, points, areas, from_line);
        let mut other_bones = vec![];
        let held = skin
            .weighed_patch()
            .filter_map(|(at, child_weight)| {
                let distance = joint.radii_to(points[at]);
                let from_middle = f64::from(child_weight) - 0.5;
                let is_child = from_middle > 0.0;
                let mut firmness = strength
                    * ((RADIAL_FADE.end - distance) / (RADIAL_FADE.end - RADIAL_FADE.start)).clamp(0.0, 1.0);
                if is_child {
                    firmness *= 1.0 - smooth(LATERAL_FADE, from_line(points[at]) / transition_m);
                }
                let side = if is_child { 1.0 } else { -1.0 };
                let on_side = mesh
                    .weights
                    .of(at)
                    .iter()
                    .filter(|entry| skin.is_below[entry.bone as usize] == is_child);
                let bone = on_side
                    .max_by(|a, b| a.weight.total_cmp(&b.weight).then(b.bone.cmp(&a.bone)))?
                    .bone as usize;
                let other = OtherBone { bone, is_child };
                let margin = MARGIN_SLOPE * (from_middle.abs() - SLACK);
                let margin_m = margin.min(LARGEST_MARGIN_OF_RADIUS) * joint.radius_m;
                let at_rest_m = side * (points[at] - joint.centre).dot(normal);
                (firmness > 0.0).then(|| HeldVertex {
                    other: (bone != if is_child { joint.child } else { joint.parent })
                        .then(|| index_in(&mut other_bones, other)),
                    rest: points[at].as_vec3a(),
                    vertex: at as u32,
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

    /// Sets the plane and its constraints for a pose. `strength` is 0 to 1. A pure twist has no plane. A
    /// vertex that moves against the joint's bone on its side is released: another finger, the other leg,
    /// a fingertip that returns to the palm.
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
        let rotated = |linear: DMat3, direction: DVec3| (linear * direction).normalize_or_zero();
        let swing =
            rotated(parent.matrix3, joint.direction).angle_between(rotated(child.matrix3, joint.direction));
        let normal =
            rotated(parent.matrix3, self.normal).lerp(rotated(child.matrix3, self.normal), self.blend);
        posed.through = parent.transform_point3(joint.centre).as_vec3a();
        posed.normal = normal.normalize_or_zero().as_vec3a();
        posed.relative.clear();
        posed.near.clear();
        posed.far.clear();
        if normal.length() <= 1e-6 {
            return; // folded onto itself: no plane is between
        }
        posed.relative.extend(self.other_bones.iter().map(|other| {
            let joint_bone = if other.is_child { child } else { parent };
            let matrix = palette.skinning_matrices()[other.bone];
            Affine3A {
                matrix3: (matrix.matrix3 - joint_bone.matrix3).as_mat3().into(),
                translation: (matrix.translation - joint_bone.translation).as_vec3a(),
            }
        }));
        let scale = palette.scales()[joint.parent] as f32;
        let firmness = strength * smooth(SWING_FADE, swing) as f32;
        let release_m = (RELEASE_OF_RADIUS * joint.radius_m) as f32 * scale;
        let near_m = NEAR_OF_RADIUS * joint.radius_m as f32 * scale;
        for held in &self.held {
            let mut firmness = held.firmness * firmness;
            if let Some(other) = held.other {
                let relative_m = posed.relative[other as usize]
                    .transform_point3a(held.rest)
                    .length();
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
    /// The buffers for `crease`.
    pub fn new(crease: &Crease) -> Self {
        Self {
            through: Vec3A::ZERO,
            normal: Vec3A::ZERO,
            relative: Vec::with_capacity(crease.other_bones.len()),
            near: Vec::with_capacity(crease.held.len()),
            far: Vec::with_capacity(crease.held.len()),
        }
    }

    /// Moves vertices that are below their smallest height back along the normal, by their firmness.
    /// `displacements` are those from the anchors. Vertices that were far from the plane are included
    /// only in the last iteration.
    pub fn project(&self, displacements: &mut [Vec3A], is_last: bool) {
        let far: &[PosedConstraint] = if is_last { &self.far } else { &[] };
        for constraint in self.near.iter().chain(far) {
            let displacement = &mut displacements[constraint.vertex as usize];
            let penetration_m = constraint.least_m - constraint.side * displacement.dot(self.normal);
            if penetration_m > 0.0 {
                *displacement += self.normal * (constraint.side * penetration_m * constraint.firmness);
            }
        }
    }
}

/// The index of `other` in `other_bones`. Appends it if it is missing.
fn index_in(other_bones: &mut Vec<OtherBone>, other: OtherBone) -> u32 {
    let index = other_bones
        .iter()
        .position(|known| *known == other)
        .unwrap_or_else(|| {
            other_bones.push(other);
            other_bones.len() - 1
        });
    index as u32
}

/// Fraction of the skin's area within the joint's radius that is at rest on the side that its weights
/// say.
fn separability(skin: &JointSkin, points: &[DVec3], areas: &[f64], normal: DVec3) -> f64 {
    let (mut agreeing, mut total) = (0.0, 0.0);
    for (vertex, child_weight) in skin.weighed_patch() {
        if skin.joint.radii_to(points[vertex]) < 1.0 {
            let is_child = child_weight > 0.5;
            let is_on_child_side = (points[vertex] - skin.joint.centre).dot(normal) > 0.0;
            total += areas[vertex];
            agreeing += if is_child == is_on_child_side {
                areas[vertex]
            } else {
                0.0
            };
        }
    }
    agreeing / f64::max(total, f64::MIN_POSITIVE)
}

/// Mean distance of the transition from the line of the child bone, m.
fn transition_m(skin: &JointSkin, points: &[DVec3], areas: &[f64], from_line: impl Fn(DVec3) -> f64) -> f64 {
    let (mut sum, mut total) = (0.0, f64::MIN_POSITIVE);
    for (vertex, child_weight) in skin.weighed_patch() {
        let child_weight = f64::from(child_weight);
        let weight = areas[vertex] * child_weight * (1.0 - child_weight);
        sum += weight * from_line(points[vertex]);
        total += weight;
    }
    sum / total
}

/// The unit gradient of the child weight: of a linear fit, weighted by area, within the joint's radius.
fn weight_gradient(skin: &JointSkin, points: &[DVec3], areas: &[f64]) -> Option<DVec3> {
    let near = || {
        let near = skin.weighed_patch();
        near.filter(|&(vertex, _)| skin.joint.radii_to(points[vertex]) < 1.0)
            .map(|(vertex, child_weight)| (points[vertex], f64::from(child_weight), areas[vertex]))
    };
    let total: f64 = near().map(|(_, _, area)| area).sum();
    if total <= 0.0 {
        return None;
    }
    let middle = near().map(|(point, _, area)| point * area).sum::<DVec3>() / total;
    let mean = near()
        .map(|(_, child_weight, area)| child_weight * area)
        .sum::<f64>()
        / total;
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

/// 0 below `range`, 1 above it, smooth between.
fn smooth(range: std::ops::Range<f64>, value: f64) -> f64 {
    smooth_step((value - range.start) / (range.end - range.start))
}
