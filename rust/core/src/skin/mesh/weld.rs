//! Which vertices of a mesh are one place of its surface.
//!
//! Files split a vertex wherever a UV seam or a hard edge passes it. Relaxation, volume and contact need the surface itself, so
//! vertices that coincide at rest and move alike are welded here, at the door, and everything behind it knows one vertex for them.

use std::collections::HashMap;

use glam::DVec3;

use crate::skin::mesh::bone_weights::{BoneWeight, BoneWeights};

/// Distance up to which two vertices coincide, over the size of the mesh: what f32 and a file's quantisation leave of one place.
const COINCIDENT_OF_SIZE: f64 = 1e-6;
/// Sum of the differences between the weights of two vertices up to which they move alike. Exporters round weights to 1/255, and
/// up to eight of them; lips, which coincide as well, differ by about 2.
const ALIKE: f32 = 0.5;
/// Side of a cell of the search grid over the distance up to which vertices coincide: nearly all vertices fall into one cell.
const CELL: f64 = 64.0;

type Cell = [i64; 3];

/// For each vertex the first one that it coincides with and moves like; itself where there is none.
pub(crate) fn representatives(points: &[DVec3], weights: &BoneWeights) -> Vec<u32> {
    let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let coincident_m = (COINCIDENT_OF_SIZE * (high - low).max_element()).max(f64::MIN_POSITIVE);
    let cell_of = |point: DVec3| ((point - low) / (CELL * coincident_m)).floor();
    let mut grid: HashMap<Cell, Vec<u32>> = HashMap::with_capacity(points.len());
    let mut found = Vec::with_capacity(points.len());
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
        found.push(known.unwrap_or(vertex as u32));
    }
    found
}

fn cells(first: DVec3, last: DVec3) -> impl Iterator<Item = Cell> {
    let range = move |axis: usize| first[axis] as i64..=last[axis] as i64;
    let cells = range(0).flat_map(move |x| range(1).map(move |y| (x, y)));
    cells.flat_map(move |(x, y)| range(2).map(move |z| [x, y, z]))
}

/// Whether two rows of weights carry a vertex alike.
fn are_alike(one: &[BoneWeight], other: &[BoneWeight]) -> bool {
    if one.is_empty() != other.is_empty() {
        return false; // what no bone moves stays behind
    }
    let of = |row: &[BoneWeight], bone: u32| {
        let own = row.iter().filter(|own| own.bone == bone);
        own.map(|own| own.weight).sum::<f32>()
    };
    let common: f32 = one
        .iter()
        .map(|own| (own.weight - of(other, own.bone)).abs())
        .sum();
    let rest = other.iter().filter(|own| of(one, own.bone) == 0.0);
    common + rest.map(|own| own.weight).sum::<f32>() <= ALIKE
}
