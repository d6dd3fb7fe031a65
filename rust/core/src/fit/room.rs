//! How much room a belly has, by rays from its long axis to the skin.
//!
//! Such rays meet the skin of the belly's own limb. Their lengths do not depend on the belly's widths, so fitting a fitted
//! belly changes next to nothing.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use glam::{DVec2, DVec3};

use super::placed_tissue::PlacedTissue;
use super::skin_surface::SkinSurface;

/// Stations along the axis where a belly is measured at first; its ends are -1 and 1.
pub(super) const COARSE: [f64; 9] = [-0.97, -0.85, -0.6, -0.3, 0.0, 0.3, 0.6, 0.85, 0.97];
/// Stations where it is checked.
pub(super) const FINE: [f64; 17] = [
    -0.98, -0.94, -0.88, -0.8, -0.7, -0.55, -0.4, -0.2, 0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.88, 0.94, 0.98,
];
/// Rays at a station.
pub(super) const SPOKES: usize = 16;
/// Cosines of the angles between spokes, over a quarter of a turn.
const QUARTER: [f64; SPOKES / 4 + 1] = [
    1.0,
    0.923_879_532_511_286_7,
    FRAC_1_SQRT_2,
    0.382_683_432_365_089_8,
    0.0,
];
/// Room, over the margin, of an axis that is outside itself.
const OUTSIDE_OF_MARGIN: f64 = 0.05;
/// How much more room, over the size of the skin, one side may have for the other to be its mirror image.
const SAME_ROOM_OF_SIZE: f64 = 6e-5;
/// A share of this or less is rounding.
const NEXT_TO_NOTHING: f64 = 1e-9;
/// Smallest cosine between a spoke and local x with which the spoke limits the thickness.
const SMALLEST_COSINE: f64 = 1e-7;
/// Stations and spokes at which a protrusion is looked for.
const PROTRUSION_STATIONS: usize = 25;
const PROTRUSION_SPOKES: usize = 32;
const PROTRUSION_END: f64 = 0.98;

/// The room that a tissue has at some stations.
#[derive(Debug, Clone)]
pub(super) struct Room {
    stations: &'static [f64],
    /// Directions across, in units of local x and y.
    spokes: [DVec2; SPOKES],
    /// From the axis to just under the skin, m, by station and spoke; infinite where there is no skin.
    metres: Vec<[f64; SPOKES]>,
}

/// How much wider a tissue could be before it met the skin.
#[derive(Debug, Clone)]
pub(super) struct Freedom {
    /// The factor by station and spoke.
    factors: Vec<[f64; SPOKES]>,
    /// The least of all.
    pub(super) least: f64,
    /// The station where that is.
    pub(super) tightest: f64,
}

/// Directions at equal angles, the first along local x. Exactly the same in all four quarters, so that mirror images tie alike.
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

/// Directions evenly about the outline: a flat belly pokes out with its edges.
pub(super) fn outline_spokes(semi_axes: DVec3) -> [DVec2; SPOKES] {
    even_spokes().map(|spoke| (spoke * semi_axes.truncate()).normalize_or_zero())
}

impl Room {
    /// The room of a tissue under `skin`.
    pub(super) fn of(
        tissue: &PlacedTissue,
        skin: &SkinSurface,
        stations: &'static [f64],
        spokes: [DVec2; SPOKES],
    ) -> Self {
        let axes = tissue.axes();
        let (margin_m, least_m) = (skin.margin_m(), OUTSIDE_OF_MARGIN * skin.margin_m());
        let at = |station: &f64| {
            let middle = tissue.at.centre + axes.z_axis * (station * tissue.at.semi_axes.z);
            spokes.map(|spoke| {
                let direction = axes.x_axis * spoke.x + axes.y_axis * spoke.y;
                let to_skin_m = skin.distance_along(middle, direction);
                // where the axis itself is outside, there is next to none
                to_skin_m.map_or(f64::INFINITY, |m| (m - margin_m).max(least_m))
            })
        };
        Self {
            stations,
            spokes,
            metres: stations.iter().map(at).collect(),
        }
    }

    /// The room at the stations that a belly is placed by.
    pub(super) fn coarse(tissue: &PlacedTissue, skin: &SkinSurface) -> Self {
        Self::of(tissue, skin, &COARSE, even_spokes())
    }

    /// By what factor the widths could grow before the tissue met the skin.
    pub(super) fn freedom(&self, semi_axes: DVec3) -> Freedom {
        let across = self.spokes.map(|spoke| (spoke / semi_axes.truncate()).length());
        let mut found = Freedom {
            factors: Vec::with_capacity(self.stations.len()),
            least: f64::INFINITY,
            tightest: 0.0,
        };
        for (&station, metres) in self.stations.iter().zip(&self.metres) {
            let rib = (1.0 - station * station).sqrt(); // how wide an ellipsoid is there
            let mut factors = [0.0; SPOKES];
            for spoke in 0..SPOKES {
                factors[spoke] = metres[spoke] * across[spoke] / rib;
                if factors[spoke] < found.least {
                    (found.least, found.tightest) = (factors[spoke], station);
                }
            }
            found.factors.push(factors);
        }
        found
    }

    /// The largest semi-axis along x, m, that fits with the semi-axis along y that the tissue has; infinite where nothing
    /// limits it.
    pub(super) fn thickest_m(&self, semi_axes: DVec3) -> f64 {
        let mut thickest_m = f64::INFINITY;
        for (&station, metres) in self.stations.iter().zip(&self.metres) {
            for (spoke, &room_m) in self.spokes.iter().zip(metres) {
                let sideways = room_m * spoke.y / semi_axes.y;
                let left = (1.0 - station * station) - sideways * sideways;
                if left > NEXT_TO_NOTHING && spoke.x.abs() > SMALLEST_COSINE {
                    thickest_m = thickest_m.min(room_m * spoke.x.abs() / left.sqrt());
                }
            }
        }
        thickest_m
    }

    /// Whether this has as much room as the mirror image of `left`. An image's y axis looks the other way, so its spokes run
    /// backward.
    pub(super) fn is_image_of(&self, left: &Self, skin: &SkinSurface) -> bool {
        let tolerance_m = SAME_ROOM_OF_SIZE * skin.size_m();
        let same = |a: f64, b: f64| a == b || (a - b).abs() <= tolerance_m;
        self.metres
            .iter()
            .zip(&left.metres)
            .all(|(own, others)| (0..SPOKES).all(|spoke| same(own[(SPOKES - spoke) % SPOKES], others[spoke])))
    }
}

impl Freedom {
    /// The direction, across and in units of local x and y, away from where there is too little room; 0 where there is none.
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
        // equal on both sides, they leave only rounding, which is no direction
        if away.length() > NEXT_TO_NOTHING * sum {
            away.normalize_or_zero()
        } else {
            DVec2::ZERO
        }
    }
}

/// How far a tissue pokes out of the skin, m; 0 where it does not. Sampled finer than a fit samples.
pub fn protrusion_m(tissue: &PlacedTissue, skin: &SkinSurface) -> f64 {
    let axes = tissue.axes();
    let mut farthest_m = 0.0_f64;
    for station in 0..PROTRUSION_STATIONS {
        let share = station as f64 / (PROTRUSION_STATIONS - 1) as f64;
        let station = PROTRUSION_END * (2.0 * share - 1.0);
        let middle = tissue.at.centre + axes.z_axis * (station * tissue.at.semi_axes.z);
        let rib = (1.0 - station * station).sqrt();
        for spoke in 0..PROTRUSION_SPOKES {
            let angle = spoke as f64 * (2.0 * PI / PROTRUSION_SPOKES as f64);
            let across = DVec2::from_angle(angle) * tissue.at.semi_axes.truncate() * rib;
            let spoke = axes.x_axis * across.x + axes.y_axis * across.y;
            if skin
                .distance_along(middle, spoke)
                .is_some_and(|lengths| lengths < 1.0)
            {
                farthest_m = farthest_m.max(skin.nearest(middle + spoke).distance_m);
            }
        }
    }
    farthest_m
}
