//! One frame: the posed place of every vertex, as a displacement from rest (ALGORITHM 4).
//!
//! Everything is kept as the difference from the rest pose, in which f32 is exact where nothing moves: at rest the skin
//! comes back to the bit that its mesh has, and a correction is 0.

use glam::{DMat3, DVec3, Mat3A, Vec3A};
use rayon::prelude::*;

use super::anchor::{Anchors, FullAnchor, SwellingAnchor};
use super::correction::undo;
use super::elastic::{Elastic, Relaxation};
use super::skinning::BoneMaps;
use super::{Skin, Skinning};
use crate::error::Result;
use crate::musculature::{Carry, Musculature};
use crate::pose::{ColumnMajor, Palette};

/// Vertices that one thread takes at a time.
const CHUNK: usize = 512;

/// What a pose does to the skin around one carrier, less what is there at rest.
#[derive(Debug, Clone, Copy)]
struct CarryChange {
    /// Change of the widths alone, in the posed axes.
    swelling: Mat3A,
    /// Change of the map of surface points.
    stretch: Mat3A,
    /// Change of the map of fat.
    turn: Mat3A,
    /// Change of place, m.
    shift: Vec3A,
}

impl CarryChange {
    const NONE: Self = Self {
        swelling: Mat3A::ZERO,
        stretch: Mat3A::ZERO,
        turn: Mat3A::ZERO,
        shift: Vec3A::ZERO,
    };

    fn new(carry: &Carry, rest: &crate::musculature::Carrier) -> Self {
        let narrow = |matrix: DMat3| Mat3A::from(matrix.as_mat3());
        Self {
            swelling: narrow(widening(carry)),
            stretch: narrow(carry.stretch - rest.axes),
            turn: narrow(carry.turn - rest.axes),
            shift: (carry.centre - rest.centre).as_vec3a(),
        }
    }
}

/// `σ R (S - 1)` without its part along the belly. The bones hold the skin along a limb; taking it along with the ends of
/// the bellies as well opened the crook of the knee and lost volume: at 140° the body's knee kept 0.766 of it, without 0.787.
fn widening(carry: &Carry) -> DMat3 {
    let mut change = carry.stretch - carry.turn;
    change.z_axis = DVec3::ZERO;
    change
}

/// The buffers of a frame, made once a skin.
#[derive(Debug)]
pub(super) struct Workspace {
    palette: Palette,
    bones: BoneMaps,
    carriers: Vec<CarryChange>,
    elastic: Option<ElasticFrame>,
}

/// What an elastic skin needs of a frame.
#[derive(Debug)]
struct ElasticFrame {
    /// The anchors' own maps: linear ones would collapse a joint before it is relaxed.
    bones: BoneMaps,
    relaxation: Relaxation,
    is_awake: bool,
}

impl Workspace {
    pub fn new(musculature: &Musculature, skinning: Skinning, elastic: Option<&Elastic>) -> Self {
        let skeleton = musculature.skeleton();
        Self {
            palette: Palette::at_rest(skeleton),
            bones: BoneMaps::at_rest(skinning, skeleton.len()),
            carriers: vec![CarryChange::NONE; musculature.carriers().len()],
            elastic: elastic.map(|elastic| ElasticFrame {
                bones: BoneMaps::at_rest(Skinning::PreserveVolume, skeleton.len()),
                relaxation: Relaxation::new(elastic),
                is_awake: false,
            }),
        }
    }

    /// Takes on a pose; adds the tissues that came near their floor to `clamped`.
    pub fn set(
        &mut self,
        musculature: &Musculature,
        pose: &[ColumnMajor],
        tension: &[f32],
        clamped: &mut Vec<usize>,
    ) -> Result<()> {
        musculature.require_tension(tension)?;
        self.palette.set(musculature.skeleton(), pose)?;
        self.bones.set(musculature.skeleton(), &self.palette);
        for (index, (rest, change)) in musculature.carriers().iter().zip(&mut self.carriers).enumerate() {
            let (carry, is_clamped) = musculature.carry(index, &self.palette, tension[rest.tissue]);
            *change = CarryChange::new(&carry, rest);
            if is_clamped && clamped.last() != Some(&rest.tissue) {
                clamped.push(rest.tissue);
            }
        }
        Ok(())
    }
}

impl Skin {
    /// Relaxes an elastic skin in the pose that `frame` has taken on.
    pub(super) fn relax(&self, frame: &mut Workspace) {
        let (Some(elastic), Some(mut own)) = (&self.elastic, frame.elastic.take()) else {
            return;
        };
        own.is_awake = own.relaxation.wake(elastic, &frame.palette);
        if own.is_awake {
            own.bones.set(self.musculature.skeleton(), &frame.palette);
            let (bones, shared) = (&own.bones, &*frame);
            own.relaxation.anchor(|place| {
                let vertex = elastic.vertices()[place] as usize;
                let map = bones.blend(self.bone_weights.of(vertex));
                let carried = map.at(self.points[vertex]);
                let pulled = carried + self.pull(shared, vertex, carried).unwrap_or(Vec3A::ZERO);
                (self.points[vertex] + pulled, map.linear + Mat3A::IDENTITY)
            });
            own.relaxation.run(elastic, &frame.palette);
        }
        frame.elastic = Some(own);
    }

    /// How far a vertex is to be pulled from where the modifier has `carried` it: by its tissues, or to where the elastic
    /// skin around its joint has come to lie; `None` where by nothing.
    fn whole_pull(&self, frame: &Workspace, vertex: usize, carried: Vec3A) -> Option<Vec3A> {
        let pull = self.pull(frame, vertex, carried);
        let Some((shown, relaxed)) = self.relaxed(frame, vertex) else {
            return pull;
        };
        let (pull, elastic) = (
            pull.unwrap_or(Vec3A::ZERO),
            relaxed - self.points[vertex] - carried,
        );
        Some(pull + (elastic - pull) * shown)
    }

    /// How fully the relaxed skin shows at a vertex, and where it lies there.
    fn relaxed(&self, frame: &Workspace, vertex: usize) -> Option<(f32, Vec3A)> {
        let own = frame.elastic.as_ref().filter(|own| own.is_awake)?;
        let place = self.elastic.as_ref()?.place_of(vertex)?;
        let shown = own.relaxation.shown[place];
        (shown > 0.0).then(|| (shown, own.relaxation.skin[place]))
    }

    /// Writes the posed skin, mesh space.
    pub(super) fn write_deformed(&self, frame: &Workspace, out: &mut [[f32; 3]]) {
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, places)| {
            for (vertex, place) in (chunk * CHUNK..).zip(places) {
                let own = frame.bones.blend(self.bone_weights.of(vertex));
                let carried = own.at(self.points[vertex]);
                let moved = carried + self.whole_pull(frame, vertex, carried).unwrap_or(Vec3A::ZERO);
                *place = (self.mesh_points[vertex] + self.armature_to_mesh * moved).to_array();
            }
        });
    }

    /// Writes the correction, mesh space; returns the number of damped vertices.
    pub(super) fn write_correction(&self, frame: &Workspace, out: &mut [[f32; 3]]) -> usize {
        let correct = |(chunk, offsets): (usize, &mut [[f32; 3]])| {
            let mut damped = 0;
            for (vertex, offset) in (chunk * CHUNK..).zip(offsets) {
                *offset = [0.0; 3];
                if !self.anchors.has(vertex) && self.relaxed(frame, vertex).is_none() {
                    continue; // most of a body: its bones need not be blended
                }
                let own = frame.bones.blend(self.bone_weights.of(vertex));
                let Some(pull) = self.whole_pull(frame, vertex, own.at(self.points[vertex])) else {
                    continue;
                };
                let undone = undo(own.linear + Mat3A::IDENTITY, pull);
                damped += usize::from(undone.is_damped);
                *offset = (self.armature_to_mesh * undone.offset).to_array();
            }
            damped
        };
        out.par_chunks_mut(CHUNK).enumerate().map(correct).sum()
    }

    /// How far the tissues pull a vertex from where its bones have `carried` it (both m, armature space), `None` where it
    /// has no anchor.
    fn pull(&self, frame: &Workspace, vertex: usize, carried: Vec3A) -> Option<Vec3A> {
        match &self.anchors {
            Anchors::Swelling(rows) => match rows.row(vertex) {
                [] => None,
                anchors => Some(swelling(frame, anchors)),
            },
            Anchors::Full(rows) => match rows.row(vertex) {
                [] => None,
                anchors => Some(full(frame, anchors, carried)),
            },
        }
    }
}

/// `Σ w σ R (S - 1) p`, across the bellies.
fn swelling(frame: &Workspace, anchors: &[SwellingAnchor]) -> Vec3A {
    anchors.iter().fold(Vec3A::ZERO, |pull, anchor| {
        pull + frame.carriers[anchor.carrier as usize].swelling * Vec3A::from(anchor.surface)
    })
}

/// `Σ w (A x - x) - Σ w (M x - x)`.
fn full(frame: &Workspace, anchors: &[FullAnchor], carried: Vec3A) -> Vec3A {
    anchors.iter().fold(Vec3A::ZERO, |pull, anchor| {
        let change = &frame.carriers[anchor.carrier as usize];
        pull + (change.shift - carried) * anchor.weight
            + change.stretch * Vec3A::from(anchor.surface)
            + change.turn * Vec3A::from(anchor.fat)
    })
}
