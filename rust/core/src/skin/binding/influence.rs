//! The weights of tissues at vertices: sparse rows, smoothed over the mesh (mathematics/binding.md,
//! Smoothing).

use rayon::prelude::*;

use crate::skin::mesh::adjacency::Adjacency;

/// Most carriers that influence one vertex, which bounds the cost of a frame.
pub(crate) const INFLUENCE_LIMIT: usize = 8;
/// Most entries of a row between passes. More than the final limit, so that smoothing does not depend on
/// the order in which weak entries are dropped.
const ROW_CAPACITY: usize = 24;
/// Passes of smoothing, which reach as many rings of neighbours. Their width in metres depends on the
/// density of the mesh.
const PASSES: usize = 4;
/// Entries below this are dropped between passes: no vertex moves visibly by them.
const SMALLEST_ENTRY: f32 = 1e-7;
/// Rows with a smaller sum are emptied, so that chunks of the body far from tissues are skipped.
const SMALLEST_SUM: f32 = 1e-4;

/// The influence of one carrier.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Influence {
    pub carrier: u32,
    pub weight: f32,
}

/// The influences on one vertex. No carrier occurs twice.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    entries: [Influence; ROW_CAPACITY],
    length: usize,
}

impl Row {
    pub const EMPTY: Self = Self {
        entries: [Influence {
            carrier: 0,
            weight: 0.0,
        }; ROW_CAPACITY],
        length: 0,
    };

    pub fn entries(&self) -> &[Influence] {
        &self.entries[..self.length]
    }

    pub fn sum(&self) -> f32 {
        self.entries().iter().map(|entry| entry.weight).sum()
    }

    /// The `limit` strongest of `influences` (of equals the lower carrier), scaled to the sum of all.
    /// Sorts `influences`.
    pub fn strongest(influences: &mut [Influence], limit: usize) -> Self {
        influences.sort_unstable_by(|a, b| b.weight.total_cmp(&a.weight).then(a.carrier.cmp(&b.carrier)));
        let total: f32 = influences.iter().map(|entry| entry.weight).sum();
        let length = influences
            .iter()
            .take(limit.min(ROW_CAPACITY))
            .take_while(|entry| entry.weight > SMALLEST_ENTRY)
            .count();
        let mut row = Self {
            length,
            ..Self::EMPTY
        };
        row.entries[..length].copy_from_slice(&influences[..length]);
        row.scale_to(total);
        row
    }

    /// Scales the row to the sum `total`.
    pub fn scale_to(&mut self, total: f32) {
        let sum = self.sum();
        if sum > 0.0 {
            self.entries[..self.length]
                .iter_mut()
                .for_each(|entry| entry.weight *= total / sum);
        }
    }
}

/// Smooths `rows` over the mesh: in a pass each row becomes half of itself plus half of its neighbours'
/// mean. The last pass keeps the strongest entries.
pub(crate) fn smoothed(mut rows: Vec<Row>, adjacency: &Adjacency, carriers: usize) -> Vec<Row> {
    for pass in 1..=PASSES {
        let limit = if pass == PASSES {
            INFLUENCE_LIMIT
        } else {
            ROW_CAPACITY
        };
        rows = (0..rows.len())
            .into_par_iter()
            .map_init(
                || RowSum::new(carriers),
                |sum, vertex| sum.smooth(&rows, vertex, adjacency.neighbours(vertex), limit),
            )
            .collect();
    }
    rows
}

/// Empties every row whose sum is below [`SMALLEST_SUM`].
pub(crate) fn drop_weak(rows: &mut [Row]) {
    rows.iter_mut()
        .filter(|row| row.sum() < SMALLEST_SUM)
        .for_each(|row| *row = Row::EMPTY);
}

/// A weighted sum of rows; one per thread.
struct RowSum {
    weights: Vec<f32>,
    touched: Vec<u32>,
    influences: Vec<Influence>,
}

impl RowSum {
    fn new(carriers: usize) -> Self {
        Self {
            weights: vec![0.0; carriers],
            touched: vec![],
            influences: vec![],
        }
    }

    fn smooth(&mut self, rows: &[Row], vertex: usize, neighbours: &[u32], limit: usize) -> Row {
        if neighbours.is_empty() {
            self.add(&rows[vertex], 1.0);
        } else {
            self.add(&rows[vertex], 0.5);
            let factor = 0.5 / neighbours.len() as f32;
            for &neighbour in neighbours {
                self.add(&rows[neighbour as usize], factor);
            }
        }
        self.influences.clear();
        for carrier in self.touched.drain(..) {
            let weight = std::mem::take(&mut self.weights[carrier as usize]);
            self.influences.push(Influence { carrier, weight });
        }
        Row::strongest(&mut self.influences, limit)
    }

    fn add(&mut self, row: &Row, factor: f32) {
        for entry in row.entries() {
            let weight = &mut self.weights[entry.carrier as usize];
            if *weight == 0.0 {
                self.touched.push(entry.carrier);
            }
            *weight += factor * entry.weight;
        }
    }
}
