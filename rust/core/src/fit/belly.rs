//! Bellies just under the skin: as thick as there is room, never poking out in the rest pose.

use glam::DVec3;

use super::detour::kept_inside;
use super::placed_tissue::PlacedTissue;
use super::room::{FINE, Freedom, Room, outline_spokes};
use super::skin_surface::SkinSurface;
use crate::muscles::tissue::TissueKind;

/// Station beyond which a belly that pokes out is cut, not moved.
const END_STATION: f64 = 0.8;
/// A belly that would lose more width than this is first moved, or cut at its end.
const KEPT_WIDTH: f64 = 0.8;
/// Most moves and cuts.
const MOVES: usize = 16;
/// A move, over the belly's thickness.
const MOVE_OF_THICKNESS: f64 = 0.15;
/// Largest way into the skin, over the belly's half length: what is farther outside is not covered by this skin.
const LARGEST_MOVE_OF_BELLY: f64 = 0.5;
/// A belly this near to the skin grows up to it; one with more room lies deep, and stays.
const GROWTH: f64 = 1.3;
/// A factor this near to 1 changes nothing.
const UNCHANGED: f64 = 1e-4;
/// Most trims.
const TRIMS: usize = 32;
/// Station up to which a belly is trimmed at its middle.
const MIDDLE_STATION: f64 = 0.25;
/// A belly that would keep less than this of its width is cut instead.
const NEEDLE: f64 = 0.3;

/// The tissue with the widths that its place under the skin allows; as it is where the skin does not cover it.
///
/// A sphere shrinks where the skin is nearer than it is large. Anything else is brought inside, moved away from the skin or
/// cut at the end that pokes out, then trimmed. A muscle near the skin also grows up to it, and its via points are drawn in.
pub fn fit(tissue: &PlacedTissue, skin: &SkinSurface) -> PlacedTissue {
    if tissue.at.kind == TissueKind::Sphere {
        return sphere_inside(tissue, skin);
    }
    let Some(inside) = brought_inside(tissue, skin) else {
        return tissue.clone();
    };
    let (moved, room) = moved_inside(inside, skin);
    let filled = if tissue.at.kind == TissueKind::Muscle {
        filled(moved, &room)
    } else {
        moved
    };
    kept_inside(trimmed(filled, skin), skin)
}

fn sphere_inside(tissue: &PlacedTissue, skin: &SkinSurface) -> PlacedTissue {
    if !skin.is_inside(tissue.at.centre) {
        return tissue.clone();
    }
    let margin_m = skin.margin_m();
    let room_m = (skin.nearest(tissue.at.centre).distance_m - margin_m).max(margin_m);
    let largest_m = tissue.at.semi_axes.max_element();
    let mut made = tissue.clone();
    if largest_m > room_m {
        made.at.semi_axes *= room_m / largest_m;
    }
    made
}

/// A straight line between two points in a bent body can run outside; such a belly is brought in, if it is near.
fn brought_inside(tissue: &PlacedTissue, skin: &SkinSurface) -> Option<PlacedTissue> {
    if skin.is_inside(tissue.at.centre) {
        return Some(tissue.clone());
    }
    let nearest = skin.nearest(tissue.at.centre);
    if nearest.distance_m > LARGEST_MOVE_OF_BELLY * tissue.at.semi_axes.z {
        return None;
    }
    let to_skin = nearest.point - tissue.at.centre;
    let deeper = to_skin.normalize_or_zero() * (tissue.thickness_m() + skin.margin_m());
    let brought = tissue.moved(to_skin + deeper);
    skin.is_inside(brought.at.centre).then_some(brought)
}

/// Moved away from the skin, or cut at the end that it pokes out with, until little width has to go; and the room there.
fn moved_inside(mut tissue: PlacedTissue, skin: &SkinSurface) -> (PlacedTissue, Room) {
    let mut room = Room::coarse(&tissue, skin);
    for _ in 0..MOVES {
        let freedom = room.freedom(tissue.at.semi_axes);
        if freedom.least >= KEPT_WIDTH {
            break;
        }
        tissue = if freedom.tightest.abs() > END_STATION {
            tissue.cut(freedom.tightest)
        } else {
            moved_away(&tissue, &freedom, skin)
        };
        room = Room::coarse(&tissue, skin);
    }
    (tissue, room)
}

/// A step away from where the belly pokes out; as far as the skin, where its very axis is outside.
fn moved_away(tissue: &PlacedTissue, freedom: &Freedom, skin: &SkinSurface) -> PlacedTissue {
    let axes = tissue.axes();
    let middle = tissue.at.centre + axes.z_axis * (freedom.tightest * tissue.at.semi_axes.z);
    if !skin.is_inside(middle) {
        let to_skin = skin.nearest(middle).point - middle;
        let inward = to_skin - axes.z_axis * to_skin.dot(axes.z_axis);
        let deeper_m = tissue.thickness_m() + skin.margin_m();
        return tissue.moved(inward + inward.normalize_or_zero() * deeper_m);
    }
    let away = freedom.away();
    let step_m = MOVE_OF_THICKNESS * tissue.thickness_m();
    tissue.moved((axes.x_axis * away.x + axes.y_axis * away.y) * step_m)
}

/// Widths scaled to just under the skin where it is near; then the thickness alone, where only the edges touch.
fn filled(tissue: PlacedTissue, room: &Room) -> PlacedTissue {
    let factor = room.freedom(tissue.at.semi_axes).least;
    if !(NEEDLE..=GROWTH).contains(&factor) {
        return tissue; // with room to spare, or to be cut
    }
    let mut made = if (factor - 1.0).abs() > UNCHANGED {
        tissue.widened(factor, factor)
    } else {
        tissue
    };
    let DVec3 { x, .. } = made.at.semi_axes;
    let thickest_m = room.thickest_m(made.at.semi_axes);
    if x * (1.0 + UNCHANGED) < thickest_m && thickest_m <= GROWTH * x {
        made.at.semi_axes.x = thickest_m;
    }
    made
}

/// What still pokes out between the coarse stations goes: from the widths where it is little, else from the end.
fn trimmed(mut tissue: PlacedTissue, skin: &SkinSurface) -> PlacedTissue {
    for _ in 0..TRIMS {
        let spokes = outline_spokes(tissue.at.semi_axes);
        let freedom = Room::of(&tissue, skin, &FINE, spokes).freedom(tissue.at.semi_axes);
        if freedom.least >= 1.0 - UNCHANGED {
            break;
        }
        tissue = if freedom.least >= NEEDLE {
            tissue.widened(freedom.least, freedom.least)
        } else if freedom.tightest.abs() > MIDDLE_STATION {
            tissue.cut(freedom.tightest)
        } else {
            moved_away(&tissue, &freedom, skin)
        };
    }
    tissue
}
