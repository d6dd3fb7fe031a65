//! Makes a field exactly symmetric where it is symmetric except for rounding.

use glam::IVec3;
use rayon::prelude::*;

use super::bricks::{Bricks, Values, first_of, offset_of};
use super::lattice::mirrored;

/// Difference, in voxels, below which two mirror images count as equal.
const SAME: f32 = 0.02;

/// Gives a voxel and its mirror image the larger of their values where these are nearly equal.
pub(super) fn symmetrise(bricks: &mut Bricks) {
    let symmetric: Vec<Values> = bricks
        .stored()
        .par_iter()
        .zip(&bricks.values)
        .map(|(&brick, values)| {
            let first = first_of(brick);
            std::array::from_fn(|index| {
                let image = bricks.value(mirrored(first + offset_of(index)));
                let depth = values[index];
                if (depth - image).abs() < SAME {
                    depth.max(image)
                } else {
                    depth
                }
            })
        })
        .collect();
    bricks.values = symmetric;
}

/// The mirror image of a cell (the cube between eight voxels, named by the first).
pub(super) fn mirrored_cell(cell: IVec3) -> IVec3 {
    IVec3::new(-2 - cell.x, cell.y, cell.z)
}
