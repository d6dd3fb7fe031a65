//! Many tissues fitted at once; the right of a symmetric body as the exact mirror image of the left.

use rayon::prelude::*;

use super::belly::fit;
use super::placed_tissue::PlacedTissue;
use super::room::Room;
use super::skin_surface::SkinSurface;
use crate::error::{Error, Result, require_length};

/// Each tissue fitted under `skin`, on all threads.
///
/// `lefts` names for each tissue the one on the left whose mirror image it may be. It is that image where both were placed
/// as mirror images and the skin is as far from both; else it is fitted by itself. A tissue that has a left is nobody's left.
/// The order of the tissues does not matter.
///
/// # Errors
/// [`Error::Length`] where `lefts` is not one per tissue, [`Error::Index`] for a left that is no tissue.
pub fn fit_all(
    tissues: &[PlacedTissue],
    lefts: &[Option<usize>],
    skin: &SkinSurface,
) -> Result<Vec<PlacedTissue>> {
    require_length("lefts", tissues.len(), "one per tissue", lefts.len())?;
    for (position, &left) in lefts.iter().enumerate() {
        if let Some(left) = left.filter(|&left| left >= tissues.len()) {
            return Err(Error::Index {
                list: "lefts",
                position,
                found: left as i64,
                limit: tissues.len(),
                of: "tissues",
            });
        }
    }
    let left_of = |place: usize| {
        let left = lefts[place]?;
        (lefts[left].is_none() && tissues[place].is_image_of(&tissues[left])).then_some(left)
    };
    let first: Vec<Option<PlacedTissue>> = tissues
        .par_iter()
        .enumerate()
        .map(|(place, tissue)| left_of(place).is_none().then(|| fit(tissue, skin)))
        .collect();
    let all = tissues.par_iter().enumerate().map(|(place, tissue)| {
        if let Some(fitted) = &first[place] {
            return fitted.clone();
        }
        let left = left_of(place).and_then(|left| first[left].as_ref());
        left.and_then(|left| image_of(left, tissue, skin))
            .unwrap_or_else(|| fit(tissue, skin))
    });
    Ok(all.collect())
}

/// The mirror image of a fitted left tissue, if the skin is as far from it as from the left one.
fn image_of(left: &PlacedTissue, right: &PlacedTissue, skin: &SkinSurface) -> Option<PlacedTissue> {
    let image = right.as_image_of(left);
    Room::coarse(&image, skin)
        .is_image_of(&Room::coarse(left, skin), skin)
        .then_some(image)
}
