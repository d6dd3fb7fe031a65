//! A skin grown from the tissues, for characters without a modelled mesh (mathematics/growing.md; Wilhelms
//! 1997).
//!
//! The tissues in the rest pose are converted to depths on a lattice (`voxels`). The depths are smoothed
//! without losing volume (`filter`) and made manifold (`repair`). The surface between inside and outside is
//! extracted as quads (`extract`), evened out (`smoothing`), made symmetric where the tissues are (`mirror`),
//! and weighted to bones (`weights`).

mod bricks;
mod cavities;
mod extract;
mod field;
mod filter;
mod lattice;
mod mirror;
mod neighbours;
mod options;
mod pieces;
mod progress;
mod protrusion;
mod quality;
mod reduce;
mod repair;
mod smoothing;
mod solids;
mod voxels;
mod weights;

use glam::DVec3;

use extract::QuadMesh;
use field::Field;
use lattice::Lattice;
pub use options::GrowOptions;
pub use progress::Progress;
pub use weights::SkinBones;

use crate::error::require_length;
use crate::error::{Error, Result, require};
use crate::muscles::musculature::Musculature;
use crate::skin::WeightRows;

/// Smallest quality of a face that [`grow`] tries to reach: 4√3 · area over the sum of the squared edges, of
/// the worse triangle of a quad. 1 is equilateral, 0 is degenerate.
pub const LEAST_QUALITY: f64 = 0.1;

/// A skin grown in the rest pose.
#[derive(Debug, Clone)]
pub struct GrownSkin {
    /// Vertices, armature space, m.
    pub points: Vec<[f32; 3]>,
    /// Corners of the faces, counter-clockwise seen from outside.
    pub quads: Vec<[i32; 4]>,
    /// The bone weights of each vertex, the largest first.
    pub weights: WeightRows,
    /// Measurements of the result.
    pub report: GrowReport,
}

/// Measurements of a grown skin.
#[derive(Debug, Clone)]
pub struct GrowReport {
    /// Edge length of a voxel of the lattice that the faces come from, m.
    pub voxel_m: f64,
    /// Indices of the tissues that were thickened because they protruded and were thinner than a voxel,
    /// increasing.
    pub thickened: Vec<usize>,
    /// Number of connected pieces, before any was removed.
    pub pieces: usize,
    /// Quality of the worst face, see [`LEAST_QUALITY`].
    pub worst_quality: f64,
    /// Largest distance by which the anatomy protrudes from the skin, m.
    pub protrusion_m: f64,
    /// Index of the tissue that protrudes most.
    pub protruding: Option<usize>,
}

/// Grows a skin over all tissues of `musculature` in the rest pose.
///
/// `thickness_m`: thickness of the skin over each tissue, added to that of `options`.
///
/// # Errors
/// [`Error::Length`] or [`Error::Index`] for lists that do not fit tissues and bones; [`Error::Value`] for
/// values outside their limits; [`Error::NoTissues`]; [`Error::Memory`], before the memory is allocated;
/// [`Error::Cancelled`].
///
/// ```
/// use sinew_core::{
///     GrowOptions, Musculature, Progress, Skeleton, SkinBones, Tissue, TissueDescription, TissueKind, grow,
/// };
///
/// # fn main() -> sinew_core::Result<()> {
/// let rest = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
/// let skeleton = Skeleton::new(vec!["spine".to_owned()], &[-1], &[rest])?;
/// let belly = Tissue::new(TissueDescription {
///     name: "belly".to_owned(),
///     kind: TissueKind::Stuffing,
///     origin_bone: 0,
///     insertion_bone: 0,
///     centre: [0.0, 0.2, 0.0],
///     rotation: [1.0, 0.0, 0.0, 0.0],
///     semi_axes: [0.15, 0.25, 0.1],
///     origin_tendon_m: 0.0,
///     insertion_tendon_m: 0.0,
///     volume_keeping: 1.0,
///     via_points: vec![],
///     wraps: vec![],
/// })?;
/// let musculature = Musculature::new(skeleton, vec![belly])?;
/// let bones = SkinBones { lengths_m: &[0.4], weight_bones: &[0] };
/// let options = GrowOptions { resolution: 24, ..GrowOptions::default() };
/// let skin = grow(&musculature, &[0.01], bones, &options, &Progress::default())?;
/// assert_eq!(skin.report.pieces, 1);
/// assert_eq!(skin.weights.offsets.len(), skin.points.len() + 1);
/// # Ok(())
/// # }
/// ```
pub fn grow(
    musculature: &Musculature,
    thickness_m: &[f32],
    bones: SkinBones,
    options: &GrowOptions,
    progress: &Progress,
) -> Result<GrownSkin> {
    options.require_sound()?;
    require_bones(musculature, bones)?;
    if musculature.is_empty() {
        return Err(Error::NoTissues);
    }
    let thickness_m = thickness_of(musculature, thickness_m, options.thickness_m)?;
    let solids = solids::solids_of(musculature, &thickness_m);
    let (low, high) = solids::bounds_of(&solids);
    let size_m = (high - low).max_element();
    let lattice = Lattice {
        voxel_m: size_m / f64::from(options.resolution),
    };
    let field = Field::new(&solids, lattice, options, progress)?;
    let (sampler, lattice) = (field.sampler(), field.lattice());
    let mut mesh = extract::extract(field.surface());
    progress.reach(0.8)?;
    let pieces = pieces::pieces(&mesh);
    let piece_count = pieces::count(&pieces);
    if options.largest_only && piece_count > 1 {
        pieces::keep_largest(&mut mesh, &pieces);
    }
    smoothing::relax(&mut mesh, sampler, LEAST_QUALITY);
    progress.reach(0.9)?;
    let weights = weights::weights_of(&mesh, lattice, musculature, bones, size_m);
    progress.reach(0.97)?;
    let (protrusion_m, ellipsoid) = protrusion::largest(musculature.ellipsoids(), &mesh, lattice, sampler);
    let qualities = mesh.quads.iter().map(|quad| smoothing::quality_of(&mesh, quad));
    let report = GrowReport {
        voxel_m: lattice.voxel_m,
        thickened: field.thickened,
        pieces: piece_count,
        worst_quality: qualities.fold(1.0, f64::min),
        protrusion_m,
        protruding: ellipsoid.map(|index| musculature.ellipsoid_tissues()[index]),
    };
    progress.reach(1.0)?;
    Ok(GrownSkin::new(&mesh, lattice, &weights, report))
}

impl GrownSkin {
    fn new(mesh: &QuadMesh, lattice: Lattice, weights: &[weights::Weights], report: GrowReport) -> Self {
        let point = |position: &DVec3| lattice.point(*position).as_vec3().to_array();
        Self {
            points: mesh.positions.iter().map(point).collect(),
            quads: mesh
                .quads
                .iter()
                .map(|quad| quad.map(|corner| corner as i32))
                .collect(),
            weights: WeightRows::new(weights.iter().map(|row| row.iter().copied())),
            report,
        }
    }
}

fn require_bones(musculature: &Musculature, bones: SkinBones) -> Result<()> {
    let count = musculature.skeleton().len();
    require_length("bone_lengths", count, "one per bone", bones.lengths_m.len())?;
    require_length("weight_bones", count, "one per bone", bones.weight_bones.len())?;
    for (position, &found) in bones.weight_bones.iter().enumerate() {
        if found >= count {
            return Err(Error::Index {
                list: "weight_bones",
                position,
                found: found as i64,
                limit: count,
                of: "bones",
            });
        }
    }
    Ok(())
}

fn thickness_of(musculature: &Musculature, extra_m: &[f32], overall_m: f64) -> Result<Vec<f64>> {
    require_length("thickness", musculature.len(), "one per tissue", extra_m.len())?;
    let checked = musculature.tissues().iter().zip(extra_m).map(|(tissue, &found)| {
        let thing = || format!("Tissue \"{}\"", tissue.name());
        let allowed = found.is_finite() && found >= 0.0;
        let quantity = "the thickness of the skin over it (m)";
        let extra = require(allowed, thing, quantity, found.into(), "finite and 0 or more")?;
        Ok(overall_m + extra)
    });
    checked.collect()
}
