//! The faces of a surface in a hierarchy of boxes: where a ray meets them, and which is nearest to a point.

use std::cmp::Ordering;

use glam::DVec3;

use super::bvh::{Aabb, Bvh};
use super::polygons::Polygons;
use super::triangle::{Hit, Ray, nearest_weights, point_of};

/// Polygons, to be asked.
#[derive(Debug, Clone, Default)]
pub(super) struct FaceTree {
    /// In the order of the tree.
    polygons: Polygons,
    /// Which of the polygons given each is.
    given: Vec<u32>,
    tree: Bvh,
}

/// The point of a surface nearest to a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nearest {
    pub(super) point: DVec3,
    /// m².
    pub(super) distance_squared: f64,
    /// The polygon that it is on, as numbered where the tree was made.
    pub(super) face: usize,
    /// The triangle of that polygon's fan, in the order of [`Polygons::for_each_triangle`].
    pub(super) triangle: usize,
    /// How much of each of that triangle's corners it has.
    pub(super) weights: [f64; 3],
}

impl FaceTree {
    pub(super) fn new(polygons: &Polygons) -> Self {
        let bounds: Vec<Aabb> = (0..polygons.len())
            .map(|face| Aabb::around(polygons.corner_points(face)))
            .collect();
        let (tree, given) = Bvh::new(&bounds);
        Self {
            polygons: polygons.reordered(&given),
            given,
            tree,
        }
    }

    /// Where a ray first meets the surface. Of faces that it meets at one place, one that it leaves through.
    pub(super) fn first_hit(&self, ray: &Ray) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        self.tree.along(ray, |face, mut farthest| {
            self.polygons.for_each_triangle_in(
                face,
                |point| ray.to_own(point),
                |triangle| {
                    if let Some(hit) = Ray::hit(triangle)
                        && first.is_none_or(|first| in_order(&hit, &first) == Ordering::Less)
                    {
                        first = Some(hit);
                        farthest = hit.distance;
                    }
                },
            );
            farthest
        });
        first
    }

    /// All places where a ray meets the surface, rising. Hits in one direction that are less than `apart` from the one before
    /// are one: the ray met an edge.
    pub(super) fn crossings(&self, ray: &Ray, apart: f64) -> Vec<Hit> {
        let mut hits = vec![];
        self.tree.along(ray, |face, farthest| {
            let to_own = |point| ray.to_own(point);
            self.polygons
                .for_each_triangle_in(face, to_own, |triangle| hits.extend(Ray::hit(triangle)));
            farthest
        });
        hits.sort_by(in_order);
        let mut last = [f64::NEG_INFINITY; 2];
        hits.retain(|hit| {
            let last = &mut last[usize::from(hit.leaves)];
            let is_other = hit.distance >= *last + apart;
            if is_other {
                *last = hit.distance;
            }
            is_other
        });
        hits
    }

    /// The nearest point of the surface; of several the one with the lowest coordinates, and of its faces the first. `None`
    /// where there is no face.
    pub(super) fn nearest(&self, place: DVec3) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        self.tree.around(place, |face, mut farthest| {
            let given = self.given[face] as usize;
            let mut number = 0;
            self.polygons.for_each_triangle(face, |triangle| {
                let weights = nearest_weights(place, triangle);
                let point = point_of(weights, triangle);
                let found = Nearest {
                    point,
                    distance_squared: point.distance_squared(place),
                    face: given,
                    triangle: number,
                    weights,
                };
                number += 1;
                if best.is_none_or(|best| is_nearer(&found, &best)) {
                    best = Some(found);
                    farthest = found.distance_squared;
                }
            });
            farthest
        });
        best
    }
}

/// By distance; at one place leaving comes before entering.
fn in_order(a: &Hit, b: &Hit) -> Ordering {
    a.distance.total_cmp(&b.distance).then(b.leaves.cmp(&a.leaves))
}

fn is_nearer(a: &Nearest, b: &Nearest) -> bool {
    let by_coordinate = |axis: usize| a.point[axis].total_cmp(&b.point[axis]);
    a.distance_squared
        .total_cmp(&b.distance_squared)
        .then_with(|| by_coordinate(0))
        .then_with(|| by_coordinate(1))
        .then_with(|| by_coordinate(2))
        .then(a.face.cmp(&b.face))
        == Ordering::Less
}
