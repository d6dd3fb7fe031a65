//! How strongly each tissue moves each vertex: sparse rows, blended over near tissues and smoothed over the mesh
//! (ALGORITHM 3).

use rayon::prelude::*;

use crate::skin::mesh::adjacency::Adjacency;

/// Most carriers that move one vertex.
pub(crate) const INFLUENCE_LIMIT: usize = 8;
/// Most entries kept between rounds of smoothing.
const ROW_CAPACITY: usize = 24;
/// Rounds of smoothing.
const ROUNDS: usize = 4;
/// Entries below this are dropped between rounds.
const SMALLEST_ENTRY: f32 = 1e-7;
/// Rows whose sum is below this move nothing.
const SMALLEST_SUM: f32 = 1e-4;

/// One carrier's influence.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Influence {
    pub carrier: u32,
    pub weight: f32,
}

/// The influences on one vertex; carriers are distinct.
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

    /// The `limit` strongest of `influences` (the lower carrier where equal), scaled to the sum of them all; sorts
    /// `influences`.
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

    /// Scales the row to sum to `total`.
    pub fn scale_to(&mut self, total: f32) {
        let sum = self.sum();
        if sum > 0.0 {
            self.entries[..self.length]
                .iter_mut()
                .for_each(|entry| entry.weight *= total / sum);
        }
    }
}

/// Smooths `rows` over the mesh, each half its own and half the mean of its neighbours a round, and keeps the strongest.
pub(crate) fn smoothed(mut rows: Vec<Row>, adjacency: &Adjacency, carriers: usize) -> Vec<Row> {
    for round in 1..=ROUNDS {
        let limit = if round == ROUNDS {
            INFLUENCE_LIMIT
        } else {
            ROW_CAPACITY
        };
        rows = (0..rows.len())
            .into_par_iter()
            .map_init(
                || Mixer::new(carriers),
                |mixer, vertex| mixer.mix(&rows, vertex, adjacency.neighbours(vertex), limit),
            )
            .collect();
    }
    rows
}

/// Empties every row that is too weak to matter.
pub(crate) fn drop_weak(rows: &mut [Row]) {
    rows.iter_mut()
        .filter(|row| row.sum() < SMALLEST_SUM)
        .for_each(|row| *row = Row::EMPTY);
}

/// Adds up rows; one a thread.
struct Mixer {
    weights: Vec<f32>,
    touched: Vec<u32>,
    influences: Vec<Influence>,
}

impl Mixer {
    fn new(carriers: usize) -> Self {
        Self {
            weights: vec![0.0; carriers],
            touched: vec![],
            influences: vec![],
        }
    }

    fn mix(&mut self, rows: &[Row], vertex: usize, neighbours: &[u32], limit: usize) -> Row {
        if neighbours.is_empty() {
            self.add(&rows[vertex], 1.0);
        } else {
            self.add(&rows[vertex], 0.5);
            let share = 0.5 / neighbours.len() as f32;
            for &neighbour in neighbours {
                self.add(&rows[neighbour as usize], share);
            }
        }
        self.influences.clear();
        for carrier in self.touched.drain(..) {
            let weight = std::mem::take(&mut self.weights[carrier as usize]);
            self.influences.push(Influence { carrier, weight });
        }
        Row::strongest(&mut self.influences, limit)
    }

    fn add(&mut self, row: &Row, share: f32) {
        for entry in row.entries() {
            let weight = &mut self.weights[entry.carrier as usize];
            if *weight == 0.0 {
                self.touched.push(entry.carrier);
            }
            *weight += share * entry.weight;
        }
    }
}
