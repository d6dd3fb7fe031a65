//! A part of a surface that is measured on its own: the skin around a joint, or the whole surface.

use glam::DVec3;

use super::dihedral::dihedrals;
use super::topology::{InnerEdge, boundary_loops, edges, inner_edges};
use super::volume::Closed;
use super::winding::{WindingVolumes, winding_volumes};

/// Fraction of the cube around a region below which its volume counts as 0.
const FLAT: f64 = 1e-9;

/// Some triangles of a surface, and their measurements at rest. For volumes it is closed over its boundary
/// loops.
#[derive(Debug, Clone)]
pub struct SurfaceRegion {
    pub(super) faces: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) edges: Vec<[u32; 2]>,
    pub(super) inner_edges: Vec<InnerEdge>,
    pub(super) rest_degrees: Vec<f64>,
    boundary_loops: Vec<Vec<u32>>,
    rest_volume: f64,
    rest: WindingVolumes,
    is_flat: bool,
}

/// Volumes over rest; 1, 1, 0 and 0 for a flat region.
#[derive(Debug, Clone, Copy)]
pub(super) struct VolumeRatios {
    pub signed: f64,
    pub union: f64,
    pub overlap: f64,
    pub inside_out: f64,
    pub unreadable: f64,
}

impl SurfaceRegion {
    pub(super) fn new(faces: Vec<u32>, points: &[DVec3], all: &[[u32; 3]]) -> Self {
        let triangles: Vec<[u32; 3]> = faces.iter().map(|&face| all[face as usize]).collect();
        let (boundary_loops, inner_edges) = (boundary_loops(&triangles), inner_edges(&triangles));
        let closed = Closed::new(points, &triangles, &boundary_loops);
        let (low, high) = closed.bounds();
        let (rest_volume, rest) = (closed.volume(), winding_volumes(&closed));
        let flat = FLAT * (high - low).max_element().powi(3);
        Self {
            edges: edges(&triangles),
            rest_degrees: dihedrals(points, &triangles, &inner_edges),
            is_flat: rest_volume.abs() <= flat || rest.union <= flat,
            faces,
            triangles,
            inner_edges,
            boundary_loops,
            rest_volume,
            rest,
        }
    }

    /// Its triangles, as indices of the surface's triangles, increasing.
    pub fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// Occupied volume at rest, closed over its boundary loops, m³.
    pub fn rest_union(&self) -> f64 {
        self.rest.union
    }

    pub(super) fn volumes(&self, posed: &[DVec3]) -> VolumeRatios {
        let closed = Closed::new(posed, &self.triangles, &self.boundary_loops);
        let now = winding_volumes(&closed);
        if self.is_flat {
            return VolumeRatios {
                signed: 1.0,
                union: 1.0,
                overlap: 0.0,
                inside_out: 0.0,
                unreadable: now.unreadable,
            };
        }
        VolumeRatios {
            signed: closed.volume() / self.rest_volume,
            union: now.union / self.rest.union,
            overlap: now.overlap / self.rest.union,
            inside_out: now.inside_out / self.rest.union,
            unreadable: now.unreadable,
        }
    }
}
