//! Bone weights of a grown skin from the tissues below it, so that an Armature modifier alone deforms it, too
//! (mathematics/growing.md, Weights).
//!
//! A vertex follows the tissues near it with weights 1 / (distance + softness)⁴, as in a bind. The weight of
//! a tissue is divided among the bones that it is attached to and those between, by the same formula with the
//! distance from the bone's line. So the weights of two bones are equal at their joint and one-sided away
//! from it, and wide limbs have soft transitions.

use glam::DVec3;
use rayon::prelude::*;

use super::bricks::brick_of;
use super::extract::QuadMesh;
use super::lattice::Lattice;
use super::neighbours::vertex_neighbours;
use crate::math::rows::Rows;
use crate::muscles::musculature::Musculature;

/// Softness over the size of the whole: 4 mm on a human of 1.73 m, as in a bind.
const SOFTNESS_OF_SIZE: f64 = 0.004 / 1.73;
/// A tissue farther than this multiple of the nearest distance is ignored: its weight would be below 1/256 of
/// the largest.
const FARTHEST: f64 = 4.0;
/// Smoothing iterations over the surface.
const ITERATIONS: usize = 4;
/// Most bones per vertex during smoothing, and at the end (as game engines allow).
const MOST_WHILE_SMOOTHED: usize = 8;
const MOST: usize = 4;
/// Smaller weights are removed at the end.
const LEAST: f32 = 0.01;

/// The bones of a grown skin.
#[derive(Debug, Clone, Copy)]
pub struct SkinBones<'a> {
    /// Length of each bone along its y axis, armature space, m.
    pub lengths_m: &'a [f32],
    /// For each bone the bone that gets its weight: itself, or the nearest ancestor that deforms meshes if it
    /// does not.
    pub weight_bones: &'a [usize],
}

/// The bones of one vertex and their weights, which sum to 1.
pub(super) type Weights = Vec<(u32, f32)>;

/// The weights of all vertices of `mesh`, each row with the largest first.
pub(super) fn weights_of(
    mesh: &QuadMesh,
    lattice: Lattice,
    musculature: &Musculature,
    bones: SkinBones,
    size_m: f64,
) -> Vec<Weights> {
    let anatomy = Anatomy::new(musculature, bones, SOFTNESS_OF_SIZE * size_m);
    // the vertices of one brick are consecutive and have the same tissues near them
    let vertices: Vec<usize> = (0..mesh.cells.len()).collect();
    let mut rows: Vec<Weights> = vertices
        .chunk_by(|&a, &b| brick_of(mesh.cells[a]) == brick_of(mesh.cells[b]))
        .collect::<Vec<_>>()
        .into_par_iter()
        .flat_map_iter(|group| {
            let points: Vec<DVec3> = group
                .iter()
                .map(|&vertex| lattice.point(mesh.positions[vertex]))
                .collect();
            let near = anatomy.near(&points);
            points
                .into_iter()
                .map(|point| anatomy.weights_at(point, &near))
                .collect::<Vec<_>>()
        })
        .collect();
    let neighbours = vertex_neighbours(mesh);
    for _ in 0..ITERATIONS {
        rows = smoothed(&rows, &neighbours);
    }
    rows.into_par_iter().map(strongest).collect()
}

/// Tissues and bones, prepared for distances.
struct Anatomy<'a> {
    musculature: &'a Musculature,
    /// The bones of each tissue: head, tail, and the bone that gets the weight.
    lines: Vec<Vec<(DVec3, DVec3, u32)>>,
    softness_m: f64,
}

impl<'a> Anatomy<'a> {
    fn new(musculature: &'a Musculature, bones: SkinBones, softness_m: f64) -> Self {
        let line = |bone: usize| {
            let rest = musculature.skeleton().rest()[bone];
            let tail = rest.transform_point3(DVec3::Y * f64::from(bones.lengths_m[bone]));
            (rest.translation, tail, bones.weight_bones[bone] as u32)
        };
        let lines_of = |tissue: usize| musculature.bones_of(tissue).into_iter().map(line).collect();
        Self {
            musculature,
            lines: (0..musculature.len()).map(lines_of).collect(),
            softness_m,
        }
    }

    fn limit_m(&self, nearest_m: f64) -> f64 {
        FARTHEST * (nearest_m.max(0.0) + self.softness_m)
    }

    /// The ellipsoids that may count for any of some points near one another.
    fn near(&self, points: &[DVec3]) -> Vec<usize> {
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        let radius = points
            .iter()
            .map(|point| point.distance(middle))
            .fold(0.0, f64::max);
        let ellipsoids = self.musculature.ellipsoids();
        let mut nearest_m = f64::INFINITY;
        for ellipsoid in ellipsoids {
            if ellipsoid.distance_bound(middle) < nearest_m {
                nearest_m = nearest_m.min(ellipsoid.nearest(middle).distance_m.max(0.0));
            }
        }
        let limit_m = self.limit_m(nearest_m + radius) + radius;
        (0..ellipsoids.len())
            .filter(|&index| ellipsoids[index].distance_bound(middle) <= limit_m)
            .collect()
    }

    fn weights_at(&self, point: DVec3, near: &[usize]) -> Weights {
        let ellipsoids = self.musculature.ellipsoids();
        let bounds: Vec<(usize, f64)> = near
            .iter()
            .map(|&index| (index, ellipsoids[index].distance_bound(point)))
            .collect();
        let distance_m = |index: usize| ellipsoids[index].nearest(point).distance_m.max(0.0);
        let first = bounds.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let nearest_m = bounds.iter().fold(
            first.map_or(0.0, |first| distance_m(first.0)),
            |nearest_m, &(index, bound_m)| {
                if bound_m < nearest_m {
                    nearest_m.min(distance_m(index))
                } else {
                    nearest_m
                }
            },
        );
        let limit_m = self.limit_m(nearest_m);
        let distances = bounds
            .into_iter()
            .filter(|found| found.1 <= limit_m)
            .map(|(index, _)| (index, distance_m(index)));
        let mut weights = Weights::new();
        for (index, distance_m) in distances.filter(|found| found.1 <= limit_m) {
            let tissue = self.musculature.ellipsoid_tissues()[index];
            let parts: Vec<_> = self.lines[tissue]
                .iter()
                .map(|&(head, tail, bone)| (bone, self.falloff(distance_from_line(point, head, tail))))
                .collect();
            let total = self.falloff(distance_m) / parts.iter().map(|part| part.1).sum::<f64>();
            parts
                .into_iter()
                .for_each(|(bone, part)| add(&mut weights, bone, (total * part) as f32));
        }
        normalise(&mut weights);
        weights
    }

    /// A weight in 0..1. Lengths are in units of the softness, so that f32 suffices for characters of any
    /// size.
    fn falloff(&self, distance_m: f64) -> f64 {
        (1.0 + distance_m / self.softness_m).powi(-4)
    }
}

fn distance_from_line(point: DVec3, head: DVec3, tail: DVec3) -> f64 {
    let line = tail - head;
    let squared = line.length_squared();
    let fraction = if squared > 0.0 {
        ((point - head).dot(line) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    point.distance(head + line * fraction)
}

fn add(weights: &mut Weights, bone: u32, weight: f32) {
    match weights.iter_mut().find(|entry| entry.0 == bone) {
        Some(entry) => entry.1 += weight,
        None => weights.push((bone, weight)),
    }
}

fn normalise(weights: &mut Weights) {
    let sum: f32 = weights.iter().map(|entry| entry.1).sum();
    weights.iter_mut().for_each(|entry| entry.1 /= sum);
}

fn keep(weights: &mut Weights, most: usize, least: f32) {
    weights.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    weights.truncate(most);
    weights.retain(|entry| entry.1 >= least);
    normalise(weights);
}

fn smoothed(rows: &[Weights], neighbours: &Rows<u32>) -> Vec<Weights> {
    (0..rows.len())
        .into_par_iter()
        .map(|vertex| {
            let mut weights = rows[vertex].clone();
            let around = neighbours.row(vertex);
            let fraction = 1.0 / around.len().max(1) as f32;
            for &neighbour in around {
                for &(bone, weight) in &rows[neighbour as usize] {
                    add(&mut weights, bone, fraction * weight);
                }
            }
            keep(&mut weights, MOST_WHILE_SMOOTHED, 0.0);
            weights
        })
        .collect()
}

fn strongest(mut weights: Weights) -> Weights {
    keep(&mut weights, MOST, LEAST);
    weights
}
