//! The elastic skin of one frame: which joints are awake, and where their rounds of relaxation bring the skin.

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
use crate::skin::tissue_change::CarryChange;

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
    rounds: JacobiSolver,
    islands: Islands,
    joints: Vec<JointFrame>,
    /// The joints to be relaxed in this frame, rising.
    active: Vec<usize>,
    /// The same by colour.
    due: Vec<usize>,
    /// How far each joint is moved from rest, 0..1.
    activity: Vec<f32>,
    /// How far each joint is closed, 0..1.
    closing: Vec<f32>,
    /// The joints that were stale when it was looked last which vertices move, with their activity and closing: most poses differ in
    /// neither, and the same vertices move again.
    opened: Vec<(usize, f32, f32)>,
    collisions: Option<Collisions>,
    /// Carriers near the joints to be relaxed.
    near: FixedBitSet,
    /// Vertices whose anchors the rounds need.
    needed: Vec<bool>,
    /// How fully the relaxed skin shows, 0..1; 0 where nothing moves.
    shown: Vec<f32>,
    /// The relaxed skin, where it shows.
    relaxed: Vec<Vec3A>,
    /// Whether the vertices of a chunk, of [`RELAXATION_CHUNK`], are otherwise than in the frame before.
    stale_chunks: Vec<bool>,
}

/// A joint's part of a frame.
#[derive(Debug)]
struct JointFrame {
    crease: Option<PosedCrease>,
    scale: f64,
    /// How fully the joint keeps its volume in this pose, 0..1.
    keeping: f32,
    /// The region's vertices as they lie, swollen.
    places: Vec<Vec3A>,
    /// Six times how the region's volume grows with the place of each, m².
    gradient: Vec<Vec3A>,
    step: f32,
}

impl Relaxation {
    pub fn new(elastic: &Elastic, vertices: usize) -> Self {
        let joint_frame = |joint: &ElasticJoint| JointFrame {
            crease: joint.crease.as_ref().map(PosedCrease::new),
            scale: 1.0,
            keeping: 1.0,
            places: vec![Vec3A::ZERO; joint.region.as_ref().map_or(0, |region| region.vertices().len())],
            gradient: vec![Vec3A::ZERO; joint.region.as_ref().map_or(0, |region| region.vertices().len())],
            step: 0.0,
        };
        Self {
            rounds: JacobiSolver::new(vertices),
            islands: Islands::new(elastic.joints.len()),
            joints: elastic.joints.iter().map(joint_frame).collect(),
            active: Vec::with_capacity(elastic.joints.len()),
            due: Vec::with_capacity(elastic.joints.len()),
            activity: vec![0.0; elastic.joints.len()],
            closing: vec![0.0; elastic.joints.len()],
            opened: Vec::with_capacity(elastic.joints.len()),
            collisions: elastic.obstacles.as_ref().map(Collisions::new),
            near: FixedBitSet::with_capacity(elastic.joints.first().map_or(0, |joint| joint.carriers.len())),
            needed: vec![false; vertices],
            shown: vec![0.0; vertices],
            relaxed: vec![Vec3A::ZERO; vertices],
            stale_chunks: vec![true; vertices.div_ceil(RELAXATION_CHUNK)],
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
        &self.rounds.axes
    }

    /// How fully the relaxed skin shows at a vertex, and where it lies there.
    pub fn at(&self, vertex: usize) -> Option<(f32, Vec3A)> {
        let shown = self.shown[vertex];
        (shown > 0.0).then(|| (shown, self.relaxed[vertex]))
    }

    /// Whether what is relaxed of some vertices differs from the frame before.
    pub fn is_stale(&self, vertices: std::ops::Range<usize>) -> bool {
        self.stale_chunks[vertices.start / RELAXATION_CHUNK..vertices.end.div_ceil(RELAXATION_CHUNK)]
            .contains(&true)
    }

    /// Finds the joints that stand otherwise than at rest, and what of them has to be computed anew.
    pub fn wake(&mut self, elastic: &Elastic, palette: &Palette, dirty: &Dirty) {
        let state = self.activity.iter_mut().zip(&mut self.closing);
        for ((activity, closing), joint) in state.zip(&elastic.joints) {
            let turn = joint.turn(palette);
            *activity = joint.activity(palette, turn);
            *closing = smooth_step(turn / CLOSED_AT) as f32;
        }
        self.islands.find(&elastic.joints, &self.activity, dirty);
        let stale = || (0..elastic.joints.len()).filter(|&joint| self.islands.is_stale[joint]);
        self.stale_chunks.fill(dirty.is_everything());
        for &chunk in stale().flat_map(|index| &elastic.joints[index].chunks) {
            self.stale_chunks[chunk as usize] = true;
        }
        self.active.clear();
        self.active
            .extend(stale().filter(|&index| self.activity[index] > 0.0));
        self.due.clone_from(&self.active);
        self.due
            .sort_unstable_by_key(|&index| (elastic.joints[index].colour, index));
        let opened = stale().map(|index| (index, self.activity[index], self.closing[index]));
        if !opened.clone().eq(self.opened.iter().copied()) {
            self.opened.clear();
            self.opened.extend(opened);
            self.open(elastic);
        }
        for &index in &self.due {
            let joint = &elastic.joints[index];
            let frame = &mut self.joints[index];
            // where another joint bends the same skin, the volume between the rims changes by right: an arm that is raised lifts
            // the flank out of a spine's region, and to make up for it the belly was pushed in by centimetres
            let others = joint.shared.iter().map(|&(other, share)| {
                let bent = self.closing[other as usize];
                1.0 - bent * ((share - LEAST_SHARED) / (1.0 - LEAST_SHARED) * SHARED_WEIGHT).clamp(0.0, 1.0)
            });
            frame.keeping = joint.volume_keeping * others.product::<f32>();
            frame.scale = (palette.scales()[joint.joint.child] * palette.scales()[joint.joint.parent]).sqrt();
        }
    }

    /// Whether there is anything to relax.
    pub fn is_active(&self) -> bool {
        !self.due.is_empty()
    }

    /// Finds which vertices the joints that are to be relaxed move, and how far: by what `opened` tells of them.
    fn open(&mut self, elastic: &Elastic) {
        self.rounds.moves.fill(false);
        self.rounds.moving_chunks.fill(false);
        self.needed.fill(false);
        for own in self
            .opened
            .iter()
            .flat_map(|&(index, ..)| &elastic.joints[index].patch)
        {
            self.shown[own.vertex as usize] = 0.0;
            self.rounds.reset(own.vertex as usize);
        }
        let active = || self.opened.iter().filter(|(_, activity, _)| *activity > 0.0);
        for &(index, activity, closing) in active() {
            let joint = &elastic.joints[index];
            for own in &joint.patch {
                let vertex = own.vertex as usize;
                self.shown[vertex] = self.shown[vertex].max(own.shown * activity);
                let yielding = &mut self.rounds.yielding[vertex];
                *yielding = yielding.max(own.yielding * closing);
                self.rounds.moves[vertex] = true;
                self.needed[vertex] = true;
            }
            for &chunk in &joint.chunks {
                self.rounds.moving_chunks[chunk as usize] = true;
            }
            for &vertex in &joint.rim {
                self.needed[vertex as usize] = true;
            }
        }
        for own in active().flat_map(|&(index, ..)| &elastic.joints[index].patch) {
            self.rounds.share(&elastic.arap.hold, own.vertex as usize);
        }
    }

    /// Relaxes what [`Relaxation::wake`] found.
    pub fn run(
        &mut self,
        elastic: &Elastic,
        palette: &Palette,
        carriers: &[CarryChange],
        anchor_of: impl Fn(usize) -> Anchor + Sync,
    ) {
        self.rounds.anchor(&self.needed, anchor_of);
        if let (Some(obstacles), Some(collisions)) = (&elastic.obstacles, &mut self.collisions) {
            self.near.clear();
            for &index in &self.due {
                self.near.union_with(&elastic.joints[index].carriers);
            }
            collisions.find(obstacles, carriers, &self.near, &self.rounds);
        }
        for round in 0..elastic.arap.rounds {
            if round == 0 {
                self.begin(elastic, palette);
            } else {
                self.rounds.relax(&elastic.arap, round);
            }
            if keeps_volume(round, elastic.arap.rounds) {
                self.keep_volume(elastic);
            }
            self.collide();
            self.hold_creases(round + 1 == elastic.arap.rounds);
        }
        self.rounds.write_swollen(&mut self.relaxed);
    }

    /// The first round's steps, and at the same time, since they do not know of them yet, the creases of this pose.
    fn begin(&mut self, elastic: &Elastic, palette: &Palette) {
        let swollen_anchors = std::mem::take(&mut self.rounds.swollen_anchors);
        let (rounds, joints, active) = (&mut self.rounds, &mut self.joints, &self.active);
        let pose_crease = |index: usize, frame: &mut JointFrame| {
            let joint = &elastic.joints[index];
            if let (Some(crease), Some(posed)) = (&joint.crease, &mut frame.crease) {
                crease.pose(&joint.joint, palette, joint.creasing, &swollen_anchors, posed);
            }
        };
        rayon::join(
            || rounds.relax(&elastic.arap, 0),
            || each(active, 0, joints, &pose_crease),
        );
        self.rounds.swollen_anchors = swollen_anchors;
    }

    /// Brings each region back to its volume, colour by colour.
    fn keep_volume(&mut self, elastic: &Elastic) {
        let Self {
            rounds, joints, due, ..
        } = self;
        for due in due.chunk_by(|&a, &b| elastic.joints[a].colour == elastic.joints[b].colour) {
            let shared = &*rounds;
            each(due, 0, joints, &|index, frame| {
                if let Some(region) = &elastic.joints[index].region {
                    region.place(|vertex| shared.swollen_place(vertex), &mut frame.places);
                    frame.step = frame.keeping * region.step(&frame.places, frame.scale, &mut frame.gradient);
                }
            });
            for &index in due {
                if let Some(region) = &elastic.joints[index].region {
                    region.push(
                        &mut rounds.displacements,
                        &joints[index].gradient,
                        joints[index].step,
                    );
                }
            }
        }
    }

    /// Moves what lies in tissues out of them.
    fn collide(&mut self) {
        if let Some(collisions) = &self.collisions {
            collisions.resolve(&mut self.rounds);
        }
    }

    /// Brings each side of a closed joint back to its own side: what lies near its plane, and after the `last` round all.
    fn hold_creases(&mut self, is_last: bool) {
        for &index in &self.due {
            if let Some(crease) = &self.joints[index].crease {
                crease.hold(&mut self.rounds.displacements, is_last);
            }
        }
    }
}

/// Has `work` done for the frames of `due` joints, rising, of which `frames` begin at the joint `first`; in parallel.
fn each(
    due: &[usize],
    first: usize,
    frames: &mut [JointFrame],
    work: &(impl Fn(usize, &mut JointFrame) + Sync),
) {
    match due {
        [] => {}
        [index] => work(*index, &mut frames[index - first]),
        _ => {
            let (low, high) = due.split_at(due.len() / 2);
            let (low_frames, high_frames) = frames.split_at_mut(high[0] - first);
            rayon::join(
                || each(low, first, low_frames, work),
                || each(high, high[0], high_frames, work),
            );
        }
    }
}

/// Whether regions are brought back to their volume in a round of `rounds`: in every second, the last one of them. In all of them
/// nothing is better: the next round finds what is missing as well.
fn keeps_volume(round: usize, rounds: usize) -> bool {
    (rounds - 1 - round).is_multiple_of(2)
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
        // by its sine: the arc cosine makes 1e-4 of what f32 rounds off a matrix, enough to wake every toe of a body that walks
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
