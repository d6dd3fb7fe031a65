//! Evens out the quads of a surface: vertices slide along it toward the middle of their neighbours, and stay on it.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::bricks::Bricks;
use super::extract::QuadMesh;
use super::mirror::mirrored_cell;
use super::neighbours::Rows;
use super::quality;

/// Rounds of sliding.
const ROUNDS: usize = 4;
/// Part of the way that a vertex goes in a round.
const STEP: f64 = 0.6;
/// Rounds that mend bad faces, by the neighbours and then by the cells.
const MENDING_ROUNDS: [usize; 2] = [10, 200];
/// Longest step toward the surface, voxels.
const LONGEST_STEP: f64 = 0.35;
/// How far a vertex may go from where it was extracted, voxels of its own lattice.
const MAX_DISPLACEMENT: f64 = 0.9;
/// Gradients below this, squared, point nowhere: at a crease or beyond the band.
const LEAST_GRADIENT: f64 = 0.05;
/// Difference of mirror images, voxels, that is rounding.
const SAME: f64 = 1e-3;

/// The field that a surface was extracted from, and how many of its voxels one of the surface's own is.
#[derive(Clone, Copy)]
pub(super) struct FieldSampler<'a> {
    /// The field; it may be finer than the lattice of the surface.
    pub bricks: &'a Bricks,
    /// Voxels of the field along a voxel of the surface.
    pub finer: f64,
}

impl FieldSampler<'_> {
    /// Depth, in voxels of the surface, and gradient.
    pub fn sample(&self, place: DVec3) -> (f64, DVec3) {
        // whole numbers are the centres of voxels, so the corner of the first voxel is at -1/2 on both lattices
        let (depth, gradient) = self.bricks.sample((place + 0.5) * self.finer - 0.5);
        (depth / self.finer, gradient)
    }

    /// A step from `place` toward the surface, and the direction across it; `None` where the field is flat.
    fn step(&self, place: DVec3) -> Option<(DVec3, DVec3)> {
        let (depth, gradient) = self.sample(place);
        let slope = gradient.length_squared();
        (slope > LEAST_GRADIENT).then(|| {
            let step = -gradient * (depth / slope);
            (step.clamp_length_max(LONGEST_STEP), gradient / slope.sqrt())
        })
    }
}

/// Evens out `mesh`, whose faces become no worse than `least_quality` where that can be reached.
pub(super) fn relax(mesh: &mut QuadMesh, ground: FieldSampler, least_quality: f64) {
    pair(mesh);
    let extracted = mesh.places.clone();
    let rows = Rows::of_vertices(mesh);
    for _ in 0..ROUNDS {
        mesh.places = slid(mesh, &rows, ground, &extracted);
    }
    repair_quality(mesh, &rows, least_quality);
    pair(mesh);
}

fn slid(mesh: &QuadMesh, rows: &Rows, ground: FieldSampler, extracted: &[DVec3]) -> Vec<DVec3> {
    (0..mesh.places.len())
        .into_par_iter()
        .map(|vertex| {
            let place = mesh.places[vertex];
            let mut way = STEP * (middle_of(&mesh.places, rows.of(vertex)) - place);
            if let Some((_, across)) = ground.step(place) {
                way -= across * across.dot(way);
            }
            let mut next = place + way;
            if let Some((step, _)) = ground.step(next) {
                next += step;
            }
            extracted[vertex] + (next - extracted[vertex]).clamp_length_max(MAX_DISPLACEMENT)
        })
        .collect()
}

fn middle_of(places: &[DVec3], vertices: &[u32]) -> DVec3 {
    vertices
        .iter()
        .map(|&vertex| places[vertex as usize])
        .sum::<DVec3>()
        / vertices.len().max(1) as f64
}

/// Moves the corners of bad faces to the middle of their neighbours, on the surface or not, and if that does not help to the
/// middle of their cells: with all vertices there, all faces are squares, so that this comes to an end.
fn repair_quality(mesh: &mut QuadMesh, rows: &Rows, least_quality: f64) {
    for round in 0..MENDING_ROUNDS[0] + MENDING_ROUNDS[1] {
        let quads = mesh.quads.par_iter();
        let bad = quads.filter(|quad| quality_of(mesh, quad) < least_quality);
        let mut vertices: Vec<u32> = bad.flat_map_iter(|quad| *quad).collect();
        if vertices.is_empty() {
            return;
        }
        vertices.sort_unstable();
        vertices.dedup();
        let goal = |vertex: usize| {
            if round < MENDING_ROUNDS[0] {
                middle_of(&mesh.places, rows.of(vertex))
            } else {
                mesh.cells[vertex].as_dvec3() + 0.5
            }
        };
        let moved: Vec<DVec3> = vertices
            .iter()
            .map(|&vertex| mesh.places[vertex as usize].midpoint(goal(vertex as usize)))
            .collect();
        for (vertex, place) in vertices.into_iter().zip(moved) {
            mesh.places[vertex as usize] = place;
        }
    }
}

/// The quality of a quad of `mesh`.
pub(super) fn quality_of(mesh: &QuadMesh, quad: &[u32; 4]) -> f64 {
    quality::of_quad(quad.map(|vertex| mesh.places[vertex as usize]))
}

/// Makes mirror images exact where they differ by rounding alone, and puts the middle on the plane.
fn pair(mesh: &mut QuadMesh) {
    let numbers: FxHashMap<IVec3, usize> = mesh.cells.iter().copied().zip(0..).collect();
    // a place in voxels is mirrored in the plane x = -1/2
    let flip = |place: DVec3| DVec3::new(-1.0 - place.x, place.y, place.z);
    let even: Vec<DVec3> = (0..mesh.places.len())
        .into_par_iter()
        .map(|vertex| {
            let own = mesh.places[vertex];
            let image = numbers
                .get(&mirrored_cell(mesh.cells[vertex]))
                .map(|&image| flip(mesh.places[image]));
            match image {
                Some(image) if image.distance(own) < SAME => own.midpoint(image),
                _ => own,
            }
        })
        .collect();
    mesh.places = even;
}
