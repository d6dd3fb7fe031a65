//! One frame: the posed place of every vertex, as a displacement from rest (ALGORITHM 4).
//!
//! Everything is kept as the difference from the rest pose, in which f32 is exact where nothing moves: at rest the skin
//! comes back to the bit that its mesh has, and a correction is 0.

use glam::{DMat3, Mat3A, Vec3A};
use rayon::prelude::*;

use super::anchor::{Anchors, FullAnchor, SwellingAnchor};
use super::correction::undo;
use super::skinning::BoneMaps;
use super::{Skin, Skinning};
use crate::course::Tracing;
use crate::error::Result;
use crate::musculature::{Carrier, Musculature};
use crate::pose::{ColumnMajor, Palette};
use crate::posing::Carry;

/// Vertices that one thread takes at a time.
const CHUNK: usize = 512;

/// What a pose does to the skin around one carrier, less what is there at rest.
#[derive(Debug, Clone, Copy)]
struct CarryChange {
    /// Change of shape alone, in the posed axes.
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

    fn new(carry: &Carry, rest: &Carrier) -> Self {
        let narrow = |matrix: DMat3| Mat3A::from(matrix.as_mat3());
        Self {
            swelling: narrow(carry.stretch - carry.turn),
            stretch: narrow(carry.stretch - rest.axes),
            turn: narrow(carry.turn - rest.axes),
            shift: (carry.centre - rest.centre).as_vec3a(),
        }
    }
}

/// The buffers of a frame, made once a skin.
#[derive(Debug)]
pub(super) struct Workspace {
    palette: Palette,
    bones: BoneMaps,
    carriers: Vec<CarryChange>,
    tracing: Tracing,
}

impl Workspace {
    pub fn new(musculature: &Musculature, skinning: Skinning) -> Self {
        let skeleton = musculature.skeleton();
        Self {
            palette: Palette::at_rest(skeleton),
            bones: BoneMaps::at_rest(skinning, skeleton.len()),
            carriers: vec![CarryChange::NONE; musculature.carriers().len()],
            tracing: Tracing::default(),
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
        let Self {
            palette,
            carriers,
            tracing,
            ..
        } = self;
        musculature.carry_all(palette, tension, tracing, |index, carry, is_clamped| {
            let rest = &musculature.carriers()[index];
            carriers[index] = CarryChange::new(&carry, rest);
            if is_clamped && clamped.last() != Some(&rest.tissue) {
                clamped.push(rest.tissue);
            }
        });
        Ok(())
    }
}

impl Skin {
    /// Writes the posed skin, mesh space.
    pub(super) fn write_deformed(&self, frame: &Workspace, out: &mut [[f32; 3]]) {
        out.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, places)| {
            for (vertex, place) in (chunk * CHUNK..).zip(places) {
                let own = frame.bones.blend(self.bone_weights.of(vertex));
                let carried = own.at(self.points[vertex]);
                let moved = carried + self.pull(frame, vertex, carried).unwrap_or(Vec3A::ZERO);
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
                let own = frame.bones.blend(self.bone_weights.of(vertex));
                let Some(pull) = self.pull(frame, vertex, own.at(self.points[vertex])) else {
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

/// `Σ w σ R (S - 1) p`.
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
