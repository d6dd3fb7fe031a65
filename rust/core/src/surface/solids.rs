//! The tissues as solids: their ellipsoids, each extended by the thickness of the skin over it.

use glam::DVec3;
use rayon::prelude::*;

use crate::ellipsoid::Ellipsoid;
use crate::muscles::musculature::Musculature;

/// Half width, in voxels, of parts that are never lost: a ball with this radius contains the centre of a
/// voxel, wherever it is (half the diagonal of a cube, and a margin).
const LEAST_HALF_WIDTH: f64 = 0.9;
/// Distance between the points where a tissue is tested, in voxels.
const TEST_STEP: f64 = 0.5;
/// Distance of the last of these points from the edge of the tissue, in voxels.
const FROM_EDGE: f64 = 0.25;
/// Most test points on each side of the centre along an axis.
const MOST_TESTS: f64 = 64.0;
/// Smallest semi-axis of a rounded tissue, in voxels.
const LEAST_SEMI_AXIS: f64 = 1e-3;

/// An ellipsoid extended by a thickness.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solid {
    /// Index of its tissue.
    pub tissue: usize,
    /// The ellipsoid, armature space.
    pub ellipsoid: Ellipsoid,
    /// Thickness of the layer around it, m.
    pub thickness_m: f64,
}

impl Solid {
    /// Half of its extent along the axes of armature space, m.
    pub fn half_extent_m(&self) -> DVec3 {
        let Ellipsoid { axes, semi_axes, .. } = self.ellipsoid;
        let scaled = [
            axes.x_axis * semi_axes.x,
            axes.y_axis * semi_axes.y,
            axes.z_axis * semi_axes.z,
        ];
        let squares = scaled.iter().map(|axis| axis * axis).sum::<DVec3>();
        squares.map(f64::sqrt) + self.thickness_m
    }

    /// The depth of `point` inside, m; negative outside.
    pub fn depth_m(&self, point: DVec3) -> f64 {
        self.thickness_m - self.ellipsoid.nearest(point).distance_m
    }

    /// An upper bound of the depth of `point`, m.
    pub fn depth_bound_m(&self, point: DVec3) -> f64 {
        let local = (self.ellipsoid.axes.transpose() * (point - self.ellipsoid.centre)).abs();
        let beyond = local - self.ellipsoid.semi_axes;
        let outside = beyond.max(DVec3::ZERO).length();
        if outside > 0.0 {
            self.thickness_m - outside
        } else {
            self.thickness_m - beyond.max_element()
        }
    }

    /// Half of its smallest width, m.
    fn half_width_m(&self) -> f64 {
        self.ellipsoid.semi_axes.min_element() + self.thickness_m
    }

    /// True if voxels of this size may miss parts of it.
    pub fn is_thin(&self, voxel_m: f64) -> bool {
        self.half_width_m() < LEAST_HALF_WIDTH * voxel_m
    }

    /// Test points over its two longer axes, except near the edge, where voxels of this size may miss it.
    fn thin_places(&self, voxel_m: f64) -> impl Iterator<Item = DVec3> {
        let Ellipsoid {
            centre,
            axes,
            semi_axes,
        } = self.ellipsoid;
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| semi_axes[b].total_cmp(&semi_axes[a]));
        let [long, middle, short] = order;
        let step_m = TEST_STEP * voxel_m;
        let tested_m = |axis: usize| (semi_axes[axis] - FROM_EDGE * voxel_m).max(0.0);
        let [(long_m, along), (middle_m, across)] = [long, middle].map(|axis| {
            let steps = (tested_m(axis) / step_m).ceil().clamp(1.0, MOST_TESTS);
            (tested_m(axis), steps as i32)
        });
        let missing_m = LEAST_HALF_WIDTH * voxel_m - self.thickness_m;
        (-along..=along).flat_map(move |i| {
            (-across..=across).filter_map(move |j| {
                let (u, v) = (f64::from(i) / f64::from(along), f64::from(j) / f64::from(across));
                let (u_m, v_m) = (u * long_m, v * middle_m);
                let aside = (u_m / semi_axes[long]).powi(2) + (v_m / semi_axes[middle]).powi(2);
                let half_m = semi_axes[short] * (1.0 - aside).max(0.0).sqrt();
                let is_tested = u * u + v * v <= 1.0 && half_m < missing_m;
                is_tested.then(|| centre + axes.col(long) * u_m + axes.col(middle) * v_m)
            })
        })
    }
}

/// The ellipsoids of all tissues in the rest pose, each extended by the thickness over its tissue.
pub(super) fn solids_of(musculature: &Musculature, thickness_m: &[f64]) -> Vec<Solid> {
    let owners = musculature.ellipsoid_tissues().iter();
    let solid = |(ellipsoid, &tissue): (&Ellipsoid, &usize)| Solid {
        tissue,
        ellipsoid: *ellipsoid,
        thickness_m: thickness_m[tissue],
    };
    musculature.ellipsoids().iter().zip(owners).map(solid).collect()
}

/// Lower and upper corner of the bounding box of `solids`, armature space, m.
pub(super) fn bounds_of(solids: &[Solid]) -> (DVec3, DVec3) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    solids.iter().fold(none, |(low, high), solid| {
        let (centre, half) = (solid.ellipsoid.centre, solid.half_extent_m());
        (low.min(centre - half), high.max(centre + half))
    })
}

/// Indices of the solids of which a field with voxels of this size has lost a part: a test point is not
/// inside.
pub(super) fn lost(solids: &[Solid], voxel_m: f64, is_inside: impl Fn(DVec3) -> bool + Sync) -> Vec<usize> {
    let has_lost = |index: &usize| !solids[*index].thin_places(voxel_m).all(&is_inside);
    (0..solids.len()).into_par_iter().filter(has_lost).collect()
}

/// Some of `solids`, with the same length and width, rounded so that voxels of this size miss no part: thin
/// parts become thicker and points become blunt.
pub(super) fn rounded(solids: &[Solid], which: &[usize], voxel_m: f64) -> Vec<Solid> {
    let round = |&index: &usize| {
        let mut solid = solids[index];
        let radius_m = (LEAST_HALF_WIDTH * voxel_m - solid.thickness_m).max(0.0);
        let semi_axes = solid.ellipsoid.semi_axes;
        // the smoothing draws in the ends of tissues that are thin everywhere
        let shrunk = |axis: f64| {
            if solid.is_thin(voxel_m) && axis > radius_m {
                axis - 0.5 * radius_m
            } else {
                axis - radius_m
            }
        };
        solid.ellipsoid.semi_axes = semi_axes.map(|axis| shrunk(axis).max(LEAST_SEMI_AXIS * voxel_m));
        solid.thickness_m += radius_m;
        solid
    };
    which.iter().map(round).collect()
}
