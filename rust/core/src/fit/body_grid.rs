//! The inside of a body as the points of a regular grid. (docs/mathematics/fitting.md, Fill)
//!
//! The grid is the same on both sides of the plane x = 0.

use glam::{DVec3, UVec3};
use rayon::prelude::*;

use super::skin_surface::SkinSurface;

/// Number of points inside the body that the spacing is chosen for: 8 mm on a person.
const WANTED_POINTS: f64 = 120_000.0;
/// Points along the longest side of the skin of the grid that measures the volume of the body: 17 mm on a person.
const COARSE_ALONG: f64 = 100.0;
/// Most points along the longest side, for bodies that are almost flat.
const MOST_ALONG: f64 = 400.0;

/// The volume of a body, m³: overlapping shells count once. Counted on a grid, to about one part in a hundred.
pub fn volume_m3(skin: &SkinSurface) -> f64 {
    let grid = BodyGrid::inside(skin, skin.size_m() / COARSE_ALONG);
    grid.depths_m.iter().filter(|&&depth_m| depth_m > 0.0).count() as f64 * grid.cell_m3()
}

/// The points of a regular grid around a body, those inside, and how deep under the skin they are.
#[derive(Debug, Clone)]
pub(super) struct BodyGrid {
    /// Distance of neighbouring points, m.
    pub(super) spacing_m: f64,
    low: DVec3,
    counts: UVec3,
    /// Depth of each point under the skin, m; infinite if it is deeper than anyone asked; negative outside.
    depths_m: Vec<f32>,
}

impl BodyGrid {
    /// The grid of a body. Depths are known up to `deepest_m`.
    pub(super) fn new(skin: &SkinSurface, deepest_m: f64) -> Self {
        let spacing_m = (volume_m3(skin) / WANTED_POINTS).cbrt();
        let mut grid = Self::inside(skin, spacing_m.max(skin.size_m() / MOST_ALONG));
        grid.measure_depths(skin, deepest_m);
        grid
    }

    /// Volume for which a point counts, m³.
    pub(super) fn cell_m3(&self) -> f64 {
        self.spacing_m.powi(3)
    }

    /// The number of points of the whole grid.
    pub(super) fn len(&self) -> usize {
        self.depths_m.len()
    }

    /// The position of a point, m.
    fn point(&self, x: u32, y: u32, z: u32) -> DVec3 {
        self.low + DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * self.spacing_m
    }

    /// The position of the point with this index, m.
    pub(super) fn point_at(&self, index: usize) -> DVec3 {
        let [across, along] = [self.counts.x as usize, self.counts.y as usize];
        let (x, y, z) = (index % across, index / across % along, index / (across * along));
        self.point(x as u32, y as u32, z as u32)
    }

    fn index(&self, x: u32, y: u32, z: u32) -> usize {
        ((z * self.counts.y + y) * self.counts.x + x) as usize
    }

    /// Depth of a point under the skin, m.
    pub(super) fn depth_m(&self, index: usize) -> f64 {
        f64::from(self.depths_m[index])
    }

    /// The points within `low` and `high`: index and position, m.
    pub(super) fn within(&self, low: DVec3, high: DVec3) -> impl Iterator<Item = (usize, DVec3)> {
        let largest = self.counts.as_dvec3() - 1.0;
        let first = ((low - self.low) / self.spacing_m).ceil().max(DVec3::ZERO);
        let last = ((high - self.low) / self.spacing_m).floor().min(largest);
        // the end of an axis without points is at or below its start
        let (first, end) = (first.as_uvec3(), (last + 1.0).as_uvec3());
        (first.z..end.z)
            .flat_map(move |z| (first.y..end.y).map(move |y| (y, z)))
            .flat_map(move |(y, z)| (first.x..end.x).map(move |x| (x, y, z)))
            .map(|(x, y, z)| (self.index(x, y, z), self.point(x, y, z)))
    }

    /// A grid with this spacing that knows what is inside: a depth of infinity there, and -1 outside.
    fn inside(skin: &SkinSurface, spacing_m: f64) -> Self {
        let (low, high) = skin.bounds();
        let half = (low.x.abs().max(high.x.abs()) / spacing_m).ceil();
        let low = DVec3::new(-(half - 0.5) * spacing_m, low.y, low.z);
        let along = ((high - low) / spacing_m).ceil().max(DVec3::ONE).as_uvec3() + 1;
        let counts = UVec3::new(2 * half as u32, along.y, along.z);
        let mut grid = Self {
            spacing_m,
            low,
            counts,
            depths_m: vec![],
        };
        let rows = (0..counts.z * counts.x).into_par_iter();
        let rows: Vec<Vec<bool>> = rows
            .map(|row| {
                let start = grid.point(row % counts.x, 0, row / counts.x);
                skin.inside_along_y(start, spacing_m, counts.y as usize)
            })
            .collect();
        grid.depths_m = vec![-1.0; (counts.x * counts.y * counts.z) as usize];
        for (row, inside) in rows.iter().enumerate() {
            let (x, z) = (row as u32 % counts.x, row as u32 / counts.x);
            for (y, _) in inside.iter().enumerate().filter(|(_, inside)| **inside) {
                let index = grid.index(x, y as u32, z);
                grid.depths_m[index] = f32::INFINITY;
            }
        }
        grid
    }

    /// Measures the depth of the points that can be less deep than `deepest_m`.
    fn measure_depths(&mut self, skin: &SkinSurface, deepest_m: f64) {
        let layers = (deepest_m / self.spacing_m).ceil() as usize + 1;
        let strides = [
            1,
            self.counts.x as usize,
            (self.counts.x * self.counts.y) as usize,
        ];
        let is_outside = |index: usize| self.depths_m[index] < 0.0;
        let mut near: Vec<bool> = (0..self.len()).map(is_outside).collect();
        for stride in strides {
            near = spread(&near, stride, layers);
        }
        let measured: Vec<usize> = (0..self.len())
            .filter(|&index| near[index] && !is_outside(index))
            .collect();
        let depth_m = |&index: &usize| skin.nearest(self.point_at(index)).distance_m as f32;
        let depths_m: Vec<f32> = measured.par_iter().map(depth_m).collect();
        for (index, depth_m) in measured.into_iter().zip(depths_m) {
            self.depths_m[index] = depth_m;
        }
    }
}

/// For each place whether one of `flags` is set at most `reach` steps of `stride` away.
fn spread(flags: &[bool], stride: usize, reach: usize) -> Vec<bool> {
    let mut spread = flags.to_vec();
    for step in (1..=reach).map(|step| step * stride) {
        for index in 0..flags.len() {
            if flags[index] {
                if index >= step {
                    spread[index - step] = true;
                }
                if index + step < flags.len() {
                    spread[index + step] = true;
                }
            }
        }
    }
    spread
}
