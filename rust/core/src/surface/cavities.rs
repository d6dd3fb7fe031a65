//! Fills outside regions that are not connected with the far outside: a skin has no inner surfaces.
//!
//! A flood fill starts far away and moves from voxel to voxel through their faces. Filling the voxels that it
//! does not reach keeps the field well-composed: of voxels that touch only in an edge or a corner, each has a
//! neighbour that was reached.

use glam::IVec3;

use super::bricks::{Brick, Bricks, EDGE, brick_of, bricks_of, first_of};

/// The six neighbours of a voxel or of a brick.
const NEIGHBOURS: [IVec3; 6] = [
    IVec3::X,
    IVec3::NEG_X,
    IVec3::Y,
    IVec3::NEG_Y,
    IVec3::Z,
    IVec3::NEG_Z,
];
/// Smallest depth, in voxels, of a filled voxel.
const FILLED_DEPTH: f32 = 0.25;

/// Fills the cavities of a field.
pub(super) fn fill_cavities(bricks: &mut Bricks) {
    let mut reached = Outside::new(bricks);
    // the first brick of the table is a margin, far outside
    reached.enter_brick(bricks, bricks.extent().0);
    while let Some(next) = reached.open.pop() {
        match next {
            Next::Voxel(voxel) => NEIGHBOURS
                .iter()
                .for_each(|step| reached.enter(bricks, voxel + step)),
            Next::Brick(brick) => NEIGHBOURS
                .iter()
                .for_each(|&step| reached.enter_from(bricks, brick, step)),
        }
    }
    reached.fill_others(bricks);
}

/// Where the flood fill continues.
enum Next {
    Voxel(IVec3),
    /// A brick in which all voxels are outside.
    Brick(IVec3),
}

/// The outside, as far as the flood fill has reached.
struct Outside {
    /// One bit per voxel of the stored bricks.
    voxels: Vec<[u64; 8]>,
    /// One flag per brick of the table, set for bricks in which all voxels are outside.
    bricks: Vec<bool>,
    open: Vec<Next>,
}

impl Outside {
    fn new(bricks: &Bricks) -> Self {
        Self {
            voxels: vec![[0; 8]; bricks.stored().len()],
            bricks: vec![false; bricks.extent().1.as_usizevec3().element_product()],
            open: vec![],
        }
    }

    fn enter(&mut self, bricks: &Bricks, voxel: IVec3) {
        let brick = brick_of(voxel);
        match bricks.brick(brick) {
            Brick::Inside => {}
            Brick::Outside => self.enter_brick(bricks, brick),
            Brick::Stored(slot) => {
                let at = voxel - first_of(brick);
                let (word, bit) = (at.z as usize, 1_u64 << (at.y * EDGE + at.x));
                let depth = bricks.values[slot][(at.z * EDGE * EDGE + at.y * EDGE + at.x) as usize];
                if depth <= 0.0 && self.voxels[slot][word] & bit == 0 {
                    self.voxels[slot][word] |= bit;
                    self.open.push(Next::Voxel(voxel));
                }
            }
        }
    }

    fn enter_brick(&mut self, bricks: &Bricks, brick: IVec3) {
        if let Some(row) = bricks.row(brick)
            && !self.bricks[row]
        {
            self.bricks[row] = true;
            self.open.push(Next::Brick(brick));
        }
    }

    /// Continues from a brick to its neighbour in a direction, through all voxels of their common face.
    fn enter_from(&mut self, bricks: &Bricks, brick: IVec3, step: IVec3) {
        match bricks.brick(brick + step) {
            Brick::Inside => {}
            Brick::Outside => self.enter_brick(bricks, brick + step),
            Brick::Stored(_) => {
                let first = first_of(brick + step);
                // the face of the neighbour towards this brick
                let side = (-step).max(IVec3::ZERO) * (EDGE - 1);
                let [u, v] = if step.x != 0 {
                    [IVec3::Y, IVec3::Z]
                } else if step.y != 0 {
                    [IVec3::X, IVec3::Z]
                } else {
                    [IVec3::X, IVec3::Y]
                };
                for (i, j) in (0..EDGE).flat_map(|j| (0..EDGE).map(move |i| (i, j))) {
                    self.enter(bricks, first + side + u * i + v * j);
                }
            }
        }
    }

    fn fill_others(&self, bricks: &mut Bricks) {
        for (values, reached) in bricks.values.iter_mut().zip(&self.voxels) {
            for (index, value) in values.iter_mut().enumerate() {
                let is_reached = reached[index >> 6] >> (index & 63) & 1 == 1;
                if *value <= 0.0 && !is_reached {
                    *value = FILLED_DEPTH.max(-*value);
                }
            }
        }
        let (first, size) = bricks.extent();
        for (brick, is_reached) in bricks_of(first, size).zip(&self.bricks) {
            if !is_reached && bricks.brick(brick) == Brick::Outside {
                bricks.fill(brick);
            }
        }
    }
}
