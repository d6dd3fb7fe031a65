//! A tissue that grows into the room that a body leaves: the shape that it takes from its points of the body.
//! (docs/mathematics/fitting.md, Fill)

use glam::{DMat2, DMat3, DQuat, DVec2, DVec3};

use super::placed_tissue::PlacedTissue;
use crate::ellipsoid::{Ellipsoid, volume_m3};
use crate::math::eigen::SymmetricEigen;
use crate::muscles::belly_chain::{LENGTHS, LINKS, POSITIONS, inscribed_width};
use crate::muscles::tissue::{TissueKind, shaft_and_ends};

/// Part of the change of a round that is made.
const DAMPING: f64 = 0.5;
/// A tissue with fewer points keeps its shape.
const FEWEST_POINTS: usize = 24;
/// Factor on the size of stuffing that there is no room for, in a round.
const WITHERING: f64 = 0.8;
/// Volume of a tissue over that of its points. Below 1, neighbours overlap less and leave more gaps.
const FULLNESS: f64 = 1.05;
/// Volume of a belly over the measured one, at least and at most.
const LEAST_OF_MEASURED: f64 = 0.85;
const MOST_OF_MEASURED: f64 = 1.2;
/// Volume over the measured one that a belly strives for where there is room.
const AIM_OF_MEASURED: f64 = 1.1;
/// Largest displacement of a belly across its axis, over its distance from origin to insertion.
const MOVE_OF_LENGTH: f64 = 0.12;
/// Smaller over larger width of a belly, at least.
const FLATTEST: f64 = 0.15;
/// Length of a belly over the placed one, at least and at most.
const SHORTEST: f64 = 0.8;
const LONGEST: f64 = 1.2;
/// How fast the distance bias of a tissue follows its volume, over its mean width.
const BIAS_RATE: f64 = 0.25;

/// What a tissue should become in a filled body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Volume that it should have, m³; 0 for as much as there is room.
    pub volume_m3: f64,
    /// Depth of fat between the tissue and the skin, m.
    pub fat_m: f64,
}

/// Sums over the points of a tissue.
#[derive(Debug, Clone, Copy)]
pub(super) struct Share {
    points: usize,
    sum: DVec3,
    /// Sums of the products of coordinates, about the origin.
    products: DMat3,
}

impl Share {
    pub(super) const NOTHING: Self = Self {
        points: 0,
        sum: DVec3::ZERO,
        products: DMat3::ZERO,
    };

    pub(super) fn add(&mut self, point: DVec3) {
        self.points += 1;
        self.sum += point;
        self.products += DMat3::from_cols(point * point.x, point * point.y, point * point.z);
    }

    fn centre(&self) -> DVec3 {
        self.sum / self.points as f64
    }

    fn covariance(&self) -> DMat3 {
        let centre = self.centre();
        let about_origin = self.products * (1.0 / self.points as f64);
        about_origin - DMat3::from_cols(centre * centre.x, centre * centre.y, centre * centre.z)
    }
}

/// A tissue while it grows.
#[derive(Debug, Clone)]
pub(super) struct Growing {
    pub(super) tissue: PlacedTissue,
    placed: PlacedTissue,
    pub(super) goal: Goal,
    /// The tissue of which it is the mirror image.
    pub(super) twin: Option<usize>,
    /// It is in the middle of the body, and stays symmetric.
    is_central: bool,
    /// Distance by which its surface counts as farther out, m.
    pub(super) bias_m: f64,
}

impl Growing {
    pub(super) fn new(tissue: &PlacedTissue, goal: Goal, twin: Option<usize>, central_m: f64) -> Self {
        let mut start = tissue.clone();
        if goal.volume_m3 > 0.0 {
            let widths = (goal.volume_m3 / volume_m3(tissue.at.semi_axes)).sqrt();
            start = start.widened(widths, widths);
        }
        Self {
            tissue: start,
            placed: tissue.clone(),
            goal,
            twin,
            is_central: tissue.at.centre.x.abs() < central_m,
            bias_m: 0.0,
        }
    }

    /// Whether it takes part; bones and spheres only occupy their place.
    pub(super) fn grows(&self) -> bool {
        matches!(self.tissue.at.kind, TissueKind::Muscle | TissueKind::Stuffing)
    }

    /// The ellipsoids that it consists of.
    pub(super) fn parts(&self) -> Vec<Ellipsoid> {
        let at = &self.tissue.at;
        let envelope = Ellipsoid {
            centre: at.centre,
            axes: self.tissue.axes(),
            semi_axes: at.semi_axes,
        };
        if at.kind == TissueKind::Bone {
            return shaft_and_ends(&envelope).to_vec();
        }
        if at.via_points.is_empty() {
            return vec![envelope];
        }
        links(&self.tissue)
    }

    /// One round: takes the shape of its points, within the limits of its kind.
    pub(super) fn grow(&mut self, share: &Share, cell_m3: f64, reach_m: f64) {
        if !self.grows() || share.points < FEWEST_POINTS {
            if self.tissue.at.kind == TissueKind::Stuffing {
                self.tissue.at.semi_axes *= WITHERING;
            }
            return;
        }
        let got_m3 = share.points as f64 * cell_m3;
        if self.tissue.at.kind == TissueKind::Stuffing {
            self.grow_freely(share, got_m3);
            return;
        }
        if self.goal.volume_m3 > 0.0 {
            let mean_width_m = (self.tissue.at.semi_axes.x * self.tissue.at.semi_axes.y).sqrt();
            let missing = (AIM_OF_MEASURED * self.goal.volume_m3 / got_m3)
                .ln()
                .clamp(-1.0, 1.0);
            self.bias_m =
                (self.bias_m + BIAS_RATE * mean_width_m * missing).clamp(-0.5 * reach_m, 0.5 * reach_m);
        }
        if self.tissue.at.via_points.is_empty() {
            self.grow_across(share, got_m3);
        } else {
            let wanted = self.wanted_m3(got_m3) / volume_m3(self.tissue.at.semi_axes);
            let factor = wanted.powf(0.5 * DAMPING);
            self.tissue = self.tissue.widened(factor, factor);
        }
    }

    /// The volume for points of this volume, within what was measured.
    fn wanted_m3(&self, got_m3: f64) -> f64 {
        let goal_m3 = self.goal.volume_m3;
        if goal_m3 > 0.0 {
            (FULLNESS * got_m3).clamp(LEAST_OF_MEASURED * goal_m3, MOST_OF_MEASURED * goal_m3)
        } else {
            FULLNESS * got_m3
        }
    }

    fn grow_across(&mut self, share: &Share, got_m3: f64) {
        let at = &self.tissue.at;
        let axes = self.tissue.axes();
        let semi_axes = at.semi_axes;
        // in local axes
        let offset = axes.transpose() * (share.centre() - at.centre);
        let covariance = axes.transpose() * share.covariance() * axes;
        let across = DMat2::from_cols(covariance.x_axis.truncate(), covariance.y_axis.truncate());
        let (angle, variances) = principal_axes(across);
        let widths = DVec2::new(variances.x.sqrt(), variances.y.sqrt()) * 5.0_f64.sqrt();
        let placed_z_m = self.placed.at.semi_axes.z;
        let half_m = (5.0 * covariance.z_axis.z)
            .sqrt()
            .clamp(SHORTEST * placed_z_m, LONGEST * placed_z_m);

        let mut target = DVec3::new(widths.x, widths.y, half_m).max(DVec3::splat(1e-6));
        let flattest = FLATTEST * target.x.max(target.y);
        target = DVec3::new(target.x.max(flattest), target.y.max(flattest), target.z);
        let factor = (self.wanted_m3(got_m3) / volume_m3(target)).sqrt();
        target *= DVec3::new(factor, factor, 1.0);

        let roll = DQuat::from_axis_angle(axes.z_axis, DAMPING * angle);
        let whole_m = (self.placed.insertion() - self.placed.origin()).length();
        let moved = at.centre + (axes.x_axis * offset.x + axes.y_axis * offset.y) * DAMPING;
        let from_placed = moved - self.placed.at.centre;
        let along = axes.z_axis * from_placed.dot(axes.z_axis);
        let aside = (from_placed - along).clamp_length_max(MOVE_OF_LENGTH * whole_m);

        // the belly between origin and insertion, in distances from the placed centre along the axis
        let z_m = blend(semi_axes.z, target.z);
        let (low_m, high_m) = (
            -placed_z_m - self.placed.at.origin_tendon_m,
            placed_z_m + self.placed.at.insertion_tendon_m,
        );
        let z_m = z_m.min(0.5 * (high_m - low_m));
        let centre_m = (from_placed.dot(axes.z_axis) + DAMPING * offset.z)
            .min(high_m - z_m)
            .max(low_m + z_m);
        let at = &mut self.tissue.at;
        at.centre = self.placed.at.centre + aside + axes.z_axis * centre_m;
        at.rotation = (roll * at.rotation).normalize();
        at.semi_axes = DVec3::new(blend(semi_axes.x, target.x), blend(semi_axes.y, target.y), z_m);
        at.origin_tendon_m = (centre_m - z_m - low_m).max(0.0);
        at.insertion_tendon_m = (high_m - centre_m - z_m).max(0.0);
    }

    /// Stuffing takes centre, axes and semi-axes of its points.
    fn grow_freely(&mut self, share: &Share, got_m3: f64) {
        let axes = self.tissue.axes();
        let is_central = self.is_central;
        let mut covariance = share.covariance();
        let mut centre = share.centre();
        if is_central {
            centre.x = 0.0;
            covariance.x_axis = DVec3::new(covariance.x_axis.x, 0.0, 0.0);
            covariance.y_axis.x = 0.0;
            covariance.z_axis.x = 0.0;
        }
        let Some(eigen) = SymmetricEigen::new(covariance.to_cols_array_2d()) else {
            return;
        };
        let found: [DVec3; 3] = eigen.vectors.map(DVec3::from_array);
        let (order, semi_axes) = nearest_order(&found, eigen.values, axes);
        let target = semi_axes.max(DVec3::splat(1e-6));
        let factor = (FULLNESS * got_m3 / volume_m3(target)).cbrt();
        let at = &mut self.tissue.at;
        at.centre += (centre - at.centre) * DAMPING;
        at.rotation = DQuat::from_mat3(&order).normalize();
        let target = target * factor;
        at.semi_axes = DVec3::new(
            blend(at.semi_axes.x, target.x),
            blend(at.semi_axes.y, target.y),
            blend(at.semi_axes.z, target.z),
        );
    }
}

/// Halfway between two lengths, on a logarithmic scale.
fn blend(from: f64, to: f64) -> f64 {
    from * (to / from).powf(DAMPING)
}

/// The angle by which the axes turn to the nearest principal axes of a symmetric matrix, and the values along them.
fn principal_axes(matrix: DMat2) -> (f64, DVec2) {
    let (xx, xy, yy) = (matrix.x_axis.x, matrix.x_axis.y, matrix.y_axis.y);
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = half.hypot(xy);
    // within a quarter turn: x keeps the larger value if it has it
    let angle = if half >= 0.0 {
        0.5 * xy.atan2(half)
    } else {
        0.5 * (-xy).atan2(-half)
    };
    let larger = mean + radius;
    let smaller = (mean - radius).max(0.0);
    let values = if half >= 0.0 {
        DVec2::new(larger, smaller)
    } else {
        DVec2::new(smaller, larger)
    };
    (angle, values)
}

/// The principal axes in the order and with the signs nearest to `axes`, and the semi-axes of the ellipsoid with these variances.
fn nearest_order(found: &[DVec3; 3], variances: [f64; 3], axes: DMat3) -> (DMat3, DVec3) {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let agreement = |order: &[usize; 3]| -> f64 {
        (0..3)
            .map(|axis| found[order[axis]].dot(axes.col(axis)).abs())
            .sum()
    };
    let mut best = ORDERS[0];
    for order in ORDERS {
        if agreement(&order) > agreement(&best) + 1e-9 {
            best = order;
        }
    }
    let toward = |axis: usize| {
        let vector = found[best[axis]];
        if vector.dot(axes.col(axis)) < 0.0 {
            -vector
        } else {
            vector
        }
    };
    let (x, y) = (toward(0), toward(1));
    let semi_axes = best.map(|index| (5.0 * variances[index].max(0.0)).sqrt());
    (DMat3::from_cols(x, y, x.cross(y)), DVec3::from_array(semi_axes))
}

/// The ellipsoids along the path of a curved muscle, without cubic pieces.
fn links(tissue: &PlacedTissue) -> Vec<Ellipsoid> {
    let path = tissue.path();
    let tendons_m = tissue.at.origin_tendon_m + tissue.at.insertion_tendon_m;
    let half_m = 0.5 * (path.length() - tendons_m);
    let middle_m = tissue.at.origin_tendon_m + half_m;
    (0..LINKS)
        .map(|link| {
            let centre_m = middle_m + POSITIONS[link] * half_m;
            let length_m = LENGTHS[link] * half_m;
            let chord = path.at(centre_m + 0.5 * length_m) - path.at(centre_m - 0.5 * length_m);
            let z = chord.normalize_or(tissue.axes().z_axis);
            let x = (tissue.axes().x_axis - z * tissue.axes().x_axis.dot(z))
                .normalize_or(z.any_orthonormal_vector());
            let width = inscribed_width(POSITIONS[link], LENGTHS[link]);
            Ellipsoid {
                centre: path.at(centre_m),
                axes: DMat3::from_cols(x, z.cross(x), z),
                semi_axes: DVec3::new(
                    tissue.at.semi_axes.x * width,
                    tissue.at.semi_axes.y * width,
                    length_m,
                ),
            }
        })
        .collect()
}
