//! One frame: the posed place of every vertex, as a displacement from rest (ALGORITHM 4).
//!
//! Everything is kept as the difference from the rest pose, in which f32 is exact where nothing moves: at rest the skin
//! comes back to the bit that its mesh has, and a correction is 0.

use std::sync::PoisonError;

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::error::{Result, require_length};
use crate::parallel::{OUTPUT_CHUNK, OUTPUT_CHUNKS_PER_TASK, with_hot_pool};
use crate::pose::ColumnMajor;
use crate::skin::binding::anchor::{Anchors, FullAnchor, SwellingAnchor};
use crate::skin::contact::frame::ContactFrame;
use crate::skin::correction::inverse::{PosedOffset, invert, invert_each};
use crate::skin::relaxation::arap::Anchor;
use crate::skin::skin::Skin;
use crate::skin::workspace::{Workspace, Written};

/// What one frame met.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FrameReport {
    /// Indices of the muscles whose belly came near its floor.
    pub clamped: Vec<usize>,
    /// Vertices whose correction is damped or bounded.
    pub damped: usize,
}

impl Skin {
    /// Writes the correction of one frame to `out`: what to add to the rest points, mesh space, before the Armature
    /// modifier; exactly 0 where no tissue is near. `tension` 0..1, one per tissue.
    ///
    /// # Errors
    /// Lists that do not fit the rig or the mesh, a pose that is not affine, a tension outside 0..1; `out` is then as it was.
    pub fn correct(
        &self,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
    ) -> Result<FrameReport> {
        self.frame(pose, tension, out, |frame| self.write_correction(frame))
    }

    /// Writes the deformed skin of one frame to `out`, mesh space, as it stands after the Armature modifier.
    ///
    /// # Errors
    /// As [`Skin::correct`].
    pub fn deform(&self, pose: &[ColumnMajor], tension: &[f32], out: &mut [[f32; 3]]) -> Result<FrameReport> {
        self.frame(pose, tension, out, |frame| {
            self.write_deformed(frame);
            0
        })
    }

    fn frame(
        &self,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
        write: impl FnOnce(&mut Workspace) -> usize + Send,
    ) -> Result<FrameReport> {
        require_length("out", self.len(), "one per vertex", out.len())?;
        let mut workspace = self.borrow_workspace();
        let report = with_hot_pool(|| self.frame_in(&mut workspace, pose, tension, out, write));
        self.workspaces
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(workspace);
        report
    }

    fn frame_in(
        &self,
        workspace: &mut Workspace,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
        write: impl FnOnce(&mut Workspace) -> usize,
    ) -> Result<FrameReport> {
        let mut clamped = Vec::new();
        workspace.set(
            &self.musculature,
            &self.bones_of_tissue,
            self.elastic.as_ref(),
            pose,
            tension,
            &mut clamped,
        )?;
        self.relax(workspace);
        let damped = write(workspace);
        self.order.to_mesh_order(&workspace.output, out);
        self.write_aliases(workspace, out);
        Ok(FrameReport { clamped, damped })
    }

    fn borrow_workspace(&self) -> Workspace {
        let idle = self
            .workspaces
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        idle.unwrap_or_else(|| {
            let elastic = self.elastic.as_ref();
            Workspace::new(
                &self.musculature,
                self.skinning,
                elastic,
                self.contact.as_ref(),
                self.guard.as_ref(),
                self.points.len(),
                self.needs.len(),
            )
        })
    }

    /// Relaxes an elastic skin in the pose that `frame` has taken on.
    pub(crate) fn relax(&self, frame: &mut Workspace) {
        let (Some(elastic), Some(mut own)) = (&self.elastic, frame.elastic.take()) else {
            return;
        };
        if own.relaxation.is_active() {
            let (bones, shared) = (&own.bones, &*frame);
            own.relaxation
                .run(elastic, shared.palette(), &shared.carriers, |vertex| {
                    let motion = bones.motion(self.bone_weights.of(vertex));
                    let carried = motion.map.at(self.points[vertex]);
                    let pull = self.pull(shared, vertex, carried).unwrap_or(Vec3A::ZERO);
                    let (whole, swelling) = match self.anchors {
                        Anchors::Swelling(_) => (Vec3A::ZERO, pull),
                        Anchors::Full(_) => (pull, Vec3A::ZERO),
                    };
                    Anchor {
                        position: self.points[vertex] + carried + whole,
                        axes: motion.axes,
                        scale: motion.scale,
                        swelling,
                    }
                });
        }
        frame.elastic = Some(own);
    }

    /// Moves apart what of the skin meets in the pose that `frame` has taken on.
    fn resolve_contact(&self, frame: &mut Workspace) {
        if frame.dirty.is_nothing() {
            return;
        }
        let (Some(contact), Some(mut own)) = (&self.contact, frame.contact.take()) else {
            return;
        };
        let mut check = frame.contact_check.take();
        let shared = &*frame;
        let guarded: &[Vec3A] = shared.guard.as_ref().map_or(&[], |guard| &guard.guarded);
        let place_of = |vertex: usize| guarded[vertex];
        let is_relaxed = |vertex: usize| relaxed(shared, vertex).is_some();
        own.resolve(contact, shared.palette(), is_relaxed, place_of);
        if let (Some(guard), Some(check)) = (&self.guard, &mut check) {
            let (shifted, shift) = own.moved();
            check.restrain(guard, &self.bone_weights, shifted, shift, guarded);
        }
        (frame.contact, frame.contact_check) = (Some(own), check);
    }

    /// How far a vertex is to be pulled from where the modifier has `carried` it; `None` where by nothing.
    fn offset_after_modifier(&self, frame: &Workspace, vertex: usize, carried: Vec3A) -> Option<Vec3A> {
        let offset = self.guarded_offset(frame, vertex, carried);
        let shift = frame.contact.as_ref().and_then(|contact| contact.shift(vertex));
        match (offset, shift) {
            (None, shift) => shift,
            (offset, None) => offset,
            (Some(offset), Some(shift)) => Some(offset + shift),
        }
    }

    /// The same before contact. Where a joint's skin is worse than the modifier's, it returns to that.
    fn guarded_offset(&self, frame: &Workspace, vertex: usize, carried: Vec3A) -> Option<Vec3A> {
        let returned = frame.guard.as_ref().map_or(0.0, |guard| guard.share(vertex));
        if returned == 1.0 {
            return None;
        }
        let offset = self.relaxed_offset(frame, vertex, carried);
        offset.map(|offset| offset * (1.0 - returned))
    }

    /// How far tissues pull a vertex from where the modifier has `carried` it, or how far it is to where the elastic skin around its
    /// joint has come to lie; `None` where by nothing.
    fn relaxed_offset(&self, frame: &Workspace, vertex: usize, carried: Vec3A) -> Option<Vec3A> {
        let elastic = |place: Vec3A| place - self.points[vertex] - carried;
        match relaxed(frame, vertex) {
            None => self.pull(frame, vertex, carried),
            // whatever its tissues do
            Some((1.0, place)) => Some(elastic(place)),
            Some((shown, place)) => {
                let pull = self.pull(frame, vertex, carried).unwrap_or(Vec3A::ZERO);
                Some(pull + (elastic(place) - pull) * shown)
            }
        }
    }

    /// Writes the posed skin, mesh space, to the frame's own output.
    pub(crate) fn write_deformed(&self, frame: &mut Workspace) {
        self.write(frame, Written::Deformed, |frame, first, places| {
            for (vertex, place) in (first..).zip(places) {
                let own = frame.bones.blend(self.bone_weights.of(vertex));
                let carried = own.at(self.points[vertex]);
                let moved = carried
                    + self
                        .offset_after_modifier(frame, vertex, carried)
                        .unwrap_or(Vec3A::ZERO);
                *place = (self.mesh_points[vertex] + self.armature_to_mesh * moved).to_array();
            }
            0
        });
    }

    /// Writes the correction, mesh space, to the frame's own output; returns the number of damped vertices.
    pub(crate) fn write_correction(&self, frame: &mut Workspace) -> usize {
        self.write(frame, Written::Correction, |frame, first, offsets| {
            offsets.fill([0.0; 3]);
            let vertices = first..first + offsets.len();
            let mut damped = 0;
            let anchored = self.anchors.each(vertices);
            invert_each(
                anchored.filter_map(|(vertex, is_anchored)| self.wanted(frame, vertex, is_anchored)),
                |vertex, undone| {
                    offsets[vertex - first] = (self.armature_to_mesh * undone.offset).to_array();
                    damped += usize::from(undone.is_damped);
                },
            );
            damped
        });
        frame.damped.iter().sum()
    }

    /// Writes the mesh's vertices that are welded to others with weights of their own: each comes to where the other one does.
    fn write_aliases(&self, frame: &Workspace, out: &mut [[f32; 3]]) {
        for (alias, weights) in self.aliases.iter() {
            let vertex = alias.number as usize;
            let carried = frame
                .bones
                .blend(self.bone_weights.of(vertex))
                .at(self.points[vertex]);
            let offset = self.offset_after_modifier(frame, vertex, carried);
            let moved = carried + offset.unwrap_or(Vec3A::ZERO);
            let written = if frame.written == Written::Deformed {
                alias.mesh_point + self.armature_to_mesh * moved
            } else {
                let own = frame.bones.blend(weights);
                let undone = invert(own.linear + Mat3A::IDENTITY, moved - own.at(alias.point));
                self.armature_to_mesh * undone.offset
            };
            out[alias.vertex as usize] = written.to_array();
        }
    }

    /// What a vertex is to be corrected by, after the modifier; `None` where by nothing.
    fn wanted(&self, frame: &Workspace, vertex: usize, is_anchored: bool) -> Option<PosedOffset> {
        let is_shifted = || {
            let contact = frame.contact.as_ref();
            contact.is_some_and(|contact| contact.shift(vertex).is_some())
        };
        if !is_anchored && relaxed(frame, vertex).is_none() && !is_shifted() {
            return None; // most of a body: its bones need not be blended
        }
        let own = frame.bones.blend(self.bone_weights.of(vertex));
        let offset = self.offset_after_modifier(frame, vertex, own.at(self.points[vertex]))?;
        Some(PosedOffset {
            key: vertex,
            linear: own.linear + Mat3A::IDENTITY,
            offset,
        })
    }

    /// Moves apart what of the skin meets, and lets `write` fill the frame's output, chunk by chunk, where it is not as in the frame
    /// before; it gets the first vertex of the chunk, and says at how many of them what it wrote is damped.
    fn write(
        &self,
        frame: &mut Workspace,
        kind: Written,
        write: impl Fn(&Workspace, usize, &mut [[f32; 3]]) -> usize + Sync,
    ) {
        let is_whole = frame.written != kind;
        frame.stale.fill(false);
        mark_shifted(&mut frame.stale, frame.contact.as_ref());
        self.safeguard(frame);
        self.resolve_contact(frame);
        mark_shifted(&mut frame.stale, frame.contact.as_ref());
        let (mut output, mut damped) = (
            std::mem::take(&mut frame.output),
            std::mem::take(&mut frame.damped),
        );
        let shared = &*frame;
        let is_due = |chunk: usize| is_whole || shared.stale[chunk] || self.moves(shared, chunk);
        write_chunks(&mut output, &mut damped, is_due, |first, places| {
            write(shared, first, places)
        });
        (frame.output, frame.damped, frame.written) = (output, damped, kind);
    }

    /// Whether the skin of a chunk, before contact, is otherwise than in the frame before.
    fn moves(&self, frame: &Workspace, chunk: usize) -> bool {
        let vertices = chunk * OUTPUT_CHUNK..((chunk + 1) * OUTPUT_CHUNK).min(self.points.len());
        let elastic = frame.elastic.as_ref();
        let relaxes_anew = || elastic.is_some_and(|own| own.relaxation.is_dirty(vertices));
        let (bones, carriers) = (&self.needs.bones[chunk], &self.needs.carriers[chunk]);
        frame.dirty.any_of(bones, carriers) || relaxes_anew()
    }

    /// Finds where the skin has to return to the modifier's, and marks the chunks in which it does so otherwise than before.
    fn safeguard(&self, frame: &mut Workspace) {
        if frame.dirty.is_nothing() {
            return;
        }
        let (Some(guard), Some(mut own)) = (&self.guard, frame.guard.take()) else {
            return;
        };
        let (mut stale, mut places) = (std::mem::take(&mut frame.stale), frame.places.take());
        let shared = &*frame;
        let place_of = |vertex: usize| {
            let carried = shared
                .bones
                .blend(self.bone_weights.of(vertex))
                .at(self.points[vertex]);
            let modifier = self.points[vertex] + carried;
            let offset = self.relaxed_offset(shared, vertex, carried);
            (modifier + offset.unwrap_or(Vec3A::ZERO), modifier)
        };
        if let Some(places) = &mut places {
            places.set(|chunk| self.moves(shared, chunk), place_of);
            let elastic = shared.elastic.as_ref();
            let active: Vec<usize> = elastic
                .iter()
                .flat_map(|elastic| elastic.relaxation.moved_joints())
                .collect();
            let axes = elastic.map_or(&[][..], |elastic| elastic.relaxation.anchor_axes());
            own.compare(guard, &active, axes, places, &self.bone_weights, |vertex| {
                stale[vertex as usize / OUTPUT_CHUNK] = true;
            });
        }
        (frame.stale, frame.places, frame.guard) = (stale, places, Some(own));
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

/// Marks the chunks in which `contact` has shifted skin as stale.
fn mark_shifted(stale: &mut [bool], contact: Option<&ContactFrame>) {
    for &vertex in contact.iter().flat_map(|contact| &contact.shifted) {
        stale[vertex as usize / OUTPUT_CHUNK] = true;
    }
}

/// Lets `write` fill the chunks of the output that are `due`, and notes at how many vertices it says that is damped.
fn write_chunks(
    output: &mut [[f32; 3]],
    damped: &mut [usize],
    is_due: impl Fn(usize) -> bool + Sync,
    write: impl Fn(usize, &mut [[f32; 3]]) -> usize + Sync,
) {
    let chunks = output.par_chunks_mut(OUTPUT_CHUNK).zip(damped).enumerate();
    let chunks = chunks.with_max_len(OUTPUT_CHUNKS_PER_TASK);
    chunks
        .filter(|(chunk, _)| is_due(*chunk))
        .for_each(|(chunk, (places, damped))| {
            *damped = write(chunk * OUTPUT_CHUNK, places);
        });
}

/// How fully the relaxed skin shows at a vertex, and where it lies there.
fn relaxed(frame: &Workspace, vertex: usize) -> Option<(f32, Vec3A)> {
    frame.elastic.as_ref()?.relaxation.at(vertex)
}

/// `Σ w σ R (S - 1) p`, across the bellies.
fn swelling(frame: &Workspace, anchors: &[SwellingAnchor]) -> Vec3A {
    anchors.iter().fold(Vec3A::ZERO, |pull, anchor| {
        let [x, y] = frame.carriers[anchor.carrier as usize].swelling;
        pull + (x * anchor.across.x + y * anchor.across.y)
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
