//! The elastic skin of one frame: which joints are awake, and where their solver of relaxation bring the skin.

use fixedbitset::FixedBitSet;
use glam::{DMat3, DQuat, DVec3, Mat3A, Vec3A};

use crate::math::smoothstep::smooth_step;
use crate::parallel::RELAXATION_CHUNK;
use crate::pose::Palette;
use crate::skin::dirty::Dirty;
use crate::skin::relaxation::arap::{Anchor, JacobiSolver};
use crate::skin::relaxation::crease_plane::PosedCrease;
use crate::skin::relaxation::elastic::{Elastic, ElasticJoint};
use crate::skin::relaxation::islands::Islands;
use crate::skin::relaxation::tissue_collision::Collisions;
use crate::skin::tissue_change::TissueChange;

/// Turn of the child bone against its parent at which the relaxation shows fully, radians; 0 at rest.
const SHOWS_AT: f64 = 0.14;
/// Shift of the child bone off its joint at which it does, over the joint's radius.
const SHOWS_AT_SHIFT: f64 = 0.1;
/// Share of a joint's region up to which another joint may bend it without a loss, and how fast it loses its hold beyond.
const LEAST_SHARED: f32 = 0.1;
const SHARED_WEIGHT: f32 = 3.0;
/// Turn at which the joint counts as closed, and its crook yields fully, radians.
const CLOSED_AT: f64 = 0.7;

/// The buffers of a frame and what they hold of the frame before.
#[derive(Debug)]
pub struct Relaxation {
    solver: JacobiSolver,
    islands: Islands,
    joints: Vec<JointFrame>,
    /// The joints to be relaxed in this frame, rising.
    active: Vec<usize>,
    /// The same by colour.
    by_color: Vec<usize>,
    /// How far each joint is moved from rest, 0..1.
    activity: Vec<f32>,
    /// How far each joint is closed, 0..1.
    closing: Vec<f32>,
    /// The joints that were dirty_joints when it was looked last which vertices move, with their activity and closing: most poses differ in
    /// neither, and the same vertices move again.
    moving_joints: Vec<(usize, f32, f32)>,
    collisions: Option<Collisions>,
    /// Carriers near the joints to be relaxed.
    near: FixedBitSet,
    /// Vertices whose anchors the solver need.
    needed: Vec<bool>,
    /// How fully the relaxed skin shows, 0..1; 0 where nothing moves.
    shown: Vec<f32>,
    /// The relaxed skin, where it shows.
    relaxed: Vec<Vec3A>,
    /// Whether the vertices of a chunk, of [`RELAXATION_CHUNK`], are otherwise than in the frame before.
    dirty_chunks: Vec<bool>,
}

/// A joint's part of a frame.
#[derive(Debug)]
struct JointFrame {
    crease: Option<PosedCrease>,
    scale: f64,
    /// How fully the joint keeps its volume in this pose, 0..1.
    volume_strength: f32,
    /// The region's vertices as they lie, swollen.
    positions: Vec<Vec3A>,
    /// Six times how the region's volume grows with the place of each, m².
    gradient: Vec<Vec3A>,
    lambda: f32,
}

impl Relaxation {
    pub fn new(elastic: &Elastic, vertices: usize) -> Self {
        let joint_frame = |joint: &ElasticJoint| JointFrame {
            crease: joint.crease.as_ref().map(PosedCrease::new),
            scale: 1.0,
            volume_strength: 1.0,
            positions: vec![Vec3A::ZERO; joint.region.as_ref().map_or(0, |region| region.vertices().len())],
            gradient: vec![Vec3A::ZERO; joint.region.as_ref().map_or(0, |region| region.vertices().len())],
            lambda: 0.0,
        };
        Self {
            solver: JacobiSolver::new(vertices),
            islands: Islands::new(elastic.joints.len()),
            joints: elastic.joints.iter().map(joint_frame).collect(),
            active: Vec::with_capacity(elastic.joints.len()),
            by_color: Vec::with_capacity(elastic.joints.len()),
            activity: vec![0.0; elastic.joints.len()],
            closing: vec![0.0; elastic.joints.len()],
            moving_joints: Vec::with_capacity(elastic.joints.len()),
            collisions: elastic.obstacles.as_ref().map(Collisions::new),
            near: FixedBitSet::with_capacity(elastic.joints.first().map_or(0, |joint| joint.carriers.len())),
            needed: vec![false; vertices],
            shown: vec![0.0; vertices],
            relaxed: vec![Vec3A::ZERO; vertices],
            dirty_chunks: vec![true; vertices.div_ceil(RELAXATION_CHUNK)],
        }
    }

    /// The joints that are moved from rest, rising.
    pub fn moved_joints(&self) -> impl Iterator<Item = usize> {
        let moved = self.activity.iter().enumerate();
        moved
            .filter(|(_, activity)| **activity > 0.0)
            .map(|(joint, _)| joint)
    }

    /// How each vertex that moves is turned and scaled on its anchor.
    pub fn anchor_axes(&self) -> &[Mat3A] {
        &self.solver.axes
    }

    /// How fully the relaxed skin shows at a vertex, and where it lies there.
    pub fn at(&self, vertex: usize) -> Option<(f32, Vec3A)> {
        let shown = self.shown[vertex];
        (shown > 0.0).then(|| (shown, self.relaxed[vertex]))
    }

    /// Whether what is relaxed of some vertices differs from the frame before.
    pub fn is_dirty(&self, vertices: std::ops::Range<usize>) -> bool {
        self.dirty_chunks[vertices.start / RELAXATION_CHUNK..vertices.end.div_ceil(RELAXATION_CHUNK)]
            .contains(&true)
    }

    /// Finds the joints that stand otherwise than at rest, and what of them has to be computed anew.
    pub fn update_activity(&mut self, elastic: &Elastic, palette: &Palette, dirty: &Dirty) {
        let state = self.activity.iter_mut().zip(&mut self.closing);
        for ((activity, closing), joint) in state.zip(&elastic.joints) {
            let turn = joint.turn(palette);
            *activity = joint.activity(palette, turn);
            *closing = smooth_step(turn / CLOSED_AT) as f32;
        }
        self.islands.find(&elastic.joints, &self.activity, dirty);
        let dirty_joints = || (0..elastic.joints.len()).filter(|&joint| self.islands.is_dirty[joint]);
        self.dirty_chunks.fill(dirty.is_everything());
        for &chunk in dirty_joints().flat_map(|index| &elastic.joints[index].chunks) {
            self.dirty_chunks[chunk as usize] = true;
        }
        self.active.clear();
        self.active
            .extend(dirty_joints().filter(|&index| self.activity[index] > 0.0));
        self.by_color.clone_from(&self.active);
        self.by_color
            .sort_unstable_by_key(|&index| (elastic.joints[index].colour, index));
        let moving_joints = dirty_joints().map(|index| (index, self.activity[index], self.closing[index]));
        if !moving_joints.clone().eq(self.moving_joints.iter().copied()) {
            self.moving_joints.clear();
            self.moving_joints.extend(moving_joints);
            self.find_moving_vertices(elastic);
        }
        for &index in &self.by_color {
            let joint = &elastic.joints[index];
            let frame = &mut self.joints[index];
            // where another joint bends the same skin, the volume between the rims changes by right: an arm that is raised lifts
            // the flank out of a spine's region, and to make up for it the belly was pushed in by centimetres
            let others = joint.shared.iter().map(|&(other, share)| {
                let bent = self.closing[other as usize];
                1.0 - bent * ((share - LEAST_SHARED) / (1.0 - LEAST_SHARED) * SHARED_WEIGHT).clamp(0.0, 1.0)
            });
            frame.volume_strength = joint.volume_strength * others.product::<f32>();
            frame.scale = (palette.scales()[joint.joint.child] * palette.scales()[joint.joint.parent]).sqrt();
        }
    }

    /// Whether there is anything to relax.
    pub fn is_active(&self) -> bool {
        !self.by_color.is_empty()
    }

    /// Finds which vertices the joints that are to be relaxed move, and how far: by what `moving_joints` tells of them.
    fn find_moving_vertices(&mut self, elastic: &Elastic) {
        self.solver.moves.fill(false);
        self.solver.moving_chunks.fill(false);
        self.needed.fill(false);
        for own in self
            .moving_joints
            .iter()
            .flat_map(|&(index, ..)| &elastic.joints[index].patch)
        {
            self.shown[own.vertex as usize] = 0.0;
            self.solver.reset(own.vertex as usize);
        }
        let active = || self.moving_joints.iter().filter(|(_, activity, _)| *activity > 0.0);
        for &(index, activity, closing) in active() {
            let joint = &elastic.joints[index];
            for own in &joint.patch {
                let vertex = own.vertex as usize;
                self.shown[vertex] = self.shown[vertex].max(own.shown * activity);
                let yielding = &mut self.solver.yielding[vertex];
                *yielding = yielding.max(own.yielding * closing);
                self.solver.moves[vertex] = true;
                self.needed[vertex] = true;
            }
            for &chunk in &joint.chunks {
                self.solver.moving_chunks[chunk as usize] = true;
            }
            for &vertex in &joint.rim {
                self.needed[vertex as usize] = true;
            }
        }
        for own in active().flat_map(|&(index, ..)| &elastic.joints[index].patch) {
            self.solver.set_step_factors(&elastic.arap.anchor_springs, own.vertex as usize);
        }
    }

    /// Relaxes what [`Relaxation::update_activity`] found.
    pub fn run(
        &mut self,
        elastic: &Elastic,
        palette: &Palette,
        carriers: &[TissueChange],
        anchor_of: impl Fn(usize) -> Anchor + Sync,
    ) {
        self.solver.anchor(&self.needed, anchor_of);
        if let (Some(obstacles), Some(collisions)) = (&elastic.obstacles, &mut self.collisions) {
            self.near.clear();
            for &index in &self.by_color {
                self.near.union_with(&elastic.joints[index].carriers);
            }
            collisions.find(obstacles, carriers, &self.near, &self.solver);
        }
        for iteration in 0..elastic.arap.iterations {
            if iteration == 0 {
                self.begin(elastic, palette);
            } else {
                self.solver.relax(&elastic.arap, iteration);
            }
            if keeps_volume(iteration, elastic.arap.iterations) {
                self.keep_volume(elastic);
            }
            self.collide();
            self.project_creases(iteration + 1 == elastic.arap.iterations);
        }
        self.solver.write_swollen(&mut self.relaxed);
    }

    /// The first iteration's steps, and at the same time, since they do not know of them yet, the creases of this pose.
    fn begin(&mut self, elastic: &Elastic, palette: &Palette) {
        let swollen_anchors = std::mem::take(&mut self.solver.swollen_anchors);
        let (solver, joints, active) = (&mut self.solver, &mut self.joints, &self.active);
        let pose_crease = |index: usize, frame: &mut JointFrame| {
            let joint = &elastic.joints[index];
            if let (Some(crease), Some(posed)) = (&joint.crease, &mut frame.crease) {
                crease.pose(&joint.joint, palette, joint.crease_strength, &swollen_anchors, posed);
            }
        };
        rayon::join(
            || solver.relax(&elastic.arap, 0),
            || each(active, 0, joints, &pose_crease),
        );
        self.solver.swollen_anchors = swollen_anchors;
    }

    /// Brings each region back to its volume, colour by colour.
    fn keep_volume(&mut self, elastic: &Elastic) {
        let Self {
            solver, joints, by_color, ..
        } = self;
        for by_color in by_color.chunk_by(|&a, &b| elastic.joints[a].colour == elastic.joints[b].colour) {
            let shared = &*solver;
            each(by_color, 0, joints, &|index, frame| {
                if let Some(region) = &elastic.joints[index].region {
                    region.gather(|vertex| shared.swollen_position(vertex), &mut frame.positions);
                    frame.lambda = frame.volume_strength * region.lambda(&frame.positions, frame.scale, &mut frame.gradient);
                }
            });
            for &index in by_color {
                if let Some(region) = &elastic.joints[index].region {
                    region.project(
                        &mut solver.displacements,
                        &joints[index].gradient,
                        joints[index].lambda,
                    );
                }
            }
        }
    }

    /// Moves what lies in tissues out of them.
    fn collide(&mut self) {
        if let Some(collisions) = &self.collisions {
            collisions.resolve(&mut self.solver);
        }
    }

    /// Brings each side of a closed joint back to its own side: what lies near its plane, and after the `last` iteration all.
    fn project_creases(&mut self, is_last: bool) {
        for &index in &self.by_color {
            if let Some(crease) = &self.joints[index].crease {
                crease.project(&mut self.solver.displacements, is_last);
            }
        }
    }
}

/// Has `work` done for the frames of `by_color` joints, rising, of which `frames` begin at the joint `first`; in parallel.
fn each(
    by_color: &[usize],
    first: usize,
    frames: &mut [JointFrame],
    work: &(impl Fn(usize, &mut JointFrame) + Sync),
) {
    match by_color {
        [] => {}
        [index] => work(*index, &mut frames[index - first]),
        _ => {
            let (low, high) = by_color.split_at(by_color.len() / 2);
            let (low_frames, high_frames) = frames.split_at_mut(high[0] - first);
            rayon::join(
                || each(low, first, low_frames, work),
                || each(high, high[0], high_frames, work),
            );
        }
    }
}

/// Whether regions are brought back to their volume in a iteration of `solver`: in every second, the last one of them. In all of them
/// nothing is better: the next iteration finds what is missing as well.
fn keeps_volume(iteration: usize, solver: usize) -> bool {
    (solver - 1 - iteration).is_multiple_of(2)
}

impl ElasticJoint {
    /// How far the joint, at its `turn`, is moved from rest, 0..1; 1 from a few degrees on.
    fn activity(&self, palette: &Palette, turn: f64) -> f32 {
        let (child, parent) = (
            &palette.skinning_matrices()[self.joint.child],
            &palette.skinning_matrices()[self.joint.parent],
        );
        let shift_m = child
            .transform_point3(self.joint.centre)
            .distance(parent.transform_point3(self.joint.centre));
        let off = shift_m / (SHOWS_AT_SHIFT * self.joint.radius_m * palette.scales()[self.joint.parent]);
        let shown = smooth_step((turn / SHOWS_AT).max(off));
        if shown < 1e-6 { 0.0 } else { shown as f32 }
    }

    /// Turn of the child bone against its parent from rest, radians.
    fn turn(&self, palette: &Palette) -> f64 {
        let turn_of = |bone: usize| DQuat::from_mat3(&unscaled(palette.skinning_matrices()[bone].matrix3));
        let between = turn_of(self.joint.parent).conjugate() * turn_of(self.joint.child);
        // by its sine: the arc cosine makes 1e-4 of what f32 solver off a matrix, enough to update_activity every toe of a body that walks
        2.0 * between.xyz().length().atan2(between.w.abs())
    }
}

fn unscaled(linear: DMat3) -> DMat3 {
    DMat3::from_cols(
        linear.x_axis.normalize_or(DVec3::X),
        linear.y_axis.normalize_or(DVec3::Y),
        linear.z_axis.normalize_or(DVec3::Z),
    )
}
