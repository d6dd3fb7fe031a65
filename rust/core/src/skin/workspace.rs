//! The buffers of a frame, which keep the results of the frame before.
//!
//! A frame is a function of its inputs alone. Results whose inputs did not change since the frame before are
//! kept; only what depends on a dirty bone or carrier is computed again.

use fixedbitset::FixedBitSet;

use crate::error::Result;
use crate::muscles::muscle_path::PathBuffers;
use crate::muscles::musculature::Musculature;
use crate::pose::{ColumnMajor, Palette};
use crate::skin::contact::contact::Contact;
use crate::skin::contact::frame::ContactFrame;
use crate::skin::dirty::Dirty;
use crate::skin::relaxation::elastic::Elastic;
use crate::skin::relaxation::frame::Relaxation;
use crate::skin::safeguard::frame::GuardFrame;
use crate::skin::safeguard::guard::Guard;
use crate::skin::settings::bind::Skinning;
use crate::skin::skinning::dual_quaternion::WIDE_TOLERANCE;
use crate::skin::skinning::dual_quaternion_blend::PreserveVolume;
use crate::skin::skinning::modifier::BoneMaps;
use crate::skin::tissue_change::TissueChange;

/// What the output of a workspace contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Written {
    Nothing,
    Deformed,
    Correction,
}

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct Workspace {
    pub bones: BoneMaps,
    pub carriers: Vec<TissueChange>,
    pub elastic: Option<ElasticFrame>,
    pub contact: Option<ContactFrame>,
    pub guard: Option<GuardFrame>,
    pub dirty: Dirty,
    /// The last frame's corrections or positions, mesh space, and which of the two they are.
    pub output: Vec<[f32; 3]>,
    pub written: Written,
    /// Chunks of the output that the safeguard or contact changes in this frame, or changed in the frame
    /// before.
    pub dirty_chunks: Vec<bool>,
    /// Number of damped vertices in each chunk of the output.
    pub damped: Vec<usize>,
    palette: Palette,
    pose: Vec<ColumnMajor>,
    tension: Vec<f32>,
    is_clamped: Vec<bool>,
    /// The dirty tissues.
    dirty_tissues: FixedBitSet,
    path_buffers: PathBuffers,
}

/// The buffers of an elastic skin.
#[derive(Debug)]
pub(crate) struct ElasticFrame {
    /// The maps of the anchors. Linear blending would collapse a joint before it is relaxed.
    pub bones: PreserveVolume,
    pub relaxation: Relaxation,
}

impl Workspace {
    pub fn new(
        musculature: &Musculature,
        (skinning, are_both_blended): (Skinning, bool),
        elastic: Option<&Elastic>,
        contact: Option<&Contact>,
        guard: Option<&Guard>,
        vertices: usize,
        chunks: usize,
    ) -> Self {
        let skeleton = musculature.skeleton();
        let carriers = musculature.carriers().len();
        Self {
            bones: BoneMaps::at_rest(skinning, are_both_blended, skeleton.len()),
            carriers: vec![TissueChange::NONE; carriers],
            elastic: elastic.map(|elastic| ElasticFrame {
                bones: PreserveVolume::at_rest(skeleton.len(), WIDE_TOLERANCE),
                relaxation: Relaxation::new(elastic, vertices),
            }),
            contact: contact.map(ContactFrame::new),
            guard: guard.map(|guard| GuardFrame::new(guard, vertices, skeleton.len())),
            dirty: Dirty {
                bones: FixedBitSet::with_capacity(skeleton.len()),
                carriers: FixedBitSet::with_capacity(carriers),
                is_everything: true,
            },
            output: vec![[0.0; 3]; vertices],
            written: Written::Nothing,
            dirty_chunks: vec![false; chunks],
            damped: vec![0; chunks],
            palette: Palette::at_rest(skeleton),
            pose: vec![[f32::NAN; 16]; skeleton.len()],
            tension: vec![f32::NAN; musculature.len()],
            is_clamped: vec![false; musculature.len()],
            dirty_tissues: FixedBitSet::with_capacity(musculature.len()),
            path_buffers: PathBuffers::default(),
        }
    }

    /// Sets the pose. Adds the indices of the muscles whose belly is close to its minimum length to
    /// `clamped`. `bones_of` are the bones that each tissue depends on. After an error the buffers hold no
    /// frame.
    pub fn set(
        &mut self,
        musculature: &Musculature,
        bones_of: &[FixedBitSet],
        elastic: Option<&Elastic>,
        pose: &[ColumnMajor],
        tension: &[f32],
        clamped: &mut Vec<usize>,
    ) -> Result<()> {
        let holds_a_frame = self.written != Written::Nothing;
        let written = std::mem::replace(&mut self.written, Written::Nothing);
        musculature.require_tension(tension)?;
        self.palette.set(musculature.skeleton(), pose)?;
        self.written = written;
        self.find_dirty(musculature, bones_of, pose, tension, !holds_a_frame);
        let Self {
            bones,
            carriers,
            elastic: elastic_frame,
            dirty,
            palette,
            is_clamped,
            dirty_tissues,
            path_buffers,
            ..
        } = self;
        bones.set(musculature.skeleton(), palette, &dirty.bones);
        if let Some(elastic_frame) = elastic_frame {
            elastic_frame
                .bones
                .set(musculature.skeleton(), palette, &dirty.bones);
        }
        let (dirty_tissues, dirty) = (&*dirty_tissues, &*dirty);
        rayon::join(
            || {
                let is_dirty = |tissue: usize| dirty_tissues.contains(tissue);
                musculature.each_transform(
                    palette,
                    tension,
                    path_buffers,
                    is_dirty,
                    |index, transform, clamps| {
                        let rest = &musculature.carriers()[index];
                        carriers[index] = TissueChange::new(&transform, rest);
                        is_clamped[rest.tissue] = clamps;
                    },
                );
            },
            || {
                if let Some((elastic_frame, elastic)) = elastic_frame.as_mut().zip(elastic) {
                    elastic_frame.relaxation.update_activity(elastic, palette, dirty);
                }
            },
        );
        clamped.extend((0..is_clamped.len()).filter(|&tissue| is_clamped[tissue]));
        Ok(())
    }

    /// Finds the dirty inputs and stores them; all are dirty if `everything`.
    fn find_dirty(
        &mut self,
        musculature: &Musculature,
        bones_of: &[FixedBitSet],
        pose: &[ColumnMajor],
        tension: &[f32],
        everything: bool,
    ) {
        let Dirty {
            bones,
            carriers,
            is_everything,
        } = &mut self.dirty;
        *is_everything = everything;
        bones.clear();
        let bits = |matrix: &ColumnMajor| matrix.map(f32::to_bits);
        for (bone, (now, before)) in pose.iter().zip(&mut self.pose).enumerate() {
            if everything || bits(now) != bits(before) {
                bones.insert(bone);
                *before = *now;
            }
        }
        self.dirty_tissues.clear();
        for (tissue, (now, before)) in tension.iter().zip(&mut self.tension).enumerate() {
            let is_tension_dirty = now.to_bits() != before.to_bits();
            *before = *now;
            self.dirty_tissues.set(
                tissue,
                everything || is_tension_dirty || !bones.is_disjoint(&bones_of[tissue]),
            );
        }
        carriers.clear();
        let owners = musculature.carriers().iter().map(|carrier| carrier.tissue);
        let dirty_carriers = owners
            .enumerate()
            .filter(|(_, tissue)| self.dirty_tissues.contains(*tissue));
        carriers.extend(dirty_carriers.map(|(carrier, _)| carrier));
    }

    /// The bones' poses.
    pub fn palette(&self) -> &Palette {
        &self.palette
    }
}
