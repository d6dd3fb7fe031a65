//! Settings of [`crate::grow`].

use crate::error::{Result, require};

/// Smallest and largest resolution.
const RESOLUTIONS: std::ops::RangeInclusive<u32> = 4..=8192;
/// Most passes of the filter, and its largest radius.
const MOST_PASSES: u32 = 100;
const LARGEST_RADIUS: u32 = 4;
/// Smallest number of faces that can be requested.
const FEWEST_FACES: usize = 50;

/// Settings of [`crate::grow`]. The defaults are those of Wilhelms 1997.
#[derive(Debug, Clone, PartialEq)]
pub struct GrowOptions {
    /// Voxels along the longest side of all tissues, 4..8192.
    pub resolution: u32,
    /// Thickness of the skin over all tissues, m.
    pub thickness_m: f64,
    /// Passes of the filter, 0..100.
    pub smoothing: u32,
    /// Radius of the filter, voxels, 0..4.
    pub radius: u32,
    /// Decay of the filter's weights e^(-decay · d²), with the distance d in voxels; 0 or more.
    pub decay: f64,
    /// Largest number of faces; `None` for the number that follows from the resolution.
    pub faces: Option<usize>,
    /// Make the surface exactly symmetric about x = 0 wherever the tissues are, except for rounding.
    pub symmetric: bool,
    /// Remove all pieces but the largest.
    pub largest_only: bool,
    /// Memory limit, bytes.
    pub memory_limit_bytes: f64,
}

impl Default for GrowOptions {
    fn default() -> Self {
        Self {
            resolution: 83,
            thickness_m: 0.0,
            smoothing: 5,
            radius: 1,
            decay: 1.0,
            faces: None,
            symmetric: true,
            largest_only: false,
            memory_limit_bytes: 2e9,
        }
    }
}

impl GrowOptions {
    /// Checks all values.
    ///
    /// # Errors
    /// [`crate::Error::Value`] for a number outside its limits.
    pub(super) fn require_sound(&self) -> Result<()> {
        let thing = || "Growing a skin".to_owned();
        let check = |allowed: bool, quantity, found: f64, limit| {
            require(allowed, thing, quantity, found, limit).map(|_| ())
        };
        let is_length = |found: f64| found.is_finite() && found >= 0.0;
        check(
            RESOLUTIONS.contains(&self.resolution),
            "the resolution (voxels along the longest side)",
            self.resolution.into(),
            "4 to 8192",
        )?;
        let thickness_m = self.thickness_m;
        check(
            is_length(thickness_m),
            "the thickness (m)",
            thickness_m,
            "finite and 0 or more",
        )?;
        check(
            self.smoothing <= MOST_PASSES,
            "the smoothing (passes of the filter)",
            self.smoothing.into(),
            "0 to 100",
        )?;
        check(
            self.radius <= LARGEST_RADIUS,
            "the radius of the filter (voxels)",
            self.radius.into(),
            "0 to 4",
        )?;
        check(
            is_length(self.decay),
            "the decay of the filter",
            self.decay,
            "finite and 0 or more",
        )?;
        let faces = self.faces.unwrap_or(FEWEST_FACES);
        check(
            faces >= FEWEST_FACES,
            "the number of faces",
            faces as f64,
            "50 or more",
        )?;
        let limit = self.memory_limit_bytes;
        check(
            limit.is_finite() && limit > 0.0,
            "the memory limit (bytes)",
            limit,
            "finite and above 0",
        )
    }
}
