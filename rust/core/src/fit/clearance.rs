//! The clearance of a belly: rays from its long axis to the skin.
//! (docs/mathematics/fitting.md, Fit under the skin)
//!
//! Such rays hit the skin of the belly's limb. Their lengths do not depend on the belly's widths, so fitting a fitted belly
//! changes almost nothing.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DVec2, DVec3};

use super::placed_tissue::PlacedTissue;
use super::skin_surface::SkinSurface;

/// Stations along the axis where a belly is measured first; its ends are -1 and 1.
pub(super) const COARSE: [f64; 9] = [-0.97, -0.85, -0.6, -0.3, 0.0, 0.3, 0.6, 0.85, 0.97];
/// Stations where a belly is trimmed.
pub(super) const FINE: [f64; 17] = [
    -0.98, -0.94, -0.88, -0.8, -0.7, -0.55, -0.4, -0.2, 0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.88, 0.94, 0.98,
];
/// Number of rays at a station.
pub(super) const SPOKES: usize = 16;
/// Cosines of the angles between spokes, over a quarter of a turn.
const QUARTER: [f64; SPOKES / 4 + 1] = [
    1.0,
    0.923_879_532_511_286_7,
    FRAC_1_SQRT_2,
    0.382_683_432_365_089_8,
    0.0,
];
/// Clearance, over the margin, where the axis is outside.
const OUTSIDE_OF_MARGIN: f64 = 0.05;
/// Largest difference of the clearance of two mirror images, over the size of the skin.
const SAME_CLEARANCE_OF_SIZE: f64 = 6e-5;
/// A fraction of at most this is rounding.
const ROUNDING: f64 = 1e-9;
/// Smallest cosine between a spoke and local x with which the spoke limits the thickness.
const SMALLEST_COSINE: f64 = 1e-7;
/// Stations at which a protrusion is measured.
const PROTRUSION_STATIONS: usize = 25;
/// Spokes per station at which a protrusion is measured.
const PROTRUSION_SPOKES: usize = 32;
/// The last of these stations.
const PROTRUSION_END: f64 = 0.98;

/// The clearance of a tissue at some stations.
#[derive(Debug, Clone)]
pub(super) struct Clearance {
    stations: &'static [f64],
    /// Directions across the axis, in units of local x and y.
    spokes: [DVec2; SPOKES],
    /// Distance from the axis to the margin under the skin, m, by station and spoke; infinite where no skin is hit.
    metres: Vec<[f64; SPOKES]>,
}

/// The factors by which the widths of a tissue could grow before it touches the skin.
#[derive(Debug, Clone)]
pub(super) struct WidthFactors {
    /// By station and spoke.
    factors: Vec<[f64; SPOKES]>,
    /// The smallest of all.
    pub(super) smallest: f64,
    /// The station of the smallest.
    pub(super) tightest: f64,
}

/// Directions at equal angles, the first along local x.
///
/// The coordinates are the same in all four quarters, so that ties of mirror images break alike.
pub(super) fn even_spokes() -> [DVec2; SPOKES] {
    let quarter = SPOKES / 4;
    std::array::from_fn(|spoke| {
        let (cosine, sine) = (QUARTER[spoke % quarter], QUARTER[quarter - spoke % quarter]);
        match spoke / quarter {
            0 => DVec2::new(cosine, sine),
            1 => DVec2::new(-sine, cosine),
            2 => DVec2::new(-cosine, -sine),
            _ => DVec2::new(sine, -cosine),
        }
    })
}

/// Directions to evenly spaced points of the outline, because the edges of a flat belly protrude first.
pub(super) fn outline_spokes(semi_axes: DVec3) -> [DVec2; SPOKES] {
    even_spokes().map(|spoke| (spoke * semi_axes.truncate()).normalize_or_zero())
}

impl Clearance {
    /// The clearance of a tissue under `skin`.
    pub(super) fn of(
        tissue: &PlacedTissue,
        skin: &SkinSurface,
        stations: &'static [f64],
        spokes: [DVec2; SPOKES],
    ) -> Self {
        let axes = tissue.axes();
        let (margin_m, smallest_m) = (skin.margin_m(), OUTSIDE_OF_MARGIN * skin.margin_m());
        let at = |station: &f64| {
            let on_axis = tissue.at.centre + axes.z_axis * (station * tissue.at.semi_axes.z);
            spokes.map(|spoke| {
                let direction = axes.x_axis * spoke.x + axes.y_axis * spoke.y;
                let to_skin_m = skin.distance_along(on_axis, direction);
                to_skin_m.map_or(f64::INFINITY, |m| (m - margin_m).max(smallest_m))
            })
        };
        Self {
            stations,
            spokes,
            metres: stations.iter().map(at).collect(),
        }
    }

    /// The clearance at the coarse stations and even spokes.
    pub(super) fn coarse(tissue: &PlacedTissue, skin: &SkinSurface) -> Self {
        Self::of(tissue, skin, &COARSE, even_spokes())
    }

    /// The factors by which these widths could grow before the tissue touches the skin.
    pub(super) fn width_factors(&self, semi_axes: DVec3) -> WidthFactors {
        let across = self.spokes.map(|spoke| (spoke / semi_axes.truncate()).length());
        let mut all = WidthFactors {
            factors: Vec::with_capacity(self.stations.len()),
            smallest: f64::INFINITY,
            tightest: 0.0,
        };
        for (&station, metres) in self.stations.iter().zip(&self.metres) {
            let relative_width = relative_width(station);
            let mut factors = [0.0; SPOKES];
            for spoke in 0..SPOKES {
                factors[spoke] = metres[spoke] * across[spoke] / relative_width;
                if factors[spoke] < all.smallest {
                    (all.smallest, all.tightest) = (factors[spoke], station);
                }
            }
            all.factors.push(factors);
        }
        all
    }

    /// The largest semi-axis along x, m, that fits with the tissue's semi-axis along y; infinite if nothing limits it.
    pub(super) fn thickest_m(&self, semi_axes: DVec3) -> f64 {
        let mut thickest_m = f64::INFINITY;
        for (&station, metres) in self.stations.iter().zip(&self.metres) {
            for (spoke, &clearance_m) in self.spokes.iter().zip(metres) {
                let sideways = clearance_m * spoke.y / semi_axes.y;
                let rest = (1.0 - station * station) - sideways * sideways;
                if rest > ROUNDING && spoke.x.abs() > SMALLEST_COSINE {
                    thickest_m = thickest_m.min(clearance_m * spoke.x.abs() / rest.sqrt());
                }
            }
        }
        thickest_m
    }

    /// Whether this is the mirror image of the clearance `left`. The y axis of an image points the other way, so its spokes
    /// are in reverse order.
    pub(super) fn is_image_of(&self, left: &Self, skin: &SkinSurface) -> bool {
        let tolerance_m = SAME_CLEARANCE_OF_SIZE * skin.size_m();
        let same = |a: f64, b: f64| a == b || (a - b).abs() <= tolerance_m;
        self.metres
            .iter()
            .zip(&left.metres)
            .all(|(right, left)| (0..SPOKES).all(|spoke| same(right[(SPOKES - spoke) % SPOKES], left[spoke])))
    }
}

impl WidthFactors {
    /// The unit direction, in units of local x and y, away from where the tissue is too wide; 0 if there is none.
    pub(super) fn away(&self) -> DVec2 {
        let (mut away, mut sum) = (DVec2::ZERO, 0.0);
        for (spoke, direction) in even_spokes().into_iter().enumerate() {
            let missing = self
                .factors
                .iter()
                .map(|factors| (1.0 - factors[spoke]).clamp(0.0, 1.0));
            let missing: f64 = missing.sum();
            away -= direction * missing;
            sum += missing;
        }
        // if opposite sides miss the same, only rounding remains
        if away.length() > ROUNDING * sum {
            away.normalize_or_zero()
        } else {
            DVec2::ZERO
        }
    }
}

/// The width of an ellipsoid at a station, over its width at the middle.
fn relative_width(station: f64) -> f64 {
    (1.0 - station * station).sqrt()
}

/// The distance by which a tissue protrudes from the skin, m; 0 if it does not. Measured at more points than a fit uses.
pub fn protrusion_m(tissue: &PlacedTissue, skin: &SkinSurface) -> f64 {
    let axes = tissue.axes();
    let mut farthest_m = 0.0_f64;
    for station in 0..PROTRUSION_STATIONS {
        let fraction = station as f64 / (PROTRUSION_STATIONS - 1) as f64;
        let station = PROTRUSION_END * (2.0 * fraction - 1.0);
        let on_axis = tissue.at.centre + axes.z_axis * (station * tissue.at.semi_axes.z);
        for spoke in 0..PROTRUSION_SPOKES {
            let angle = spoke as f64 * (2.0 * PI / PROTRUSION_SPOKES as f64);
            let across = DVec2::from_angle(angle) * tissue.at.semi_axes.truncate() * relative_width(station);
            let spoke = axes.x_axis * across.x + axes.y_axis * across.y;
            if skin
                .distance_along(on_axis, spoke)
                .is_some_and(|lengths| lengths < 1.0)
            {
                farthest_m = farthest_m.max(skin.nearest(on_axis + spoke).distance_m);
            }
        }
    }
    farthest_m
}
