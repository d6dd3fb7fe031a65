//! Evens out the quads of a surface: vertices move along it towards the centre of their neighbours.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::bricks::Bricks;
use super::extract::QuadMesh;
use super::mirror::mirrored_cell;
use super::neighbours::vertex_neighbours;
use super::quality;
use crate::math::rows::Rows;

/// Number of smoothing iterations.
const ITERATIONS: usize = 4;
/// Fraction of the displacement that a vertex moves in an iteration.
const STEP: f64 = 0.6;
/// Iterations that repair bad faces, towards the neighbours' centre and then towards the cells' centres.
const REPAIR_ITERATIONS: [usize; 2] = [10, 200];
/// Longest step towards the surface, voxels.
const LONGEST_STEP: f64 = 0.35;
/// Largest distance of a vertex from its extracted position, voxels of the surface.
const MAX_DISPLACEMENT: f64 = 0.9;
/// Squared gradient below which the direction to the surface is undefined: at a crease or beyond the band.
const LEAST_GRADIENT: f64 = 0.05;
/// Difference of mirror images, voxels, that counts as rounding.
const SAME: f64 = 1e-3;

/// The field that a surface was extracted from, sampled in voxels of the surface.
#[derive(Clone, Copy)]
pub(super) struct FieldSampler<'a> {
    /// The field. Its lattice may be finer than that of the surface.
    pub bricks: &'a Bricks,
    /// Edge length of the surface's voxels in voxels of the field.
    pub ratio: f64,
}

impl FieldSampler<'_> {
    /// Depth, in voxels of the surface, and gradient.
    pub fn sample(&self, position: DVec3) -> (f64, DVec3) {
        // integers are the centres of voxels, so the corner of the first voxel is at -1/2 on both lattices
        let (depth, gradient) = self.bricks.sample((position + 0.5) * self.ratio - 0.5);
        (depth / self.ratio, gradient)
    }

    /// A step from `position` to the surface, and the unit normal; `None` if the gradient is too small.
    fn step(&self, position: DVec3) -> Option<(DVec3, DVec3)> {
        let (depth, gradient) = self.sample(position);
        let slope = gradient.length_squared();
        (slope > LEAST_GRADIENT).then(|| {
            let step = -gradient * (depth / slope);
            (step.clamp_length_max(LONGEST_STEP), gradient / slope.sqrt())
        })
    }
}

/// Evens out `mesh`. The quality of its faces becomes at least `least_quality` where possible.
pub(super) fn relax(mesh: &mut QuadMesh, sampler: FieldSampler, least_quality: f64) {
    symmetrise(mesh);
    let extracted = mesh.positions.clone();
    let rows = vertex_neighbours(mesh);
    for _ in 0..ITERATIONS {
        mesh.positions = smoothed(mesh, &rows, sampler, &extracted);
    }
    repair_quality(mesh, &rows, least_quality);
    symmetrise(mesh);
}

fn smoothed(mesh: &QuadMesh, rows: &Rows<u32>, sampler: FieldSampler, extracted: &[DVec3]) -> Vec<DVec3> {
    (0..mesh.positions.len())
        .into_par_iter()
        .map(|vertex| {
            let position = mesh.positions[vertex];
            let mut displacement = STEP * (middle_of(&mesh.positions, rows.row(vertex)) - position);
            if let Some((_, across)) = sampler.step(position) {
                displacement -= across * across.dot(displacement);
            }
            let mut next = position + displacement;
            if let Some((step, _)) = sampler.step(next) {
                next += step;
            }
            extracted[vertex] + (next - extracted[vertex]).clamp_length_max(MAX_DISPLACEMENT)
        })
        .collect()
}

fn middle_of(positions: &[DVec3], vertices: &[u32]) -> DVec3 {
    vertices
        .iter()
        .map(|&vertex| positions[vertex as usize])
        .sum::<DVec3>()
        / vertices.len().max(1) as f64
}

/// Moves the corners of bad faces to the centre of their neighbours, on the surface or not; if that does not
/// help, to the centres of their cells. With all vertices at the centres of their cells all faces are
/// squares, so the iteration ends.
fn repair_quality(mesh: &mut QuadMesh, rows: &Rows<u32>, least_quality: f64) {
    for iteration in 0..REPAIR_ITERATIONS[0] + REPAIR_ITERATIONS[1] {
        let quads = mesh.quads.par_iter();
        let bad = quads.filter(|quad| quality_of(mesh, quad) < least_quality);
        let mut vertices: Vec<u32> = bad.flat_map_iter(|quad| *quad).collect();
        if vertices.is_empty() {
            return;
        }
        vertices.sort_unstable();
        vertices.dedup();
        let target = |vertex: usize| {
            if iteration < REPAIR_ITERATIONS[0] {
                middle_of(&mesh.positions, rows.row(vertex))
            } else {
                mesh.cells[vertex].as_dvec3() + 0.5
            }
        };
        let moved: Vec<DVec3> = vertices
            .iter()
            .map(|&vertex| mesh.positions[vertex as usize].midpoint(target(vertex as usize)))
            .collect();
        for (vertex, position) in vertices.into_iter().zip(moved) {
            mesh.positions[vertex as usize] = position;
        }
    }
}

/// The quality of a quad of `mesh`.
pub(super) fn quality_of(mesh: &QuadMesh, quad: &[u32; 4]) -> f64 {
    quality::of_quad(quad.map(|vertex| mesh.positions[vertex as usize]))
}

/// Makes mirror images exact where they differ by rounding only, and moves the middle onto the plane.
fn symmetrise(mesh: &mut QuadMesh) {
    let vertices: FxHashMap<IVec3, usize> = mesh.cells.iter().copied().zip(0..).collect();
    // in voxels the plane is x = -1/2
    let flip = |position: DVec3| DVec3::new(-1.0 - position.x, position.y, position.z);
    let even: Vec<DVec3> = (0..mesh.positions.len())
        .into_par_iter()
        .map(|vertex| {
            let position = mesh.positions[vertex];
            let image = vertices
                .get(&mirrored_cell(mesh.cells[vertex]))
                .map(|&image| flip(mesh.positions[image]));
            match image {
                Some(image) if image.distance(position) < SAME => position.midpoint(image),
                _ => position,
            }
        })
        .collect();
    mesh.positions = even;
}
