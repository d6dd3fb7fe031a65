//! The relaxation of one frame: Jacobi steps towards edges that keep their rest shape up to a turn for each vertex, every
//! vertex on its own, so that the result is the same bits on any number of threads.

use glam::{DVec3, Mat3A, Quat, Vec3, Vec3A};
use rayon::prelude::*;

use super::super::mesh::Adjacency;
use super::crease::PosedPlane;
use super::{Elastic, ElasticJoint};
use crate::pose::Palette;

/// Over-relaxation of a Jacobi step.
const STEP: f32 = 1.5;
/// Share of the last move that a vertex goes on with, once up to speed, and the iterations until it is.
const MOMENTUM: f32 = 0.5;
const MOMENTUM_ITERATIONS: f32 = 4.0;
/// Turn of the child bone against its parent at which the relaxation shows fully, radians; 0 at rest.
const SHOWS_AT: f64 = 0.14;
/// Rest length below which an edge's weight grows no more, as a share of the median.
const SHORTEST_OF_MEDIAN: f64 = 0.02;
/// Vertices that one thread takes at a time.
const CHUNK: usize = 256;

/// One end of an edge.
#[derive(Debug, Clone, Copy)]
struct Spring {
    to: u32,
    weight: f32,
    /// From the vertex to the other end at rest.
    rest: Vec3,
}

/// All edges of the patches.
#[derive(Debug)]
pub(super) struct Springs {
    offsets: Vec<u32>,
    springs: Vec<Spring>,
    /// One over the sum of a vertex's spring weights.
    inverse_weight: Vec<f32>,
    anchoring: Vec<f32>,
    is_border: Vec<bool>,
}

impl Springs {
    pub fn new(
        points: &[DVec3],
        struts: &Adjacency,
        vertices: &[u32],
        places: &[u32],
        anchoring: Vec<f32>,
    ) -> Self {
        let mut lengths: Vec<f64> = vertices
            .iter()
            .flat_map(|&from| struts.neighbours(from as usize).iter().map(move |&to| (from, to)))
            .map(|(from, to)| points[from as usize].distance(points[to as usize]))
            .collect();
        lengths.sort_unstable_by(f64::total_cmp);
        let median = lengths
            .get(lengths.len() / 2)
            .copied()
            .unwrap_or(1.0)
            .max(f64::MIN_POSITIVE);
        let (mut offsets, mut springs, mut inverse_weight, mut is_border) = (vec![0], vec![], vec![], vec![]);
        for &from in vertices {
            let neighbours = struts.neighbours(from as usize);
            let first = springs.len();
            for &to in neighbours.iter().filter(|&&to| places[to as usize] != u32::MAX) {
                let rest = points[to as usize] - points[from as usize];
                let relative = (rest.length() / median).max(SHORTEST_OF_MEDIAN);
                springs.push(Spring {
                    to: places[to as usize],
                    weight: (1.0 / (relative * relative)) as f32,
                    rest: rest.as_vec3(),
                });
            }
            let total: f32 = springs[first..].iter().map(|spring| spring.weight).sum();
            inverse_weight.push(if total > 0.0 { 1.0 / total } else { 0.0 });
            is_border.push(springs.len() - first < neighbours.len());
            offsets.push(springs.len() as u32);
        }
        Self {
            offsets,
            springs,
            inverse_weight,
            anchoring,
            is_border,
        }
    }

    fn of(&self, place: usize) -> &[Spring] {
        &self.springs[self.offsets[place] as usize..self.offsets[place + 1] as usize]
    }
}

/// The buffers of a frame, by places in the patches.
#[derive(Debug)]
pub struct Relaxation {
    /// Where this frame's anchors are.
    pub anchors: Vec<Vec3A>,
    /// How each vertex's anchor is turned; the relaxation's first guess.
    pub turns: Vec<Quat>,
    /// Uniform scale at each vertex.
    pub scales: Vec<f32>,
    /// How fully the relaxed skin shows, 0..1; 0 where nothing moves.
    pub shown: Vec<f32>,
    /// The relaxed skin.
    pub skin: Vec<Vec3A>,
    before: Vec<Vec3A>,
    next: Vec<Vec3A>,
    axes: Vec<Mat3A>,
    /// Whether a vertex moves this frame; the others stay on their anchors.
    moves: Vec<bool>,
    activity: Vec<f32>,
    planes: Vec<Option<PosedPlane>>,
    gradient: Vec<Vec3A>,
}

impl Relaxation {
    pub fn new(elastic: &Elastic) -> Self {
        let count = elastic.vertices.len();
        let largest = elastic
            .joints
            .iter()
            .filter_map(|joint| Some(joint.region.as_ref()?.len()))
            .max();
        Self {
            anchors: vec![Vec3A::ZERO; count],
            turns: vec![Quat::IDENTITY; count],
            scales: vec![1.0; count],
            shown: vec![0.0; count],
            skin: vec![Vec3A::ZERO; count],
            before: vec![Vec3A::ZERO; count],
            next: vec![Vec3A::ZERO; count],
            axes: vec![Mat3A::IDENTITY; count],
            moves: vec![false; count],
            activity: vec![0.0; elastic.joints.len()],
            planes: vec![None; elastic.joints.len()],
            gradient: vec![Vec3A::ZERO; largest.unwrap_or(0)],
        }
    }

    /// Finds the joints that stand otherwise than at rest; false where there are none, and nothing is to do.
    pub fn wake(&mut self, elastic: &Elastic, palette: &Palette) -> bool {
        self.shown.fill(0.0);
        self.moves.fill(false);
        let mut any = false;
        for (index, joint) in elastic.joints.iter().enumerate() {
            let activity = joint.activity(palette);
            self.activity[index] = activity;
            self.planes[index] = None;
            if activity == 0.0 {
                continue;
            }
            any = true;
            self.planes[index] = joint
                .crease
                .as_ref()
                .map(|crease| crease.posed(&joint.joint, palette));
            for &(place, shown) in &joint.shown {
                let place = place as usize;
                self.shown[place] = self.shown[place].max(shown * activity);
                self.moves[place] |= !elastic.springs.is_border[place];
            }
        }
        any
    }

    /// Takes on the frame's anchors: `anchor_of` gives, for a place in the patches, the anchor and the linear part of the map
    /// that brought it there.
    pub fn anchor(&mut self, anchor_of: impl Fn(usize) -> (Vec3A, Mat3A) + Sync) {
        let turns = self
            .turns
            .par_chunks_mut(CHUNK)
            .zip(self.scales.par_chunks_mut(CHUNK));
        let work = self.anchors.par_chunks_mut(CHUNK).zip(turns);
        work.enumerate().for_each(|(chunk, (anchors, (turns, scales)))| {
            for (slot, anchor) in anchors.iter_mut().enumerate() {
                let (place, linear) = anchor_of(chunk * CHUNK + slot);
                let scale = linear.determinant().abs().cbrt().max(f32::MIN_POSITIVE);
                *anchor = place;
                scales[slot] = scale;
                turns[slot] = turn_of(linear);
            }
        });
    }

    /// Relaxes from the anchors.
    pub fn run(&mut self, elastic: &Elastic, palette: &Palette) {
        self.skin.copy_from_slice(&self.anchors);
        self.before.copy_from_slice(&self.anchors);
        for iteration in 0..elastic.iterations {
            self.turn(&elastic.springs, iteration == 0);
            let momentum = MOMENTUM * (iteration as f32 / MOMENTUM_ITERATIONS).min(1.0);
            self.step(&elastic.springs, momentum);
            std::mem::swap(&mut self.before, &mut self.skin);
            std::mem::swap(&mut self.skin, &mut self.next);
            self.constrain(elastic, palette);
        }
    }

    /// Turns every vertex's frame to fit its edges best: one step of M. Müller et al., "A Robust Method to Extract the
    /// Rotational Part of Deformations", 2016, from the turn before.
    fn turn(&mut self, springs: &Springs, is_first: bool) {
        let (skin, moves, scales) = (&self.skin, &self.moves, &self.scales);
        let work = self
            .turns
            .par_chunks_mut(CHUNK)
            .zip(self.axes.par_chunks_mut(CHUNK));
        work.enumerate().for_each(|(chunk, (turns, axes))| {
            for (place, (turn, axes)) in (chunk * CHUNK..).zip(turns.iter_mut().zip(axes)) {
                if moves[place] {
                    let mut fit = Mat3A::ZERO;
                    for spring in springs.of(place) {
                        let edge = (skin[spring.to as usize] - skin[place]) * spring.weight;
                        fit.x_axis += edge * spring.rest.x;
                        fit.y_axis += edge * spring.rest.y;
                        fit.z_axis += edge * spring.rest.z;
                    }
                    *turn = turned_to(*turn, &fit);
                } else if !is_first {
                    continue; // what does not move keeps its anchor's turn
                }
                *axes = Mat3A::from_quat(*turn) * scales[place];
            }
        });
    }

    fn step(&mut self, springs: &Springs, momentum: f32) {
        let Self {
            skin,
            before,
            next,
            axes,
            anchors,
            moves,
            ..
        } = self;
        next.par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(chunk, places)| {
                for (place, next) in (chunk * CHUNK..).zip(places) {
                    let own = skin[place];
                    if !moves[place] {
                        *next = anchors[place];
                        continue;
                    }
                    let mut pull = Vec3A::ZERO;
                    for spring in springs.of(place) {
                        let to = spring.to as usize;
                        let wanted = (axes[place] + axes[to]) * Vec3A::from(spring.rest) * 0.5;
                        pull += (skin[to] - own - wanted) * spring.weight;
                    }
                    *next = own
                        + pull * (0.5 * STEP * springs.inverse_weight[place])
                        + (anchors[place] - own) * springs.anchoring[place]
                        + (own - before[place]) * momentum;
                }
            });
    }

    fn constrain(&mut self, elastic: &Elastic, palette: &Palette) {
        for (joint, activity) in elastic.joints.iter().zip(&self.activity) {
            if let (Some(region), true) = (&joint.region, *activity > 0.0) {
                let scales = palette.scales();
                let scale = (scales[joint.joint.child] * scales[joint.joint.parent]).sqrt();
                region.keep_volume(&mut self.skin, scale, &mut self.gradient);
            }
        }
        for (joint, plane) in elastic.joints.iter().zip(&self.planes) {
            if let (Some(crease), Some(plane)) = (&joint.crease, plane) {
                crease.hold(plane, &mut self.skin);
            }
        }
        for (place, skin) in self.skin.iter_mut().enumerate() {
            if !self.moves[place] {
                *skin = self.anchors[place];
            }
        }
    }
}

impl ElasticJoint {
    /// How far the joint is turned from rest, 0..1; 1 from a few degrees on.
    fn activity(&self, palette: &Palette) -> f32 {
        let (child, parent) = (
            &palette.carries()[self.joint.child],
            &palette.carries()[self.joint.parent],
        );
        let (own, above) = (
            glam::DQuat::from_mat3(&unscaled(child)),
            glam::DQuat::from_mat3(&unscaled(parent)),
        );
        let turn = own.angle_between(above);
        let t = (turn / SHOWS_AT).min(1.0);
        let shown = t * t * (3.0 - 2.0 * t);
        if shown < 1e-6 { 0.0 } else { shown as f32 }
    }
}

fn unscaled(map: &glam::DAffine3) -> glam::DMat3 {
    let linear = map.matrix3;
    glam::DMat3::from_cols(
        linear.x_axis.normalize_or(DVec3::X),
        linear.y_axis.normalize_or(DVec3::Y),
        linear.z_axis.normalize_or(DVec3::Z),
    )
}

/// The turn of a map, near enough to begin with.
fn turn_of(linear: Mat3A) -> Quat {
    let x = linear.x_axis.normalize_or(Vec3A::X);
    let y = linear
        .y_axis
        .reject_from_normalized(x)
        .normalize_or(x.any_orthonormal_vector());
    Quat::from_mat3a(&Mat3A::from_cols(x, y, x.cross(y)))
}

fn turned_to(turn: Quat, fit: &Mat3A) -> Quat {
    let axes = Mat3A::from_quat(turn);
    let torque =
        axes.x_axis.cross(fit.x_axis) + axes.y_axis.cross(fit.y_axis) + axes.z_axis.cross(fit.z_axis);
    let inertia = axes.x_axis.dot(fit.x_axis) + axes.y_axis.dot(fit.y_axis) + axes.z_axis.dot(fit.z_axis);
    let rotation = Vec3::from(torque) / inertia.abs().max(f32::MIN_POSITIVE);
    if !rotation.is_finite() || rotation.length_squared() < 1e-16 {
        return turn;
    }
    (Quat::from_scaled_axis(rotation.clamp_length_max(1.0)) * turn).normalize()
}
