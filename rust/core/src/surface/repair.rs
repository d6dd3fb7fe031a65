//! Makes the boundary of a field a manifold, by filling voxels and never by removing any.
//!
//! Where two inside voxels touch only in an edge or a corner, or two outside voxels do, the surface between
//! inside and outside would touch itself. A set of voxels without such places is *well-composed*, and its
//! boundary is a closed manifold (L. Latecki, "3D Well-Composed Pictures", 1997). Dual methods, with one
//! vertex per cell and one quad per edge between inside and outside, make exactly that boundary. So after
//! this no cell is ambiguous.

use glam::IVec3;
use rayon::prelude::*;
use std::collections::HashSet;

use super::bricks::{Bricks, EDGE, brick_of, first_of};

/// Depth, in voxels, of a filled voxel.
const FILLED_DEPTH: f32 = 0.25;
/// Edge length, in voxels, of a brick with one voxel around it.
const WIDE: usize = EDGE as usize + 2;
/// The corners of each face of a cube, in order around it. Corner c is at x = c & 1, y = c >> 1 & 1, z = c >>
/// 2.
const FACES: [[usize; 4]; 6] = [
    [0, 1, 3, 2],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 3, 7, 6],
    [0, 2, 6, 4],
    [1, 3, 7, 5],
];

/// Fills voxels until the field is well-composed. If either of two voxels would do, the deeper one is filled;
/// if they are equally deep, both, so that symmetry is kept.
pub(super) fn make_well_composed(bricks: &mut Bricks) {
    let mut suspects: Vec<IVec3> = bricks.stored().to_vec();
    while !suspects.is_empty() {
        let mut found: Vec<IVec3> = suspects
            .par_iter()
            .map_init(Vec::new, |around, &brick| fillings(bricks, brick, around))
            .flatten_iter()
            .collect();
        found.sort_unstable_by_key(|voxel| voxel.to_array());
        found.dedup();
        let mut changed = HashSet::new();
        for voxel in found {
            bricks.set(voxel, FILLED_DEPTH);
            // the cells that contain it start in its brick or in those one voxel before it
            for corner in 0..8 {
                changed.insert(brick_of(voxel - corner_of(corner)).to_array());
            }
        }
        suspects = changed.into_iter().map(IVec3::from_array).collect();
        suspects.sort_unstable_by_key(|brick| brick.to_array());
    }
}

fn corner_of(corner: usize) -> IVec3 {
    let corner = corner as i32;
    IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2)
}

/// The voxels to fill in the cells that start in a brick.
fn fillings(bricks: &Bricks, brick: IVec3, around: &mut Vec<f32>) -> Vec<IVec3> {
    bricks.gather(brick, 1, around);
    let mut found = vec![];
    let is_inside = around[0] > 0.0;
    if around.iter().all(|value| (*value > 0.0) == is_inside) {
        return found;
    }
    let (row, layer) = (WIDE, WIDE * WIDE);
    let strides: [usize; 8] = std::array::from_fn(|corner| {
        let at = corner_of(corner);
        at.x as usize + at.y as usize * row + at.z as usize * layer
    });
    for z in 1..=EDGE as usize {
        for y in 1..=EDGE as usize {
            for x in 1..=EDGE as usize {
                let first = x + y * row + z * layer;
                let depths = strides.map(|stride| around[first + stride]);
                let cell = first_of(brick) + IVec3::new(x as i32, y as i32, z as i32) - 1;
                fill_cell(&depths, |corner| found.push(cell + corner_of(corner)));
            }
        }
    }
    found
}

/// Calls `fill` for the corners to fill in a cell with these depths.
fn fill_cell(depths: &[f32; 8], mut fill: impl FnMut(usize)) {
    let inside = (0..8).filter(|&corner| depths[corner] > 0.0).count();
    if inside == 0 || inside == 8 {
        return;
    }
    let mut fill_deepest = |corners: &[usize]| {
        let deepest = corners
            .iter()
            .map(|&corner| depths[corner])
            .fold(f32::NEG_INFINITY, f32::max);
        corners
            .iter()
            .filter(|&&corner| depths[corner] == deepest)
            .for_each(|&corner| fill(corner));
    };
    for [a, b, c, d] in FACES {
        let [in_a, in_b, in_c, in_d] = [a, b, c, d].map(|corner| depths[corner] > 0.0);
        if in_a == in_c && in_b == in_d && in_a != in_b {
            fill_deepest(&if in_a { [b, d] } else { [a, c] });
        }
    }
    for corner in 0..4 {
        let opposite = 7 - corner;
        let in_both = depths[corner] > 0.0 && depths[opposite] > 0.0;
        let in_none = depths[corner] <= 0.0 && depths[opposite] <= 0.0;
        if in_both && inside == 2 {
            let others: Vec<usize> = (0..8)
                .filter(|&other| other != corner && other != opposite)
                .collect();
            fill_deepest(&others);
        } else if in_none && inside == 6 {
            fill_deepest(&[corner, opposite]);
        }
    }
}
