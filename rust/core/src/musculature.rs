//! All tissues of one rig, and how they stand in a pose.
//!
//! Skin hangs on *carriers*: a belly carries with its own motion, all ellipsoids of a rigid tissue carry alike. Today a
//! tissue has one carrier; a curved muscle will have one for each ellipsoid of its chain.

use std::ops::Range;

use glam::{DAffine3, DMat3, DMat4, DVec3};

use crate::ellipsoid::{Ellipsoid, Nearest};
use crate::error::{Error, Result, require, require_distinct};
use crate::muscle::Belly;
use crate::pose::{Palette, Skeleton, require_length};
use crate::tissue::Tissue;

/// The tissues of one rig.
#[derive(Debug, Clone)]
pub struct Musculature {
    skeleton: Skeleton,
    tissues: Vec<Tissue>,
    ellipsoids: Vec<Ellipsoid>,
    carriers: Vec<Carrier>,
}

/// What moves as one: some ellipsoids of a tissue, and the frame in which skin is anchored to them.
#[derive(Debug, Clone)]
pub struct Carrier {
    /// Index of its tissue.
    pub tissue: usize,
    /// Centre of its frame at rest, armature space, m.
    pub centre: DVec3,
    /// Orthonormal axes of its frame at rest.
    pub axes: DMat3,
    ellipsoids: Range<usize>,
}

/// What a pose does to the space around a carrier: a point at `surface + fat` in its rest frame goes to
/// `centre + stretch · surface + turn · fat`.
#[derive(Debug, Clone, Copy)]
pub struct Carry {
    /// Posed centre, armature space, m.
    pub centre: DVec3,
    /// Rest frame to armature space, with the change of shape.
    pub stretch: DMat3,
    /// Rest frame to armature space, without it.
    pub turn: DMat3,
}

/// What one pose did to the tissues.
#[derive(Debug, Clone)]
pub struct PosedMusculature {
    /// Unit sphere to posed tissue (belly, or envelope of a bone), armature space; one a tissue.
    pub matrices: Vec<DMat4>,
    /// Posed over rest belly length, without the rig's scale; 1 for rigid kinds.
    pub stretch: Vec<f64>,
    /// Posed volume, m³.
    pub volume: Vec<f64>,
    /// Indices of the muscles whose belly came near its floor.
    pub clamped: Vec<usize>,
}

impl Musculature {
    /// The musculature of `tissues` on `skeleton`.
    ///
    /// # Errors
    /// A tissue on a bone that the skeleton has not, an empty name, or one that two tissues share.
    pub fn new(skeleton: Skeleton, tissues: Vec<Tissue>) -> Result<Self> {
        require_distinct("tissue", tissues.iter().map(Tissue::name))?;
        for tissue in &tissues {
            require_bone(tissue, "origin", tissue.origin_bone(), skeleton.len())?;
            require_bone(tissue, "insertion", tissue.insertion_bone(), skeleton.len())?;
        }
        let (mut ellipsoids, mut carriers) = (Vec::new(), Vec::new());
        for (index, tissue) in tissues.iter().enumerate() {
            let first = ellipsoids.len();
            ellipsoids.extend_from_slice(tissue.ellipsoids());
            let &Ellipsoid { centre, axes, .. } = tissue.envelope();
            carriers.push(Carrier {
                tissue: index,
                centre,
                axes,
                ellipsoids: first..ellipsoids.len(),
            });
        }
        Ok(Self {
            skeleton,
            tissues,
            ellipsoids,
            carriers,
        })
    }

    /// Number of tissues.
    pub fn len(&self) -> usize {
        self.tissues.len()
    }

    /// True without tissues.
    pub fn is_empty(&self) -> bool {
        self.tissues.is_empty()
    }

    /// The rig.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// The tissues, in order.
    pub fn tissues(&self) -> &[Tissue] {
        &self.tissues
    }

    /// The carriers, in order of their tissues.
    pub fn carriers(&self) -> &[Carrier] {
        &self.carriers
    }

    /// The nearest surface point of the ellipsoids of carrier `carrier`, armature space.
    pub fn nearest(&self, carrier: usize, point: DVec3) -> Nearest {
        let ellipsoids = &self.ellipsoids[self.carriers[carrier].ellipsoids.clone()];
        let (first, others) = (ellipsoids[0], &ellipsoids[1..]);
        others
            .iter()
            .map(|ellipsoid| ellipsoid.nearest(point))
            .fold(first.nearest(point), |best, next| {
                if next.distance_m < best.distance_m {
                    next
                } else {
                    best
                }
            })
    }

    /// A distance, m, that the distance of `point` from carrier `carrier` is never below.
    pub fn distance_bound(&self, carrier: usize, point: DVec3) -> f64 {
        let ellipsoids = &self.ellipsoids[self.carriers[carrier].ellipsoids.clone()];
        ellipsoids
            .iter()
            .map(|ellipsoid| ellipsoid.distance_bound(point))
            .fold(f64::INFINITY, f64::min)
    }

    /// The tissues in a pose; `tension` 0..1, one a tissue.
    ///
    /// # Errors
    /// As [`Musculature::require_tension`].
    pub fn pose(&self, palette: &Palette, tension: &[f32]) -> Result<PosedMusculature> {
        self.require_tension(tension)?;
        let mut posed = PosedMusculature {
            matrices: vec![],
            stretch: vec![],
            volume: vec![],
            clamped: vec![],
        };
        for (index, (tissue, &tension)) in self.tissues.iter().zip(tension).enumerate() {
            let rest = tissue.envelope();
            let bone = tissue.origin_bone();
            match tissue
                .muscle()
                .map(|muscle| muscle.posed(palette, tension.into()))
            {
                Some(belly) => {
                    let semi_axes = rest.semi_axes * belly.shape * belly.scale;
                    let axes = belly.axes * DMat3::from_diagonal(semi_axes);
                    posed.matrices.push(
                        DAffine3 {
                            matrix3: axes,
                            translation: belly.centre,
                        }
                        .into(),
                    );
                    posed.stretch.push(belly.shape.z);
                    posed
                        .volume
                        .push(tissue.volume() * belly.shape.element_product() * belly.scale.powi(3));
                    if belly.is_clamped {
                        posed.clamped.push(index);
                    }
                }
                None => {
                    let axes = rest.axes * DMat3::from_diagonal(rest.semi_axes);
                    let own = DAffine3 {
                        matrix3: axes,
                        translation: rest.centre,
                    };
                    posed.matrices.push((palette.carries()[bone] * own).into());
                    posed.stretch.push(1.0);
                    posed
                        .volume
                        .push(tissue.volume() * palette.scales()[bone].powi(3));
                }
            }
        }
        Ok(posed)
    }

    /// What a pose does to the skin around carrier `carrier`, and whether its belly came near its floor.
    pub fn carry(&self, carrier: usize, palette: &Palette, tension: f32) -> (Carry, bool) {
        let Carrier {
            tissue, centre, axes, ..
        } = self.carriers[carrier];
        let tissue = &self.tissues[tissue];
        match tissue
            .muscle()
            .map(|muscle| muscle.posed(palette, tension.into()))
        {
            Some(Belly {
                centre,
                axes,
                scale,
                shape,
                is_clamped,
            }) => {
                let turn = axes * scale;
                (
                    Carry {
                        centre,
                        stretch: turn * DMat3::from_diagonal(shape),
                        turn,
                    },
                    is_clamped,
                )
            }
            None => {
                let bone = palette.carries()[tissue.origin_bone()];
                let turn = bone.matrix3 * axes;
                (
                    Carry {
                        centre: bone.transform_point3(centre),
                        stretch: turn,
                        turn,
                    },
                    false,
                )
            }
        }
    }

    /// Fails unless `tension` has a number 0..1 for each tissue.
    ///
    /// # Errors
    /// [`Error::Length`] or [`Error::Value`], naming the tissue.
    pub fn require_tension(&self, tension: &[f32]) -> Result<()> {
        require_length("tension", self.tissues.len(), "one a tissue", tension.len())?;
        for (tissue, &found) in self.tissues.iter().zip(tension) {
            let thing = || format!("tissue \"{}\"", tissue.name());
            require(
                (0.0..=1.0).contains(&found),
                thing,
                "its tension",
                found.into(),
                "0 to 1",
            )?;
        }
        Ok(())
    }
}

fn require_bone(tissue: &Tissue, end: &'static str, bone: usize, limit: usize) -> Result<()> {
    if bone < limit {
        return Ok(());
    }
    Err(Error::UnknownBone {
        tissue: tissue.name().to_owned(),
        end,
        found: bone as i64,
        limit,
    })
}
