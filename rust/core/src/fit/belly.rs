//! Fits a tissue under the skin in the rest pose: a belly fills the clearance and never protrudes.
//! (docs/mathematics/fitting.md, Fit under the skin)

use super::clearance::{Clearance, FINE, WidthFactors, outline_spokes};
use super::placed_tissue::PlacedTissue;
use super::skin_surface::SkinSurface;
use super::via_points::moved_inside_skin;
use crate::muscles::tissue::TissueKind;

/// Station beyond which a protruding belly is shortened, not moved.
const END_STATION: f64 = 0.8;
/// A belly whose widths would shrink by more than this factor is first moved, or shortened at its end.
const KEPT_WIDTH: f64 = 0.8;
/// Largest number of moves and cuts.
const MOVES: usize = 16;
/// Length of a move, over the belly's thickness.
const MOVE_OF_THICKNESS: f64 = 0.15;
/// Largest displacement into the skin, over the belly's half length. A belly farther outside is not covered by this skin.
const LARGEST_MOVE_OF_BELLY: f64 = 0.5;
/// A belly whose width factor is at most this grows up to the skin. One with more clearance is deep and keeps its widths.
const GROWTH: f64 = 1.3;
/// A factor that differs from 1 by at most this is ignored.
const UNCHANGED: f64 = 1e-4;
/// Largest number of trims.
const TRIMS: usize = 32;
/// Number of widths along local y that are tried where a belly is too wide.
const NARROWINGS: i32 = 8;
/// A belly that is too wide between this station and the middle is moved, not shortened.
const MIDDLE_STATION: f64 = 0.25;
/// Smallest factor on the widths; below it a belly is shortened instead.
const SMALLEST_WIDTH_FACTOR: f64 = 0.3;

/// The tissue, sized to fit under the skin; unchanged where the skin does not cover it.
///
/// A sphere shrinks to the distance of its centre from the skin. Other tissues are moved inside, moved away from the skin or
/// shortened at the end that protrudes, then trimmed. A muscle near the skin also grows up to it, and its via points are moved
/// inside.
pub fn fit(tissue: &PlacedTissue, skin: &SkinSurface) -> PlacedTissue {
    if tissue.at.kind == TissueKind::Sphere {
        return sphere_inside(tissue, skin);
    }
    let Some(inside) = centre_inside(tissue, skin) else {
        return tissue.clone();
    };
    let (moved, clearance) = moved_or_shortened(inside, skin);
    let filled = if tissue.at.kind == TissueKind::Muscle {
        filled(moved, &clearance)
    } else {
        moved
    };
    moved_inside_skin(trimmed(filled, skin, even), skin)
}

fn sphere_inside(tissue: &PlacedTissue, skin: &SkinSurface) -> PlacedTissue {
    if !skin.is_inside(tissue.at.centre) {
        return tissue.clone();
    }
    let margin_m = skin.margin_m();
    let clearance_m = (skin.nearest(tissue.at.centre).distance_m - margin_m).max(margin_m);
    let largest_m = tissue.at.semi_axes.max_element();
    let mut fitted = tissue.clone();
    if largest_m > clearance_m {
        fitted.at.semi_axes *= clearance_m / largest_m;
    }
    fitted
}

/// The tissue with its centre inside the skin; `None` if it is too far outside.
///
/// A straight line between two points of a bent body can be outside, so a centre can be.
fn centre_inside(tissue: &PlacedTissue, skin: &SkinSurface) -> Option<PlacedTissue> {
    if skin.is_inside(tissue.at.centre) {
        return Some(tissue.clone());
    }
    let nearest = skin.nearest(tissue.at.centre);
    if nearest.distance_m > LARGEST_MOVE_OF_BELLY * tissue.at.semi_axes.z {
        return None;
    }
    let to_skin = nearest.point - tissue.at.centre;
    let deeper = to_skin.normalize_or_zero() * (tissue.thickness_m() + skin.margin_m());
    let moved = tissue.moved(to_skin + deeper);
    skin.is_inside(moved.at.centre).then_some(moved)
}

/// The tissue moved away from the skin, or shortened at the end that protrudes, until its widths shrink little; and its
/// clearance there.
fn moved_or_shortened(mut tissue: PlacedTissue, skin: &SkinSurface) -> (PlacedTissue, Clearance) {
    let mut clearance = Clearance::coarse(&tissue, skin);
    for _ in 0..MOVES {
        let factors = clearance.width_factors(tissue.at.semi_axes);
        if factors.smallest >= KEPT_WIDTH {
            break;
        }
        tissue = if factors.tightest.abs() > END_STATION {
            tissue.shortened(factors.tightest)
        } else {
            moved_away(&tissue, &factors, skin)
        };
        clearance = Clearance::coarse(&tissue, skin);
    }
    (tissue, clearance)
}

/// The tissue moved away from where it protrudes: by a step, or to below the skin where its axis is outside.
fn moved_away(tissue: &PlacedTissue, factors: &WidthFactors, skin: &SkinSurface) -> PlacedTissue {
    let axes = tissue.axes();
    let on_axis = tissue.at.centre + axes.z_axis * (factors.tightest * tissue.at.semi_axes.z);
    if !skin.is_inside(on_axis) {
        let to_skin = skin.nearest(on_axis).point - on_axis;
        let inward = to_skin - axes.z_axis * to_skin.dot(axes.z_axis);
        let deeper_m = tissue.thickness_m() + skin.margin_m();
        return tissue.moved(inward + inward.normalize_or_zero() * deeper_m);
    }
    let away = factors.away();
    let step_m = MOVE_OF_THICKNESS * tissue.thickness_m();
    tissue.moved((axes.x_axis * away.x + axes.y_axis * away.y) * step_m)
}

/// The tissue with widths scaled up to the skin if that is near, then with a larger thickness if only its edges touch.
fn filled(tissue: PlacedTissue, clearance: &Clearance) -> PlacedTissue {
    let factor = clearance.width_factors(tissue.at.semi_axes).smallest;
    if !(SMALLEST_WIDTH_FACTOR..=GROWTH).contains(&factor) {
        return tissue; // deep, or shortened by `trimmed`
    }
    let mut filled = if (factor - 1.0).abs() > UNCHANGED {
        tissue.widened(factor, factor)
    } else {
        tissue
    };
    let x_m = filled.at.semi_axes.x;
    let thickest_m = clearance.thickest_m(filled.at.semi_axes);
    if x_m * (1.0 + UNCHANGED) < thickest_m && thickest_m <= GROWTH * x_m {
        filled.at.semi_axes.x = thickest_m;
    }
    filled
}

/// A belly that was not fitted, under the skin, with up to `volume_m3` where the skin leaves room.
///
/// It is moved away from the skin or shortened at the end that protrudes, trimmed, and widened again.
pub(super) fn settled(tissue: PlacedTissue, volume_m3: f64, skin: &SkinSurface) -> PlacedTissue {
    let (moved, _clearance) = moved_or_shortened(tissue, skin);
    let settled = trimmed(moved, skin, narrowed);
    let clearance = Clearance::of(&settled, skin, &FINE, outline_spokes(settled.at.semi_axes));
    let free = clearance.width_factors(settled.at.semi_axes).smallest;
    let missing = (volume_m3 / settled.volume_m3()).sqrt();
    let factor = missing.min(free);
    if factor > 1.0 + UNCHANGED {
        return trimmed(settled.widened(factor, factor), skin, narrowed);
    }
    settled
}

/// The tissue without what protrudes between the coarse stations: narrower, or shortened where the widths would shrink too
/// much.
fn trimmed(mut tissue: PlacedTissue, skin: &SkinSurface, narrow: Narrow) -> PlacedTissue {
    for _ in 0..TRIMS {
        let spokes = outline_spokes(tissue.at.semi_axes);
        let clearance = Clearance::of(&tissue, skin, &FINE, spokes);
        let factors = clearance.width_factors(tissue.at.semi_axes);
        if factors.smallest >= 1.0 - UNCHANGED {
            break;
        }
        tissue = if factors.smallest >= SMALLEST_WIDTH_FACTOR {
            narrow(&tissue, &clearance, factors.smallest)
        } else if factors.tightest.abs() > MIDDLE_STATION {
            tissue.shortened(factors.tightest)
        } else {
            moved_away(&tissue, &factors, skin)
        };
    }
    tissue
}

/// How a belly becomes narrower: from its clearance and a factor, below 1, by which both widths fit.
type Narrow = fn(&PlacedTissue, &Clearance, f64) -> PlacedTissue;

/// Both widths alike, as the fit does: fitted again, the belly stays.
fn even(tissue: &PlacedTissue, _clearance: &Clearance, feasible: f64) -> PlacedTissue {
    tissue.widened(feasible, feasible)
}

/// The tissue with the largest cross-section within its widths that the clearance leaves. Both widths times `feasible`, below 1,
/// is one. A flat belly near the skin keeps its width and loses thickness.
fn narrowed(tissue: &PlacedTissue, clearance: &Clearance, feasible: f64) -> PlacedTissue {
    let mut best = tissue.widened(feasible, feasible);
    for step in 0..NARROWINGS {
        let y = feasible.powf(f64::from(step) / f64::from(NARROWINGS));
        let narrow = tissue.widened(1.0, y);
        let x = (clearance.thickest_m(narrow.at.semi_axes) / tissue.at.semi_axes.x).min(1.0);
        let found = narrow.widened(x, 1.0);
        let fits = || clearance.width_factors(found.at.semi_axes).smallest >= 1.0 - UNCHANGED;
        if x * y > feasible * feasible && found.volume_m3() > best.volume_m3() && fits() {
            best = found;
        }
    }
    best
}
