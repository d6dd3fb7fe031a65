//! Fits many tissues; on a symmetric body the right side is the exact mirror image of the left.
//! (docs/mathematics/fitting.md, Fit under the skin)

use rayon::prelude::*;

use super::belly::fit;
use super::clearance::Clearance;
use super::placed_tissue::PlacedTissue;
use super::skin_surface::SkinSurface;
use crate::error::{Error, Result, require_length};

/// Each tissue fitted under `skin`, on all threads.
///
/// `left_twins`: for each tissue its twin on the left, if it has one. A tissue becomes the mirror image of its fitted twin if
/// both were placed as mirror images, the twin has no twin itself, and the clearance of both is the same. Otherwise it is
/// fitted alone. The order of the tissues does not matter.
///
/// # Errors
/// [`Error::Length`] if `left_twins` is not one per tissue, [`Error::Index`] for a twin that is not a tissue.
pub fn fit_all(
    tissues: &[PlacedTissue],
    left_twins: &[Option<usize>],
    skin: &SkinSurface,
) -> Result<Vec<PlacedTissue>> {
    require_length("left_twins", tissues.len(), "one per tissue", left_twins.len())?;
    require_twins(left_twins)?;
    let twin_of = |index: usize| {
        let twin = left_twins[index]?;
        (left_twins[twin].is_none() && tissues[index].is_image_of(&tissues[twin])).then_some(twin)
    };
    let fitted_alone: Vec<Option<PlacedTissue>> = tissues
        .par_iter()
        .enumerate()
        .map(|(index, tissue)| twin_of(index).is_none().then(|| fit(tissue, skin)))
        .collect();
    let all = tissues.par_iter().enumerate().map(|(index, tissue)| {
        if let Some(fitted) = &fitted_alone[index] {
            return fitted.clone();
        }
        let left = twin_of(index).and_then(|twin| fitted_alone[twin].as_ref());
        left.and_then(|left| image_of(left, tissue, skin))
            .unwrap_or_else(|| fit(tissue, skin))
    });
    Ok(all.collect())
}

/// The mirror image of a fitted left tissue, if it has the same clearance as the left one.
fn image_of(left: &PlacedTissue, right: &PlacedTissue, skin: &SkinSurface) -> Option<PlacedTissue> {
    let image = right.as_image_of(left);
    Clearance::coarse(&image, skin)
        .is_image_of(&Clearance::coarse(left, skin), skin)
        .then_some(image)
}

/// Checks that each twin is a tissue.
pub(super) fn require_twins(left_twins: &[Option<usize>]) -> Result<()> {
    for (position, &twin) in left_twins.iter().enumerate() {
        if let Some(twin) = twin.filter(|&twin| twin >= left_twins.len()) {
            return Err(Error::Index {
                list: "left_twins",
                position,
                found: twin as i64,
                limit: left_twins.len(),
                of: "tissues",
            });
        }
    }
    Ok(())
}
