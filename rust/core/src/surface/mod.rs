//! A skin grown from the tissues, for characters that no artist has modelled (ALGORITHM 7; Wilhelms 1997).
//!
//! The tissues in the rest pose become depths on a lattice (`voxels`), these are smoothed without losing anything (`filter`),
//! and the surface between inside and outside becomes quads (`extract`): a closed manifold whatever the tissues are
//! (`repair`), of well-shaped faces (`smoothing`), symmetric where the tissues are (`mirror`), weighed by bones (`weights`).

mod bricks;
mod cavities;
mod extract;
mod field;
mod filter;
mod islands;
mod lattice;
mod mirror;
mod neighbours;
mod options;
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

/// What the shape of a face is not below: 4√3 · area over the squared edges, of the worse triangle of a quad (1 is
/// equilateral, a sliver 0).
pub const LEAST_QUALITY: f64 = 0.1;

/// A skin grown in the rest pose.
#[derive(Debug, Clone)]
pub struct GrownSkin {
    /// Vertices, armature space, m.
    pub points: Vec<[f32; 3]>,
    /// Corners of the faces, counter-clockwise seen from outside.
    pub quads: Vec<[i32; 4]>,
    /// Where the bone weights of each vertex start; one more than vertices.
    pub weight_offsets: Vec<i32>,
    /// The bone of each weight.
    pub weight_bones: Vec<i32>,
    /// The weights; those of a vertex sum to 1, the heaviest first.
    pub weights: Vec<f32>,
    /// What was met.
    pub report: GrowReport,
}

/// What was met when a skin was grown.
#[derive(Debug, Clone)]
pub struct GrowReport {
    /// Length of a voxel's edge, m: of the lattice that the faces stand on.
    pub voxel_m: f64,
    /// Tissues that were thinner than a voxel, stood out of the others and were thickened to be kept, rising.
    pub thickened: Vec<usize>,
    /// Pieces that do not hang together, before any was dropped.
    pub pieces: usize,
    /// Shape of the worst face, see [`LEAST_QUALITY`].
    pub worst_quality: f64,
    /// How far the anatomy stands out of the skin at most, m.
    pub protrusion_m: f64,
    /// The tissue that stands out so far.
    pub protruding: Option<usize>,
}

/// Grows a skin over all tissues of `musculature` in the rest pose.
///
/// `thickness_m`: of the skin over each tissue, added to that of `options`.
///
/// # Errors
/// Lists of other lengths than tissues and bones, values outside their limits, no tissues, [`Error::Memory`] before too much
/// memory is taken, [`Error::Cancelled`] once `progress` was cancelled.
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
    let (ground, lattice) = (field.ground(), field.lattice());
    let mut mesh = extract::extract(field.surface());
    progress.reach(0.8)?;
    let pieces = islands::pieces(&mesh);
    let piece_count = islands::count(&pieces);
    if options.largest_only && piece_count > 1 {
        islands::keep_largest(&mut mesh, &pieces);
    }
    smoothing::relax(&mut mesh, ground, LEAST_QUALITY);
    progress.reach(0.9)?;
    let weights = weights::weights_of(&mesh, lattice, musculature, bones, size_m);
    progress.reach(0.97)?;
    let (protrusion_m, ellipsoid) = protrusion::largest(musculature.ellipsoids(), &mesh, lattice, ground);
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
        let point = |place: &DVec3| lattice.point(*place).as_vec3().to_array();
        let mut weight_offsets = vec![0];
        weight_offsets.extend(weights.iter().scan(0, |sum, row| {
            *sum += row.len() as i32;
            Some(*sum)
        }));
        Self {
            points: mesh.places.iter().map(point).collect(),
            quads: mesh
                .quads
                .iter()
                .map(|quad| quad.map(|corner| corner as i32))
                .collect(),
            weight_offsets,
            weight_bones: weights.iter().flatten().map(|entry| entry.0 as i32).collect(),
            weights: weights.iter().flatten().map(|entry| entry.1).collect(),
            report,
        }
    }
}

fn require_bones(musculature: &Musculature, bones: SkinBones) -> Result<()> {
    let count = musculature.skeleton().len();
    require_length("bone_lengths", count, "one a bone", bones.lengths_m.len())?;
    require_length("stand_ins", count, "one a bone", bones.stand_ins.len())?;
    for (position, &found) in bones.stand_ins.iter().enumerate() {
        if found >= count {
            return Err(Error::Index {
                list: "stand_ins",
                position,
                found: found as i64,
                limit: count,
                of: "bones",
            });
        }
    }
    Ok(())
}

fn thickness_of(musculature: &Musculature, own_m: &[f32], overall_m: f64) -> Result<Vec<f64>> {
    require_length("thickness", musculature.len(), "one a tissue", own_m.len())?;
    let checked = musculature.tissues().iter().zip(own_m).map(|(tissue, &found)| {
        let thing = || format!("tissue \"{}\"", tissue.name());
        let allowed = found.is_finite() && found >= 0.0;
        let quantity = "the thickness of the skin over it (m)";
        let own = require(allowed, thing, quantity, found.into(), "finite and 0 or more")?;
        Ok(overall_m + own)
    });
    checked.collect()
}
