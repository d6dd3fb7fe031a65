//! What two motions together need beyond the correctives of each, such as shoulder and elbow
//! (mathematics/baking.md, Combinations).

use rayon::prelude::*;

use super::corrective::{MotionKeys, pruned, tent_weights};
use super::error_metric::ErrorMetric;
use crate::error::require_length;
use crate::error::{Result, require};

/// The corrective keys of two motions together, in one of the four quadrants around rest.
///
/// The weight of each key is the product of two tent weights, one per motion. So no key acts if one of the
/// motions is at rest.
#[derive(Debug, Clone)]
pub struct CombinationKeys {
    /// The values of the first motion at the nodes of its tents, increasing. Rest, 0, is a node, too, but not
    /// in the list.
    pub first_at: Vec<f64>,
    /// The same for the second motion.
    pub second_at: Vec<f64>,
    /// The index of each key in `first_at` and in `second_at`.
    pub corners: Vec<[usize; 2]>,
    /// The correction of each key where both tent weights are 1, one vector per vertex, m.
    pub corrections: Vec<Vec<[f32; 3]>>,
    /// Largest error of all samples with the keys of the single motions only, m.
    pub error_before_m: f64,
    /// Largest error of the samples where both tent weights are 1, m: the effect of the threshold.
    pub error_at_m: f64,
    /// Largest error of all other samples, m.
    pub error_between_m: f64,
}

/// Two motions, sampled on a grid.
#[derive(Debug, Clone, Copy)]
pub struct Grid<'a> {
    /// The keys of the first motion.
    pub first: &'a MotionKeys,
    /// The keys of the second motion.
    pub second: &'a MotionKeys,
    /// Values of the first motion, increasing, all of one sign. The outermost and every second one from there
    /// towards rest may become nodes; the samples between only check the error.
    pub first_at: &'a [f64],
    /// The same for the second motion.
    pub second_at: &'a [f64],
    /// The corrections at each pair of values, m: one vector per vertex, second motion fastest.
    pub corrections: &'a [[f32; 3]],
    /// How errors are measured.
    pub metric: ErrorMetric<'a>,
}

/// The difference between each sample and the keys of the single motions.
struct Residuals<'a> {
    grid: Grid<'a>,
    shapes: Vec<Vec<[f32; 3]>>,
}

/// Indices of the grid's values that are nodes of tents.
#[derive(Debug, Clone, PartialEq)]
struct GridNodes {
    rows: Vec<usize>,
    columns: Vec<usize>,
}

impl CombinationKeys {
    /// The keys that the grid needs. The first has both motions at their extremes. Then one value of one
    /// motion is added at a time, the one that lowers the largest error most, until the error is within
    /// `tolerance_m` or there would be more than `most` keys. Entries of a key up to `threshold_m` long
    /// become 0.
    ///
    /// # Errors
    /// [`crate::Error::Length`] for lists that do not fit one another; [`crate::Error::Value`] for values
    /// that do not increase, have both signs, or are 0.
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
        let nodes = match residuals.nodes(tolerance_m, most) {
            Some(nodes) if found.error_before_m > tolerance_m => nodes,
            _ => return Ok(found),
        };
        for (row_place, &row) in nodes.rows.iter().enumerate() {
            for (column_place, &column) in nodes.columns.iter().enumerate() {
                let correction = pruned(residuals.shape(row, column), threshold_m);
                if correction.iter().any(|entry| *entry != [0.0; 3]) {
                    found.corners.push([row_place, column_place]);
                    found.corrections.push(correction);
                }
            }
        }
        found.first_at = nodes.rows.iter().map(|&row| grid.first_at[row]).collect();
        found.second_at = nodes
            .columns
            .iter()
            .map(|&column| grid.second_at[column])
            .collect();
        (found.error_between_m, found.error_at_m) = residuals.error_m(Some(&nodes), Some(&found));
        Ok(found)
    }

    /// The keys that act at these values of the motions, with their weights.
    pub fn weights(&self, first: f64, second: f64) -> Vec<(usize, f64)> {
        let mut weights = vec![];
        for (row, of_row) in tent_weights(&self.first_at, first) {
            for (column, of_column) in tent_weights(&self.second_at, second) {
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
        let expected = vertices * grid.first_at.len() * grid.second_at.len();
        require_length(
            "corrections",
            expected,
            "one per vertex and pair of values",
            grid.corrections.len(),
        )?;
        grid.metric
            .require_fit(vertices, grid.first_at.len() * grid.second_at.len())?;
        for (motion, at) in [("first", grid.first_at), ("second", grid.second_at)] {
            for (index, &value) in at.iter().enumerate() {
                let rises = index == 0 || value > at[index - 1];
                let allowed = rises && value != 0.0 && value * at[0] > 0.0;
                require(
                    allowed,
                    || format!("Value {index} of the {motion} motion"),
                    "at",
                    value,
                    "increasing and of one sign, not 0",
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

    /// The nodes; `None` for an empty grid, or if no key is allowed.
    fn nodes(&self, tolerance_m: f64, most: usize) -> Option<GridNodes> {
        let (rows, columns) = (
            candidate_nodes(self.grid.first_at),
            candidate_nodes(self.grid.second_at),
        );
        if most == 0 {
            return None;
        }
        let mut nodes = GridNodes {
            rows: vec![*rows.first()?],
            columns: vec![*columns.first()?],
        };
        let mut error_m = self.error_m(Some(&nodes), None).0;
        while error_m > tolerance_m {
            let more_rows = rows.iter().filter(|row| !nodes.rows.contains(row));
            let more_columns = columns.iter().filter(|column| !nodes.columns.contains(column));
            let wider = more_rows.map(|&row| nodes.with(Some(row), None));
            let wider = wider.chain(more_columns.map(|&column| nodes.with(None, Some(column))));
            let allowed = wider.filter(|nodes| nodes.rows.len() * nodes.columns.len() <= most);
            let tried = allowed.map(|nodes| (self.error_m(Some(&nodes), None).0, nodes));
            // the first of equal ones, in the order of the values
            let Some((best_m, best)) =
                tried.reduce(|best, other| if other.0 < best.0 { other } else { best })
            else {
                break;
            };
            (error_m, nodes) = (best_m, best);
        }
        Some(nodes)
    }

    /// Largest errors, m, of the samples that are not nodes, and of those that are. A node shows its whole
    /// residual, or its key in `keys`.
    fn error_m(&self, nodes: Option<&GridNodes>, keys: Option<&CombinationKeys>) -> (f64, f64) {
        let columns = self.grid.second_at.len();
        let value_of =
            |at: &'a [f64], indices: &[usize]| indices.iter().map(|&index| at[index]).collect::<Vec<_>>();
        let none = GridNodes {
            rows: vec![],
            columns: vec![],
        };
        let nodes = nodes.unwrap_or(&none);
        let (first, second) = (
            value_of(self.grid.first_at, &nodes.rows),
            value_of(self.grid.second_at, &nodes.columns),
        );
        let errors: Vec<(bool, f64)> = (0..self.shapes.len())
            .into_par_iter()
            .map(|cell| {
                let (row, column) = (cell / columns, cell % columns);
                let mut acting: Vec<(&[[f32; 3]], f64)> = vec![];
                for (r, of_row) in tent_weights(&first, self.grid.first_at[row]) {
                    for (c, of_column) in tent_weights(&second, self.grid.second_at[column]) {
                        let whole = self.shape(nodes.rows[r], nodes.columns[c]);
                        let shape = keys.map_or(Some(whole), |keys| {
                            let key = keys.corners.iter().position(|corner| *corner == [r, c]);
                            key.map(|key| keys.corrections[key].as_slice())
                        });
                        acting.extend(shape.map(|shape| (shape, of_row * of_column)));
                    }
                }
                let at_corner = nodes.rows.contains(&row) && nodes.columns.contains(&column);
                (
                    at_corner,
                    self.grid.metric.largest_m(cell, &self.shapes[cell], &acting),
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

/// The indices of a grid's values that may become nodes: the outermost, then every second one towards rest.
fn candidate_nodes(at: &[f64]) -> Vec<usize> {
    let inward: Vec<usize> = match at.first() {
        Some(&first) if first < 0.0 => (0..at.len()).collect(),
        _ => (0..at.len()).rev().collect(),
    };
    inward.into_iter().step_by(2).collect()
}
