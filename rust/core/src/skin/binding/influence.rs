//! The weights of tissues at vertices: sparse rows, smoothed over the mesh (mathematics/binding.md,
//! Smoothing).

use crate::math::rows::Rows;
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

/// The influence of one carrier. No carrier occurs twice at a vertex.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Influence {
    pub carrier: u32,
    pub weight: f32,
}

/// The sum of the weights of a row.
fn sum(row: &[Influence]) -> f32 {
    row.iter().map(|entry| entry.weight).sum()
}

/// Scales a row to the sum `total`.
pub(crate) fn scale_to(row: &mut [Influence], total: f32) {
    let sum = sum(row);
    if sum > 0.0 {
        row.iter_mut().for_each(|entry| entry.weight *= total / sum);
    }
}

/// Keeps the `limit` strongest entries of the row that starts at `first` (of equals the lower carrier), scaled to the
/// sum of all.
pub(crate) fn keep_strongest(rows: &mut Vec<Influence>, first: usize, limit: usize) {
    let row = &mut rows[first..];
    row.sort_unstable_by(|a, b| b.weight.total_cmp(&a.weight).then(a.carrier.cmp(&b.carrier)));
    let total = sum(row);
    let kept = row
        .iter()
        .take(limit.min(ROW_CAPACITY))
        .take_while(|entry| entry.weight > SMALLEST_ENTRY)
        .count();
    rows.truncate(first + kept);
    scale_to(&mut rows[first..], total);
}

/// Smooths `rows` over the mesh: in a pass each row becomes half of itself plus half of its neighbours'
/// mean. The last pass keeps the strongest entries.
pub(crate) fn smoothed(mut rows: Rows<Influence>, adjacency: &Adjacency, carriers: usize) -> Rows<Influence> {
    for pass in 1..=PASSES {
        let limit = if pass == PASSES {
            INFLUENCE_LIMIT
        } else {
            ROW_CAPACITY
        };
        let write = |sum: &mut RowSum, vertex: usize, smoothed: &mut Vec<Influence>| {
            sum.smooth(&rows, vertex, adjacency.neighbours(vertex), limit, smoothed);
        };
        rows = Rows::computed(rows.len(), || RowSum::new(carriers), write);
    }
    rows
}

/// Whether a row is so weak that it is emptied.
pub(crate) fn is_weak(row: &[Influence]) -> bool {
    sum(row) < SMALLEST_SUM
}

/// A weighted sum of rows; one per thread.
struct RowSum {
    weights: Vec<f32>,
    touched: Vec<u32>,
}

impl RowSum {
    fn new(carriers: usize) -> Self {
        Self {
            weights: vec![0.0; carriers],
            touched: vec![],
        }
    }

    /// Appends the smoothed row of a vertex to `smoothed`.
    fn smooth(
        &mut self,
        rows: &Rows<Influence>,
        vertex: usize,
        neighbours: &[u32],
        limit: usize,
        smoothed: &mut Vec<Influence>,
    ) {
        if neighbours.is_empty() {
            self.add(rows.row(vertex), 1.0);
        } else {
            self.add(rows.row(vertex), 0.5);
            let factor = 0.5 / neighbours.len() as f32;
            for &neighbour in neighbours {
                self.add(rows.row(neighbour as usize), factor);
            }
        }
        let first = smoothed.len();
        for carrier in self.touched.drain(..) {
            let weight = std::mem::take(&mut self.weights[carrier as usize]);
            smoothed.push(Influence { carrier, weight });
        }
        keep_strongest(smoothed, first, limit);
    }

    fn add(&mut self, row: &[Influence], factor: f32) {
        for entry in row {
            let weight = &mut self.weights[entry.carrier as usize];
            if *weight == 0.0 {
                self.touched.push(entry.carrier);
            }
            *weight += factor * entry.weight;
        }
    }
}
