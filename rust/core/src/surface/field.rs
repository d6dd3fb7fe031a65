//! The smoothed field of the tissues, whose surface is the skin.

use super::bricks::Bricks;
use super::filter::Filter;
use super::lattice::Lattice;
use super::options::GrowOptions;
use super::progress::Progress;
use super::reduce::{self, Coarse};
use super::smoothing::FieldSampler;
use super::solids::{self, Solid};
use super::{cavities, mirror, repair, voxels};
use crate::error::Result;

/// Width to which thin parts are thickened for a coarser lattice, in its voxels. Interpolation of depths
/// between the voxels of the finer lattice lowers their peaks.
const RESAMPLED: f64 = 1.3;

/// Number of coarser lattices that are tried at most.
const TRIES: usize = 5;

/// The field, and a coarser one if fewer faces are requested.
pub(super) struct Field {
    lattice: Lattice,
    bricks: Bricks,
    coarse: Option<Coarse>,
    /// Indices of the tissues that were thickened, increasing.
    pub thickened: Vec<usize>,
}

impl Field {
    /// The field of `solids`. Thin solids are thickened so that no part of them is lost.
    ///
    /// # Errors
    /// [`crate::Error::Memory`], [`crate::Error::Cancelled`].
    pub fn new(
        solids: &[Solid],
        lattice: Lattice,
        options: &GrowOptions,
        progress: &Progress,
    ) -> Result<Self> {
        let band = filter_of(options).band();
        let limit_bytes = options.memory_limit_bytes;
        let mut raw = voxels::voxelised(solids, lattice, band, limit_bytes, progress)?;
        let mut thickened = vec![];
        let mut keep = |raw: &mut Bricks, lost: Vec<usize>, voxel_m: f64| {
            let round = solids::rounded(solids, &lost, voxel_m);
            let thin = lost.into_iter().filter(|&solid| solids[solid].is_thin(voxel_m));
            thickened.extend(thin.map(|solid| solids[solid].tissue));
            voxels::voxelised(&round, lattice, band, limit_bytes, progress).map(|round| raw.unite(&round))
        };
        let lost = lost_in(&raw, lattice, solids);
        if !lost.is_empty() {
            keep(&mut raw, lost, lattice.voxel_m)?;
        }
        if options.faces.is_none() {
            let mut field = Self::smoothed(raw, lattice, options, progress)?;
            field.thickened = distinct(thickened);
            return Ok(field);
        }
        let mut field = Self::smoothed(raw.clone(), lattice, options, progress)?;
        for _ in 0..TRIES {
            // solids that the fine lattice resolves may be too thin for the coarser one; thickened, they have
            // more faces, which needs a still coarser one
            let Some(coarse) = &field.coarse else { break };
            let lost = lost_in(&coarse.bricks, field.lattice(), solids);
            if lost.is_empty() {
                break;
            }
            keep(&mut raw, lost, RESAMPLED * field.lattice().voxel_m)?;
            field = Self::smoothed(raw.clone(), lattice, options, progress)?;
        }
        field.thickened = distinct(thickened);
        Ok(field)
    }

    fn smoothed(
        mut bricks: Bricks,
        lattice: Lattice,
        options: &GrowOptions,
        progress: &Progress,
    ) -> Result<Self> {
        if options.symmetric {
            mirror::symmetrise(&mut bricks);
        }
        filter_of(options).apply(&mut bricks, progress, 0.45, 0.65)?;
        repair::make_well_composed(&mut bricks);
        cavities::fill_cavities(&mut bricks);
        progress.reach(0.72)?;
        let reduced = |faces| reduce::reduced(&bricks, reduce::faces_of(&bricks), faces);
        let coarse = options.faces.and_then(reduced);
        progress.reach(0.75)?;
        Ok(Self {
            lattice,
            bricks,
            coarse,
            thickened: vec![],
        })
    }

    /// The field from which the surface is extracted.
    pub fn surface(&self) -> &Bricks {
        self.coarse.as_ref().map_or(&self.bricks, |coarse| &coarse.bricks)
    }

    /// The finest field, sampled in voxels of the surface's lattice.
    pub fn sampler(&self) -> FieldSampler<'_> {
        FieldSampler {
            bricks: &self.bricks,
            ratio: self.coarse.as_ref().map_or(1.0, |coarse| coarse.ratio),
        }
    }

    /// The lattice of the surface.
    pub fn lattice(&self) -> Lattice {
        Lattice {
            voxel_m: self.lattice.voxel_m * self.sampler().ratio,
        }
    }
}

fn distinct(mut tissues: Vec<usize>) -> Vec<usize> {
    tissues.sort_unstable();
    tissues.dedup();
    tissues
}

fn filter_of(options: &GrowOptions) -> Filter {
    Filter {
        passes: options.smoothing,
        radius: options.radius,
        decay: options.decay,
    }
}

fn lost_in(bricks: &Bricks, lattice: Lattice, solids: &[Solid]) -> Vec<usize> {
    solids::lost(solids, lattice.voxel_m, |point| {
        bricks.sample(lattice.in_voxels(point)).0 > 0.0
    })
}
