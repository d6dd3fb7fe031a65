//! About which axis muscles turn each joint that they cross: how a joint is tried where nobody says how it bends.
//!
//! A muscle that passes a joint turns it about `arm × direction` of its path there. Flexors and extensors of one hinge have
//! opposite such moments on one line; so the line along which the moments of all its muscles lie best is the joint's axis.

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen};

use crate::muscles::muscle::square_to;
use crate::muscles::musculature::Musculature;
use crate::pose::Palette;

/// Share of the moments (squared) on the axis from which a joint counts as a hinge.
const HINGE_FROM: f64 = 0.74;
/// Bend of the rest pose, radians, from which it shows which way a hinge bends.
const SHOWN_FROM: f64 = 0.05;
/// Rounds after which the search for an axis gives up; a few are enough.
const MOST_ROUNDS: usize = 100;

/// A joint that muscles cross, at the head of its child bone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MuscleJoint {
    /// The bone below.
    pub child: usize,
    /// The bone above.
    pub parent: usize,
    /// Unit, armature space at rest. Of a hinge that is bent at rest, a positive turn bends it further.
    pub axis: DVec3,
    /// Whether it is a hinge whose rest pose shows the one way in which it bends.
    pub bends_one_way: bool,
}

impl Musculature {
    /// The joints that muscles cross, in the order of their child bones.
    pub fn joints(&self) -> Vec<MuscleJoint> {
        let paths = self.paths(&Palette::at_rest(self.skeleton()));
        let mut moments = vec![Matrix3::zeros(); self.skeleton().len()];
        for (tissue, ends) in self.tissues().iter().zip(paths.offsets.windows(2)) {
            let path = &paths.points[ends[0]..ends[1]];
            let length_m: f64 = path.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
            if length_m <= 0.0 {
                continue; // no muscle
            }
            // as strong as it is thick: volume over length
            let strength = tissue.volume() / length_m;
            let bones = self
                .skeleton()
                .path(tissue.origin_bone(), tissue.insertion_bone());
            for &child in &bones {
                if self.skeleton().parents()[child].is_some_and(|parent| bones.contains(&parent)) {
                    let moment = moment(path, self.skeleton().rest()[child].translation);
                    let [x, y, z] = moment.to_array();
                    let moment = nalgebra::Vector3::new(x, y, z);
                    moments[child] += strength * moment * moment.transpose();
                }
            }
        }
        let found = moments.iter().enumerate();
        found
            .filter_map(|(child, moments)| self.joint(child, moments))
            .collect()
    }

    /// The joint above a bone, by the sum of its muscles' moments, each times itself; `None` where none turns it.
    fn joint(&self, child: usize, moments: &Matrix3<f64>) -> Option<MuscleJoint> {
        let parent = self.skeleton().parents()[child]?;
        let eigen = SymmetricEigen::try_new(*moments, f64::EPSILON, MOST_ROUNDS)?;
        let (place, all) = (eigen.eigenvalues.imax(), eigen.eigenvalues.sum());
        let axis = eigen.eigenvectors.column(place);
        let axis = DVec3::new(axis[0], axis[1], axis[2]).try_normalize()?;
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
            bends_one_way: eigen.eigenvalues[place] >= HINGE_FROM * all && bend.abs() >= SHOWN_FROM,
        })
    }
}

/// The moment about `joint` of a pull along `path` where it passes nearest, m.
fn moment(path: &[DVec3], joint: DVec3) -> DVec3 {
    let pass = path.windows(2).map(|ends| {
        let along = ends[1] - ends[0];
        let share =
            ((joint - ends[0]).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (ends[0] + share * along - joint, along.normalize_or_zero())
    });
    let nearest = pass.min_by(|(a, _), (b, _)| a.length_squared().total_cmp(&b.length_squared()));
    nearest.map_or(DVec3::ZERO, |(arm, along)| arm.cross(along))
}

/// The turn about `axis` from one direction to another, as seen along it, radians; 0 where one lies along it.
fn bend_about(axis: DVec3, above: DVec3, below: DVec3) -> f64 {
    match (square_to(axis, above), square_to(axis, below)) {
        (Some(above), Some(below)) => above.cross(below).dot(axis).atan2(above.dot(below)),
        _ => 0.0,
    }
}
