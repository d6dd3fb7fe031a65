//! The axis about which muscles rotate each joint that they cross (mathematics/muscles.md, Joint axes).
//! Correctives and measurements use it for joints without limits.
//!
//! A muscle that passes a joint rotates it about `arm × direction` of its path there. Flexors and extensors
//! of a hinge have opposite moments on one line. So the axis of the joint is the line that fits the moments
//! of all its muscles best: the eigenvector of the largest eigenvalue of the sum of `moment momentᵀ`.

use glam::{DMat3, DVec3};

use crate::math::eigen::SymmetricEigen;
use crate::math::outer::outer;
use crate::muscles::muscle::perpendicular_part;
use crate::muscles::musculature::Musculature;
use crate::pose::Palette;

/// Fraction of the squared moments on the axis from which a joint counts as a hinge.
const HINGE_FROM: f64 = 0.74;
/// Bend of the rest pose, radians, from which the rest pose shows in which direction a hinge bends.
const SHOWN_FROM: f64 = 0.05;

/// A joint that muscles cross. It is at the head of its child bone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MuscleJoint {
    /// Index of the bone below.
    pub child: usize,
    /// Index of the bone above.
    pub parent: usize,
    /// Unit axis, armature space, at rest. A positive rotation bends a hinge further that is bent at rest.
    pub axis: DVec3,
    /// True for a hinge whose rest pose shows in which direction it bends.
    pub bends_one_way: bool,
}

impl Musculature {
    /// The joints that muscles cross, ordered by child bone.
    pub fn joints(&self) -> Vec<MuscleJoint> {
        let paths = self.paths(&Palette::at_rest(self.skeleton()));
        let mut moments = vec![DMat3::ZERO; self.skeleton().len()];
        for (tissue, path) in self.tissues().iter().zip(paths.iter()) {
            let length_m: f64 = path.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
            if length_m <= 0.0 {
                continue; // not a muscle
            }
            // a muscle is as strong as it is thick: volume over length
            let strength = tissue.volume() / length_m;
            let bones = self
                .skeleton()
                .path(tissue.origin_bone(), tissue.insertion_bone());
            for &child in &bones {
                if self.skeleton().parents()[child].is_some_and(|parent| bones.contains(&parent)) {
                    let moment = moment(path, self.skeleton().rest()[child].translation);
                    moments[child] += outer(strength * moment, moment);
                }
            }
        }
        let found = moments.iter().enumerate();
        found
            .filter_map(|(child, moments)| self.joint(child, moments))
            .collect()
    }

    /// The joint at the head of bone `child`, from the sum of `strength · moment momentᵀ` of its muscles;
    /// `None` if none of them has a moment.
    fn joint(&self, child: usize, moments: &DMat3) -> Option<MuscleJoint> {
        let parent = self.skeleton().parents()[child]?;
        let eigen = SymmetricEigen::new(moments.to_cols_array_2d())?;
        let (largest, all) = (eigen.largest(), eigen.values.iter().sum::<f64>());
        let axis = DVec3::from_array(eigen.vectors[largest]).try_normalize()?;
        if all <= 0.0 {
            return None;
        }
        let rest = self.skeleton().rest();
        let above = rest[child].translation - rest[parent].translation;
        let bend = bend_about(axis, above, rest[child].matrix3.y_axis);
        Some(MuscleJoint {
            child,
            parent,
            axis: axis * if bend < 0.0 { -1.0 } else { 1.0 },
            bends_one_way: eigen.values[largest] >= HINGE_FROM * all && bend.abs() >= SHOWN_FROM,
        })
    }
}

/// The moment about `joint`, m, of a unit pull along the nearest part of `path`.
fn moment(path: &[DVec3], joint: DVec3) -> DVec3 {
    let pass = path.windows(2).map(|ends| {
        let along = ends[1] - ends[0];
        let fraction =
            ((joint - ends[0]).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (ends[0] + fraction * along - joint, along.normalize_or_zero())
    });
    let nearest = pass.min_by(|(a, _), (b, _)| a.length_squared().total_cmp(&b.length_squared()));
    nearest.map_or(DVec3::ZERO, |(arm, along)| arm.cross(along))
}

/// The rotation about `axis` from one direction to another, radians; 0 if one of them is along the axis.
fn bend_about(axis: DVec3, above: DVec3, below: DVec3) -> f64 {
    match (perpendicular_part(axis, above), perpendicular_part(axis, below)) {
        (Some(above), Some(below)) => above.cross(below).dot(axis).atan2(above.dot(below)),
        _ => 0.0,
    }
}
