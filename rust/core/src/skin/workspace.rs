//! The buffers of a frame, and what of the frame before in the same buffers still holds.
//!
//! A frame is a function of its inputs alone; but what the same inputs have given once is the same again, so only what hangs
//! on a bone or a carrier that moved since is computed anew.

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
use crate::skin::safeguard::contact_check::ContactCheck;
use crate::skin::safeguard::frame::GuardFrame;
use crate::skin::safeguard::guard::Guard;
use crate::skin::safeguard::places::PosedPlaces;
use crate::skin::settings::bind::Skinning;
use crate::skin::skinning::dual_quaternion::WIDE_TOLERANCE;
use crate::skin::skinning::dual_quaternion_blend::PreserveVolume;
use crate::skin::skinning::modifier::BoneMaps;
use crate::skin::tissue_change::TissueChange;

/// What a frame's offsets or places were written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Written {
    Nothing,
    Deformed,
    Correction,
}

/// The buffers of a frame, made once a skin.
#[derive(Debug)]
pub(crate) struct Workspace {
    pub bones: BoneMaps,
    pub carriers: Vec<TissueChange>,
    pub elastic: Option<ElasticFrame>,
    pub contact: Option<ContactFrame>,
    pub places: Option<PosedPlaces>,
    pub guard: Option<GuardFrame>,
    pub contact_check: Option<ContactCheck>,
    pub dirty: Dirty,
    /// The last frame's offsets or places, mesh space, and which of the two they are.
    pub output: Vec<[f32; 3]>,
    pub written: Written,
    /// Chunks of the output in which skin meets skin, or, before that is found, in which it did in the frame before.
    pub stale: Vec<bool>,
    /// Number of damped vertices in each chunk of the output.
    pub damped: Vec<usize>,
    palette: Palette,
    pose: Vec<ColumnMajor>,
    tension: Vec<f32>,
    is_clamped: Vec<bool>,
    /// The tissues that are otherwise than in the frame before.
    due: FixedBitSet,
    tracing: PathBuffers,
}

/// What an elastic skin needs of a frame.
#[derive(Debug)]
pub(crate) struct ElasticFrame {
    /// The anchors' own maps: linear ones would collapse a joint before it is relaxed.
    pub bones: PreserveVolume,
    pub relaxation: Relaxation,
}

impl Workspace {
    pub fn new(
        musculature: &Musculature,
        skinning: Skinning,
        elastic: Option<&Elastic>,
        contact: Option<&Contact>,
        guard: Option<&Guard>,
        vertices: usize,
        chunks: usize,
    ) -> Self {
        let skeleton = musculature.skeleton();
        let carriers = musculature.carriers().len();
        Self {
            bones: BoneMaps::at_rest(skinning, skeleton.len()),
            carriers: vec![TissueChange::NONE; carriers],
            elastic: elastic.map(|elastic| ElasticFrame {
                bones: PreserveVolume::at_rest(skeleton.len(), WIDE_TOLERANCE),
                relaxation: Relaxation::new(elastic, vertices),
            }),
            contact: contact.map(ContactFrame::new),
            places: guard.map(|_| PosedPlaces::new(vertices)),
            guard: guard.map(|guard| GuardFrame::new(guard, vertices, skeleton.len())),
            contact_check: contact.map(|_| ContactCheck::new(vertices, skeleton.len())),
            dirty: Dirty {
                bones: FixedBitSet::with_capacity(skeleton.len()),
                carriers: FixedBitSet::with_capacity(carriers),
                is_everything: true,
            },
            output: vec![[0.0; 3]; vertices],
            written: Written::Nothing,
            stale: vec![false; chunks],
            damped: vec![0; chunks],
            palette: Palette::at_rest(skeleton),
            pose: vec![[f32::NAN; 16]; skeleton.len()],
            tension: vec![f32::NAN; musculature.len()],
            is_clamped: vec![false; musculature.len()],
            due: FixedBitSet::with_capacity(musculature.len()),
            tracing: PathBuffers::default(),
        }
    }

    /// Takes on a pose; adds the tissues that came near their floor to `clamped`. `bones_of` are the bones that each tissue
    /// hangs on. After an error the buffers hold no frame.
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
        let was = std::mem::replace(&mut self.written, Written::Nothing);
        musculature.require_tension(tension)?;
        self.palette.set(musculature.skeleton(), pose)?;
        self.written = was;
        self.find_dirty(musculature, bones_of, pose, tension, !holds_a_frame);
        let Self {
            bones,
            carriers,
            elastic: own,
            dirty,
            palette,
            is_clamped,
            due,
            tracing,
            ..
        } = self;
        bones.set(musculature.skeleton(), palette, &dirty.bones);
        if let Some(own) = own {
            own.bones.set(musculature.skeleton(), palette, &dirty.bones);
        }
        let (due, dirty) = (&*due, &*dirty);
        rayon::join(
            || {
                let is_due = |tissue: usize| due.contains(tissue);
                musculature.each_transform(palette, tension, tracing, is_due, |index, carry, clamps| {
                    let rest = &musculature.carriers()[index];
                    carriers[index] = TissueChange::new(&carry, rest);
                    is_clamped[rest.tissue] = clamps;
                });
            },
            || {
                if let Some((own, elastic)) = own.as_mut().zip(elastic) {
                    own.relaxation.update_activity(elastic, palette, dirty);
                }
            },
        );
        clamped.extend((0..is_clamped.len()).filter(|&tissue| is_clamped[tissue]));
        Ok(())
    }

    /// Finds which inputs are otherwise than in the frame before, or takes `everything` for it, and keeps them.
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
        self.due.clear();
        for (tissue, (now, before)) in tension.iter().zip(&mut self.tension).enumerate() {
            let is_tense = now.to_bits() != before.to_bits();
            *before = *now;
            self.due.set(
                tissue,
                everything || is_tense || !bones.is_disjoint(&bones_of[tissue]),
            );
        }
        carriers.clear();
        let owners = musculature.carriers().iter().map(|carrier| carrier.tissue);
        let due = owners
            .enumerate()
            .filter(|(_, tissue)| self.due.contains(*tissue));
        carriers.extend(due.map(|(carrier, _)| carrier));
    }

    /// The bones' poses.
    pub fn palette(&self) -> &Palette {
        &self.palette
    }
}
