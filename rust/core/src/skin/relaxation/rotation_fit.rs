//! The fit of rotations, the local step of ARAP (Sorkine and Alexa 2007; mathematics/relaxation.md,
//! Iteration).

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::math::polar::rotate_towards_fit;
use crate::math::vec3x4::LANES;
use crate::parallel::{RELAXATION_CHUNK, RELAXATION_CHUNKS_PER_TASK};
use crate::skin::relaxation::edges::EdgeWeights;

/// Iterations from one fit of the rotations to the next. Measured: with a fit in every iteration the
/// largest edge stretch is 1.60 instead of 1.65 (elbow, 120°) and the bend is 46° instead of 44° (knee,
/// 140°). A fit costs more than a step.
const FIT_INTERVAL: usize = 2;

/// What a fit reads of a vertex and of its neighbours, in one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct FitVertex {
    /// Position at the last fit, m.
    pub position: Vec3A,
    /// Rotation and scale. They start as those of the anchor.
    pub axes: Mat3A,
}

impl FitVertex {
    pub const NONE: Self = Self {
        position: Vec3A::ZERO,
        axes: Mat3A::IDENTITY,
    };
}

/// Rotates the axes of every vertex one step towards the best fit to its edges and to its
/// neighbours' axes. If it `is_first`, all vertices are on their anchors.
///
/// `moves` are the vertices that are relaxed, `moving_chunks` the chunks with such a vertex. The result is written to
/// `next_fit_vertices`.
pub(crate) fn fit_rotations(
    fit_vertices: &[FitVertex],
    next_fit_vertices: &mut [FitVertex],
    anchored_edges: &mut [Vec3A],
    moves: &[bool],
    moving_chunks: &[bool],
    edge_weights: &EdgeWeights,
    is_first: bool,
) {
    let work = next_fit_vertices
        .par_chunks_mut(RELAXATION_CHUNK)
        .zip(anchored_edges.par_chunks_mut(RELAXATION_CHUNK))
        .enumerate()
        .with_max_len(RELAXATION_CHUNKS_PER_TASK);
    work.filter(|(chunk, _)| moving_chunks[*chunk]).for_each(
        |(chunk, (next_fit_vertices, anchored_edges))| {
            let first = chunk * RELAXATION_CHUNK;
            let vertices = first..first + next_fit_vertices.len();
            let before = fit_vertices[vertices.clone()]
                .iter()
                .zip(&moves[vertices.clone()]);
            let after = next_fit_vertices.iter_mut().zip(anchored_edges.iter_mut());
            for ((vertex, (next, anchored)), (fit_vertex, moves)) in vertices.zip(after).zip(before) {
                *next = *fit_vertex;
                if !moves {
                    continue;
                }
                let (mut fit, mut mean) = (Mat3A::ZERO, Vec3A::ZERO);
                for (edge, rest) in edge_weights.at(vertex) {
                    let neighbour = &fit_vertices[edge.to as usize];
                    let vector = neighbour.position - fit_vertex.position;
                    mean += vector * edge.weight;
                    let rest_vector = rest.vector();
                    fit.x_axis += vector * rest_vector.x;
                    fit.y_axis += vector * rest_vector.y;
                    fit.z_axis += vector * rest_vector.z;
                    fit += neighbour.axes * rest.bending();
                }
                next.axes = fit;
                if is_first {
                    *anchored = mean;
                }
            }
            for (first, fits) in (first..).step_by(LANES).zip(next_fit_vertices.chunks_mut(LANES)) {
                let group = first..first + fits.len();
                if moves[group.clone()].contains(&true) {
                    rotate_all(&fit_vertices[group], fits);
                }
            }
        },
    );
}

/// Rotates the axes of up to [`LANES`] vertices one step towards their matrices in `fits`, and writes
/// them there.
fn rotate_all(fit_vertices: &[FitVertex], fits: &mut [FitVertex]) {
    let axes = |fit_vertices: &[FitVertex]| {
        let last = fit_vertices.len() - 1;
        std::array::from_fn(|lane| fit_vertices[lane.min(last)].axes)
    };
    let rotated = rotate_towards_fit(axes(fit_vertices), axes(fits));
    for (fit, axes) in fits.iter_mut().zip(rotated) {
        fit.axes = axes;
    }
}

/// Whether the rotations are fitted in an iteration. Not in the last one, where only one step would use them.
pub(crate) fn fits_rotations(iteration: usize, iterations: usize) -> bool {
    iteration == 0 || iteration.is_multiple_of(FIT_INTERVAL) && iteration + 1 < iterations
}
