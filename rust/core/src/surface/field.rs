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

/// Widths, in voxels of a coarser lattice, of a thread that is kept there: between the voxels of the finer one, depths are
/// interpolated, which takes the tops off.
const RESAMPLED: f64 = 1.3;

/// Most coarser lattices that are tried.
const TRIES: usize = 5;

/// The field, and the coarser one that faces stand on where fewer are wanted.
pub(super) struct Field {
    lattice: Lattice,
    bricks: Bricks,
    coarse: Option<Coarse>,
    /// Tissues that were thickened to be kept, rising.
    pub thickened: Vec<usize>,
}

impl Field {
    /// The field of `solids`; of each nothing is lost, however thin it is.
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
            // what the lattice holds may be too thin for the coarser one; thickened, it has more faces, for a still coarser one
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

    /// The field whose surface is taken.
    pub fn surface(&self) -> &Bricks {
        self.coarse.as_ref().map_or(&self.bricks, |coarse| &coarse.bricks)
    }

    /// The finest field there is, under the surface.
    pub fn ground(&self) -> FieldSampler<'_> {
        FieldSampler {
            bricks: &self.bricks,
            finer: self.coarse.as_ref().map_or(1.0, |coarse| coarse.finer),
        }
    }

    /// The lattice of the surface.
    pub fn lattice(&self) -> Lattice {
        Lattice {
            voxel_m: self.lattice.voxel_m * self.ground().finer,
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
        bricks.sample(lattice.place(point)).0 > 0.0
    })
}
