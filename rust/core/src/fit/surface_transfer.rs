//! Surface transfer: for each vertex of a new surface, the nearest point of the old one and its values.
//! (docs/mathematics/fitting.md, Surface transfer)

use rayon::prelude::*;

use super::face_tree::{FaceTree, Nearest};
use super::polygons::Polygons;
use crate::error::{Error, Result, require, require_length};
use crate::math::rows::Rows;

/// The nearest points of an old surface for the vertices and faces of a new one.
#[derive(Debug, Clone)]
pub struct SurfaceTransfer {
    /// Number of corners of the old surface.
    corner_count: usize,
    /// For each new vertex the corners of the nearest old face, as indices of all old corners, and their weights, 0 to 1.
    corner_weights: Rows<(u32, f64)>,
    is_near: Vec<bool>,
    nearest_faces: Vec<u32>,
}

/// The nearest point of the old surface for one new vertex.
#[derive(Default)]
struct Source {
    face: usize,
    weights: Vec<f64>,
    is_near: bool,
}

impl SurfaceTransfer {
    /// The transfer from the surface `old` to the surface `new`, in one space, on all threads. A new vertex farther from the
    /// old surface than `max_distance_m` takes no values.
    ///
    /// # Errors
    /// [`Error::NoFaces`] if `old` has no faces, [`Error::Value`] if `max_distance_m` is negative or NaN.
    pub fn new(old: &Polygons, new: &Polygons, max_distance_m: f64) -> Result<Self> {
        if old.is_empty() {
            return Err(Error::NoFaces { mesh: 0 });
        }
        require(
            max_distance_m >= 0.0,
            || "Transfer".to_owned(),
            "max_distance (m)",
            max_distance_m,
            "0 or more",
        )?;
        let tree = FaceTree::new(old);
        let sources: Vec<Source> = new
            .points()
            .par_iter()
            .map(|&point| {
                // never the default: `old` has a face
                tree.nearest(point)
                    .map_or_else(Source::default, |nearest| Source {
                        face: nearest.face,
                        weights: corner_weights(&nearest, old.corner_range(nearest.face).len()),
                        is_near: nearest.distance_squared.sqrt() <= max_distance_m,
                    })
            })
            .collect();
        let nearest_faces = (0..new.len())
            .into_par_iter()
            .map(|face| {
                tree.nearest(new.middle(face))
                    .map_or(0, |nearest| nearest.face as u32)
            })
            .collect();
        let row = |source: &Source| {
            let corners = old.corner_range(source.face).map(|corner| corner as u32);
            corners.zip(source.weights.clone())
        };
        Ok(Self {
            corner_count: old.corner_count(),
            corner_weights: Rows::from_rows(sources.iter().map(row)),
            is_near: sources.iter().map(|source| source.is_near).collect(),
            nearest_faces,
        })
    }

    /// Number of vertices of the new surface.
    pub fn vertex_count(&self) -> usize {
        self.is_near.len()
    }

    /// Number of corners of the old surface.
    pub fn corner_count(&self) -> usize {
        self.corner_count
    }

    /// For each new vertex whether the old surface is within the largest distance.
    pub fn is_near(&self) -> &[bool] {
        &self.is_near
    }

    /// For each new face the old face nearest to its middle.
    pub fn nearest_faces(&self) -> &[u32] {
        &self.nearest_faces
    }

    /// For each new vertex the corner of the old surface with the largest weight, as an index of all old corners.
    pub fn nearest_corners(&self) -> Vec<u32> {
        let nearest = |row: &[(u32, f64)]| {
            let mut best = (f64::NEG_INFINITY, 0);
            for &(corner, weight) in row {
                if weight > best.0 {
                    best = (weight, corner);
                }
            }
            best.1
        };
        self.corner_weights.rows().map(nearest).collect()
    }

    /// Weighted means of the old surface's values for each new vertex; 0 where the old surface is not near.
    ///
    /// `values` holds `width` numbers per corner of the old surface, the result `width` numbers per new vertex.
    ///
    /// # Errors
    /// [`Error::Length`] if `values` does not have `width` numbers per corner.
    pub fn mixed(&self, values: &[f32], width: usize) -> Result<Vec<f32>> {
        require_length(
            "values",
            self.corner_count * width,
            "width numbers per corner",
            values.len(),
        )?;
        let mut mixed = vec![0.0; self.vertex_count() * width];
        if width == 0 {
            return Ok(mixed);
        }
        mixed.par_chunks_mut(width).enumerate().for_each(|(vertex, out)| {
            if self.is_near[vertex] {
                for (column, number) in out.iter_mut().enumerate() {
                    let weighted = |&(corner, weight): &(u32, f64)| {
                        weight * f64::from(values[corner as usize * width + column])
                    };
                    *number = self.corner_weights.row(vertex).iter().map(weighted).sum::<f64>() as f32;
                }
            }
        });
        Ok(mixed)
    }
}

/// The weights of a polygon's corners at one of its points. All corners have the same weight in the middle of its fan.
fn corner_weights(nearest: &Nearest, corners: usize) -> Vec<f64> {
    if corners == nearest.weights.len() {
        return nearest.weights.to_vec();
    }
    let [from, to, middle] = nearest.weights;
    let mut weights = vec![middle / corners as f64; corners];
    weights[(nearest.triangle + corners - 1) % corners] += from;
    weights[nearest.triangle] += to;
    weights
}
