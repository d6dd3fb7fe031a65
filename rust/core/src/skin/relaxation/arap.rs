//! The rounds of relaxation: Jacobi steps towards edges that keep their rest shape up to a turn for each vertex (or, as
//! springs, their rest length alone), every vertex on its own, so that the result is the same bits on any number of threads.

use std::ops::Range;

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::math::polar::rotate_towards_fit;
use crate::math::vec3x4::LANES;
use crate::parallel::{RELAXATION_CHUNK, RELAXATION_CHUNKS_PER_TASK};
use crate::skin::relaxation::anchor_springs::AnchorSprings;
use crate::skin::relaxation::edges::EdgeWeights;
use crate::skin::settings::elasticity::Energy;

/// Length of a Jacobi step over the one that would satisfy a vertex whose neighbours stand still. With momentum the rounds
/// stay stable far above 1: 10 of these come as far as 30 of length 0.75 did.
const STEP: f32 = 1.25;
/// Share of the last move that a vertex goes on with, once up to speed, and the rounds until it is.
const MOMENTUM: f32 = 0.75;
const MOMENTUM_ROUNDS: f32 = 2.0;
/// Rounds from one fit of the turns to the next: fitted in every one they lead no further (elbow 120°: largest edges of 1.60 for
/// 1.65; knee 140°: bend of 46° for 44°), and a fit costs more than a step.
const TURNS_EVERY: usize = 2;

/// What the relaxation was bound from.
#[derive(Debug)]
pub(crate) struct Arap {
    pub springs: EdgeWeights,
    pub hold: AnchorSprings,
    pub energy: Energy,
    pub rounds: usize,
}

/// Where a vertex hangs in a pose.
#[derive(Debug, Clone, Copy)]
pub struct Anchor {
    /// Its place without the swelling of tissues, m, armature space.
    pub place: Vec3A,
    /// How it is turned and scaled there.
    pub axes: Mat3A,
    /// Uniform scale there.
    pub scale: f32,
    /// What the tissues' swelling adds, m.
    pub swelling: Vec3A,
}

/// A vertex as the fits of its neighbours' turns see it: what is looked up together in one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Frame {
    /// Where it lay when the turns were fitted last, m.
    place: Vec3A,
    /// How it is turned and scaled; at first as its anchor is.
    axes: Mat3A,
}

impl Frame {
    const NONE: Self = Self {
        place: Vec3A::ZERO,
        axes: Mat3A::IDENTITY,
    };
}

/// What a vertex goes in a round.
#[derive(Debug, Clone, Copy)]
struct Shares {
    /// Share of the way that its springs pull it.
    pull: f32,
    /// Share of the way back to its anchor.
    back: f32,
}

impl Shares {
    /// The shares of a vertex that its anchor holds so stiffly against its springs. One that is stiffer than they are goes no
    /// further than all of the way: it takes from what the springs pull.
    fn new(holding: f32) -> Self {
        let most = holding.max(1.0);
        Self {
            pull: STEP / most,
            back: holding / most,
        }
    }
}

/// The state of the rounds, one entry a vertex. Where a vertex has come to is kept as its way from its anchor: short, so that f32 holds
/// it well, and nothing for all that stays there.
#[derive(Debug)]
pub(crate) struct JacobiSolver {
    /// Where this frame's anchors are.
    pub anchors: Vec<Vec3A>,
    /// The same, swollen by the tissues. The rounds relax the skin without it, or they would smooth muscles away: with it a flexed biceps
    /// raised the skin by 0.7 mm in the mean, without by 2.1. What constrains the rounds sees it.
    pub swollen_anchors: Vec<Vec3A>,
    /// How each vertex is turned and scaled on its anchor.
    pub axes: Vec<Mat3A>,
    /// Uniform scale at each vertex.
    scales: Vec<f32>,
    /// Share of its anchoring that each vertex gives up in this pose.
    pub yielding: Vec<f32>,
    /// What of its ways each vertex goes in a round.
    shares: Vec<Shares>,
    /// How far the rounds have brought each vertex from its anchor so far, m.
    pub displacements: Vec<Vec3A>,
    /// The same a round before; the next round's are written over it.
    previous: Vec<Vec3A>,
    frames: Vec<Frame>,
    next_frames: Vec<Frame>,
    /// Mean of the edges of each vertex, each by its spring's share, with everything on its anchor, m.
    anchored_edges: Vec<Vec3A>,
    /// What the springs of each vertex pull it with everything on its anchor; it holds until the turns are fitted anew.
    rhs: Vec<Vec3A>,
    /// Whether a vertex moves in this frame's rounds; the others stay on their anchors.
    pub moves: Vec<bool>,
    /// Whether any vertex of a chunk moves: where none does, threads pass it over.
    pub moving_chunks: Vec<bool>,
}

impl JacobiSolver {
    pub fn new(vertices: usize) -> Self {
        Self {
            anchors: vec![Vec3A::ZERO; vertices],
            swollen_anchors: vec![Vec3A::ZERO; vertices],
            axes: vec![Mat3A::IDENTITY; vertices],
            scales: vec![1.0; vertices],
            yielding: vec![0.0; vertices],
            shares: vec![Shares::new(1.0); vertices],
            displacements: vec![Vec3A::ZERO; vertices],
            previous: vec![Vec3A::ZERO; vertices],
            frames: vec![Frame::NONE; vertices],
            next_frames: vec![Frame::NONE; vertices],
            anchored_edges: vec![Vec3A::ZERO; vertices],
            rhs: vec![Vec3A::ZERO; vertices],
            moves: vec![false; vertices],
            moving_chunks: vec![false; vertices.div_ceil(RELAXATION_CHUNK)],
        }
    }

    /// Where a vertex has come to so far, swollen, m.
    pub fn swollen_place(&self, vertex: usize) -> Vec3A {
        self.swollen_anchors[vertex] + self.displacements[vertex]
    }

    /// Forgets what the rounds of an earlier frame did to a vertex.
    pub fn reset(&mut self, vertex: usize) {
        self.yielding[vertex] = 0.0;
        (self.displacements[vertex], self.previous[vertex]) = (Vec3A::ZERO, Vec3A::ZERO);
    }

    /// Has a vertex that moves be held as `hold` says, less what it yields.
    pub fn share(&mut self, hold: &AnchorSprings, vertex: usize) {
        self.shares[vertex] = Shares::new(hold.anchoring[vertex] * (1.0 - self.yielding[vertex]));
    }

    /// Takes on the frame's anchors where `needed`.
    pub fn anchor(&mut self, needed: &[bool], anchor_of: impl Fn(usize) -> Anchor + Sync) {
        let moves = &self.moves;
        let work = (
            self.anchors.par_chunks_mut(RELAXATION_CHUNK),
            self.swollen_anchors.par_chunks_mut(RELAXATION_CHUNK),
            self.scales.par_chunks_mut(RELAXATION_CHUNK),
            self.axes.par_chunks_mut(RELAXATION_CHUNK),
            self.frames.par_chunks_mut(RELAXATION_CHUNK),
            self.next_frames.par_chunks_mut(RELAXATION_CHUNK),
        );
        let work = work
            .into_par_iter()
            .enumerate()
            .with_max_len(RELAXATION_CHUNKS_PER_TASK);
        work.for_each(
            |(chunk, (anchors, swollen, scales, own_axes, frames, next_frames))| {
                let vertices = chunk * RELAXATION_CHUNK..chunk * RELAXATION_CHUNK + anchors.len();
                let (needed, moves) = (&needed[vertices.clone()], &moves[vertices.clone()]);
                for (slot, vertex) in vertices.enumerate() {
                    if !needed[slot] {
                        continue;
                    }
                    let Anchor {
                        place,
                        axes,
                        scale,
                        swelling,
                    } = anchor_of(vertex);
                    (anchors[slot], swollen[slot]) = (place, place + swelling);
                    scales[slot] = scale;
                    own_axes[slot] = axes;
                    frames[slot] = Frame { place, axes };
                    if !moves[slot] {
                        next_frames[slot] = frames[slot]; // no round writes it, and each buffer comes to be read
                    }
                }
            },
        );
    }

    /// Writes where the skin that moves has come to lie, swollen, to `relaxed`.
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

    /// Has `write` fill the entries of `list`, one a vertex, for ranges of vertices of which some move.
    fn each_moving<T: Send>(&self, list: &mut [T], write: impl Fn(Range<usize>, &mut [T]) + Sync) {
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

    /// One of the rounds, before what constrains it.
    pub fn relax(&mut self, arap: &Arap, round: usize) {
        let springs = &arap.springs;
        match arap.energy {
            Energy::AsRigidAsPossible if fits_turns(round, arap.rounds) => {
                if round > 0 {
                    self.place();
                }
                self.turn(springs, round == 0);
                self.find_pulls(|rounds, vertex| rounds.turned_pull(springs, vertex));
            }
            Energy::AsRigidAsPossible => {}
            Energy::Springs => {
                self.find_pulls(|rounds, vertex| rounds.sprung_pull(springs, vertex, round == 0))
            }
        }
        self.step(springs, &arap.hold, round);
    }

    /// Notes where the vertices have come to.
    fn place(&mut self) {
        let mut frames = std::mem::take(&mut self.frames);
        self.each_moving(&mut frames, |vertices, frames| {
            let displacements = self.displacements[vertices.clone()]
                .iter()
                .zip(&self.moves[vertices.clone()]);
            let own = frames.iter_mut().zip(&self.anchors[vertices]);
            for ((frame, anchor), (displacement, moves)) in own.zip(displacements) {
                if *moves {
                    frame.place = *anchor + *displacement;
                }
            }
        });
        self.frames = frames;
    }

    /// Turns every vertex's frame to fit its edges and its neighbours' turns best; where it `is_first`, all lies on its anchors.
    fn turn(&mut self, springs: &EdgeWeights, is_first: bool) {
        let Self {
            frames,
            next_frames,
            anchored_edges,
            moves,
            moving_chunks,
            ..
        } = self;
        let work = next_frames
            .par_chunks_mut(RELAXATION_CHUNK)
            .zip(anchored_edges.par_chunks_mut(RELAXATION_CHUNK))
            .enumerate()
            .with_max_len(RELAXATION_CHUNKS_PER_TASK);
        work.filter(|(chunk, _)| moving_chunks[*chunk])
            .for_each(|(chunk, (next_frames, anchored_edges))| {
                let first = chunk * RELAXATION_CHUNK;
                let vertices = first..first + next_frames.len();
                let before = frames[vertices.clone()].iter().zip(&moves[vertices.clone()]);
                let own = next_frames.iter_mut().zip(anchored_edges.iter_mut());
                for ((vertex, (next, mean)), (frame, moves)) in vertices.zip(own).zip(before) {
                    *next = *frame;
                    if !moves {
                        continue;
                    }
                    let (mut fit, mut edges) = (Mat3A::ZERO, Vec3A::ZERO);
                    for (link, rest) in springs.at(vertex) {
                        let other = &frames[link.to as usize];
                        let edge = other.place - frame.place;
                        edges += edge * link.share;
                        let at_rest = rest.edge();
                        fit.x_axis += edge * at_rest.x;
                        fit.y_axis += edge * at_rest.y;
                        fit.z_axis += edge * at_rest.z;
                        fit += other.axes * rest.bending();
                    }
                    next.axes = fit;
                    if is_first {
                        *mean = edges;
                    }
                }
                for (first, fits) in (first..).step_by(LANES).zip(next_frames.chunks_mut(LANES)) {
                    let group = first..first + fits.len();
                    if moves[group.clone()].contains(&true) {
                        turn_all(&frames[group], fits);
                    }
                }
            });
        std::mem::swap(&mut self.frames, &mut self.next_frames);
    }

    /// Finds what the springs of each vertex pull it with everything on its anchor: as `pull_of` says.
    fn find_pulls(&mut self, pull_of: impl Fn(&Self, usize) -> Vec3A + Sync) {
        let mut pulls = std::mem::take(&mut self.rhs);
        self.each_moving(&mut pulls, |vertices, pulls| {
            let own = vertices.clone().zip(pulls).zip(&self.moves[vertices]);
            for ((vertex, pull), _) in own.filter(|(_, moves)| **moves) {
                *pull = pull_of(self, vertex);
            }
        });
        self.rhs = pulls;
    }

    /// What the springs of a vertex pull it on its anchor by the turns of their ends.
    fn turned_pull(&self, springs: &EdgeWeights, vertex: usize) -> Vec3A {
        let half = self.frames[vertex].axes * springs.rest_rhs(vertex);
        let wanted = springs.at(vertex).fold(half, |wanted, (link, rest)| {
            wanted + self.frames[link.to as usize].axes * rest.edge()
        });
        self.anchored_edges[vertex] - wanted * 0.5
    }

    /// What the springs of a vertex would pull it there, where they as springs pull it where it is now, less what its way and its
    /// neighbours' add; where it `is_first`, all lies on its anchors.
    fn sprung_pull(&self, springs: &EdgeWeights, vertex: usize, is_first: bool) -> Vec3A {
        let displacement_of = |vertex: usize| {
            if is_first {
                Vec3A::ZERO
            } else {
                self.displacements[vertex]
            }
        };
        let (anchor, displacement) = (self.anchors[vertex], displacement_of(vertex));
        let pulls = springs.at(vertex).map(|(link, rest)| {
            let to = link.to as usize;
            let anchored = self.anchors[to] - anchor;
            let edge = anchored + (displacement_of(to) - displacement);
            // times the share, as the rest edge is
            let wanted_m = rest.edge().length() * 0.5 * (self.scales[vertex] + self.scales[to]);
            anchored * link.share - edge.normalize_or_zero() * wanted_m
        });
        pulls.sum()
    }

    /// Each vertex goes a step.
    fn step(&mut self, springs: &EdgeWeights, hold: &AnchorSprings, round: usize) {
        let momentum = MOMENTUM * (round as f32 / MOMENTUM_ROUNDS).min(1.0);
        let (is_plain, is_whole, displacements) =
            (hold.is_plain(), hold.rounds.is_none(), &self.displacements);
        let mut next = std::mem::take(&mut self.previous);
        self.each_moving(&mut next, |vertices, next| {
            let (own, pulls) = (&displacements[vertices.clone()], &self.rhs[vertices.clone()]);
            let (shares, moves) = (&self.shares[vertices.clone()], &self.moves[vertices.clone()]);
            let rows = springs.rows(vertices.clone());
            for (slot, links) in rows.enumerate() {
                if !moves[slot] {
                    continue;
                }
                let (displacement, share) = (own[slot], shares[slot]);
                let takes_part = is_whole || hold.takes_part(vertices.start + slot, round);
                let mut pull = pulls[slot];
                if round == 0 {
                    // nothing has left its anchor yet; what the buffers hold is of the frame before
                    next[slot] = if takes_part {
                        pull * share.pull
                    } else {
                        Vec3A::ZERO
                    };
                    continue;
                }
                if !takes_part {
                    next[slot] = displacement;
                    continue;
                }
                if !links.is_empty() {
                    for link in links {
                        pull += displacements[link.to as usize] * link.share;
                    }
                    pull -= displacement;
                }
                let back = if is_plain {
                    -displacement
                } else {
                    let vertex = vertices.start + slot;
                    hold.restoring(
                        vertex,
                        -displacement,
                        &self.frames[vertex].axes,
                        self.scales[vertex],
                    )
                };
                let before = if round == 1 { Vec3A::ZERO } else { next[slot] };
                next[slot] =
                    displacement + pull * share.pull + back * share.back + (displacement - before) * momentum;
            }
        });
        self.previous = std::mem::replace(&mut self.displacements, next);
    }
}

/// Turns up to [`LANES`] frames a step towards their fits, which stand in `fits`, and writes them there.
fn turn_all(frames: &[Frame], fits: &mut [Frame]) {
    let axes = |frames: &[Frame]| {
        let last = frames.len() - 1;
        std::array::from_fn(|lane| frames[lane.min(last)].axes)
    };
    let turned = rotate_towards_fit(axes(frames), axes(fits));
    for (fit, axes) in fits.iter_mut().zip(turned) {
        fit.axes = axes;
    }
}

/// Whether the turns are fitted anew in a round of `rounds`; in the last one they would serve a single step.
fn fits_turns(round: usize, rounds: usize) -> bool {
    round == 0 || round.is_multiple_of(TURNS_EVERY) && round + 1 < rounds
}
