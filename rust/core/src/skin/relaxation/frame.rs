//! The relaxation of one frame: which joints are active, and where the solver brings their skin
//! (mathematics/relaxation.md).

use glam::{DMat3, DQuat, DVec3, Vec3A};

use crate::math::smoothstep::smooth_step;
use crate::parallel::RELAXATION_CHUNK;
use crate::pose::Palette;
use crate::skin::dirty::Dirty;
use crate::skin::relaxation::arap::{Anchor, JacobiSolver};
use crate::skin::relaxation::crease_plane::PosedCrease;
use crate::skin::relaxation::elastic::{Elastic, ElasticJoint};
use crate::skin::relaxation::islands::Islands;

/// Rotation of the child bone against its parent at which the relaxed skin shows fully, rad. It fades in
/// from the rest pose, so that nothing jumps.
const SHOWS_AT: f64 = 0.14;
/// Shift of the child bone off its joint at which it shows fully, in radii of the joint.
const SHOWS_AT_SHIFT: f64 = 0.1;
/// Fraction of a region, shared with another joint, up to which the bend of that joint does not weaken
/// the volume constraint; and the slope with which it weakens beyond. Where another joint bends the same
/// skin, its volume changes rightly.
const LEAST_SHARED: f32 = 0.1;
const SHARED_WEIGHT: f32 = 3.0;
/// Rotation at which a joint counts as closed and the anchors on its inner side yield fully, rad.
const CLOSED_AT: f64 = 0.7;

/// The buffers of a frame, and the results of the frame before.
#[derive(Debug)]
pub struct Relaxation {
    solver: JacobiSolver,
    islands: Islands,
    joints: Vec<JointFrame>,
    /// The joints to relax in this frame, rising.
    active: Vec<usize>,
    /// The same, sorted by colour.
    by_colour: Vec<usize>,
    /// How far each joint is from its rest pose, 0 to 1.
    activity: Vec<f32>,
    /// How far each joint is closed, 0 to 1.
    closing: Vec<f32>,
    /// The dirty joints, with activity and closing, when the moving vertices were last found. Most poses
    /// change none of these, and the same vertices move again.
    moving_joints: Vec<(usize, f32, f32)>,
    /// Whether the solver needs the anchor of each vertex.
    needed: Vec<bool>,
    /// How fully the relaxed skin shows, 0 to 1; 0 where nothing moves.
    shown: Vec<f32>,
    /// The relaxed positions, where they show, m.
    relaxed: Vec<Vec3A>,
    /// Whether the relaxed skin of each chunk, of [`RELAXATION_CHUNK`] vertices, differs from the frame
    /// before.
    dirty_chunks: Vec<bool>,
}

/// The buffers of one joint.
#[derive(Debug)]
struct JointFrame {
    crease: Option<PosedCrease>,
    /// Factor of the strength of its crease plane in this pose, 0 to 1.
    crease_factor: f32,
    scale: f64,
    /// Strength of the volume constraint in this pose, 0 to 1.
    volume_strength: f32,
    /// Swollen positions of the region's vertices, m.
    positions: Vec<Vec3A>,
    /// Six times the gradient of the region's volume, m².
    gradient: Vec<Vec3A>,
    lambda: f32,
}

impl Relaxation {
    pub fn new(elastic: &Elastic, vertices: usize) -> Self {
        let joint_frame = |joint: &ElasticJoint| JointFrame {
            crease: joint.crease.as_ref().map(PosedCrease::new),
            crease_factor: 1.0,
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
            by_colour: Vec::with_capacity(elastic.joints.len()),
            activity: vec![0.0; elastic.joints.len()],
            closing: vec![0.0; elastic.joints.len()],
            moving_joints: Vec::with_capacity(elastic.joints.len()),
            needed: vec![false; vertices],
            shown: vec![0.0; vertices],
            relaxed: vec![Vec3A::ZERO; vertices],
            dirty_chunks: vec![true; vertices.div_ceil(RELAXATION_CHUNK)],
        }
    }

    /// How fully the relaxed skin shows at a vertex, and its position there, m.
    pub fn at(&self, vertex: usize) -> Option<(f32, Vec3A)> {
        let shown = self.shown[vertex];
        (shown > 0.0).then(|| (shown, self.relaxed[vertex]))
    }

    /// Whether the relaxed skin of some vertices differs from the frame before.
    pub fn is_dirty(&self, vertices: std::ops::Range<usize>) -> bool {
        self.dirty_chunks[vertices.start / RELAXATION_CHUNK..vertices.end.div_ceil(RELAXATION_CHUNK)]
            .contains(&true)
    }

    /// Finds the joints that are not in their rest pose, and those that must be computed again.
    pub fn update_activity(&mut self, elastic: &Elastic, palette: &Palette, dirty: &Dirty) {
        let state = self.activity.iter_mut().zip(&mut self.closing);
        for ((activity, closing), joint) in state.zip(&elastic.joints) {
            let angle = joint.bend(palette);
            *activity = joint.activity(palette, angle);
            *closing = smooth_step(angle / CLOSED_AT) as f32;
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
        self.by_colour.clone_from(&self.active);
        self.by_colour
            .sort_unstable_by_key(|&index| (elastic.joints[index].colour, index));
        let moving_joints = dirty_joints().map(|index| (index, self.activity[index], self.closing[index]));
        if !moving_joints.clone().eq(self.moving_joints.iter().copied()) {
            self.moving_joints.clear();
            self.moving_joints.extend(moving_joints);
            self.find_moving_vertices(elastic);
        }
        for &index in &self.by_colour {
            let joint = &elastic.joints[index];
            let frame = &mut self.joints[index];
            // where another joint bends the same skin, the volume changes rightly: a raised arm lifts the
            // flank out of a spine's region, and to compensate for it the belly was pushed in by
            // centimetres
            let others = joint.shared.iter().map(|&(other, fraction)| {
                let bent = self.closing[other as usize];
                1.0 - bent
                    * ((fraction - LEAST_SHARED) / (1.0 - LEAST_SHARED) * SHARED_WEIGHT).clamp(0.0, 1.0)
            });
            frame.volume_strength = joint.volume_strength * others.product::<f32>();
            frame.scale = (palette.scales()[joint.joint.child] * palette.scales()[joint.joint.parent]).sqrt();
        }
    }

    /// Sets the factor of the strength of each joint's crease plane, 0 to 1, by the joint's index.
    pub fn set_crease_factors(&mut self, factor_of: impl Fn(usize) -> f32) {
        for (index, frame) in self.joints.iter_mut().enumerate() {
            frame.crease_factor = factor_of(index);
        }
    }

    /// Whether any joint must be relaxed.
    pub fn is_active(&self) -> bool {
        !self.by_colour.is_empty()
    }

    /// Finds the vertices that `moving_joints` move, and how far the relaxed skin shows and the anchors
    /// yield there.
    fn find_moving_vertices(&mut self, elastic: &Elastic) {
        self.solver.moves.fill(false);
        self.solver.moving_chunks.fill(false);
        self.needed.fill(false);
        for patch_vertex in self
            .moving_joints
            .iter()
            .flat_map(|&(index, ..)| &elastic.joints[index].patch)
        {
            self.shown[patch_vertex.vertex as usize] = 0.0;
            self.solver.reset(patch_vertex.vertex as usize);
        }
        let active = || {
            self.moving_joints
                .iter()
                .filter(|(_, activity, _)| *activity > 0.0)
        };
        for &(index, activity, closing) in active() {
            let joint = &elastic.joints[index];
            for patch_vertex in &joint.patch {
                let vertex = patch_vertex.vertex as usize;
                self.shown[vertex] = self.shown[vertex].max(patch_vertex.shown * activity);
                let yielding = &mut self.solver.yielding[vertex];
                *yielding = yielding.max(patch_vertex.yielding * closing);
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
        for patch_vertex in active().flat_map(|&(index, ..)| &elastic.joints[index].patch) {
            self.solver
                .set_step_factors(&elastic.arap.anchor_springs, patch_vertex.vertex as usize);
        }
    }

    /// Relaxes the joints that [`Relaxation::update_activity`] found.
    pub fn run(&mut self, elastic: &Elastic, palette: &Palette, anchor_of: impl Fn(usize) -> Anchor + Sync) {
        self.solver.anchor(&self.needed, anchor_of);
        for iteration in 0..elastic.arap.iterations {
            if iteration == 0 {
                self.begin(elastic, palette);
            } else {
                self.solver.relax(&elastic.arap, iteration);
            }
            if keeps_volume(iteration, elastic.arap.iterations) {
                self.keep_volume(elastic);
            }
            self.project_creases(iteration + 1 == elastic.arap.iterations);
        }
        self.solver.write_swollen(&mut self.relaxed);
    }

    /// The steps of the first iteration, and beside them the crease planes of this pose, which those
    /// steps do not use.
    fn begin(&mut self, elastic: &Elastic, palette: &Palette) {
        let swollen_anchors = std::mem::take(&mut self.solver.swollen_anchors);
        let (solver, joints, active) = (&mut self.solver, &mut self.joints, &self.active);
        let pose_crease = |index: usize, frame: &mut JointFrame| {
            let joint = &elastic.joints[index];
            if let (Some(crease), Some(posed)) = (&joint.crease, &mut frame.crease) {
                crease.pose(
                    &joint.joint,
                    palette,
                    joint.crease_strength * frame.crease_factor,
                    &swollen_anchors,
                    posed,
                );
            }
        };
        rayon::join(
            || solver.relax(&elastic.arap, 0),
            || each(active, 0, joints, &pose_crease),
        );
        self.solver.swollen_anchors = swollen_anchors;
    }

    /// Corrects the volume of each region, colour by colour.
    fn keep_volume(&mut self, elastic: &Elastic) {
        let Self {
            solver,
            joints,
            by_colour,
            ..
        } = self;
        for colour in by_colour.chunk_by(|&a, &b| elastic.joints[a].colour == elastic.joints[b].colour) {
            let shared = &*solver;
            each(colour, 0, joints, &|index, frame| {
                if let Some(region) = &elastic.joints[index].region {
                    region.gather(|vertex| shared.swollen_position(vertex), &mut frame.positions);
                    frame.lambda = frame.volume_strength
                        * region.lambda(&frame.positions, frame.scale, &mut frame.gradient);
                }
            });
            for &index in colour {
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

    /// Projects vertices onto their sides of the crease planes: those near a plane, and in the last
    /// iteration all.
    fn project_creases(&mut self, is_last: bool) {
        for &index in &self.by_colour {
            if let Some(crease) = &self.joints[index].crease {
                crease.project(&mut self.solver.displacements, is_last);
            }
        }
    }
}

/// Calls `work` in parallel for the frames of the `indices` joints (rising). `frames` begins with the
/// joint `first`.
fn each(
    indices: &[usize],
    first: usize,
    frames: &mut [JointFrame],
    work: &(impl Fn(usize, &mut JointFrame) + Sync),
) {
    match indices {
        [] => {}
        [index] => work(*index, &mut frames[index - first]),
        _ => {
            let (low, high) = indices.split_at(indices.len() / 2);
            let (low_frames, high_frames) = frames.split_at_mut(high[0] - first);
            rayon::join(
                || each(low, first, low_frames, work),
                || each(high, high[0], high_frames, work),
            );
        }
    }
}

/// Whether volumes are corrected in an iteration: in every second one and in the last. Measured: a
/// correction in every iteration is not better, because the next one corrects the remaining error as
/// well.
fn keeps_volume(iteration: usize, iterations: usize) -> bool {
    (iterations - 1 - iteration).is_multiple_of(2)
}

impl ElasticJoint {
    /// How far the joint, rotated by `angle` rad, is from its rest pose, 0 to 1; 1 from a few degrees on.
    fn activity(&self, palette: &Palette, angle: f64) -> f32 {
        let (child, parent) = (
            &palette.skinning_matrices()[self.joint.child],
            &palette.skinning_matrices()[self.joint.parent],
        );
        let shift_m = child
            .transform_point3(self.joint.centre)
            .distance(parent.transform_point3(self.joint.centre));
        let off = shift_m / (SHOWS_AT_SHIFT * self.joint.radius_m * palette.scales()[self.joint.parent]);
        let shown = smooth_step((angle / SHOWS_AT).max(off));
        if shown < 1e-6 { 0.0 } else { shown as f32 }
    }

    /// Rotation of the child bone against its parent from rest, rad.
    fn bend(&self, palette: &Palette) -> f64 {
        let turn_of = |bone: usize| DQuat::from_mat3(&unscaled(palette.skinning_matrices()[bone].matrix3));
        let between = turn_of(self.joint.parent).conjugate() * turn_of(self.joint.child);
        // by the sine: the arc cosine makes 1e-4 rad of the rounding of f32 matrices, enough to activate
        // every toe of a walking body
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
