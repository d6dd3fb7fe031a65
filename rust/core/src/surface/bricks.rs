//! A scalar field on a lattice, stored only near the surface, in bricks of 8³ voxels.
//!
//! Values are depths below the surface, in voxels: positive inside, negative outside, clamped to a *band*. A
//! brick in which all values are clamped to the same end is not stored.

use glam::{DVec3, IVec3, USizeVec3};

/// Voxels along the edge of a brick.
pub(super) const EDGE: i32 = 8;
/// Voxels in a brick.
pub(super) const VOXELS: usize = (EDGE * EDGE * EDGE) as usize;

/// The values of one brick, x fastest, then y.
pub(super) type Values = [f32; VOXELS];

const OUTSIDE: u32 = u32::MAX;
const INSIDE: u32 = u32::MAX - 1;

/// The range to which depths are clamped, voxels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    /// The smallest depth, outside; negative.
    pub least: f32,
    /// The largest depth, inside; positive.
    pub most: f32,
}

/// The state of a brick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Brick {
    /// Every voxel has the smallest depth.
    Outside,
    /// Every voxel has the largest depth.
    Inside,
    /// Its values are stored, at this index.
    Stored(usize),
}

/// The field.
#[derive(Debug, Clone)]
pub(super) struct Bricks {
    first: IVec3,
    size: IVec3,
    table: Vec<u32>,
    stored: Vec<IVec3>,
    /// The values of the stored bricks, in the order of `stored`.
    pub values: Vec<Values>,
    /// The range to which values are clamped.
    pub band: Band,
}

impl Bricks {
    /// A field that is outside everywhere. Its table has `size` bricks, starting at `first`.
    pub fn new(first: IVec3, size: IVec3, band: Band) -> Self {
        Self {
            first,
            size,
            table: vec![OUTSIDE; size.as_usizevec3().element_product()],
            stored: vec![],
            values: vec![],
            band,
        }
    }

    /// The first brick of the table, and the number of bricks along each axis. All others are outside.
    pub fn extent(&self) -> (IVec3, IVec3) {
        (self.first, self.size)
    }

    /// The coordinates of the stored bricks.
    pub fn stored(&self) -> &[IVec3] {
        &self.stored
    }

    /// Memory of a table of `bricks` bricks without values, bytes.
    pub fn table_bytes(bricks: f64) -> f64 {
        bricks * size_of::<u32>() as f64
    }

    /// Stores a brick with `values`, and returns its index.
    pub fn store(&mut self, brick: IVec3, values: Values) -> usize {
        let slot = self.values.len();
        if let Some(row) = self.row(brick) {
            self.table[row] = slot as u32;
            self.stored.push(brick);
            self.values.push(values);
        }
        slot
    }

    /// Sets all voxels of a brick to inside.
    pub fn fill(&mut self, brick: IVec3) {
        if let Some(row) = self.row(brick) {
            self.table[row] = INSIDE;
        }
    }

    /// The index of a brick in the table, which has the order of [`bricks_of`]; `None` if it is not in the
    /// table.
    pub fn row(&self, brick: IVec3) -> Option<usize> {
        let at = brick - self.first;
        let is_within = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.size).all();
        is_within.then(|| {
            let (at, size): (USizeVec3, USizeVec3) = (at.as_usizevec3(), self.size.as_usizevec3());
            (at.z * size.y + at.y) * size.x + at.x
        })
    }

    /// The state of a brick.
    pub fn brick(&self, brick: IVec3) -> Brick {
        match self.row(brick).map_or(OUTSIDE, |row| self.table[row]) {
            OUTSIDE => Brick::Outside,
            INSIDE => Brick::Inside,
            slot => Brick::Stored(slot as usize),
        }
    }

    /// Extends the table so that it contains these bricks.
    fn cover(&mut self, first: IVec3, size: IVec3) {
        let (low, high) = (self.first.min(first), (self.first + self.size).max(first + size));
        if (low, high) == (self.first, self.first + self.size) {
            return;
        }
        let mut wider = Self::new(low, high - low, self.band);
        for (brick, &kept) in bricks_of(self.first, self.size).zip(&self.table) {
            if let Some(row) = wider.row(brick) {
                wider.table[row] = kept;
            }
        }
        (self.first, self.size, self.table) = (wider.first, wider.size, wider.table);
    }

    /// Takes the larger of the depths of this field and `other`, on the same lattice.
    pub fn unite(&mut self, other: &Self) {
        self.cover(other.first, other.size);
        for (&brick, values) in other.stored.iter().zip(&other.values) {
            match self.brick(brick) {
                Brick::Inside => {}
                Brick::Outside => {
                    self.store(brick, *values);
                }
                Brick::Stored(slot) => {
                    let kept = self.values[slot].iter_mut();
                    kept.zip(values)
                        .for_each(|(kept, value)| *kept = kept.max(*value));
                }
            }
        }
        for brick in bricks_of(other.first, other.size) {
            if other.brick(brick) == Brick::Inside {
                match self.brick(brick) {
                    Brick::Stored(slot) => self.values[slot] = [self.band.most; VOXELS],
                    Brick::Inside | Brick::Outside => self.fill(brick),
                }
            }
        }
    }

    /// The value of a voxel.
    pub fn value(&self, voxel: IVec3) -> f32 {
        match self.brick(brick_of(voxel)) {
            Brick::Outside => self.band.least,
            Brick::Inside => self.band.most,
            Brick::Stored(slot) => self.values[slot][within(voxel)],
        }
    }

    /// Sets the value of a voxel. Stores its brick if necessary.
    pub fn set(&mut self, voxel: IVec3, value: f32) {
        let brick = brick_of(voxel);
        let slot = match self.brick(brick) {
            Brick::Stored(slot) => slot,
            Brick::Outside => self.store(brick, [self.band.least; VOXELS]),
            Brick::Inside => self.store(brick, [self.band.most; VOXELS]),
        };
        if let Some(values) = self.values.get_mut(slot) {
            values[within(voxel)] = value;
        }
    }

    /// Writes the values of a brick and `halo` voxels around it to `out`, x fastest, then y.
    pub fn gather(&self, brick: IVec3, halo: i32, out: &mut Vec<f32>) {
        out.clear();
        let around: [Brick; 27] = std::array::from_fn(|index| {
            let index = index as i32;
            self.brick(brick + IVec3::new(index % 3, index / 3 % 3, index / 9) - 1)
        });
        // along one axis: the neighbouring brick, and the voxel in it
        let part = |at: i32| (at.div_euclid(EDGE) + 1, at.rem_euclid(EDGE));
        for z in -halo..EDGE + halo {
            let (brick_z, z) = part(z);
            for y in -halo..EDGE + halo {
                let (brick_y, y) = part(y);
                let row = ((z * EDGE + y) * EDGE) as usize;
                let mut extend = |brick_x: i32, from: i32, to: i32| {
                    let values = row + from as usize..row + to as usize;
                    match around[((brick_z * 3 + brick_y) * 3 + brick_x) as usize] {
                        Brick::Outside => out.resize(out.len() + values.len(), self.band.least),
                        Brick::Inside => out.resize(out.len() + values.len(), self.band.most),
                        Brick::Stored(slot) => out.extend_from_slice(&self.values[slot][values]),
                    }
                };
                extend(0, EDGE - halo, EDGE);
                extend(1, 0, EDGE);
                extend(2, 0, halo);
            }
        }
    }

    /// The value at a position between voxels, and its gradient per voxel, by trilinear interpolation.
    pub fn sample(&self, position: DVec3) -> (f64, DVec3) {
        let base = position.floor();
        let fraction = position - base;
        let base = base.as_ivec3();
        let corner = |x: i32, y: i32, z: i32| f64::from(self.value(base + IVec3::new(x, y, z)));
        let mix = |a: f64, b: f64, fraction: f64| a + (b - a) * fraction;
        // interpolate along x, then y, then z
        let edges = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(y, z)| [corner(0, y, z), corner(1, y, z)]);
        let along = edges.map(|[a, b]| mix(a, b, fraction.x));
        let rise = edges.map(|[a, b]| b - a);
        let gradient = DVec3::new(
            mix(
                mix(rise[0], rise[1], fraction.y),
                mix(rise[2], rise[3], fraction.y),
                fraction.z,
            ),
            mix(along[1] - along[0], along[3] - along[2], fraction.z),
            mix(along[2] - along[0], along[3] - along[1], fraction.y),
        );
        let value = mix(
            mix(along[0], along[1], fraction.y),
            mix(along[2], along[3], fraction.y),
            fraction.z,
        );
        (value, gradient)
    }
}

/// All bricks of a table.
pub(super) fn bricks_of(first: IVec3, size: IVec3) -> impl Iterator<Item = IVec3> {
    (0..size.z).flat_map(move |z| {
        (0..size.y).flat_map(move |y| (0..size.x).map(move |x| first + IVec3::new(x, y, z)))
    })
}

/// The brick of a voxel.
pub(super) fn brick_of(voxel: IVec3) -> IVec3 {
    voxel.div_euclid(IVec3::splat(EDGE))
}

/// The first voxel of a brick.
pub(super) fn first_of(brick: IVec3) -> IVec3 {
    brick * EDGE
}

/// The index of a voxel's value in its brick.
fn within(voxel: IVec3) -> usize {
    let at = voxel.rem_euclid(IVec3::splat(EDGE));
    ((at.z * EDGE + at.y) * EDGE + at.x) as usize
}

/// The voxel at `index` in a brick, relative to the first voxel of the brick.
pub(super) fn offset_of(index: usize) -> IVec3 {
    let index = index as i32;
    IVec3::new(index % EDGE, index / EDGE % EDGE, index / (EDGE * EDGE))
}
