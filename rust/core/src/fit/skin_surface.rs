//! The skin in the rest pose, for rays from inside the body, inside tests and nearest points.
//! (docs/mathematics/fitting.md, Fit under the skin)
//!
//! A ray from inside a limb first hits that limb's skin, however near the torso is, so searches around a bone use rays, not
//! nearest points.

use glam::DVec3;
use rayon::prelude::*;

use super::face_tree::FaceTree;
use super::polygons::Polygons;
use super::triangle::Ray;
use crate::error::{Error, Result};

/// Margin between a belly and the skin, over the size of the skin: 1-2 mm on a person.
const MARGIN_OF_SIZE: f64 = 0.001;
/// Hits less than this apart, over the size of the skin, are one hit of an edge.
const SAME_SKIN_OF_SIZE: f64 = 1e-6;
/// Directions of the rays of the inside test, of about unit length. They are perpendicular to x, so that the test is the same
/// on the left and on the right.
const INSIDE_TEST: [DVec3; 3] = [
    DVec3::new(0.0, 0.36, 0.93),
    DVec3::new(0.0, -0.8, -0.6),
    DVec3::new(0.0, 0.86, -0.51),
];

/// The skin of a body: one mesh or several, as one surface.
///
/// Meshes and their parts may overlap. The normals of each mesh must agree with each other, and may all point inward.
///
/// ```
/// use glam::DVec3;
/// use sinew_core::fit::{PolygonMesh, Polygons, SkinSurface};
///
/// let tetrahedron = Polygons::new(&PolygonMesh {
///     points: &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     corners: &[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
///     face_offsets: &[0, 3, 6, 9, 12],
///     to_space: None,
/// })?;
/// let skin = SkinSurface::new(&[&tetrahedron])?;
/// let inside = DVec3::splat(0.125);
/// assert!(skin.is_inside(inside));
/// assert_eq!(skin.distance_along(inside, DVec3::NEG_Z), Some(0.125));
/// assert_eq!(skin.nearest(inside).distance_m, 0.125);
/// # Ok::<(), sinew_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SkinSurface {
    faces: FaceTree,
    bounds: (DVec3, DVec3),
    size_m: f64,
}

/// The point of a skin nearest to a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestSkin {
    /// The point, m.
    pub point: DVec3,
    /// Its distance, m.
    pub distance_m: f64,
}

impl SkinSurface {
    /// The skin of some meshes, all in one space, m. Neither their order nor that of their faces matters.
    ///
    /// # Errors
    /// [`Error::NoFaces`] if a mesh has no faces or there are no meshes.
    pub fn new(meshes: &[&Polygons]) -> Result<Self> {
        let mut all = Polygons::default();
        for (mesh, polygons) in meshes.iter().enumerate() {
            if polygons.is_empty() {
                return Err(Error::NoFaces { mesh });
            }
            all.append(polygons, polygons.signed_volume_times_6() < 0.0);
        }
        let (low, high) = all.bounds().ok_or(Error::NoFaces { mesh: 0 })?;
        Ok(Self {
            faces: FaceTree::new(&all),
            bounds: (low, high),
            size_m: (high - low).max_element(),
        })
    }

    /// The longest side of the box around the skin, m.
    pub fn size_m(&self) -> f64 {
        self.size_m
    }

    /// The corners of the box around the skin, m.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Whether the skin encloses each of `count` points from `start` along y, `spacing_m` apart. Where it is not closed along
    /// this line, each point is tested alone.
    pub(super) fn inside_along_y(&self, start: DVec3, spacing_m: f64, count: usize) -> Vec<bool> {
        let below = DVec3::new(start.x, self.bounds.0.y - self.size_m, start.z);
        let crossings = self
            .faces
            .crossings(&Ray::new(below, DVec3::Y), SAME_SKIN_OF_SIZE * self.size_m);
        let mut shells = 0_i32;
        let mut is_closed = true;
        let mut next = crossings.iter().peekable();
        let mut inside = Vec::with_capacity(count);
        for index in 0..count {
            let at_m = start.y + index as f64 * spacing_m - below.y;
            while let Some(hit) = next.next_if(|hit| hit.distance <= at_m) {
                shells += if hit.leaves { -1 } else { 1 };
                is_closed &= shells >= 0;
            }
            inside.push(shells > 0);
        }
        let left: i32 = next.map(|hit| if hit.leaves { -1 } else { 1 }).sum();
        if is_closed && shells + left == 0 {
            return inside;
        }
        let point = |index: usize| start + DVec3::Y * (index as f64 * spacing_m);
        (0..count).map(|index| self.is_inside(point(index))).collect()
    }

    /// Margin between a fitted belly and the skin, m: 1-2 mm on a person.
    pub fn margin_m(&self) -> f64 {
        MARGIN_OF_SIZE * self.size_m
    }

    /// The distance from a point inside to the skin, in lengths of `direction`: 0 if the point is outside, `None` if the ray
    /// does not hit the skin or `direction` is 0.
    pub fn distance_along(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        if direction == DVec3::ZERO {
            return None;
        }
        let ray = Ray::new(origin, direction);
        let first = self.faces.first_hit(&ray)?;
        if first.leaves {
            return Some(first.distance);
        }
        Some(self.distance_through_shells(&ray, SAME_SKIN_OF_SIZE * self.size_m / direction.length()))
    }

    /// The same for a ray that first enters a surface: it starts outside, or in a shell that overlaps others.
    fn distance_through_shells(&self, ray: &Ray, apart: f64) -> f64 {
        let crossings = self.faces.crossings(ray, apart);
        let change = |leaves: bool| if leaves { -1_i64 } else { 1 };
        let mut shells = -crossings.iter().map(|hit| change(hit.leaves)).sum::<i64>();
        if shells <= 0 {
            return 0.0;
        }
        for hit in crossings {
            shells += change(hit.leaves);
            if shells == 0 {
                return hit.distance;
            }
        }
        0.0
    }

    /// Whether the skin encloses a point: at least two of three rays leave through it. For closed meshes, this is where the
    /// winding number is above 0.
    pub fn is_inside(&self, point: DVec3) -> bool {
        let leaves_along =
            |direction: &&DVec3| self.distance_along(point, **direction).is_some_and(|m| m > 0.0);
        INSIDE_TEST.iter().filter(leaves_along).count() >= 2
    }

    /// The nearest point of the skin, for a point inside or outside.
    pub fn nearest(&self, point: DVec3) -> NearestSkin {
        // never the default: there is a face
        self.faces.nearest(point).map_or(
            NearestSkin {
                point,
                distance_m: 0.0,
            },
            |nearest| NearestSkin {
                point: nearest.point,
                distance_m: nearest.distance_squared.sqrt(),
            },
        )
    }

    /// [`SkinSurface::distance_along`] for many rays, on all threads; NaN where a ray does not hit the skin.
    ///
    /// # Errors
    /// [`Error::Length`] if there are not as many directions as origins.
    pub fn distances_along(&self, origins: &[[f64; 3]], directions: &[[f64; 3]]) -> Result<Vec<f64>> {
        crate::error::require_length("directions", origins.len(), "one per origin", directions.len())?;
        let distance = |(origin, direction): (&[f64; 3], &[f64; 3])| {
            self.distance_along((*origin).into(), (*direction).into())
                .unwrap_or(f64::NAN)
        };
        Ok(origins.par_iter().zip(directions).map(distance).collect())
    }

    /// [`SkinSurface::is_inside`] for many points, on all threads.
    pub fn are_inside(&self, points: &[[f64; 3]]) -> Vec<bool> {
        points
            .par_iter()
            .map(|point| self.is_inside((*point).into()))
            .collect()
    }

    /// [`SkinSurface::nearest`] for many points, on all threads.
    pub fn nearest_to_all(&self, points: &[[f64; 3]]) -> Vec<NearestSkin> {
        points
            .par_iter()
            .map(|point| self.nearest((*point).into()))
            .collect()
    }
}
