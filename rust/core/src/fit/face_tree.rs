//! The faces of a surface in a bounding volume hierarchy, for the hits of rays and nearest points.
//! (docs/mathematics/fitting.md, Fit under the skin)

use std::cmp::Ordering;

use glam::DVec3;

use super::bvh::{Aabb, Bvh};
use super::polygons::Polygons;
use super::triangle::{Hit, Ray, nearest_weights, point_of};

/// The faces of a surface, sorted for queries.
#[derive(Debug, Clone, Default)]
pub(crate) struct FaceTree {
    /// In the order of the tree.
    polygons: Polygons,
    /// For each polygon of the tree its index in the input.
    original_face: Vec<u32>,
    tree: Bvh,
}

/// The point of a surface nearest to a position.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Nearest {
    pub(crate) point: DVec3,
    /// Squared distance to the position, m².
    pub(crate) distance_squared: f64,
    /// The polygon that contains it, as an index in the input of [`FaceTree::new`].
    pub(crate) face: usize,
    /// The triangle of that polygon's fan, in the order of [`Polygons::for_each_triangle`].
    pub(super) triangle: usize,
    /// Its barycentric coordinates in that triangle.
    pub(crate) weights: [f64; 3],
}

impl FaceTree {
    pub(crate) fn new(polygons: &Polygons) -> Self {
        let bounds: Vec<Aabb> = (0..polygons.len())
            .map(|face| Aabb::around(polygons.corner_points(face)))
            .collect();
        let (tree, original_face) = Bvh::new(&bounds);
        Self {
            polygons: polygons.reordered(&original_face),
            original_face,
            tree,
        }
    }

    /// The first hit of a ray. Of several hits at the same distance, one through which the ray leaves.
    pub(super) fn first_hit(&self, ray: &Ray) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        self.tree.along(ray, |face, mut farthest| {
            self.polygons.for_each_triangle_in(
                face,
                |point| ray.to_ray_space(point),
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

    /// All hits of a ray, by distance. A hit that is less than `apart` behind the last one in the same direction (in or out) is
    /// dropped, because the ray hit an edge.
    pub(super) fn crossings(&self, ray: &Ray, apart: f64) -> Vec<Hit> {
        let mut hits = vec![];
        self.tree.along(ray, |face, farthest| {
            let to_ray_space = |point| ray.to_ray_space(point);
            self.polygons
                .for_each_triangle_in(face, to_ray_space, |triangle| hits.extend(Ray::hit(triangle)));
            farthest
        });
        hits.sort_by(in_order);
        let mut last = [f64::NEG_INFINITY; 2];
        hits.retain(|hit| {
            let last = &mut last[usize::from(hit.leaves)];
            let is_new = hit.distance >= *last + apart;
            if is_new {
                *last = hit.distance;
            }
            is_new
        });
        hits
    }

    /// The nearest point of the surface; of several, the one with the lowest coordinates, on the first of its faces. `None` if
    /// there are no faces.
    pub(crate) fn nearest(&self, position: DVec3) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        self.tree.around(position, |face, mut farthest| {
            let original_face = self.original_face[face] as usize;
            let mut triangle_index = 0;
            self.polygons.for_each_triangle(face, |triangle| {
                let weights = nearest_weights(position, triangle);
                let point = point_of(weights, triangle);
                let candidate = Nearest {
                    point,
                    distance_squared: point.distance_squared(position),
                    face: original_face,
                    triangle: triangle_index,
                    weights,
                };
                triangle_index += 1;
                if best.is_none_or(|best| is_nearer(&candidate, &best)) {
                    best = Some(candidate);
                    farthest = candidate.distance_squared;
                }
            });
            farthest
        });
        best
    }
}

/// By distance; at the same distance, leaving comes before entering.
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
