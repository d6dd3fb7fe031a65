//! The tissues as solids: their ellipsoids, each grown by the thickness of the skin over it.

use glam::DVec3;
use rayon::prelude::*;

use crate::ellipsoid::Ellipsoid;
use crate::muscles::musculature::Musculature;

/// Half width, in voxels, that any thread needs to be kept: a ball of this radius holds the centre of a voxel wherever it
/// lies (half of a cube's diagonal, and a little).
const LEAST_HALF_WIDTH: f64 = 0.9;
/// Distance between the places where a tissue is tested, in voxels.
const TEST_STEP: f64 = 0.5;
/// Distance of the last of them from its edge, in voxels.
const FROM_EDGE: f64 = 0.25;
/// Most places tested on either side of its middle along an axis.
const MOST_TESTS: f64 = 64.0;
/// Smallest semi-axis of what is left of a thin tissue, in voxels.
const LEAST_SEMI_AXIS: f64 = 1e-3;

/// An ellipsoid grown by a thickness.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solid {
    /// Index of its tissue.
    pub tissue: usize,
    /// The ellipsoid, armature space.
    pub ellipsoid: Ellipsoid,
    /// How far its surface is grown outward, m.
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

    /// How deep `point` lies inside, m; below 0 outside.
    pub fn depth_m(&self, point: DVec3) -> f64 {
        self.thickness_m - self.ellipsoid.nearest(point).distance_m
    }

    /// A depth, m, that the true depth of `point` is never above.
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

    /// True if it is so thin that voxels of this size may miss it.
    pub fn is_thin(&self, voxel_m: f64) -> bool {
        self.half_width_m() < LEAST_HALF_WIDTH * voxel_m
    }

    /// Places all over its two longer axes, but for the outermost edge, where voxels of this size may miss it.
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

/// The ellipsoids of all tissues in the rest pose, each grown by its tissue's thickness.
pub(super) fn solids_of(musculature: &Musculature, thickness_m: &[f64]) -> Vec<Solid> {
    let owners = musculature.ellipsoid_tissues().iter();
    let solid = |(ellipsoid, &tissue): (&Ellipsoid, &usize)| Solid {
        tissue,
        ellipsoid: *ellipsoid,
        thickness_m: thickness_m[tissue],
    };
    musculature.ellipsoids().iter().zip(owners).map(solid).collect()
}

/// The corners of the box around all `solids`, armature space, m.
pub(super) fn bounds_of(solids: &[Solid]) -> (DVec3, DVec3) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    solids.iter().fold(none, |(low, high), solid| {
        let (centre, half) = (solid.ellipsoid.centre, solid.half_extent_m());
        (low.min(centre - half), high.max(centre + half))
    })
}

/// Of which solids a field sampled in voxels of this size has lost a part: it is not inside where they are.
pub(super) fn lost(solids: &[Solid], voxel_m: f64, is_inside: impl Fn(DVec3) -> bool + Sync) -> Vec<usize> {
    let has_lost = |index: &usize| !solids[*index].thin_places(voxel_m).all(&is_inside);
    (0..solids.len()).into_par_iter().filter(has_lost).collect()
}

/// Some of `solids`, as long and wide as they are, but rounded so much that voxels of this size miss nothing: what is thinner
/// becomes thicker, points become blunt.
pub(super) fn rounded(solids: &[Solid], which: &[usize], voxel_m: f64) -> Vec<Solid> {
    let round = |&index: &usize| {
        let mut solid = solids[index];
        let radius_m = (LEAST_HALF_WIDTH * voxel_m - solid.thickness_m).max(0.0);
        let semi_axes = solid.ellipsoid.semi_axes;
        // the ends of what is all thin are drawn in when faces are evened out
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
