//! The buffers of a frame, and what of the frame before in the same buffers still holds.
//!
//! A frame is a function of its inputs alone; but what the same inputs have given once is the same again, so only what hangs
//! on a bone or a carrier that moved since is computed anew.

use fixedbitset::FixedBitSet;
use glam::{DMat3, DVec3, Mat3A, Vec3A};

use super::Skinning;
use super::contact::{Contact, ContactFrame};
use super::dual_quaternion::WIDE_TOLERANCE;
use super::elastic::{Elastic, Relaxation};
use super::preserve_volume::PreserveVolume;
use super::skinning::BoneMaps;
use crate::course::Tracing;
use crate::error::Result;
use crate::musculature::{Carrier, Musculature};
use crate::pose::{ColumnMajor, Palette};
use crate::posing::Carry;

/// What a pose does to the skin around one carrier, less what is there at rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct CarryChange {
    /// Change of the widths alone, in the posed axes: what the two axes across the belly become longer by.
    pub swelling: [Vec3A; 2],
    /// Change of the map of surface points.
    pub stretch: Mat3A,
    /// Change of the map of fat.
    pub turn: Mat3A,
    /// Change of place, m.
    pub shift: Vec3A,
}

impl CarryChange {
    const NONE: Self = Self {
        swelling: [Vec3A::ZERO; 2],
        stretch: Mat3A::ZERO,
        turn: Mat3A::ZERO,
        shift: Vec3A::ZERO,
    };

    fn new(carry: &Carry, rest: &Carrier) -> Self {
        let narrow = |matrix: DMat3| Mat3A::from(matrix.as_mat3());
        Self {
            swelling: widening(carry).map(|axis| axis.as_vec3a()),
            stretch: narrow(carry.stretch - rest.axes),
            turn: narrow(carry.turn - rest.axes),
            shift: (carry.centre - rest.centre).as_vec3a(),
        }
    }
}

/// The two columns of `σ R (S - 1)` across the belly. The bones hold the skin along a limb; taking it along with the ends of
/// the bellies as well opened the crook of the knee and lost volume: at 140° the body's knee kept 0.766 of it, without 0.787.
fn widening(carry: &Carry) -> [DVec3; 2] {
    let change = carry.stretch - carry.turn;
    [change.x_axis, change.y_axis]
}

/// Which inputs of a frame differ from those of the frame before it in the same buffers.
#[derive(Debug)]
pub(super) struct Moved {
    bones: FixedBitSet,
    carriers: FixedBitSet,
    is_everything: bool,
}

impl Moved {
    /// True where nothing of an earlier frame holds.
    pub fn is_everything(&self) -> bool {
        self.is_everything
    }

    /// True where nothing moved at all.
    pub fn is_nothing(&self) -> bool {
        !self.is_everything && self.bones.is_clear() && self.carriers.is_clear()
    }

    /// Whether any of some bones or carriers moved.
    pub fn any_of(&self, bones: &FixedBitSet, carriers: &FixedBitSet) -> bool {
        self.is_everything || !self.bones.is_disjoint(bones) || !self.carriers.is_disjoint(carriers)
    }
}

/// What a frame's offsets or places were written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Written {
    Nothing,
    Deformed,
    Correction,
}

/// The buffers of a frame, made once a skin.
#[derive(Debug)]
pub(super) struct Workspace {
    pub bones: BoneMaps,
    pub carriers: Vec<CarryChange>,
    pub elastic: Option<ElasticFrame>,
    pub contact: Option<ContactFrame>,
    pub moved: Moved,
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
    tracing: Tracing,
}

/// What an elastic skin needs of a frame.
#[derive(Debug)]
pub(super) struct ElasticFrame {
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
        vertices: usize,
        chunks: usize,
    ) -> Self {
        let skeleton = musculature.skeleton();
        let carriers = musculature.carriers().len();
        Self {
            bones: BoneMaps::at_rest(skinning, skeleton.len()),
            carriers: vec![CarryChange::NONE; carriers],
            elastic: elastic.map(|elastic| ElasticFrame {
                bones: PreserveVolume::at_rest(skeleton.len(), WIDE_TOLERANCE),
                relaxation: Relaxation::new(elastic, vertices),
            }),
            contact: contact.map(ContactFrame::new),
            moved: Moved {
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
            tracing: Tracing::default(),
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
        self.find_moved(musculature, bones_of, pose, tension, !holds_a_frame);
        let Self {
            bones,
            carriers,
            elastic: own,
            moved,
            palette,
            is_clamped,
            due,
            tracing,
            ..
        } = self;
        bones.set(musculature.skeleton(), palette, &moved.bones);
        if let Some(own) = own {
            own.bones.set(musculature.skeleton(), palette, &moved.bones);
        }
        let (due, moved) = (&*due, &*moved);
        rayon::join(
            || {
                let is_due = |tissue: usize| due.contains(tissue);
                musculature.carry_each(palette, tension, tracing, is_due, |index, carry, clamps| {
                    let rest = &musculature.carriers()[index];
                    carriers[index] = CarryChange::new(&carry, rest);
                    is_clamped[rest.tissue] = clamps;
                });
            },
            || {
                if let Some((own, elastic)) = own.as_mut().zip(elastic) {
                    own.relaxation.wake(elastic, palette, moved);
                }
            },
        );
        clamped.extend((0..is_clamped.len()).filter(|&tissue| is_clamped[tissue]));
        Ok(())
    }

    /// Finds which inputs are otherwise than in the frame before, or takes `everything` for it, and keeps them.
    fn find_moved(
        &mut self,
        musculature: &Musculature,
        bones_of: &[FixedBitSet],
        pose: &[ColumnMajor],
        tension: &[f32],
        everything: bool,
    ) {
        let Moved {
            bones,
            carriers,
            is_everything,
        } = &mut self.moved;
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
