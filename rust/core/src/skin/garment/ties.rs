//! A garment's ties to the body under it, found in the rest pose (mathematics/garments.md, Ties).

use std::sync::Arc;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use crate::error::{Result, require_length, require_triangles};
use crate::fit::{FaceTree, Polygons};
use crate::math::rows::Rows;
use crate::math::smoothstep::smooth_step;
use crate::skin::garment::body::Body;
use crate::skin::skin::Skin;

/// Distances from the body, over its size, up to which a garment follows it whole, and from which it does not
/// follow it: 3.5 and 14 cm on a person. Between them the folds of a skirt hang more and more freely.
const NEAR_OF_SIZE: f64 = 0.02;
const FAR_OF_SIZE: f64 = 0.08;
/// Smallest cosine between the normal of the body and the direction to the garment with which the garment
/// covers the body there.
const COVERING: f64 = 0.5;

/// A vertex of one mesh and the triangle of the other mesh that is nearest to it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tie {
    /// Sorted indices of the triangle's corners.
    pub corners: [u32; 3],
    /// Barycentric coordinates of the nearest point.
    pub weights: [f32; 3],
    /// Distance of the garment from the body along the body's normal, m; negative inside.
    pub thickness_m: f32,
}

impl Tie {
    /// The weighted mean of the corners' values.
    pub fn mean(&self, of_vertices: &[Vec3A]) -> Vec3A {
        let [a, b, c] = self.corners.map(|corner| of_vertices[corner as usize]);
        let [u, v, w] = self.weights;
        a * u + b * v + c * w
    }
}

/// All ties of a garment.
#[derive(Debug)]
pub(crate) struct Ties {
    pub body: Body,
    /// The body under each vertex of the garment, and how fully the vertex follows it, 0 to 1.
    pub of_vertices: Vec<(Tie, f32)>,
    /// The garment above vertices of the body: the body's vertex by sorted index, and the garment's triangle.
    pub covers: Vec<(u32, Tie)>,
    /// The neighbours of each vertex of the garment along the edges of its triangles.
    pub beside: Rows<u32>,
    /// Largest distance by which the garment is pushed out of the body at once, m.
    pub largest_push_m: f32,
}

impl Skin {
    /// The same skin as a garment over `body`. It follows the body's correction in place of its tissues.
    /// `body_triangles` and `triangles` are those of the two meshes.
    ///
    /// # Errors
    /// A body with another musculature or without triangles, or a triangle with a vertex that does not exist.
    pub fn worn_over(
        mut self,
        body: Arc<Skin>,
        body_triangles: &[[i32; 3]],
        triangles: &[[i32; 3]],
    ) -> Result<Self> {
        let (bones, tissues) = (self.musculature().skeleton().len(), self.musculature().len());
        let of_body = (body.musculature().skeleton().len(), body.musculature().len());
        require_length("body's bones", bones, "as many as the garment's", of_body.0)?;
        require_length("body's tissues", tissues, "as many as the garment's", of_body.1)?;
        let triangles = self.order.triangles(require_triangles(triangles, self.len())?);
        let body = Body::new(body, body_triangles)?;
        let size = body.size_m();
        let points: Vec<DVec3> = self.points.iter().map(|point| point.as_dvec3()).collect();
        let ties = ties(&points, &body, size);
        let triangles = triangles.entries();
        let covers = covers(&points, triangles, &body, NEAR_OF_SIZE * size);
        let ends = |&[a, b, c]: &[u32; 3]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)];
        self.garment = Some(Box::new(Ties {
            body,
            of_vertices: ties,
            covers,
            beside: Rows::from_set(points.len(), triangles.iter().flat_map(ends).collect()),
            largest_push_m: (NEAR_OF_SIZE * size) as f32,
        }));
        Ok(self)
    }
}

/// The body under each of the garment's `points`, and how fully the point follows it.
fn ties(points: &[DVec3], body: &Body, size_m: f64) -> Vec<(Tie, f32)> {
    let tree = FaceTree::new(&Polygons::of_triangles(body.rest_points(), body.triangles()));
    let (near_m, far_m) = (NEAR_OF_SIZE * size_m, FAR_OF_SIZE * size_m);
    let of_point = |&point: &DVec3| {
        // never the default: a body has triangles
        let nearest = tree.nearest(point).unwrap_or_default();
        let tie = Tie {
            corners: body.triangles()[nearest.face],
            weights: nearest.weights.map(|weight| weight as f32),
            thickness_m: 0.0,
        };
        let normal = tie.mean(body.rest_normals()).normalize_or_zero().as_dvec3();
        let thickness_m = (point - nearest.point).dot(normal) as f32;
        let distance_m = nearest.distance_squared.sqrt();
        let fraction = 1.0 - smooth_step((distance_m - near_m) / (far_m - near_m));
        (Tie { thickness_m, ..tie }, fraction as f32)
    };
    points.par_iter().map(of_point).collect()
}

/// The vertices of the body that the garment covers within `near_m`.
fn covers(points: &[DVec3], triangles: &[[u32; 3]], body: &Body, near_m: f64) -> Vec<(u32, Tie)> {
    if triangles.is_empty() {
        return vec![];
    }
    let tree = FaceTree::new(&Polygons::of_triangles(points.to_vec(), triangles));
    let of_vertex = |(vertex, (point, normal)): (usize, (DVec3, &Vec3A))| {
        let nearest = tree.nearest(point)?;
        let (distance_m, thickness_m) = (
            nearest.distance_squared.sqrt(),
            (nearest.point - point).dot(normal.as_dvec3()),
        );
        let is_covered = distance_m < near_m && thickness_m > COVERING * distance_m;
        is_covered.then(|| {
            let tie = Tie {
                corners: triangles[nearest.face],
                weights: nearest.weights.map(|weight| weight as f32),
                thickness_m: thickness_m as f32,
            };
            (vertex as u32, tie)
        })
    };
    let vertices = body
        .rest_points()
        .into_par_iter()
        .zip(body.rest_normals())
        .enumerate();
    vertices.filter_map(of_vertex).collect()
}
