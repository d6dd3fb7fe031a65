//! As-rigid-as-possible relaxation (ARAP; Sorkine and Alexa 2007): damped Jacobi iterations with
//! heavy-ball momentum (Polyak 1964). Rotations are fitted again in every second iteration. The same
//! solver relaxes length springs (Wilhelms 1997). See mathematics/relaxation.md, Iteration.
//!
//! Every vertex reads only the last iteration and writes its own entry, so the number of threads does
//! not change a bit.

use std::ops::Range;

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::parallel::{RELAXATION_CHUNK, RELAXATION_CHUNKS_PER_TASK};
use crate::skin::relaxation::anchor_springs::AnchorSprings;
use crate::skin::relaxation::edges::EdgeWeights;
use crate::skin::relaxation::rotation_fit::{FitVertex, fit_rotations, fits_rotations};
use crate::skin::settings::elasticity::Energy;

/// Length of a Jacobi step, as a factor of the step that would satisfy a vertex whose neighbours do not
/// move. With momentum, heavy ball is stable while `STEP · 2 + anchor < 2 (1 + MOMENTUM)`
/// (mathematics/relaxation.md, Iteration). Measured: 10 iterations at 1.25 with momentum come as far as
/// 30 at 0.75 without.
const STEP: f32 = 1.25;
/// Fraction of its last step that a vertex repeats (heavy ball), from iteration [`MOMENTUM_ITERATIONS`]
/// on. Before that it rises linearly from 0, because the first steps are long.
const MOMENTUM: f32 = 0.75;
const MOMENTUM_ITERATIONS: f32 = 2.0;

/// The solver's input that does not depend on the pose.
#[derive(Debug)]
pub(crate) struct Arap {
    pub edge_weights: EdgeWeights,
    pub anchor_springs: AnchorSprings,
    pub energy: Energy,
    pub iterations: usize,
}

/// The anchor of a vertex in a pose.
#[derive(Debug, Clone, Copy)]
pub struct Anchor {
    /// Position without the swelling of tissues, m, armature space.
    pub position: Vec3A,
    /// Rotation and uniform scale.
    pub axes: Mat3A,
    /// Uniform scale.
    pub scale: f32,
    /// Displacement by the swelling of tissues, m.
    pub swelling: Vec3A,
}

/// Factors of the two parts of a vertex's step.
#[derive(Debug, Clone, Copy)]
struct StepFactors {
    /// Factor of the residual of the edges.
    edges: f32,
    /// Factor of the vector back to the anchor.
    anchor: f32,
}

impl StepFactors {
    /// The factors for an anchor of this stiffness, in units of the edges' stiffness. Above 1 the
    /// anchor's factor stays 1, so that no vertex overshoots its anchor, and the edges' factor is
    /// divided by the stiffness instead.
    fn new(stiffness: f32) -> Self {
        let largest = stiffness.max(1.0);
        Self {
            edges: STEP / largest,
            anchor: stiffness / largest,
        }
    }
}

/// The state of the solver, one entry per vertex. Positions are stored as displacements from the
/// anchors, which are short enough for f32 and 0 where nothing moves.
#[derive(Debug)]
pub(crate) struct JacobiSolver {
    /// Positions of this frame's anchors, m.
    pub anchors: Vec<Vec3A>,
    /// The same with the swelling of tissues. The solver works without the swelling, because it would
    /// smooth muscles away: a flexed biceps raised the skin by 0.7 mm on average with it, and by 2.1 mm
    /// without. Constraints use the swollen positions.
    pub swollen_anchors: Vec<Vec3A>,
    /// Uniform scale at each vertex.
    scales: Vec<f32>,
    /// Fraction of its anchor stiffness that each vertex loses in this pose.
    pub yielding: Vec<f32>,
    step_factors: Vec<StepFactors>,
    /// Displacement of each vertex from its anchor, m.
    pub displacements: Vec<Vec3A>,
    /// The displacements of the iteration before. The next iteration overwrites them.
    previous: Vec<Vec3A>,
    pub fit_vertices: Vec<FitVertex>,
    pub next_fit_vertices: Vec<FitVertex>,
    /// Weighted mean of the edge vectors of each vertex with every vertex on its anchor, m.
    pub anchored_edges: Vec<Vec3A>,
    /// Residual of each vertex with every vertex on its anchor. It holds until the next fit of the rotations.
    rhs: Vec<Vec3A>,
    /// Whether a vertex is relaxed in this frame. The others stay on their anchors.
    pub moves: Vec<bool>,
    /// Whether any vertex of a chunk is relaxed. Other chunks are skipped.
    pub moving_chunks: Vec<bool>,
}

impl JacobiSolver {
    pub fn new(vertices: usize) -> Self {
        Self {
            anchors: vec![Vec3A::ZERO; vertices],
            swollen_anchors: vec![Vec3A::ZERO; vertices],
            scales: vec![1.0; vertices],
            yielding: vec![0.0; vertices],
            step_factors: vec![StepFactors::new(1.0); vertices],
            displacements: vec![Vec3A::ZERO; vertices],
            previous: vec![Vec3A::ZERO; vertices],
            fit_vertices: vec![FitVertex::NONE; vertices],
            next_fit_vertices: vec![FitVertex::NONE; vertices],
            anchored_edges: vec![Vec3A::ZERO; vertices],
            rhs: vec![Vec3A::ZERO; vertices],
            moves: vec![false; vertices],
            moving_chunks: vec![false; vertices.div_ceil(RELAXATION_CHUNK)],
        }
    }

    /// Sets the positions for the next fit.
    fn update_fit_positions(&mut self) {
        let mut fit_vertices = std::mem::take(&mut self.fit_vertices);
        self.each_moving(&mut fit_vertices, |vertices, fit_vertices| {
            let displacements = self.displacements[vertices.clone()]
                .iter()
                .zip(&self.moves[vertices.clone()]);
            let anchored = fit_vertices.iter_mut().zip(&self.anchors[vertices]);
            for ((fit_vertex, anchor), (displacement, moves)) in anchored.zip(displacements) {
                if *moves {
                    fit_vertex.position = *anchor + *displacement;
                }
            }
        });
        self.fit_vertices = fit_vertices;
    }

    /// The present position of a vertex with the swelling of tissues, m.
    pub fn swollen_position(&self, vertex: usize) -> Vec3A {
        self.swollen_anchors[vertex] + self.displacements[vertex]
    }

    /// Clears the state that an earlier frame left at a vertex.
    pub fn reset(&mut self, vertex: usize) {
        self.yielding[vertex] = 0.0;
        (self.displacements[vertex], self.previous[vertex]) = (Vec3A::ZERO, Vec3A::ZERO);
    }

    /// Sets the step factors of a vertex from its anchor stiffness and its yielding.
    pub fn set_step_factors(&mut self, anchor_springs: &AnchorSprings, vertex: usize) {
        self.step_factors[vertex] =
            StepFactors::new(anchor_springs.stiffness[vertex] * (1.0 - self.yielding[vertex]));
    }

    /// Sets this frame's anchors of the vertices that are `needed`.
    pub fn anchor(&mut self, needed: &[bool], anchor_of: impl Fn(usize) -> Anchor + Sync) {
        let moves = &self.moves;
        let work = (
            self.anchors.par_chunks_mut(RELAXATION_CHUNK),
            self.swollen_anchors.par_chunks_mut(RELAXATION_CHUNK),
            self.scales.par_chunks_mut(RELAXATION_CHUNK),
            self.fit_vertices.par_chunks_mut(RELAXATION_CHUNK),
            self.next_fit_vertices.par_chunks_mut(RELAXATION_CHUNK),
        );
        let work = work
            .into_par_iter()
            .enumerate()
            .with_max_len(RELAXATION_CHUNKS_PER_TASK);
        work.for_each(
            |(chunk, (anchors, swollen, scales, fit_vertices, next_fit_vertices))| {
                let vertices = chunk * RELAXATION_CHUNK..chunk * RELAXATION_CHUNK + anchors.len();
                let (needed, moves) = (&needed[vertices.clone()], &moves[vertices.clone()]);
                for (slot, vertex) in vertices.enumerate() {
                    if !needed[slot] {
                        continue;
                    }
                    let Anchor {
                        position,
                        axes,
                        scale,
                        swelling,
                    } = anchor_of(vertex);
                    (anchors[slot], swollen[slot]) = (position, position + swelling);
                    scales[slot] = scale;
                    fit_vertices[slot] = FitVertex { position, axes };
                    if !moves[slot] {
                        // no iteration writes it, and fits read both buffers in turn
                        next_fit_vertices[slot] = fit_vertices[slot];
                    }
                }
            },
        );
    }

    /// Writes the swollen positions of the vertices that move to `relaxed`.
    pub fn write_swollen(&self, relaxed: &mut [Vec3A]) {
        self.each_moving(relaxed, |vertices, relaxed| {
            let swollen = self.swollen_anchors[vertices.clone()].iter();
            let displacements = self.displacements[vertices.clone()]
                .iter()
                .zip(&self.moves[vertices]);
            for ((relaxed, swollen), (displacement, moves)) in
                relaxed.iter_mut().zip(swollen).zip(displacements)
            {
                if *moves {
                    *relaxed = *swollen + *displacement;
                }
            }
        });
    }

    /// Calls `write` with each chunk of `list` (one entry per vertex) in which a vertex moves, and its
    /// vertices.
    pub fn each_moving<T: Send>(&self, list: &mut [T], write: impl Fn(Range<usize>, &mut [T]) + Sync) {
        let chunks = list
            .par_chunks_mut(RELAXATION_CHUNK)
            .enumerate()
            .with_max_len(RELAXATION_CHUNKS_PER_TASK);
        chunks
            .filter(|(chunk, _)| self.moving_chunks[*chunk])
            .for_each(|(chunk, list)| {
                write(
                    chunk * RELAXATION_CHUNK..chunk * RELAXATION_CHUNK + list.len(),
                    list,
                )
            });
    }

    /// Computes one iteration, without constraints.
    pub fn relax(&mut self, arap: &Arap, iteration: usize) {
        let edge_weights = &arap.edge_weights;
        match arap.energy {
            Energy::AsRigidAsPossible if fits_rotations(iteration, arap.iterations) => {
                if iteration > 0 {
                    self.update_fit_positions();
                }
                fit_rotations(
                    &self.fit_vertices,
                    &mut self.next_fit_vertices,
                    &mut self.anchored_edges,
                    &self.moves,
                    &self.moving_chunks,
                    edge_weights,
                    iteration == 0,
                );
                std::mem::swap(&mut self.fit_vertices, &mut self.next_fit_vertices);
                self.step(arap, iteration, |solver, vertex, _| {
                    solver.arap_residual(edge_weights, vertex)
                });
            }
            Energy::AsRigidAsPossible => self.step(arap, iteration, |_, _, rhs| rhs),
            Energy::Springs => self.step(arap, iteration, |solver, vertex, _| {
                solver.spring_residual(edge_weights, vertex, iteration == 0)
            }),
        }
    }

    /// The ARAP residual of a vertex with every vertex on its anchor.
    #[inline(always)]
    fn arap_residual(&self, edge_weights: &EdgeWeights, vertex: usize) -> Vec3A {
        let half = self.fit_vertices[vertex].axes * edge_weights.rest_rhs(vertex);
        let (edges, rests) = edge_weights.at(vertex);
        let target = edges.iter().zip(rests).fold(half, |target, (edge, rest)| {
            target + self.fit_vertices[edge.to as usize].axes * rest.vector()
        });
        self.anchored_edges[vertex] - target * 0.5
    }

    /// The length-spring residual of a vertex at its present position, less the displacement terms that
    /// [`JacobiSolver::step`] adds. If it `is_first`, all vertices are on their anchors.
    fn spring_residual(&self, edge_weights: &EdgeWeights, vertex: usize, is_first: bool) -> Vec3A {
        let displacement_of = |vertex: usize| {
            if is_first {
                Vec3A::ZERO
            } else {
                self.displacements[vertex]
            }
        };
        let (anchor, displacement) = (self.anchors[vertex], displacement_of(vertex));
        let (edges, rests) = edge_weights.at(vertex);
        let residuals = edges.iter().zip(rests).map(|(edge, rest)| {
            let to = edge.to as usize;
            let anchored = self.anchors[to] - anchor;
            let vector = anchored + (displacement_of(to) - displacement);
            // the rest vector already includes the weight
            let target_m = rest.vector().length() * 0.5 * (self.scales[vertex] + self.scales[to]);
            anchored * edge.weight - vector.normalize_or_zero() * target_m
        });
        residuals.sum()
    }

    /// Moves each vertex one Jacobi step with momentum. `residual_of` gives its residual with every vertex on its
    /// anchor, from the solver, the vertex and the residual of the iteration before.
    fn step(
        &mut self,
        arap: &Arap,
        iteration: usize,
        residual_of: impl Fn(&Self, usize, Vec3A) -> Vec3A + Sync,
    ) {
        let Arap {
            edge_weights,
            anchor_springs,
            ..
        } = arap;
        let momentum = MOMENTUM * (iteration as f32 / MOMENTUM_ITERATIONS).min(1.0);
        let (is_plain, is_whole) = (anchor_springs.is_plain(), anchor_springs.iterations.is_none());
        let (mut next, mut rhs) = (std::mem::take(&mut self.previous), std::mem::take(&mut self.rhs));
        let chunks = next
            .par_chunks_mut(RELAXATION_CHUNK)
            .zip(rhs.par_chunks_mut(RELAXATION_CHUNK))
            .enumerate()
            .with_max_len(RELAXATION_CHUNKS_PER_TASK)
            .filter(|(chunk, _)| self.moving_chunks[*chunk]);
        chunks.for_each(|(chunk, (next, rhs))| {
            let vertices = chunk * RELAXATION_CHUNK..chunk * RELAXATION_CHUNK + next.len();
            let before = &self.displacements[vertices.clone()];
            let (step_factors, moves) = (
                &self.step_factors[vertices.clone()],
                &self.moves[vertices.clone()],
            );
            let rows = edge_weights.rows(vertices.clone());
            for (slot, edges) in rows.enumerate() {
                if !moves[slot] {
                    continue;
                }
                let vertex = vertices.start + slot;
                let (displacement, factors) = (before[slot], step_factors[slot]);
                rhs[slot] = residual_of(self, vertex, rhs[slot]);
                let takes_part = is_whole || anchor_springs.takes_part(vertex, iteration);
                let mut residual = rhs[slot];
                if iteration == 0 {
                    // all displacements are 0; the buffers hold those of an earlier frame
                    next[slot] = if takes_part {
                        residual * factors.edges
                    } else {
                        Vec3A::ZERO
                    };
                    continue;
                }
                if !takes_part {
                    next[slot] = displacement;
                    continue;
                }
                if !edges.is_empty() {
                    for edge in edges {
                        residual += self.displacements[edge.to as usize] * edge.weight;
                    }
                    residual -= displacement;
                }
                let restoring = if is_plain {
                    -displacement
                } else {
                    let axes = &self.fit_vertices[vertex].axes;
                    anchor_springs.restoring(vertex, -displacement, axes, self.scales[vertex])
                };
                let previous = if iteration == 1 { Vec3A::ZERO } else { next[slot] };
                next[slot] = displacement
                    + residual * factors.edges
                    + restoring * factors.anchor
                    + (displacement - previous) * momentum;
            }
        });
        self.previous = std::mem::replace(&mut self.displacements, next);
        self.rhs = rhs;
    }
}
