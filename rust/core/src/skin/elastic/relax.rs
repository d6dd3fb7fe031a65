//! The rounds of relaxation: Jacobi steps towards edges that keep their rest shape up to a turn for each vertex (or, as
//! springs, their rest length alone), every vertex on its own, so that the result is the same bits on any number of threads.

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use super::super::elasticity::{ElasticSettings, Energy};
use super::springs::Springs;
use super::turn::{LANES, turn_to};

/// Length of a Jacobi step over the one that would satisfy a vertex whose neighbours stand still. With momentum the rounds
/// stay stable far above 1: 10 of these come as far as 30 of length 0.75 did.
const STEP: f32 = 1.25;
/// Share of the last move that a vertex goes on with, once up to speed, and the rounds until it is.
const MOMENTUM: f32 = 0.75;
const MOMENTUM_ROUNDS: f32 = 2.0;
/// Rounds from one fit of the turns to the next: fitted in every one they lead no further (elbow 120°: largest edges of 1.60 for
/// 1.65; knee 140°: bend of 46° for 44°), and a fit costs more than a step.
const TURNS_EVERY: usize = 2;
/// Vertices that one thread takes at a time.
pub(super) const CHUNK: usize = 256;

/// How each vertex takes part.
#[derive(Debug)]
pub(super) struct Hold {
    /// How stiff its anchor is against its edges: the share of the way back that a vertex goes in a round, and above 1 that of
    /// the way back in all of its way.
    pub anchoring: Vec<f32>,
    /// How far from its anchor it may lie before it is pulled, m; `None` where nowhere.
    pub rest_distance_m: Option<Vec<f32>>,
    /// How freely it slides along the skin's own plane, 0..1; `None` where nowhere.
    pub sliding: Option<Vec<f32>>,
    /// Rounds it takes part in; `None` where all do in all.
    pub rounds: Option<Vec<f32>>,
    /// Unit normals at rest; used where something slides.
    pub normals: Vec<Vec3A>,
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

/// The state of the rounds, one entry a vertex.
#[derive(Debug)]
pub(super) struct Rounds {
    /// Where this frame's anchors are.
    pub anchors: Vec<Vec3A>,
    /// Uniform scale at each vertex.
    pub scales: Vec<f32>,
    /// Share of its anchoring that each vertex gives up in this pose.
    pub yielding: Vec<f32>,
    /// What of its ways each vertex goes in a round.
    shares: Vec<Shares>,
    /// How the tissues swell the skin at each vertex, m. The rounds relax the skin without it, or they would smooth muscles away:
    /// with it a flexed biceps raised the skin by 0.7 mm in the mean, without by 2.1. What constrains the rounds sees it.
    pub swelling: Vec<Vec3A>,
    /// Where the rounds have brought each vertex so far.
    pub skin: Vec<Vec3A>,
    before: Vec<Vec3A>,
    next: Vec<Vec3A>,
    /// How each vertex is turned and scaled; at first as its anchor is.
    axes: Vec<Mat3A>,
    next_axes: Vec<Mat3A>,
    /// What the edges of each vertex want, by the turns of their ends; it holds until these are fitted anew.
    wanted: Vec<Vec3A>,
    /// Whether a vertex moves in this frame's rounds; the others stay on their anchors.
    pub moves: Vec<bool>,
    /// Whether any vertex of a chunk moves, and whether any has an anchor to be found: where not, threads pass it over.
    pub moving_chunks: Vec<bool>,
}

impl Rounds {
    pub fn new(vertices: usize) -> Self {
        Self {
            anchors: vec![Vec3A::ZERO; vertices],
            scales: vec![1.0; vertices],
            yielding: vec![0.0; vertices],
            shares: vec![Shares::new(1.0); vertices],
            swelling: vec![Vec3A::ZERO; vertices],
            skin: vec![Vec3A::ZERO; vertices],
            before: vec![Vec3A::ZERO; vertices],
            next: vec![Vec3A::ZERO; vertices],
            axes: vec![Mat3A::IDENTITY; vertices],
            next_axes: vec![Mat3A::IDENTITY; vertices],
            wanted: vec![Vec3A::ZERO; vertices],
            moves: vec![false; vertices],
            moving_chunks: vec![false; vertices.div_ceil(CHUNK)],
        }
    }

    /// Takes on the frame's anchors where `needed`, each held as `hold` says.
    pub fn anchor(&mut self, hold: &Hold, needed: &[bool], anchor_of: impl Fn(usize) -> Anchor + Sync) {
        let places = (
            self.anchors.par_chunks_mut(CHUNK),
            self.skin.par_chunks_mut(CHUNK),
            self.before.par_chunks_mut(CHUNK),
            self.next.par_chunks_mut(CHUNK),
        );
        let frames = (
            self.scales.par_chunks_mut(CHUNK),
            self.axes.par_chunks_mut(CHUNK),
            self.next_axes.par_chunks_mut(CHUNK),
            self.swelling.par_chunks_mut(CHUNK),
            self.shares.par_chunks_mut(CHUNK),
        );
        let (moves, yielding) = (&self.moves, &self.yielding);
        let work = (places, frames).into_par_iter();
        work.enumerate().for_each(|(chunk, (places, frames))| {
            let (anchors, skin, before, next) = places;
            let (scales, axes, next_axes, swelling, shares) = frames;
            for slot in 0..anchors.len() {
                let vertex = chunk * CHUNK + slot;
                if !needed[vertex] {
                    continue;
                }
                let anchor = anchor_of(vertex);
                let place = anchor.place;
                swelling[slot] = anchor.swelling;
                scales[slot] = anchor.scale;
                axes[slot] = anchor.axes;
                (anchors[slot], skin[slot]) = (place, place);
                shares[slot] = Shares::new(hold.anchoring[vertex] * (1.0 - yielding[vertex]));
                if !moves[vertex] {
                    // no round writes these, and each buffer comes to be read
                    (before[slot], next[slot], next_axes[slot]) = (place, place, anchor.axes);
                }
            }
        });
    }

    /// Adds the swelling to the skin that moves, `share` 1, or takes it away again, -1.
    pub fn swell(&mut self, share: f32) {
        let (swelling, moves, moving_chunks) = (&self.swelling, &self.moves, &self.moving_chunks);
        let skin = self.skin.par_chunks_mut(CHUNK).enumerate();
        skin.filter(|(chunk, _)| moving_chunks[*chunk])
            .for_each(|(chunk, skin)| {
                for (vertex, skin) in (chunk * CHUNK..).zip(skin) {
                    if moves[vertex] {
                        *skin += swelling[vertex] * share;
                    }
                }
            });
    }

    /// Writes where the skin that moves has come to lie, swollen, to `relaxed`.
    pub fn write_swollen(&self, relaxed: &mut [Vec3A]) {
        let chunks = relaxed.par_chunks_mut(CHUNK).enumerate();
        chunks
            .filter(|(chunk, _)| self.moving_chunks[*chunk])
            .for_each(|(chunk, relaxed)| {
                for (vertex, relaxed) in (chunk * CHUNK..).zip(relaxed) {
                    if self.moves[vertex] {
                        *relaxed = self.skin[vertex] + self.swelling[vertex];
                    }
                }
            });
    }

    /// Round `round` of `rounds`, before what constrains it.
    pub fn relax(&mut self, energy: Energy, springs: &Springs, hold: &Hold, round: usize, rounds: usize) {
        let is_turned = fits_turns(round, rounds);
        if energy == Energy::AsRigidAsPossible && is_turned {
            self.turn(springs);
        }
        self.step(energy, springs, hold, round, is_turned);
        std::mem::swap(&mut self.before, &mut self.skin);
        std::mem::swap(&mut self.skin, &mut self.next);
    }

    /// Turns every vertex's frame to fit its edges and its neighbours' turns best.
    fn turn(&mut self, springs: &Springs) {
        let Self {
            skin,
            axes,
            next_axes,
            moves,
            moving_chunks,
            ..
        } = self;
        let work = next_axes.par_chunks_mut(CHUNK).enumerate();
        work.filter(|(chunk, _)| moving_chunks[*chunk])
            .for_each(|(chunk, next_axes)| {
                for (vertex, next) in (chunk * CHUNK..).zip(next_axes.iter_mut()) {
                    if !moves[vertex] {
                        *next = axes[vertex]; // no turn
                        continue;
                    }
                    let mut fit = Mat3A::ZERO;
                    for (link, rest) in springs.at(vertex) {
                        let to = link.to as usize;
                        let edge = skin[to] - skin[vertex];
                        fit.x_axis += edge * rest.edge.x;
                        fit.y_axis += edge * rest.edge.y;
                        fit.z_axis += edge * rest.edge.z;
                        fit += axes[to] * rest.bending;
                    }
                    *next = fit;
                }
                for (first, fits) in (chunk * CHUNK..).step_by(LANES).zip(next_axes.chunks_mut(LANES)) {
                    let group = first..first + fits.len();
                    if moves[group.clone()].contains(&true) {
                        turn_to(&axes[group], fits);
                    }
                }
            });
        std::mem::swap(&mut self.axes, &mut self.next_axes);
    }

    fn step(&mut self, energy: Energy, springs: &Springs, hold: &Hold, round: usize, is_turned: bool) {
        let momentum = MOMENTUM * (round as f32 / MOMENTUM_ROUNDS).min(1.0);
        let Self {
            skin,
            before,
            axes,
            anchors,
            moves,
            scales,
            shares,
            moving_chunks,
            next,
            wanted,
            ..
        } = self;
        let work = (next.par_chunks_mut(CHUNK), wanted.par_chunks_mut(CHUNK));
        let work = work.into_par_iter().enumerate();
        work.filter(|(chunk, _)| moving_chunks[*chunk])
            .for_each(|(chunk, (next, wanted))| {
                for (vertex, (next, wanted)) in (chunk * CHUNK..).zip(next.iter_mut().zip(wanted)) {
                    if !moves[vertex] {
                        continue;
                    }
                    let own = skin[vertex];
                    if hold
                        .rounds
                        .as_ref()
                        .is_some_and(|rounds| rounds[vertex] <= round as f32)
                    {
                        *next = own;
                        continue;
                    }
                    let mut pull = Vec3A::ZERO;
                    match energy {
                        Energy::AsRigidAsPossible => {
                            if is_turned {
                                let half = axes[vertex] * springs.rest_pull(vertex);
                                let halves = springs.at(vertex);
                                *wanted = halves.fold(half, |sum, (link, rest)| {
                                    sum + axes[link.to as usize] * Vec3A::from(rest.edge)
                                }) * 0.5;
                            }
                            for link in springs.links(vertex) {
                                pull += (skin[link.to as usize] - own) * link.share;
                            }
                            pull -= *wanted;
                        }
                        Energy::Springs => {
                            for (link, rest) in springs.at(vertex) {
                                let to = link.to as usize;
                                let edge = skin[to] - own;
                                // times the share, as the rest edge is
                                let wanted_m = rest.edge.length() * 0.5 * (scales[vertex] + scales[to]);
                                pull += edge * link.share - edge.normalize_or_zero() * wanted_m;
                            }
                        }
                    }
                    let back = hold.way_back(vertex, anchors[vertex] - own, &axes[vertex], scales[vertex]);
                    let on = if round == 0 {
                        Vec3A::ZERO // nothing went before
                    } else {
                        (own - before[vertex]) * momentum
                    };
                    let share = shares[vertex];
                    *next = own + pull * share.pull + back * share.back + on;
                }
            });
    }
}

impl Hold {
    /// How vertices take part in `rounds` rounds with `settings`; `anchoring` is the share of the way back that a vertex with
    /// factors 1 goes in one.
    pub fn new(settings: &ElasticSettings, anchoring: f32, rounds: usize, normals: Vec<Vec3A>) -> Self {
        // what counts is how stiff the anchor is against the edges; without edges there is the anchor alone
        let share = |(anchor, edges): (&f32, &f32)| {
            if *edges > 0.0 {
                (anchoring * anchor / edges).min(f32::MAX)
            } else {
                1.0
            }
        };
        let any = |list: &[f32]| list.iter().any(|&value| value > 0.0).then(|| list.to_vec());
        let is_whole = settings.relaxation.iter().all(|&share| share == 1.0);
        let rounds_of = |share: &f32| share * rounds as f32;
        Self {
            anchoring: settings
                .anchor_stiffness
                .iter()
                .zip(&settings.edge_stiffness)
                .map(share)
                .collect(),
            rest_distance_m: any(&settings.rest_distance_m),
            sliding: any(&settings.fat_sliding),
            rounds: (!is_whole).then(|| settings.relaxation.iter().map(rounds_of).collect()),
            normals,
        }
    }

    /// What of the way back to its anchor pulls at a vertex.
    fn way_back(&self, vertex: usize, way: Vec3A, axes: &Mat3A, scale: f32) -> Vec3A {
        let mut way = way;
        if let Some(free) = &self.rest_distance_m {
            let (length_m, free_m) = (way.length(), free[vertex] * scale);
            way *= if length_m > free_m {
                (length_m - free_m) / length_m
            } else {
                0.0
            };
        }
        if let Some(sliding) = &self.sliding {
            let normal = (*axes * self.normals[vertex]).normalize_or_zero();
            let along = way - normal * way.dot(normal);
            way -= along * sliding[vertex];
        }
        way
    }
}

/// Whether the turns are fitted anew in a round of `rounds`; in the last one they would serve a single step.
fn fits_turns(round: usize, rounds: usize) -> bool {
    round == 0 || round.is_multiple_of(TURNS_EVERY) && round + 1 < rounds
}
