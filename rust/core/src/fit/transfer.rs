//! From one surface to another in its place: for each point of the new one where it is nearest to the old one, and the values
//! that the old one has there.

use rayon::prelude::*;

use super::face_tree::{FaceTree, Nearest};
use super::polygons::Polygons;
use crate::error::{Error, Result, require, require_length};

/// Where each part of a new surface is nearest to an old one.
#[derive(Debug, Clone)]
pub struct SurfaceTransfer {
    /// Number of corners of the old surface.
    corner_count: usize,
    /// Where the entries of each new vertex start in `corners` and `shares`, and their number.
    offsets: Vec<u32>,
    /// Corners of the old face that is nearest to a new vertex, among all corners.
    corners: Vec<u32>,
    /// How much of each corner, 0 to 1.
    shares: Vec<f64>,
    is_near: Vec<bool>,
    nearest_faces: Vec<u32>,
}

/// What one new vertex is nearest to.
#[derive(Default)]
struct Source {
    face: usize,
    shares: Vec<f64>,
    is_near: bool,
}

impl SurfaceTransfer {
    /// From the surface `former` to the surface `made`, in one space, on all threads. `near_m` is how far away, m, the old
    /// surface may be for a new vertex to take something from it.
    ///
    /// # Errors
    /// [`Error::NoFaces`] where `former` has none, [`Error::Value`] for `near_m` that is not a number of 0 or more.
    pub fn new(former: &Polygons, made: &Polygons, near_m: f64) -> Result<Self> {
        if former.is_empty() {
            return Err(Error::NoFaces { mesh: 0 });
        }
        require(
            near_m >= 0.0,
            || "Transfer".to_owned(),
            "near (m)",
            near_m,
            "0 or more",
        )?;
        let tree = FaceTree::new(former);
        let sources: Vec<Source> = made
            .points()
            .par_iter()
            .map(|&point| {
                // there is a face, so there is a nearest one
                tree.nearest(point)
                    .map_or_else(Source::default, |nearest| Source {
                        face: nearest.face,
                        shares: shares_of(&nearest, former.places(nearest.face).len()),
                        is_near: nearest.distance_squared.sqrt() <= near_m,
                    })
            })
            .collect();
        let nearest_faces = (0..made.len())
            .into_par_iter()
            .map(|face| {
                tree.nearest(made.middle(face))
                    .map_or(0, |found| found.face as u32)
            })
            .collect();
        let mut transfer = Self {
            corner_count: former.corner_count(),
            offsets: vec![0],
            corners: vec![],
            shares: vec![],
            is_near: sources.iter().map(|source| source.is_near).collect(),
            nearest_faces,
        };
        for source in &sources {
            for (corner, &share) in former.places(source.face).zip(&source.shares) {
                transfer.corners.push(corner as u32);
                transfer.shares.push(share);
            }
            transfer.offsets.push(transfer.corners.len() as u32);
        }
        Ok(transfer)
    }

    /// Number of vertices of the new surface.
    pub fn vertex_count(&self) -> usize {
        self.is_near.len()
    }

    /// Number of corners of all faces of the old surface.
    pub fn corner_count(&self) -> usize {
        self.corner_count
    }

    /// Whether the old surface is near, for each new vertex.
    pub fn is_near(&self) -> &[bool] {
        &self.is_near
    }

    /// For each new face the old one that is nearest to its middle.
    pub fn nearest_faces(&self) -> &[u32] {
        &self.nearest_faces
    }

    /// For each new vertex that corner, among all corners of the old surface, of which it has most.
    pub fn nearest_corners(&self) -> Vec<u32> {
        let most = |vertex: usize| {
            let mut best = (f64::NEG_INFINITY, 0);
            for (corner, share) in self.entries(vertex) {
                if share > best.0 {
                    best = (share, corner);
                }
            }
            best.1
        };
        (0..self.vertex_count()).map(most).collect()
    }

    /// Values of the old surface mixed for each new vertex; 0 where the old surface is not near.
    ///
    /// `values` holds `width` numbers for each corner of the old surface; the result as many for each new vertex.
    ///
    /// # Errors
    /// [`Error::Length`] where `values` is not `width` numbers a corner.
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
                for (place, number) in out.iter_mut().enumerate() {
                    let part = |(corner, share): (u32, f64)| {
                        share * f64::from(values[corner as usize * width + place])
                    };
                    *number = self.entries(vertex).map(part).sum::<f64>() as f32;
                }
            }
        });
        Ok(mixed)
    }

    fn entries(&self, vertex: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let own = self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize;
        let corners = self.corners[own.clone()].iter().copied();
        corners.zip(self.shares[own].iter().copied())
    }
}

/// How much of each of its polygon's corners a point has: its share of the fan's middle is one of all corners alike.
fn shares_of(nearest: &Nearest, corners: usize) -> Vec<f64> {
    if corners == nearest.weights.len() {
        return nearest.weights.to_vec();
    }
    let [from, to, middle] = nearest.weights;
    let mut shares = vec![middle / corners as f64; corners];
    shares[(nearest.triangle + corners - 1) % corners] += from;
    shares[nearest.triangle] += to;
    shares
}
