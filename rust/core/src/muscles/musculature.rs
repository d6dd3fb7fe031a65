//! All tissues of one rig in the rest pose; `posing` says how they stand in another.
//!
//! Skin hangs on *carriers*: a belly carries with its own motion, all ellipsoids of a rigid tissue carry alike. A tissue has
//! one carrier; a curved muscle has one for each ellipsoid of its chain.

use std::ops::Range;

use fixedbitset::FixedBitSet;
use glam::{DMat3, DVec3};

use crate::ellipsoid::{Ellipsoid, Nearest};
use crate::error::{Error, Result, require, require_distinct, require_length};
use crate::muscles::belly_chain::BellyChain;
use crate::muscles::muscle::Muscle;
use crate::muscles::muscle_path::{MusclePath, WrapSphere};
use crate::muscles::tissue::{Tissue, TissueKind};
use crate::pose::{Palette, Skeleton};

/// Distance that a path keeps from a sphere that it goes round, over the smaller width of its belly: half of the belly
/// gives way, as flesh does.
const CLEARANCE: f64 = 0.5;

/// The tissues of one rig.
#[derive(Debug, Clone)]
pub struct Musculature {
    skeleton: Skeleton,
    tissues: Vec<Tissue>,
    /// The curved ones' chains.
    chains: Vec<Option<BellyChain>>,
    ellipsoids: Vec<Ellipsoid>,
    /// Index of each ellipsoid's tissue.
    owners: Vec<usize>,
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

impl Musculature {
    /// The musculature of `tissues` on `skeleton`.
    ///
    /// # Errors
    /// A tissue on a bone that the skeleton has not, an empty name, or one that two tissues share, a wrap round something
    /// that is no sphere of these tissues.
    pub fn new(skeleton: Skeleton, tissues: Vec<Tissue>) -> Result<Self> {
        require_distinct("tissue", tissues.iter().map(Tissue::name))?;
        for tissue in &tissues {
            require_bone(tissue, "origin", tissue.origin_bone(), skeleton.len())?;
            require_bone(tissue, "insertion", tissue.insertion_bone(), skeleton.len())?;
            for via_point in tissue.via_points() {
                require_bone(tissue, "via point's", via_point.bone, skeleton.len())?;
            }
        }
        let at_rest = Palette::at_rest(&skeleton);
        let chain_of = |tissue: &Tissue| match tissue.muscle() {
            Some(muscle) if tissue.is_curved() => chain_of(tissue, muscle, &tissues, &at_rest).map(Some),
            _ => Ok(None),
        };
        let chains = tissues.iter().map(chain_of).collect::<Result<Vec<_>>>()?;
        let (mut ellipsoids, mut owners, mut carriers) = (vec![], vec![], vec![]);
        for (index, (tissue, chain)) in tissues.iter().zip(&chains).enumerate() {
            let mut add = |frame: &Ellipsoid, own: &[Ellipsoid]| {
                let first = ellipsoids.len();
                ellipsoids.extend_from_slice(own);
                owners.resize(ellipsoids.len(), index);
                carriers.push(Carrier {
                    tissue: index,
                    centre: frame.centre,
                    axes: frame.axes,
                    ellipsoids: first..ellipsoids.len(),
                });
            };
            match chain {
                Some(chain) => chain.links().iter().for_each(|link| add(link, &[*link])),
                None => add(tissue.envelope(), tissue.ellipsoids()),
            }
        }
        Ok(Self {
            skeleton,
            tissues,
            chains,
            ellipsoids,
            owners,
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

    /// The chain of each tissue, `None` but for curved muscles.
    pub(crate) fn chains(&self) -> &[Option<BellyChain>] {
        &self.chains
    }

    /// All ellipsoids at rest, in order of their tissues, armature space.
    pub fn ellipsoids(&self) -> &[Ellipsoid] {
        &self.ellipsoids
    }

    /// Index of the tissue of each ellipsoid, rising.
    pub fn ellipsoid_tissues(&self) -> &[usize] {
        &self.owners
    }

    /// The bones that carry tissue `tissue`, and those between its ends.
    pub fn bones_of(&self, tissue: usize) -> Vec<usize> {
        let own = &self.tissues[tissue];
        let mut bones = self.skeleton.path(own.origin_bone(), own.insertion_bone());
        bones.extend(own.via_points().iter().map(|via_point| via_point.bone));
        bones
    }

    /// All bones whose pose tissue `tissue` depends on: those of its points, and of the spheres that it goes round.
    pub(crate) fn needs_of(&self, tissue: usize) -> FixedBitSet {
        let own = &self.tissues[tissue];
        let mut bones = FixedBitSet::with_capacity(self.skeleton.len());
        bones.extend(self.bones_of(tissue));
        let spheres = self
            .tissues
            .iter()
            .filter(|other| own.wraps().iter().any(|wrap| wrap == other.name()));
        bones.extend(spheres.map(Tissue::origin_bone));
        bones
    }

    /// The carriers, in order of their tissues.
    pub fn carriers(&self) -> &[Carrier] {
        &self.carriers
    }

    /// The ellipsoids of carrier `carrier` at rest, armature space.
    pub(crate) fn ellipsoids_of(&self, carrier: usize) -> &[Ellipsoid] {
        &self.ellipsoids[self.carriers[carrier].ellipsoids.clone()]
    }

    /// The nearest surface point of the ellipsoids of carrier `carrier`, armature space.
    pub fn nearest(&self, carrier: usize, point: DVec3) -> Nearest {
        let ellipsoids = self.ellipsoids_of(carrier);
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
        let ellipsoids = self.ellipsoids_of(carrier);
        ellipsoids
            .iter()
            .map(|ellipsoid| ellipsoid.distance_bound(point))
            .fold(f64::INFINITY, f64::min)
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

/// The chain of a curved muscle among all `tissues`.
fn chain_of(tissue: &Tissue, muscle: &Muscle, tissues: &[Tissue], at_rest: &Palette) -> Result<BellyChain> {
    let ball = |wrap: &String| {
        let names = || (tissue.name().to_owned(), wrap.clone());
        match tissues.iter().find(|other| other.name() == wrap) {
            Some(sphere) if sphere.kind() == TissueKind::Sphere => Ok(WrapSphere {
                bone: sphere.origin_bone(),
                centre: sphere.envelope().centre,
                radius_m: sphere.envelope().semi_axes.max_element(),
            }),
            Some(_) => {
                let (tissue, wrap) = names();
                Err(Error::WrapOfOtherKind { tissue, wrap })
            }
            None => {
                let (tissue, wrap) = names();
                Err(Error::UnknownWrap { tissue, wrap })
            }
        }
    };
    let balls = tissue.wraps().iter().map(ball).collect::<Result<Vec<_>>>()?;
    let mut nodes = vec![muscle.origin];
    nodes.extend_from_slice(tissue.via_points());
    nodes.push(muscle.insertion);
    let belly = *tissue.envelope();
    let clearance_m = CLEARANCE * belly.semi_axes.x.min(belly.semi_axes.y);
    let course = MusclePath::new(nodes, &balls, clearance_m, belly.axes.x_axis);
    Ok(BellyChain::new(course, muscle, belly, at_rest))
}
