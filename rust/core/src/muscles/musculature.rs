//! All tissues of one rig in the rest pose. `posing` computes them in other poses.
//!
//! Skin is moved by *carriers*. A rigid tissue and a straight muscle have one carrier each. A curved muscle
//! has one for each ellipsoid of its chain.

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

/// Distance of a path from a sphere that it wraps around, over the smaller width of the belly: half of the
/// belly is compressed.
const CLEARANCE: f64 = 0.5;

/// The tissues of one rig.
///
/// ```
/// use sinew_core::{Musculature, Palette, Skeleton, Tissue, TissueDescription, TissueKind};
///
/// # fn main() -> sinew_core::Result<()> {
/// let at = |x: f32| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., x, 0., 0., 1.];
/// let names = vec!["upper".to_owned(), "lower".to_owned()];
/// let skeleton = Skeleton::new(names, &[-1, 0], &[at(0.0), at(0.3)])?;
/// let biceps = Tissue::new(TissueDescription {
///     name: "biceps".to_owned(),
///     kind: TissueKind::Muscle,
///     origin_bone: 0,
///     insertion_bone: 1,
///     centre: [0.2, 0.0, 0.04],
///     rotation: [0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt(), 0.0], // z along armature x
///     semi_axes: [0.02, 0.02, 0.1],
///     origin_tendon_m: 0.05,
///     insertion_tendon_m: 0.02,
///     volume_keeping: 1.0,
///     via_points: vec![],
///     wraps: vec![],
/// })?;
/// let musculature = Musculature::new(skeleton, vec![biceps])?;
///
/// // the lower bone moves 4 cm towards the upper one: the belly shortens and keeps its volume
/// let pose = Palette::new(musculature.skeleton(), &[at(0.0), at(0.26)])?;
/// let posed = musculature.pose(&pose, &[0.0])?;
/// assert!((posed.stretch[0] - 0.8).abs() < 1e-6);
/// assert!((posed.volume[0] / musculature.tissues()[0].volume() - 1.0).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Musculature {
    skeleton: Skeleton,
    tissues: Vec<Tissue>,
    /// The chain of each tissue; `None` unless it is a curved muscle.
    chains: Vec<Option<BellyChain>>,
    ellipsoids: Vec<Ellipsoid>,
    /// The tissue of each ellipsoid.
    owners: Vec<usize>,
    carriers: Vec<Carrier>,
}

/// A part of a tissue that moves skin as a unit: some of its ellipsoids, and the axes to which skin is
/// anchored.
#[derive(Debug, Clone)]
pub struct Carrier {
    /// Index of its tissue.
    pub tissue: usize,
    /// The origin of its axes at rest, armature space, m.
    pub centre: DVec3,
    /// Its orthonormal axes at rest.
    pub axes: DMat3,
    ellipsoids: Range<usize>,
}

impl Musculature {
    /// The musculature of `tissues` on `skeleton`.
    ///
    /// # Errors
    /// [`Error::UnknownBone`] for a tissue on a bone that is not in the skeleton; [`Error::Nameless`] or
    /// [`Error::Duplicate`]; [`Error::UnknownWrap`] or [`Error::WrapOfOtherKind`] for a wrap around something
    /// that is not a sphere of these tissues.
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
            let mut add = |frame: &Ellipsoid, tissue_ellipsoids: &[Ellipsoid]| {
                let first = ellipsoids.len();
                ellipsoids.extend_from_slice(tissue_ellipsoids);
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

    /// True if there are no tissues.
    pub fn is_empty(&self) -> bool {
        self.tissues.is_empty()
    }

    /// The bones that the tissues are on.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// The tissues, in order.
    pub fn tissues(&self) -> &[Tissue] {
        &self.tissues
    }

    /// The chain of each tissue; `None` unless it is a curved muscle.
    pub(crate) fn chains(&self) -> &[Option<BellyChain>] {
        &self.chains
    }

    /// All ellipsoids at rest, ordered by tissue, armature space, m.
    pub fn ellipsoids(&self) -> &[Ellipsoid] {
        &self.ellipsoids
    }

    /// Index of the tissue of each ellipsoid, never decreasing.
    pub fn ellipsoid_tissues(&self) -> &[usize] {
        &self.owners
    }

    /// The bones that tissue `tissue` is attached to, those between its ends, and those of its via points.
    pub fn bones_of(&self, tissue: usize) -> Vec<usize> {
        let tissue_ellipsoids = &self.tissues[tissue];
        let mut bones = self.skeleton.path(
            tissue_ellipsoids.origin_bone(),
            tissue_ellipsoids.insertion_bone(),
        );
        bones.extend(
            tissue_ellipsoids
                .via_points()
                .iter()
                .map(|via_point| via_point.bone),
        );
        bones
    }

    /// All bones whose pose tissue `tissue` depends on: those of [`Musculature::bones_of`] and of the spheres
    /// that it wraps around.
    pub(crate) fn needs_of(&self, tissue: usize) -> FixedBitSet {
        let tissue_ellipsoids = &self.tissues[tissue];
        let mut bones = FixedBitSet::with_capacity(self.skeleton.len());
        bones.extend(self.bones_of(tissue));
        let spheres = self
            .tissues
            .iter()
            .filter(|other| tissue_ellipsoids.wraps().iter().any(|wrap| wrap == other.name()));
        bones.extend(spheres.map(Tissue::origin_bone));
        bones
    }

    /// The carriers, ordered by tissue.
    pub fn carriers(&self) -> &[Carrier] {
        &self.carriers
    }

    /// The ellipsoids of carrier `carrier` at rest, armature space.
    pub(crate) fn ellipsoids_of(&self, carrier: usize) -> &[Ellipsoid] {
        &self.ellipsoids[self.carriers[carrier].ellipsoids.clone()]
    }

    /// The point nearest to `point` on the ellipsoids of carrier `carrier`, armature space, m.
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

    /// The unit outward normal of carrier `carrier` at its surface point nearest to `point`.
    pub(crate) fn normal_towards(&self, carrier: usize, point: DVec3) -> DVec3 {
        let ellipsoids = self.ellipsoids_of(carrier).iter();
        let with_distance = ellipsoids.map(|ellipsoid| (ellipsoid, ellipsoid.nearest(point).distance_m));
        let nearest = with_distance.reduce(|best, next| if next.1 < best.1 { next } else { best });
        nearest.map_or(DVec3::ZERO, |(ellipsoid, _)| ellipsoid.normal_towards(point))
    }

    /// The ellipsoid of carrier `carrier`, if it is of a muscle.
    pub(crate) fn belly_of(&self, carrier: usize) -> Option<&Ellipsoid> {
        let is_muscle = self.tissues[self.carriers[carrier].tissue].muscle().is_some();
        is_muscle.then(|| &self.ellipsoids_of(carrier)[0])
    }

    /// A lower bound, m, of the distance of `point` from carrier `carrier`.
    pub fn distance_bound(&self, carrier: usize, point: DVec3) -> f64 {
        let ellipsoids = self.ellipsoids_of(carrier);
        ellipsoids
            .iter()
            .map(|ellipsoid| ellipsoid.distance_bound(point))
            .fold(f64::INFINITY, f64::min)
    }

    /// Checks that `tension` has a number 0..1 for each tissue.
    ///
    /// # Errors
    /// [`Error::Length`], or [`Error::Value`] that names the tissue.
    pub fn require_tension(&self, tension: &[f32]) -> Result<()> {
        require_length("tension", self.tissues.len(), "one per tissue", tension.len())?;
        for (tissue, &found) in self.tissues.iter().zip(tension) {
            let thing = || format!("Tissue \"{}\"", tissue.name());
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

/// The chain of a curved muscle. `tissues` are all tissues of the rig.
fn chain_of(tissue: &Tissue, muscle: &Muscle, tissues: &[Tissue], at_rest: &Palette) -> Result<BellyChain> {
    let sphere = |wrap: &String| {
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
    let spheres = tissue.wraps().iter().map(sphere).collect::<Result<Vec<_>>>()?;
    let mut nodes = vec![muscle.origin];
    nodes.extend_from_slice(tissue.via_points());
    nodes.push(muscle.insertion);
    let belly = *tissue.envelope();
    let clearance_m = CLEARANCE * belly.semi_axes.x.min(belly.semi_axes.y);
    let muscle_path = MusclePath::new(nodes, &spheres, clearance_m, belly.axes.x_axis);
    Ok(BellyChain::new(muscle_path, muscle, belly, at_rest))
}
