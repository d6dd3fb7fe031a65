//! Finds the vertices that are one point of the surface. Files split a vertex at a UV seam or a hard edge.
//! Such vertices are welded before the bind. Vertices are welded if they coincide at rest and move alike
//! (mathematics/binding.md, Welded vertices).

use std::collections::HashMap;

use glam::DVec3;

use crate::skin::mesh::bone_weights::{BoneWeight, BoneWeights};

/// Largest distance of coinciding vertices, over the size of the mesh: rounding and quantisation.
const COINCIDENT_OF_SIZE: f64 = 1e-6;
/// Largest sum of the differences between the weights of two vertices that move alike: exporters round up to
/// eight weights to 1/255. Vertices that differ more are apart under the Armature modifier, too. If they were
/// welded, one of them would leave the place where the modifier puts it, and no safeguard could undo that.
const ALIKE: f32 = 8.0 / 255.0;
/// Side of a cell of the search grid, over the largest distance of coinciding vertices. It is large, so that
/// the search around nearly every vertex reads one cell only.
const CELL: f64 = 64.0;

type Cell = [i64; 3];

/// For each vertex the first one that it is welded to, or its own index.
pub(crate) fn representatives(points: &[DVec3], weights: &BoneWeights) -> Vec<u32> {
    let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let coincident_m = (COINCIDENT_OF_SIZE * (high - low).max_element()).max(f64::MIN_POSITIVE);
    let cell_of = |point: DVec3| ((point - low) / (CELL * coincident_m)).floor();
    let mut grid: HashMap<Cell, Vec<u32>> = HashMap::with_capacity(points.len());
    let mut representatives = Vec::with_capacity(points.len());
    for (vertex, &point) in points.iter().enumerate() {
        let (first, last) = (cell_of(point - coincident_m), cell_of(point + coincident_m));
        let known = cells(first, last)
            .filter_map(|cell| grid.get(&cell))
            .flatten()
            .copied()
            .filter(|&other| points[other as usize].distance(point) <= coincident_m)
            .filter(|&other| are_alike(weights.of(other as usize), weights.of(vertex)))
            .min();
        if known.is_none() {
            let [x, y, z] = cell_of(point).to_array();
            grid.entry([x as i64, y as i64, z as i64])
                .or_default()
                .push(vertex as u32);
        }
        representatives.push(known.unwrap_or(vertex as u32));
    }
    representatives
}

fn cells(first: DVec3, last: DVec3) -> impl Iterator<Item = Cell> {
    let range = move |axis: usize| first[axis] as i64..=last[axis] as i64;
    let cells = range(0).flat_map(move |x| range(1).map(move |y| (x, y)));
    cells.flat_map(move |(x, y)| range(2).map(move |z| [x, y, z]))
}

/// Whether two vertices with these rows of weights move alike.
fn are_alike(one: &[BoneWeight], other: &[BoneWeight]) -> bool {
    if one.is_empty() != other.is_empty() {
        return false; // a vertex without weights does not move
    }
    let of = |row: &[BoneWeight], bone: u32| {
        let entries = row.iter().filter(|entry| entry.bone == bone);
        entries.map(|entry| entry.weight).sum::<f32>()
    };
    let common: f32 = one
        .iter()
        .map(|entry| (entry.weight - of(other, entry.bone)).abs())
        .sum();
    let rest = other.iter().filter(|entry| of(one, entry.bone) == 0.0);
    common + rest.map(|entry| entry.weight).sum::<f32>() <= ALIKE
}
