//! What two motions together need beyond what each needs alone: a shoulder by an elbow (ALGORITHM 11).

use rayon::prelude::*;

use super::corrective::{MotionKeys, hats, pruned};
use super::error_metric::ErrorMetric;
use crate::error::require_length;
use crate::error::{Result, require};

/// The corrective keys of two motions at once, in one of the four quadrants around rest.
///
/// Each key is driven by the product of two hats, one over each motion: so it acts neither at rest nor where one of the two
/// motions rests.
#[derive(Debug, Clone)]
pub struct CombinationKeys {
    /// The values of the first motion that the hats stand on, rising; rest, 0, is one besides.
    pub first_at: Vec<f64>,
    /// The same of the second motion.
    pub second_at: Vec<f64>,
    /// Each key's place in `first_at` and in `second_at`.
    pub corners: Vec<[usize; 2]>,
    /// What each key adds where both hats are 1.
    pub corrections: Vec<Vec<[f32; 3]>>,
    /// Largest distance of all samples from the motions' own keys alone, m.
    pub error_before_m: f64,
    /// Largest distance of the samples at which both hats are 1, m: what the threshold took.
    pub error_at_m: f64,
    /// Largest distance of all other samples, m.
    pub error_between_m: f64,
}

/// Both motions, sampled on a grid.
#[derive(Debug, Clone, Copy)]
pub struct Grid<'a> {
    /// The first motion's own keys.
    pub first: &'a MotionKeys,
    /// The second motion's own keys.
    pub second: &'a MotionKeys,
    /// Values of the first motion, rising, all of one sign. Hats may stand on the outermost and on every second one from there
    /// inward; those between are checked.
    pub first_at: &'a [f64],
    /// Values of the second motion likewise.
    pub second_at: &'a [f64],
    /// The corrections at each pair, the second motion's values changing faster.
    pub corrections: &'a [[f32; 3]],
    /// How a correction of each pair shows on the posed skin.
    pub seen: ErrorMetric<'a>,
}

/// What is left of each sample after the motions' own keys, and where on the grid it stands.
struct Residuals<'a> {
    grid: Grid<'a>,
    shapes: Vec<Vec<[f32; 3]>>,
}

/// Places on the grid where hats stand.
#[derive(Debug, Clone, PartialEq)]
struct GridNodes {
    rows: Vec<usize>,
    columns: Vec<usize>,
}

impl CombinationKeys {
    /// The keys that the grid needs: at first where both motions are at their extremes, then one value of one motion more at a time,
    /// where it lowers the largest error most, until that is within the tolerance or there would be more than `most` keys.
    ///
    /// # Errors
    /// Lists that do not fit each other; values of both signs, or 0.
    pub fn new(grid: Grid, tolerance_m: f64, threshold_m: f64, most: usize) -> Result<Self> {
        let residuals = Residuals::new(grid)?;
        let mut found = Self {
            first_at: vec![],
            second_at: vec![],
            corners: vec![],
            corrections: vec![],
            error_before_m: residuals.error_m(None, None).0,
            error_at_m: 0.0,
            error_between_m: 0.0,
        };
        found.error_between_m = found.error_before_m;
        let stands = match residuals.stands(tolerance_m, most) {
            Some(stands) if found.error_before_m > tolerance_m => stands,
            _ => return Ok(found),
        };
        for (row_place, &row) in stands.rows.iter().enumerate() {
            for (column_place, &column) in stands.columns.iter().enumerate() {
                let correction = pruned(residuals.shape(row, column), threshold_m);
                if correction.iter().any(|entry| *entry != [0.0; 3]) {
                    found.corners.push([row_place, column_place]);
                    found.corrections.push(correction);
                }
            }
        }
        found.first_at = stands.rows.iter().map(|&row| grid.first_at[row]).collect();
        found.second_at = stands
            .columns
            .iter()
            .map(|&column| grid.second_at[column])
            .collect();
        (found.error_between_m, found.error_at_m) = residuals.error_m(Some(&stands), Some(&found));
        Ok(found)
    }

    /// The keys that act where the motions have these values, with their weights.
    pub fn weights(&self, first: f64, second: f64) -> Vec<(usize, f64)> {
        let mut weights = vec![];
        for (row, of_row) in hats(&self.first_at, first) {
            for (column, of_column) in hats(&self.second_at, second) {
                let key = self.corners.iter().position(|corner| *corner == [row, column]);
                weights.extend(key.map(|key| (key, of_row * of_column)));
            }
        }
        weights
    }
}

impl<'a> Residuals<'a> {
    fn new(grid: Grid<'a>) -> Result<Self> {
        let vertices = grid.first.vertices();
        require_length(
            "second",
            vertices,
            "as many vertices as first",
            grid.second.vertices(),
        )?;
        let due = vertices * grid.first_at.len() * grid.second_at.len();
        require_length(
            "corrections",
            due,
            "one a vertex and pair of values",
            grid.corrections.len(),
        )?;
        grid.seen
            .require_fit(vertices, grid.first_at.len() * grid.second_at.len())?;
        for (motion, at) in [("first", grid.first_at), ("second", grid.second_at)] {
            for (place, &value) in at.iter().enumerate() {
                let rises = place == 0 || value > at[place - 1];
                let allowed = rises && value != 0.0 && value * at[0] > 0.0;
                require(
                    allowed,
                    || format!("value {place} of the {motion} motion"),
                    "at",
                    value,
                    "rising and of one sign, not 0",
                )?;
            }
        }
        let columns = grid.second_at.len();
        let alone: Vec<_> = grid.second_at.iter().map(|&at| grid.second.shown(at)).collect();
        let shapes = (0..grid.first_at.len() * columns)
            .into_par_iter()
            .map(|cell| {
                let of_first = grid.first.shown(grid.first_at[cell / columns]);
                let of_second = &alone[cell % columns];
                let sample = &grid.corrections[cell * vertices..][..vertices];
                let left = |vertex: usize| {
                    std::array::from_fn(|axis| {
                        let alone = of_first[vertex][axis] + of_second[vertex][axis];
                        (f64::from(sample[vertex][axis]) - alone) as f32
                    })
                };
                (0..vertices).map(left).collect()
            })
            .collect();
        Ok(Self { grid, shapes })
    }

    fn shape(&self, row: usize, column: usize) -> &[[f32; 3]] {
        &self.shapes[row * self.grid.second_at.len() + column]
    }

    /// Where hats stand; `None` for an empty grid, or where not even one key is allowed.
    fn stands(&self, tolerance_m: f64, most: usize) -> Option<GridNodes> {
        let (rows, columns) = (
            candidate_nodes(self.grid.first_at),
            candidate_nodes(self.grid.second_at),
        );
        if most == 0 {
            return None;
        }
        let mut stands = GridNodes {
            rows: vec![*rows.first()?],
            columns: vec![*columns.first()?],
        };
        let mut error_m = self.error_m(Some(&stands), None).0;
        while error_m > tolerance_m {
            let more_rows = rows.iter().filter(|row| !stands.rows.contains(row));
            let more_columns = columns.iter().filter(|column| !stands.columns.contains(column));
            let wider = more_rows.map(|&row| stands.with(Some(row), None));
            let wider = wider.chain(more_columns.map(|&column| stands.with(None, Some(column))));
            let allowed = wider.filter(|stands| stands.rows.len() * stands.columns.len() <= most);
            let tried = allowed.map(|stands| (self.error_m(Some(&stands), None).0, stands));
            // the first of equals: the order is that of the values
            let Some((best_m, best)) =
                tried.reduce(|best, other| if other.0 < best.0 { other } else { best })
            else {
                break;
            };
            (error_m, stands) = (best_m, best);
        }
        Some(stands)
    }

    /// Largest distances, m, of the samples beside and at the corners of `stands` from what is shown there: each corner's whole
    /// residual, or what `keys` made of it.
    fn error_m(&self, stands: Option<&GridNodes>, keys: Option<&CombinationKeys>) -> (f64, f64) {
        let columns = self.grid.second_at.len();
        let value_of =
            |at: &'a [f64], places: &[usize]| places.iter().map(|&place| at[place]).collect::<Vec<_>>();
        let none = GridNodes {
            rows: vec![],
            columns: vec![],
        };
        let stands = stands.unwrap_or(&none);
        let (first, second) = (
            value_of(self.grid.first_at, &stands.rows),
            value_of(self.grid.second_at, &stands.columns),
        );
        let errors: Vec<(bool, f64)> = (0..self.shapes.len())
            .into_par_iter()
            .map(|cell| {
                let (row, column) = (cell / columns, cell % columns);
                let mut acting: Vec<(&[[f32; 3]], f64)> = vec![];
                for (r, of_row) in hats(&first, self.grid.first_at[row]) {
                    for (c, of_column) in hats(&second, self.grid.second_at[column]) {
                        let whole = self.shape(stands.rows[r], stands.columns[c]);
                        let shape = keys.map_or(Some(whole), |keys| {
                            let key = keys.corners.iter().position(|corner| *corner == [r, c]);
                            key.map(|key| keys.corrections[key].as_slice())
                        });
                        acting.extend(shape.map(|shape| (shape, of_row * of_column)));
                    }
                }
                let at_corner = stands.rows.contains(&row) && stands.columns.contains(&column);
                (
                    at_corner,
                    self.grid.seen.largest_m(cell, &self.shapes[cell], &acting),
                )
            })
            .collect();
        let largest = |at_corner: bool| {
            let wanted = errors.iter().filter(|(found, _)| *found == at_corner);
            wanted.map(|&(_, error_m)| error_m).fold(0.0, f64::max)
        };
        (largest(false), largest(true))
    }
}

impl GridNodes {
    fn with(&self, row: Option<usize>, column: Option<usize>) -> Self {
        let mut wider = self.clone();
        wider.rows.extend(row);
        wider.columns.extend(column);
        wider.rows.sort_unstable();
        wider.columns.sort_unstable();
        wider
    }
}

/// The places of a grid's values that may carry a hat: the outermost, then every second one towards rest.
fn candidate_nodes(at: &[f64]) -> Vec<usize> {
    let inward: Vec<usize> = match at.first() {
        Some(&first) if first < 0.0 => (0..at.len()).collect(),
        _ => (0..at.len()).rev().collect(),
    };
    inward.into_iter().step_by(2).collect()
}
