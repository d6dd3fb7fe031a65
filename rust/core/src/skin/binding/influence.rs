//! What carriers mean to vertices: sparse rows, smoothed over the mesh (mathematics/binding.md, Smoothing).

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
/// Entries up to this fraction are dropped between passes.
pub(crate) const SMALLEST_ENTRY: f32 = 1e-7;
/// Rows with a smaller sum are emptied, so that chunks of the body far from tissues are skipped.
const SMALLEST_SUM: f32 = 1e-4;

/// What one carrier means to a vertex. No carrier occurs twice in a row.
pub(crate) trait RowEntry: Copy + Default + Send + Sync {
    /// What is blended.
    type Value: Copy
        + Default
        + PartialEq
        + std::ops::AddAssign
        + std::ops::Mul<f32, Output = Self::Value>
        + Send;

    fn new(carrier: u32, value: Self::Value) -> Self;
    fn carrier(&self) -> u32;
    fn value(&self) -> Self::Value;
    /// The strength by which entries of a row are kept.
    fn strength(&self) -> f32;
    /// The strength up to which entries of a row with the sum `total` are dropped between passes: no vertex moves visibly
    /// by them.
    fn negligible(total: f32) -> f32;
    /// Gives a row whose weakest entries were dropped the sum of strengths `total` that it had before.
    fn make_up(row: &mut [Self], total: f32);
}

/// The influence of one carrier.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Influence {
    pub carrier: u32,
    pub weight: f32,
}

impl RowEntry for Influence {
    type Value = f32;

    fn new(carrier: u32, weight: f32) -> Self {
        Self { carrier, weight }
    }

    fn carrier(&self) -> u32 {
        self.carrier
    }

    fn value(&self) -> f32 {
        self.weight
    }

    fn strength(&self) -> f32 {
        self.weight
    }

    fn negligible(_total: f32) -> f32 {
        SMALLEST_ENTRY
    }

    fn make_up(row: &mut [Self], total: f32) {
        scale_to(row, total);
    }
}

/// The sum of the strengths of a row.
fn sum(row: &[impl RowEntry]) -> f32 {
    row.iter().map(RowEntry::strength).sum()
}

/// Scales a row to the sum `total`.
pub(crate) fn scale_to(row: &mut [Influence], total: f32) {
    let sum = sum(row);
    if sum > 0.0 {
        row.iter_mut().for_each(|entry| entry.weight *= total / sum);
    }
}

/// Keeps the `limit` strongest entries of the row that starts at `first` (of equals the lower carrier).
pub(crate) fn keep_strongest<E: RowEntry>(rows: &mut Vec<E>, first: usize, limit: usize) {
    let row = &mut rows[first..];
    row.sort_unstable_by(|a, b| {
        b.strength()
            .total_cmp(&a.strength())
            .then(a.carrier().cmp(&b.carrier()))
    });
    let total = sum(row);
    let kept = row
        .iter()
        .take(limit.min(ROW_CAPACITY))
        .take_while(|entry| entry.strength() > E::negligible(total))
        .count();
    rows.truncate(first + kept);
    E::make_up(&mut rows[first..], total);
}

/// Smooths `rows` over the mesh: in a pass each row becomes half of itself plus half of its neighbours'
/// mean. The last pass keeps the strongest entries.
pub(crate) fn smoothed<E: RowEntry>(mut rows: Rows<E>, adjacency: &Adjacency, carriers: usize) -> Rows<E> {
    for pass in 1..=PASSES {
        let limit = if pass == PASSES {
            INFLUENCE_LIMIT
        } else {
            ROW_CAPACITY
        };
        let write = |sum: &mut RowSum<E>, vertex: usize, smoothed: &mut Vec<E>| {
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
struct RowSum<E: RowEntry> {
    values: Vec<E::Value>,
    touched: Vec<u32>,
}

impl<E: RowEntry> RowSum<E> {
    fn new(carriers: usize) -> Self {
        Self {
            values: vec![E::Value::default(); carriers],
            touched: vec![],
        }
    }

    /// Appends the smoothed row of a vertex to `smoothed`.
    fn smooth(
        &mut self,
        rows: &Rows<E>,
        vertex: usize,
        neighbours: &[u32],
        limit: usize,
        smoothed: &mut Vec<E>,
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
            let value = std::mem::take(&mut self.values[carrier as usize]);
            smoothed.push(E::new(carrier, value));
        }
        keep_strongest(smoothed, first, limit);
    }

    fn add(&mut self, row: &[E], factor: f32) {
        for entry in row {
            let value = &mut self.values[entry.carrier() as usize];
            if *value == E::Value::default() {
                self.touched.push(entry.carrier());
            }
            *value += entry.value() * factor;
        }
    }
}
