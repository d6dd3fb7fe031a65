//! Computes both skins of a pose: the Armature modifier's, and Sinew's. Poses are computed one after another, and only
//! what differs from the pose before.

use std::sync::PoisonError;

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::parallel::{OUTPUT_CHUNK, OUTPUT_CHUNKS_PER_TASK};
use crate::pose::ColumnMajor;
use crate::skin::safeguard::sampler::Sampler;
use crate::skin::skin::Skin;
use crate::skin::workspace::{Workspace, Written};

impl Skin {
    /// Calls `work` with buffers that nothing else uses.
    pub(crate) fn with_sampler(&self, work: impl FnOnce(&mut Sampler)) {
        let samplers = || self.samplers.lock().unwrap_or_else(PoisonError::into_inner);
        let idle = samplers().pop();
        let mut sampler = idle.unwrap_or_else(|| {
            let workspace = Workspace::new(
                &self.musculature,
                (self.skinning, self.preserved.is_some()),
                self.elastic.as_ref(),
                self.contact.as_ref(),
                None,
                self.points.len(),
                self.needs.len(),
            );
            Sampler::new(
                workspace,
                self.points.len(),
                self.musculature.len(),
                self.needs.len(),
            )
        });
        work(&mut sampler);
        samplers().push(sampler);
    }

    /// Computes both skins of a pose; `crease` is the factor of the crease planes, 0 to 1. False if the pose
    /// cannot be computed, as if a bone is too far away for f32.
    pub(crate) fn pose_both(&self, sampler: &mut Sampler, pose: &[ColumnMajor], crease: f32) -> bool {
        let workspace = &mut sampler.workspace;
        if crease != sampler.crease {
            workspace.written = Written::Nothing; // nothing of the pose before is kept
            sampler.crease = crease;
        }
        let shifted = |workspace: &Workspace, is_dirty: &mut [bool]| {
            for &vertex in workspace.contact.iter().flat_map(|contact| &contact.shifted) {
                is_dirty[vertex as usize / OUTPUT_CHUNK] = true;
            }
        };
        sampler.is_dirty.fill(false);
        shifted(workspace, &mut sampler.is_dirty);
        let is_set = workspace.set(
            &self.musculature,
            &self.bones_of_tissue,
            self.elastic.as_ref(),
            pose,
            &sampler.tension,
            &mut vec![],
        );
        if is_set.is_err() {
            return false;
        }
        if let Some(elastic) = &mut workspace.elastic {
            elastic.relaxation.set_crease_factors(|_| crease);
        }
        self.relax(workspace);
        if let (Some(contact), Some(mut frame)) = (&self.contact, workspace.contact.take()) {
            self.resolve_contact(workspace, (contact, &mut frame));
            workspace.contact = Some(frame);
        }
        workspace.written = Written::Deformed;
        shifted(workspace, &mut sampler.is_dirty);
        let (workspace, is_dirty) = (&*workspace, &sampler.is_dirty);
        let alone = sampler.alone.par_chunks_mut(OUTPUT_CHUNK);
        let chunks = alone
            .zip(sampler.whole.par_chunks_mut(OUTPUT_CHUNK))
            .zip(sampler.maps.par_chunks_mut(OUTPUT_CHUNK))
            .enumerate()
            .with_max_len(OUTPUT_CHUNKS_PER_TASK);
        chunks
            .filter(|(chunk, _)| is_dirty[*chunk] || self.is_chunk_dirty(workspace, *chunk))
            .for_each(|(chunk, ((alone, whole), maps))| {
                for (index, alone) in alone.iter_mut().enumerate() {
                    let vertex = chunk * OUTPUT_CHUNK + index;
                    let map = workspace
                        .bones
                        .blend(self.bone_weights.of(vertex), self.preserved_fraction(vertex));
                    let modifier_offset = map.at(self.points[vertex]);
                    let offset = self.offset_after_modifier(workspace, vertex, modifier_offset);
                    *alone = self.points[vertex] + modifier_offset;
                    whole[index] = *alone + offset.unwrap_or(Vec3A::ZERO);
                    maps[index] = map.linear + Mat3A::IDENTITY;
                }
            });
        true
    }
}
