//! The fit of rotations, the local step of ARAP (Sorkine and Alexa 2007; mathematics/relaxation.md,
//! Iteration).

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::math::polar::rotate_towards_fit;
use crate::math::vec3x4::LANES;
use crate::parallel::{RELAXATION_CHUNK, RELAXATION_CHUNKS_PER_TASK};
use crate::skin::relaxation::edges::{Edge, EdgeWeights, RestEdge};

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
            let firsts = (chunk * RELAXATION_CHUNK..).step_by(LANES);
            let groups = next_fit_vertices
                .chunks_mut(LANES)
                .zip(anchored_edges.chunks_mut(LANES));
            for (first, (next, anchored)) in firsts.zip(groups) {
                let vertices = first..first + next.len();
                let (before, moves) = (&fit_vertices[vertices.clone()], &moves[vertices]);
                if !moves.contains(&true) {
                    next.copy_from_slice(before);
                    continue;
                }
                // lanes without a vertex repeat the last one
                let lane = |lane: usize| before[lane.min(before.len() - 1)].axes;
                let (axes, mut fits) = (std::array::from_fn(lane), [Mat3A::ZERO; LANES]);
                for (slot, fit_vertex) in before.iter().enumerate() {
                    if !moves[slot] {
                        fits[slot] = fit_vertex.axes;
                        continue;
                    }
                    let (edges, rests) = edge_weights.at(first + slot);
                    fits[slot] = match (<&[Edge; 4]>::try_from(edges), <&[RestEdge; 4]>::try_from(rests)) {
                        (Ok(edges), Ok(rests)) => fit(fit_vertices, fit_vertex, edges, rests),
                        _ => fit(fit_vertices, fit_vertex, edges, rests),
                    };
                    if is_first {
                        anchored[slot] = mean_edge(fit_vertices, fit_vertex, edges);
                    }
                }
                let rotated = rotate_towards_fit(axes, fits);
                for (slot, next) in next.iter_mut().enumerate() {
                    *next = before[slot];
                    if moves[slot] {
                        next.axes = rotated[slot];
                    }
                }
            }
        },
    );
}

/// The matrix that the rotation of a vertex is fitted to. For vertices with four edges, as nearly all of a mesh of quads
/// have, the compiler knows their number.
#[inline(always)]
fn fit(fit_vertices: &[FitVertex], at: &FitVertex, edges: &[Edge], rests: &[RestEdge]) -> Mat3A {
    let mut fit = Mat3A::ZERO;
    for (edge, rest) in edges.iter().zip(rests) {
        let neighbour = &fit_vertices[edge.to as usize];
        let (vector, rest_vector) = (neighbour.position - at.position, rest.vector());
        fit.x_axis += vector * rest_vector.x;
        fit.y_axis += vector * rest_vector.y;
        fit.z_axis += vector * rest_vector.z;
        fit += neighbour.axes * rest.bending();
    }
    fit
}

/// The weighted mean of the edge vectors of a vertex, m.
fn mean_edge(fit_vertices: &[FitVertex], at: &FitVertex, edges: &[Edge]) -> Vec3A {
    let vector = |edge: &Edge| (fit_vertices[edge.to as usize].position - at.position) * edge.weight;
    edges.iter().map(vector).sum()
}

/// Whether the rotations are fitted in an iteration. Not in the last one, where only one step would use them.
pub(crate) fn fits_rotations(iteration: usize, iterations: usize) -> bool {
    iteration == 0 || iteration.is_multiple_of(FIT_INTERVAL) && iteration + 1 < iterations
}
