//! Fills what is outside but cut off from the far outside: a skin has no inner surfaces.
//!
//! The outside is walked from far away, from voxel to voxel through their sides. Filling what was not reached makes no new
//! place where a well-composed field touches itself: of voxels that touch so, each has a neighbour that was reached.

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
/// Least depth, in voxels, of a voxel that is filled.
const FILLED_DEPTH: f32 = 0.25;

/// Fills the cavities of a field.
pub(super) fn fill_cavities(bricks: &mut Bricks) {
    let mut reached = Outside::new(bricks);
    // the first brick of the table is one to spare, far outside
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

/// From where the walk goes on.
enum Next {
    Voxel(IVec3),
    /// A brick that is outside throughout.
    Brick(IVec3),
}

/// The outside, as far as it was reached.
struct Outside {
    /// Of the stored bricks' voxels, bit by bit.
    voxels: Vec<[u64; 8]>,
    /// Of the bricks of the table, those that are outside throughout.
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

    /// Goes on from a brick to the next in a direction: to all of the side that they share.
    fn enter_from(&mut self, bricks: &Bricks, brick: IVec3, step: IVec3) {
        match bricks.brick(brick + step) {
            Brick::Inside => {}
            Brick::Outside => self.enter_brick(bricks, brick + step),
            Brick::Stored(_) => {
                let first = first_of(brick + step);
                // the side that looks back
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
