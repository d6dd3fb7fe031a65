//! Fills a body with its tissues: bellies and stuffing grow into the room between bones, neighbours and fat.
//! (docs/mathematics/fitting.md, Fill)
//!
//! Each point of the body belongs to the tissue whose surface is nearest. A tissue becomes the ellipsoid with the second
//! moments of its points (the centroidal power diagrams of de Goes et al. 2012, with ellipsoids for the sites), so that tissues
//! push each other aside. A muscle with a measured volume gains or loses points until it has that volume.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::belly::settled;
use super::body_grid::BodyGrid;
use super::growing::{Goal, Growing, Share};
use super::mirrored_fit::require_twins;
use super::placed_tissue::PlacedTissue;
use super::skin_surface::SkinSurface;
use super::via_points::moved_inside_skin;
use crate::error::{Result, require_length};

/// Number of times that points are shared out.
const ROUNDS: usize = 32;
/// Farthest point from the surface of a tissue that it can still grow to, over the size of the skin: 20 mm on a person.
const REACH_OF_SIZE: f64 = 0.012;

/// A tissue is in the middle of the body if its centre is at most this far from the plane x = 0, over the size of the skin.
const CENTRAL_OF_SIZE: f64 = 1e-4;

/// Tissues grown into the room that the body leaves.
///
/// Bones, spheres and curved muscles stay where they are. Straight muscles move across their axis, change both widths and a
/// little of their length; stuffing changes in any way. `goals`: one per tissue. `left_twins`: as for `fit_all`, which the
/// tissues should come from: a tissue that is the exact mirror image of its twin stays one.
///
/// # Errors
/// [`crate::Error::Length`] if there is not one goal and one twin per tissue.
pub fn fill(
    tissues: &[PlacedTissue],
    goals: &[Goal],
    left_twins: &[Option<usize>],
    skin: &SkinSurface,
) -> Result<Vec<PlacedTissue>> {
    require_length("goals", tissues.len(), "one per tissue", goals.len())?;
    require_length("left_twins", tissues.len(), "one per tissue", left_twins.len())?;
    let deepest_m = goals.iter().fold(0.0, |most: f64, goal| most.max(goal.fat_m));
    let grid = BodyGrid::new(skin, deepest_m.max(skin.margin_m()));
    require_twins(left_twins)?;
    let twin_of = |index: usize| {
        let twin = left_twins[index]?;
        let is_image = left_twins[twin].is_none() && is_exact_image(&tissues[index], &tissues[twin]);
        is_image.then_some(twin)
    };
    let mut growing: Vec<Growing> = (0..tissues.len())
        .map(|index| {
            Growing::new(
                &tissues[index],
                goals[index],
                twin_of(index),
                CENTRAL_OF_SIZE * skin.size_m(),
            )
        })
        .collect();
    let reach_m = REACH_OF_SIZE * skin.size_m();
    for _ in 0..ROUNDS {
        let owners = owners(&growing, &grid, reach_m);
        let mut shares = vec![Share::NOTHING; growing.len()];
        for (point, &owner) in owners.iter().enumerate() {
            if owner != NOBODY {
                shares[owner as usize].add(grid.point_at(point));
            }
        }
        for (tissue, share) in growing.iter_mut().zip(&shares) {
            if tissue.twin.is_none() {
                tissue.grow(share, grid.cell_m3(), reach_m);
            }
        }
        mirror_twins(&mut growing);
    }
    growing.par_iter_mut().for_each(|growing| {
        if growing.grows() && growing.twin.is_none() {
            let volume_m3 = growing.tissue.volume_m3();
            growing.tissue = moved_inside_skin(settled(growing.tissue.clone(), volume_m3, skin), skin);
        }
    });
    mirror_twins(&mut growing);
    Ok(growing.into_iter().map(|growing| growing.tissue).collect())
}

/// Makes each tissue with a twin the mirror image of it.
fn mirror_twins(growing: &mut [Growing]) {
    for index in 0..growing.len() {
        if let Some(twin) = growing[index].twin {
            growing[index].tissue = growing[index].tissue.as_image_of(&growing[twin].tissue);
            growing[index].bias_m = growing[twin].bias_m;
        }
    }
}

/// The owner of a point that no tissue reaches.
const NOBODY: u32 = u32::MAX;

/// The tissue that each point belongs to: the one whose surface is nearest, with its bias. A point in the fat of a tissue does
/// not belong to it.
fn owners(growing: &[Growing], grid: &BodyGrid, reach_m: f64) -> Vec<u32> {
    let mut owners = vec![NOBODY; grid.len()];
    let mut nearest_m = vec![f64::INFINITY; grid.len()];
    for (index, tissue) in growing.iter().enumerate() {
        let limit_m = if tissue.grows() { reach_m } else { 0.0 };
        for part in tissue.parts() {
            let half = (0..3).fold(DVec3::ZERO, |sum, axis| {
                let semi_axis = part.axes.col(axis) * part.semi_axes[axis];
                sum + semi_axis * semi_axis
            });
            let half = DVec3::new(half.x.sqrt(), half.y.sqrt(), half.z.sqrt()) + limit_m;
            let to_unit = DMat3::from_diagonal(part.semi_axes.recip()) * part.axes.transpose();
            for (point, position) in grid.within(part.centre - half, part.centre + half) {
                if grid.depth_m(point) < tissue.goal.fat_m {
                    continue;
                }
                let from_centre = position - part.centre;
                let relative = (to_unit * from_centre).length();
                let outside_m = from_centre.length() * (1.0 - 1.0 / relative.max(1e-6));
                if outside_m > limit_m {
                    continue;
                }
                let distance_m = if tissue.grows() {
                    outside_m - tissue.bias_m
                } else {
                    -reach_m + outside_m.min(0.0) - skin_of_bone(reach_m)
                };
                if distance_m < nearest_m[point] {
                    nearest_m[point] = distance_m;
                    owners[point] = index as u32;
                }
            }
        }
    }
    owners
}

/// What makes a point inside a bone belong to it, whatever the bias of others, m.
fn skin_of_bone(reach_m: f64) -> f64 {
    10.0 * reach_m
}

fn is_exact_image(right: &PlacedTissue, left: &PlacedTissue) -> bool {
    let image = right.as_image_of(left);
    image.at.centre == right.at.centre && image.at.semi_axes == right.at.semi_axes
}
