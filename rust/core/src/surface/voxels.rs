//! Tissues to voxels: the depth of each voxel near the surface in the deepest tissue (Wilhelms 1997 uses 0 or
//! 1).
//!
//! With true distances the surface of a single tissue is accurate to the second order of the voxel size.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::bricks::{Band, Bricks, EDGE, VOXELS, Values, brick_of, first_of};
use super::lattice::Lattice;
use super::progress::Progress;
use super::solids::{Solid, bounds_of};
use crate::error::{Error, Result};

/// Memory per voxel of a stored brick, bytes: the field, the filtered field, the field before, one more copy,
/// and the surface (measured: 72 MB at resolution 512 on the cat, where this gives 65).
const BYTES_A_VOXEL: f64 = 24.0;
/// Distance from the centre of a brick to the centre of its farthest voxel, in voxels: √3 · 3.5.
const REACH: f64 = 6.0622;
/// Edge length, in voxels, of the eight parts in which a brick is computed. Few solids count in each.
const PART: i32 = EDGE / 2;
/// The distance [`REACH`] in a part: √3 · 1.5.
const PART_REACH: f64 = 2.5981;
/// Voxels along the longest side above which memory is estimated on a coarser lattice.
const COARSE: f64 = 128.0;

/// A brick that the surface may pass, and the solids that count in it.
struct SurfaceBrick {
    brick: IVec3,
    solids: Vec<u32>,
}

/// The bricks of a field.
struct BrickSearch {
    first: IVec3,
    size: IVec3,
    near: Vec<SurfaceBrick>,
    inside: Vec<IVec3>,
}

/// The field of `solids`, on a table of bricks around them and the band.
///
/// # Errors
/// [`Error::Memory`] if it would take more than `limit_bytes`, before it is allocated; [`Error::Cancelled`].
pub(super) fn voxelised(
    solids: &[Solid],
    lattice: Lattice,
    band: Band,
    limit_bytes: f64,
    progress: &Progress,
) -> Result<Bricks> {
    require_memory(solids, lattice, band, limit_bytes)?;
    let found = search(solids, lattice, band);
    progress.reach(0.1)?;
    let mut bricks = Bricks::new(found.first, found.size, band);
    found.inside.iter().for_each(|&brick| bricks.fill(brick));
    let values: Vec<Values> = found
        .near
        .par_iter()
        .map(|near| {
            if progress.is_cancelled() {
                return [0.0; VOXELS];
            }
            values_of(near, solids, lattice, band)
        })
        .collect();
    for (near, values) in found.near.iter().zip(values) {
        bricks.store(near.brick, values);
    }
    progress.reach(0.45)?;
    Ok(bricks)
}

/// The first brick and the number of bricks around all solids and the band, with a margin of one brick on
/// each side.
fn extent(solids: &[Solid], lattice: Lattice, band: Band) -> (IVec3, IVec3) {
    let (low, high) = bounds_of(solids);
    let beyond = 1.0 - f64::from(band.least);
    let first = brick_of((lattice.in_voxels(low) - beyond).floor().as_ivec3()) - 1;
    let last = brick_of((lattice.in_voxels(high) + beyond).ceil().as_ivec3()) + 1;
    (first, last - first + 1)
}

fn require_memory(solids: &[Solid], lattice: Lattice, band: Band, limit_bytes: f64) -> Result<()> {
    let (low, high) = bounds_of(solids);
    let size_m = (high - low).max_element();
    let needed = needed_bytes(solids, lattice, band);
    if needed <= limit_bytes {
        return Ok(());
    }
    let resolution = size_m / lattice.voxel_m;
    // bricks grow with the square of the resolution, the table with its cube, the band not at all
    let mut fits = (resolution * (limit_bytes / needed).sqrt()).floor();
    let lattice_of = |resolution: f64| Lattice {
        voxel_m: size_m / resolution,
    };
    while fits > 1.0 && needed_bytes(solids, lattice_of(fits), band) > limit_bytes {
        fits = (0.9 * fits).floor();
    }
    Err(Error::Memory {
        resolution: resolution.round() as usize,
        needed_mb: (needed / 1e6).ceil() as usize,
        limit_mb: (limit_bytes / 1e6) as usize,
        fits: fits as usize,
    })
}

/// The largest memory that the field of `solids` takes, bytes. For fine lattices it is estimated on a coarser
/// one.
fn needed_bytes(solids: &[Solid], lattice: Lattice, band: Band) -> f64 {
    let (low, high) = bounds_of(solids);
    let ratio = ((high - low).max_element() / lattice.voxel_m / COARSE).max(1.0);
    let coarse = Lattice {
        voxel_m: lattice.voxel_m * ratio,
    };
    // in f64, since the table of a huge resolution has more bricks than an i32 can count
    let table = ((high - low) / lattice.voxel_m / f64::from(EDGE) + 4.0).element_product();
    let stored = search(solids, coarse, band).near.len() as f64 * ratio * ratio;
    Bricks::table_bytes(table) + stored * VOXELS as f64 * BYTES_A_VOXEL
}

/// The bricks that the surface may pass, in order.
fn search(solids: &[Solid], lattice: Lattice, band: Band) -> BrickSearch {
    let (first, size) = extent(solids, lattice, band);
    let layers: Vec<_> = (first.z..first.z + size.z)
        .into_par_iter()
        .map(|z| search_layer(solids, lattice, band, first, size, z))
        .collect();
    let (near, inside): (Vec<_>, Vec<_>) = layers.into_iter().unzip();
    BrickSearch {
        first,
        size,
        near: near.into_iter().flatten().collect(),
        inside: inside.into_iter().flatten().collect(),
    }
}

fn search_layer(
    solids: &[Solid],
    lattice: Lattice,
    band: Band,
    first: IVec3,
    size: IVec3,
    z: i32,
) -> (Vec<SurfaceBrick>, Vec<IVec3>) {
    let (least_depth, most_depth) = (f64::from(band.least), f64::from(band.most));
    let row = size.x as usize;
    // for each brick of the layer: the solids that may count with the upper bounds of their depths, and a
    // lower bound of the depth of all voxels
    let mut candidates: Vec<Vec<(f64, u32)>> = vec![vec![]; row * size.y as usize];
    let mut least = vec![f64::NEG_INFINITY; candidates.len()];
    for (index, solid) in solids.iter().enumerate() {
        let half = solid.half_extent_m();
        let brick =
            |corner: DVec3, beyond: f64| brick_of((lattice.in_voxels(corner) + beyond).round().as_ivec3());
        let low = brick(solid.ellipsoid.centre - half, least_depth - 1.0);
        let high = brick(solid.ellipsoid.centre + half, 1.0 - least_depth);
        if z < low.z || z > high.z {
            continue;
        }
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let at = ((y - first.y) * size.x + x - first.x) as usize;
                let centre = middle(IVec3::new(x, y, z), lattice);
                let bound = solid.depth_bound_m(centre) / lattice.voxel_m + REACH;
                if least[at] >= most_depth || bound <= least_depth.max(least[at]) {
                    continue;
                }
                let depth = solid.depth_m(centre) / lattice.voxel_m;
                least[at] = least[at].max(depth - REACH);
                if depth + REACH > least_depth {
                    candidates[at].push((depth + REACH, index as u32));
                }
            }
        }
    }
    let (mut near, mut inside) = (vec![], vec![]);
    for (at, (found, least)) in candidates.into_iter().zip(least).enumerate() {
        let brick = IVec3::new((at % row) as i32 + first.x, (at / row) as i32 + first.y, z);
        if least >= most_depth {
            inside.push(brick);
        } else if !found.is_empty() {
            let mut counting: Vec<_> = found.into_iter().filter(|(most, _)| *most > least).collect();
            // the solid that may be deepest first, which excludes most others early
            counting.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            let solids = counting.into_iter().map(|(_, solid)| solid).collect();
            near.push(SurfaceBrick { brick, solids });
        }
    }
    (near, inside)
}

fn middle(brick: IVec3, lattice: Lattice) -> DVec3 {
    lattice.point(first_of(brick).as_dvec3() + 0.5 * f64::from(EDGE - 1))
}

fn values_of(near: &SurfaceBrick, solids: &[Solid], lattice: Lattice, band: Band) -> Values {
    let first = first_of(near.brick);
    let mut values = [band.least; VOXELS];
    let mut counting = vec![];
    for part in (0..8).map(|part| IVec3::new(part & 1, part >> 1 & 1, part >> 2) * PART) {
        let middle = lattice.point((first + part).as_dvec3() + 0.5 * f64::from(PART - 1));
        deepest_first(&near.solids, solids, middle, lattice, &mut counting);
        for index in 0..(PART * PART * PART) {
            let at = part + IVec3::new(index % PART, index / PART % PART, index / (PART * PART));
            let centre = lattice.centre(first + at);
            let deepest_m = deepest_m(&counting, solids, centre, centre.distance(middle), lattice, band);
            let depth = (deepest_m / lattice.voxel_m) as f32;
            values[((at.z * EDGE + at.y) * EDGE + at.x) as usize] = depth.clamp(band.least, band.most);
        }
    }
    values
}

/// The solids that may be deepest anywhere in the part of a brick around `middle`, with their depths there,
/// m; the deepest first, which excludes most others early.
fn deepest_first(
    near: &[u32],
    solids: &[Solid],
    middle: DVec3,
    lattice: Lattice,
    counting: &mut Vec<(f64, u32)>,
) {
    let reach_m = PART_REACH * lattice.voxel_m;
    counting.clear();
    let mut least_m = f64::NEG_INFINITY;
    for &index in near {
        let solid = &solids[index as usize];
        if solid.depth_bound_m(middle) + reach_m > least_m {
            let depth_m = solid.depth_m(middle);
            least_m = least_m.max(depth_m - reach_m);
            counting.push((depth_m, index));
        }
    }
    counting.retain(|(depth_m, _)| depth_m + reach_m > least_m);
    counting.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
}

/// The depth of a point in the deepest solid, m, clamped to the band. `aside_m` is the distance of the point
/// from where the depths in `counting` were measured: none can be larger by more than that.
fn deepest_m(
    counting: &[(f64, u32)],
    solids: &[Solid],
    point: DVec3,
    aside_m: f64,
    lattice: Lattice,
    band: Band,
) -> f64 {
    let [floor_m, ceiling_m] = [band.least, band.most].map(|depth| f64::from(depth) * lattice.voxel_m);
    let mut deepest_m = floor_m;
    for &(depth_m, index) in counting {
        if deepest_m >= ceiling_m || depth_m + aside_m <= deepest_m {
            break;
        }
        let solid = &solids[index as usize];
        if solid.depth_bound_m(point) > deepest_m {
            deepest_m = deepest_m.max(solid.depth_m(point));
        }
    }
    deepest_m
}
