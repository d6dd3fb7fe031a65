//! Both skins of a pose: the Armature modifier's, and Sinew's. Poses are computed one after another, and only
//! what differs from the pose before.

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::parallel::{OUTPUT_CHUNK, OUTPUT_CHUNKS_PER_TASK};
use crate::pose::ColumnMajor;
use crate::skin::safeguard::rest_skin::Posed;
use crate::skin::skin::Skin;
use crate::skin::workspace::{Workspace, Written};

/// The buffers of the poses.
#[derive(Debug)]
pub(crate) struct Sampler {
    workspace: Workspace,
    tension: Vec<f32>,
    /// Factor of the crease planes in the pose before, 0 to 1.
    crease: f32,
    alone: Vec<Vec3A>,
    whole: Vec<Vec3A>,
    blended: Vec<Vec3A>,
    maps: Vec<Mat3A>,
    is_dirty: Vec<bool>,
}

impl Sampler {
    pub fn new(skin: &Skin) -> Self {
        let vertices = skin.points.len();
        Self {
            workspace: Workspace::new(
                &skin.musculature,
                (skin.skinning, skin.preserved.is_some()),
                skin.elastic.as_ref(),
                skin.contact.as_ref(),
                None,
                vertices,
                skin.needs.len(),
            ),
            tension: vec![0.0; skin.musculature.len()],
            crease: 1.0,
            alone: vec![Vec3A::ZERO; vertices],
            whole: vec![Vec3A::ZERO; vertices],
            blended: vec![],
            maps: vec![Mat3A::IDENTITY; vertices],
            is_dirty: vec![true; skin.needs.len()],
        }
    }

    /// The skin of the Armature modifier alone in the last pose.
    pub fn alone(&self) -> Posed<'_> {
        Posed {
            positions: &self.alone,
            maps: &self.maps,
        }
    }

    /// Sinew's skin in the last pose.
    pub fn whole(&self) -> Posed<'_> {
        Posed {
            positions: &self.whole,
            maps: &self.maps,
        }
    }

    /// The last blend of both.
    pub fn blended(&self) -> Posed<'_> {
        Posed {
            positions: &self.blended,
            maps: &self.maps,
        }
    }

    /// Blends both skins of the last pose. `fraction` is that of Sinew's, 0 to 1.
    pub fn blend(&mut self, fraction: f32) {
        let pairs = self.alone.iter().zip(&self.whole);
        self.blended.clear();
        self.blended
            .extend(pairs.map(|(&alone, &whole)| alone + (whole - alone) * fraction));
    }

    /// Computes both skins of a pose; `crease` is the factor of the crease planes, 0 to 1. False if the pose
    /// cannot be computed, as if a bone is too far away for f32.
    pub fn pose(&mut self, skin: &Skin, pose: &[ColumnMajor], crease: f32) -> bool {
        let workspace = &mut self.workspace;
        if crease != self.crease {
            workspace.written = Written::Nothing; // nothing of the pose before is kept
            self.crease = crease;
        }
        let shifted = |workspace: &Workspace, is_dirty: &mut [bool]| {
            for &vertex in workspace.contact.iter().flat_map(|contact| &contact.shifted) {
                is_dirty[vertex as usize / OUTPUT_CHUNK] = true;
            }
        };
        self.is_dirty.fill(false);
        shifted(workspace, &mut self.is_dirty);
        let is_set = workspace.set(
            &skin.musculature,
            &skin.bones_of_tissue,
            skin.elastic.as_ref(),
            pose,
            &self.tension,
            &mut vec![],
        );
        if is_set.is_err() {
            return false;
        }
        if let Some(elastic) = &mut workspace.elastic {
            elastic.relaxation.set_crease_factors(|_| crease);
        }
        skin.relax(workspace);
        if let (Some(contact), Some(mut frame)) = (&skin.contact, workspace.contact.take()) {
            skin.resolve_contact(workspace, (contact, &mut frame));
            workspace.contact = Some(frame);
        }
        workspace.written = Written::Deformed;
        shifted(workspace, &mut self.is_dirty);
        let (workspace, is_dirty) = (&*workspace, &self.is_dirty);
        let alone = self.alone.par_chunks_mut(OUTPUT_CHUNK);
        let chunks = alone
            .zip(self.whole.par_chunks_mut(OUTPUT_CHUNK))
            .zip(self.maps.par_chunks_mut(OUTPUT_CHUNK))
            .enumerate()
            .with_max_len(OUTPUT_CHUNKS_PER_TASK);
        chunks
            .filter(|(chunk, _)| is_dirty[*chunk] || skin.is_chunk_dirty(workspace, *chunk))
            .for_each(|(chunk, ((alone, whole), maps))| {
                for (index, alone) in alone.iter_mut().enumerate() {
                    let vertex = chunk * OUTPUT_CHUNK + index;
                    let map = workspace
                        .bones
                        .blend(skin.bone_weights.of(vertex), skin.preserved_fraction(vertex));
                    let modifier_offset = map.at(skin.points[vertex]);
                    let offset = skin.offset_after_modifier(workspace, vertex, modifier_offset);
                    *alone = skin.points[vertex] + modifier_offset;
                    whole[index] = *alone + offset.unwrap_or(Vec3A::ZERO);
                    maps[index] = map.linear + Mat3A::IDENTITY;
                }
            });
        true
    }
}
