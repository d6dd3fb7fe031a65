//! Moves via points so that a bent belly stays under the skin.
//! (docs/mathematics/fitting.md, Fit under the skin)
//!
//! The via points of a preset come from another body. Where the belly along them would protrude, they move toward the
//! straight line between origin and insertion, along which the belly fits. If that is not enough, the muscle becomes straight.

use glam::DVec3;

use super::placed_tissue::PlacedTissue;
use super::skin_surface::SkinSurface;

/// Stations along the belly; its ends are -1 and 1.
const STATIONS: [f64; 11] = [-0.97, -0.85, -0.7, -0.5, -0.25, 0.0, 0.25, 0.5, 0.7, 0.85, 0.97];
/// Fraction of the distance to the straight line that each step keeps.
const KEPT_DISTANCE: f64 = 0.75;
/// Largest number of steps.
const STEPS: usize = 8;
/// Factor on the widths: a path rounds its corners outward, and a bent belly is wider across the bend.
const BEND_ALLOWANCE: f64 = 1.35;

/// The tissue with via points along which its belly is under the skin, or without via points.
pub(super) fn moved_inside_skin(mut tissue: PlacedTissue, skin: &SkinSurface) -> PlacedTissue {
    let origin = tissue.origin();
    let line = (tissue.insertion() - origin).normalize_or_zero();
    for _ in 0..STEPS {
        if tissue.at.via_points.is_empty() || is_inside(&tissue, skin) {
            return tissue;
        }
        for point in &mut tissue.at.via_points {
            let on_line = origin + line * (*point - origin).dot(line);
            *point = on_line.lerp(*point, KEPT_DISTANCE);
        }
    }
    tissue.at.via_points.clear();
    tissue
}

fn is_inside(tissue: &PlacedTissue, skin: &SkinSurface) -> bool {
    let path = tissue.path();
    let belly_m = path.length() - tissue.at.origin_tendon_m - tissue.at.insertion_tendon_m;
    let widest_m = tissue.at.semi_axes.x.max(tissue.at.semi_axes.y);
    let across_m = BEND_ALLOWANCE * widest_m + skin.margin_m();
    STATIONS.iter().all(|station| {
        let along_m = tissue.at.origin_tendon_m + belly_m * (1.0 + station) / 2.0;
        let point: DVec3 = path.at(along_m);
        let width_m = across_m * (1.0 - station * station).sqrt();
        skin.nearest(point).distance_m >= width_m && skin.is_inside(point)
    })
}
