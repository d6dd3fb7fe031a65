//! One frame: the posed position of every vertex, as a displacement from rest
//! (mathematics/skinning.md, One frame).
//!
//! All values are differences from the rest pose. Where nothing moves they are 0, which f32 represents
//! exactly: at rest the skin has the bits of its mesh, and every correction is 0.

use std::sync::PoisonError;

use glam::{Mat3A, Vec3A};

use crate::error::{Result, require_length};
use crate::parallel::{OUTPUT_CHUNK, with_hot_pool};
use crate::pose::ColumnMajor;
use crate::skin::binding::anchor::{Anchors, FullAnchor, SwellingAnchor};
use crate::skin::contact::contact::Contact;
use crate::skin::contact::frame::ContactFrame;
use crate::skin::correction::inverse::{PosedOffset, invert_each};
use crate::skin::frame_report::FrameReport;
use crate::skin::output_chunks::{mark_shifted, write_chunks};
use crate::skin::relaxation::arap::Anchor;
use crate::skin::skin::Skin;
use crate::skin::workspace::{Workspace, Written};

impl Skin {
    /// Writes the correction of one frame to `out`: the offsets to add to the rest positions, mesh space,
    /// before the Armature modifier. They are exactly 0 where nothing differs from the modifier. `tension`
    /// is 0 to 1, one per tissue.
    ///
    /// # Errors
    /// Lists that do not match the rig or the mesh, a pose that is not affine, a tension outside 0 to 1.
    /// `out` is then unchanged.
    pub fn correct(
        &self,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
    ) -> Result<FrameReport> {
        if let Some(garment) = &self.garment {
            return garment.correct(self, pose, tension, out);
        }
        self.frame(pose, tension, out, |frame| self.write_correction(frame))
    }

    /// Writes the deformed skin of one frame, after the Armature modifier, to `out`, mesh space.
    ///
    /// # Errors
    /// As [`Skin::correct`].
    pub fn deform(&self, pose: &[ColumnMajor], tension: &[f32], out: &mut [[f32; 3]]) -> Result<FrameReport> {
        if let Some(garment) = &self.garment {
            return garment.deform(self, pose, tension, out);
        }
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
        self.safeguard(workspace);
        self.relax(workspace);
        let damped = write(workspace);
        self.order.to_mesh_order(&workspace.output, out);
        self.write_welded(workspace, out);
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
                (self.skinning, self.preserved.is_some()),
                elastic,
                self.contact.as_ref(),
                self.guard.as_ref(),
                self.points.len(),
                self.needs.len(),
            )
        })
    }

    /// Relaxes an elastic skin in the pose of `frame`.
    pub(crate) fn relax(&self, frame: &mut Workspace) {
        let (Some(elastic), Some(mut elastic_frame)) = (&self.elastic, frame.elastic.take()) else {
            return;
        };
        if elastic_frame.relaxation.is_active() {
            let (bones, shared) = (&elastic_frame.bones, &*frame);
            elastic_frame.relaxation.run(elastic, shared.palette(), |vertex| {
                let motion = bones.motion(self.bone_weights.of(vertex));
                let modifier_offset = motion.map.at(self.points[vertex]);
                let by_tissues = self
                    .offset_by_tissues(shared, vertex, modifier_offset)
                    .unwrap_or(Vec3A::ZERO);
                let (whole, swelling) = match self.anchors {
                    Anchors::Swelling(_) => (Vec3A::ZERO, by_tissues),
                    Anchors::Full(_) => (by_tissues, Vec3A::ZERO),
                };
                Anchor {
                    position: self.points[vertex] + modifier_offset + whole,
                    axes: motion.axes,
                    scale: motion.scale,
                    swelling,
                }
            });
        }
        frame.elastic = Some(elastic_frame);
    }

    /// Finds how much of the skin of each joint is used in the pose of `frame`, and samples what is not known.
    fn safeguard(&self, frame: &mut Workspace) {
        let (Some(guard), Some(mut guard_frame)) = (&self.guard, frame.guard.take()) else {
            return;
        };
        // most poses have the samples and weights of the frame before, and with them all that follows from them
        if guard_frame.find_counted(guard, frame.palette(), &frame.dirty) {
            let missing = guard_frame.missing(guard);
            if !missing.is_empty() {
                self.sample(guard, &missing);
            }
            if let (Some(elastic), Some(elastic_frame)) = (&self.elastic, &mut frame.elastic) {
                let factors = guard_frame.crease_factors(guard);
                elastic_frame
                    .relaxation
                    .set_crease_factors(|joint| factors[elastic.joints[joint].joint.child]);
            }
        }
        frame.guard = Some(guard_frame);
    }

    /// Resolves skin contact in the pose of `frame`.
    pub(crate) fn resolve_contact(&self, frame: &Workspace, contact: (&Contact, &mut ContactFrame)) {
        if frame.dirty.is_nothing() {
            return;
        }
        let (contact, contact_frame) = contact;
        let is_relaxed = |vertex: usize| relaxed(frame, vertex).is_some();
        contact_frame.resolve(contact, frame.palette(), is_relaxed, |vertex| {
            self.relaxed_position(frame, vertex, || self.modifier_offset(frame, vertex))
        });
    }

    /// The position of a vertex after relaxation, m, armature space. `modifier_offset` gives its displacement by
    /// the modifier.
    pub(crate) fn relaxed_position(
        &self,
        frame: &Workspace,
        vertex: usize,
        modifier_offset: impl FnOnce() -> Vec3A,
    ) -> Vec3A {
        if let Some((1.0, position)) = relaxed(frame, vertex) {
            return position; // its bones and tissues do not matter
        }
        let modifier_offset = modifier_offset();
        let offset = self.relaxed_offset(frame, vertex, modifier_offset);
        self.points[vertex] + modifier_offset + offset.unwrap_or(Vec3A::ZERO)
    }

    /// Displacement of a vertex by the Armature modifier, m, armature space.
    pub(crate) fn modifier_offset(&self, frame: &Workspace, vertex: usize) -> Vec3A {
        self.modifier_map(&frame.bones, vertex).at(self.points[vertex])
    }

    /// Offset of a vertex after the modifier; `None` if there is none. `modifier_offset` is the displacement
    /// by the modifier. All offsets are in armature space, m.
    pub(crate) fn offset_after_modifier(
        &self,
        frame: &Workspace,
        vertex: usize,
        modifier_offset: Vec3A,
    ) -> Option<Vec3A> {
        let kept = frame.guard.as_ref().map_or(1.0, |guard| guard.kept(vertex));
        if kept == 0.0 {
            return None;
        }
        let offset = self.relaxed_offset(frame, vertex, modifier_offset);
        let shift = frame.contact.as_ref().and_then(|contact| contact.shift(vertex));
        let whole = match (offset, shift) {
            (None, shift) => shift,
            (offset, None) => offset,
            (Some(offset), Some(shift)) => Some(offset + shift),
        };
        let counts = |whole: &Vec3A| {
            let guard = self.guard.as_ref();
            guard.is_none_or(|guard| whole.length_squared() > guard.least_offset_m.powi(2))
        };
        let whole = whole.filter(counts)?;
        Some(if kept < 1.0 { whole * kept } else { whole })
    }

    /// Offset by tissues, or to the relaxed position near an active joint; `None` if there is neither.
    pub(crate) fn relaxed_offset(
        &self,
        frame: &Workspace,
        vertex: usize,
        modifier_offset: Vec3A,
    ) -> Option<Vec3A> {
        let elastic = |position: Vec3A| position - self.points[vertex] - modifier_offset;
        match relaxed(frame, vertex) {
            None => self.offset_by_tissues(frame, vertex, modifier_offset),
            // the relaxed position alone counts, so the offset by tissues need not be computed
            Some((1.0, position)) => Some(elastic(position)),
            Some((shown, position)) => {
                let by_tissues = self
                    .offset_by_tissues(frame, vertex, modifier_offset)
                    .unwrap_or(Vec3A::ZERO);
                Some(by_tissues + (elastic(position) - by_tissues) * shown)
            }
        }
    }

    /// Writes the deformed skin, mesh space, to the output of `frame`.
    pub(crate) fn write_deformed(&self, frame: &mut Workspace) {
        self.write(frame, Written::Deformed, |frame, first, positions| {
            for (vertex, position) in (first..).zip(positions) {
                let map = self.modifier_map(&frame.bones, vertex);
                let modifier_offset = map.at(self.points[vertex]);
                let moved = modifier_offset
                    + self
                        .offset_after_modifier(frame, vertex, modifier_offset)
                        .unwrap_or(Vec3A::ZERO);
                *position = (self.mesh_points[vertex] + self.armature_to_mesh * moved).to_array();
            }
            0
        });
    }

    /// Writes the correction, mesh space, to the output of `frame`; returns the number of damped vertices.
    pub(crate) fn write_correction(&self, frame: &mut Workspace) -> usize {
        self.write(frame, Written::Correction, |frame, first, offsets| {
            offsets.fill([0.0; 3]);
            let vertices = first..first + offsets.len();
            let mut damped = 0;
            let anchored = self.anchors.each(vertices);
            invert_each(
                anchored.filter_map(|(vertex, is_anchored)| self.posed_offset_of(frame, vertex, is_anchored)),
                |vertex, rest_offset| {
                    offsets[vertex - first] = (self.armature_to_mesh * rest_offset.offset).to_array();
                    damped += usize::from(rest_offset.is_damped);
                },
            );
            damped
        });
        frame.damped.iter().sum()
    }

    /// The offset of a vertex that its correction must produce after the modifier; `None` if there is none.
    fn posed_offset_of(&self, frame: &Workspace, vertex: usize, is_anchored: bool) -> Option<PosedOffset> {
        let is_shifted = || {
            let contact = frame.contact.as_ref();
            contact.is_some_and(|contact| contact.shift(vertex).is_some())
        };
        if !is_anchored && relaxed(frame, vertex).is_none() && !is_shifted() {
            return None; // true of most vertices; skips the blend of their bones
        }
        let map = self.modifier_map(&frame.bones, vertex);
        let offset = self.offset_after_modifier(frame, vertex, map.at(self.points[vertex]))?;
        Some(PosedOffset {
            key: vertex,
            linear: map.linear + Mat3A::IDENTITY,
            offset,
        })
    }

    /// Resolves contact, and calls `write` for each chunk of the output that differs
    /// from the frame before. `write` takes the first vertex and the entries of the chunk, and returns the
    /// number of damped vertices.
    fn write(
        &self,
        frame: &mut Workspace,
        kind: Written,
        write: impl Fn(&Workspace, usize, &mut [[f32; 3]]) -> usize + Sync,
    ) {
        let is_whole = frame.written != kind;
        frame.dirty_chunks.fill(false);
        mark_shifted(&mut frame.dirty_chunks, frame.contact.as_ref());
        if let (Some(guard), Some(guard_frame)) = (&self.guard, &mut frame.guard) {
            let dirty_chunks = &mut frame.dirty_chunks;
            guard_frame.find_kept(guard, |vertex| {
                dirty_chunks[vertex as usize / OUTPUT_CHUNK] = true
            });
        }
        let (mut output, mut damped) = (
            std::mem::take(&mut frame.output),
            std::mem::take(&mut frame.damped),
        );
        let mut contact = frame.contact.take();
        let shared = &*frame;
        // most skin touches nothing and is written while contact is resolved
        rayon::join(
            || {
                if let Some(contact) = self.contact.as_ref().zip(contact.as_mut()) {
                    self.resolve_contact(shared, contact);
                }
            },
            || {
                let is_dirty = |chunk: usize| {
                    is_whole || shared.dirty_chunks[chunk] || self.is_chunk_dirty(shared, chunk)
                };
                write_chunks(&mut output, &mut damped, is_dirty, |first, entries| {
                    write(shared, first, entries)
                });
            },
        );
        frame.contact = contact;
        frame.dirty_chunks.fill(false);
        mark_shifted(&mut frame.dirty_chunks, frame.contact.as_ref());
        let shared = &*frame;
        let is_shifted = |chunk: usize| shared.dirty_chunks[chunk];
        write_chunks(&mut output, &mut damped, is_shifted, |first, entries| {
            write(shared, first, entries)
        });
        (frame.output, frame.damped, frame.written) = (output, damped, kind);
    }

    /// Whether the skin of a chunk, before contact, differs from the frame before.
    pub(crate) fn is_chunk_dirty(&self, frame: &Workspace, chunk: usize) -> bool {
        let vertices = chunk * OUTPUT_CHUNK..((chunk + 1) * OUTPUT_CHUNK).min(self.points.len());
        let elastic = frame.elastic.as_ref();
        let is_relaxation_dirty = || elastic.is_some_and(|elastic| elastic.relaxation.is_dirty(vertices));
        let (bones, carriers) = (&self.needs.bones[chunk], &self.needs.carriers[chunk]);
        frame.dirty.any_of(bones, carriers) || is_relaxation_dirty()
    }

    /// Offset of a vertex by its tissues; `None` if it has no anchor.
    fn offset_by_tissues(&self, frame: &Workspace, vertex: usize, modifier_offset: Vec3A) -> Option<Vec3A> {
        match &self.anchors {
            Anchors::Swelling(rows) => match rows.row(vertex) {
                [] => None,
                anchors => Some(swelling(frame, anchors)),
            },
            Anchors::Full(rows) => match rows.row(vertex) {
                [] => None,
                anchors => Some(full(frame, anchors, modifier_offset)),
            },
        }
    }
}

/// How fully the relaxed skin shows at a vertex, 0 to 1, and its position.
fn relaxed(frame: &Workspace, vertex: usize) -> Option<(f32, Vec3A)> {
    frame.elastic.as_ref()?.relaxation.at(vertex)
}

/// `Σ w σ R (S - 1) p`, without the component along each belly.
fn swelling(frame: &Workspace, anchors: &[SwellingAnchor]) -> Vec3A {
    anchors.iter().fold(Vec3A::ZERO, |offset, anchor| {
        let [x, y] = frame.carriers[anchor.carrier as usize].swelling;
        offset + (x * anchor.across.x + y * anchor.across.y)
    })
}

/// `Σ w (A x - x) - Σ w (M x - x)`.
fn full(frame: &Workspace, anchors: &[FullAnchor], modifier_offset: Vec3A) -> Vec3A {
    anchors.iter().fold(Vec3A::ZERO, |offset, anchor| {
        let change = &frame.carriers[anchor.carrier as usize];
        offset
            + (change.shift - modifier_offset) * anchor.weight
            + change.stretch * Vec3A::from(anchor.surface)
            + change.turn * Vec3A::from(anchor.fat)
    })
}
