//! The quality of a deformed skin compared with its rest pose: occupied volume, stretch, inverted faces,
//! self-intersections, smoothness, jitter and pop (mathematics/quality.md). It does not depend on bones, so
//! it measures any deformer.
//!
//! The same input gives the same bits on any number of threads. Degenerate input is allowed: faces without
//! area, loose vertices, edges of three and more faces, open surfaces.

mod dihedral;
mod motion;
mod region;
mod self_intersections;
mod topology;
mod volume;
mod winding;

use glam::DVec3;

pub use self::motion::{Jitter, Motion, Pop};
pub use self::region::SurfaceRegion;
pub use crate::faults::stretch::EdgeStretch;

use self::dihedral::bend_p99;
use self::self_intersections::{new_intersections, self_intersections};
use self::topology::{edges, largest_component};
use crate::error::require_length;
use crate::error::require_triangles;
use crate::error::{Error, Result};
use crate::faults::inverted::Neighbourhoods;
use crate::faults::stretch::{area_stretch_p99, edge_stretch, vertex_stretch};
use crate::math::rows::Rows;

/// A triangulated skin in the rest pose, with which deformed states are compared.
#[derive(Debug)]
pub struct RestSurface {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    neighbourhoods: Neighbourhoods,
    rest_intersections: Vec<[u32; 2]>,
}

/// One deformed state of a [`RestSurface`], and the measurements of its whole surface.
#[derive(Debug)]
pub struct DeformedSurface {
    points: Vec<DVec3>,
    /// Whether each triangle is inverted relative to the surrounding skin.
    pub inverted: Vec<bool>,
    /// Pairs of triangles that intersect but did not at rest, sorted, the lower index first.
    pub new_intersections: Vec<[u32; 2]>,
}

/// The quality of one region in one deformed state. Ratios are over rest: 1 is unchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinQuality {
    /// Occupied volume: everything inside the surface, counted once (by winding number).
    pub union: f64,
    /// Volume that is occupied more than once, over the volume occupied at rest.
    pub overlap: f64,
    /// Volume turned inside out, over the volume occupied at rest.
    pub inside_out: f64,
    /// Fraction of the rays that could not be evaluated, for example at a hole; 0 for a region of a closed
    /// mesh.
    pub unreadable: f64,
    /// Signed volume, in which folds count twice.
    pub volume: f64,
    /// Stretch of the edges.
    pub edge: EdgeStretch,
    /// 99th percentile of `max(A / A0, A0 / A)` over triangles of area A.
    pub area_p99: f64,
    /// Number of inverted triangles.
    pub inverted: usize,
    /// Number of new self-intersections with at least one triangle in the region.
    pub new_intersections: usize,
    /// 99th percentile of the change of the angle between the two faces at an edge, degrees.
    pub bend_p99: f64,
}

impl RestSurface {
    /// The surface of `triangles` (indices of points) over rest `points`, m.
    ///
    /// # Errors
    /// [`Error::NoVertices`]; [`Error::Index`] for a corner that is not a vertex.
    pub fn new(points: &[[f32; 3]], triangles: &[[i32; 3]]) -> Result<Self> {
        if points.is_empty() {
            return Err(Error::NoVertices);
        }
        let triangles = require_triangles(triangles, points.len())?;
        let (points, edges) = (wide(points), edges(&triangles));
        Ok(Self {
            neighbourhoods: Neighbourhoods::new(Rows::from_pairs(points.len(), &both_ways(&edges))),
            rest_intersections: self_intersections(&points, &triangles),
            points,
            triangles,
            edges,
        })
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.points.len()
    }

    /// Number of pairs of triangles that intersect at rest.
    pub fn rest_intersection_count(&self) -> usize {
        self.rest_intersections.len()
    }

    /// The skin around a joint: of the triangles whose rest centroid is closer to `centre` than `radius_m`
    /// and that have one of the `carried` vertices (one flag per vertex), the largest connected part; `None`
    /// if there is none.
    ///
    /// # Errors
    /// [`Error::Length`] if `carried` does not have one entry per vertex.
    pub fn region(
        &self,
        centre: [f64; 3],
        radius_m: f64,
        carried: Option<&[bool]>,
    ) -> Result<Option<SurfaceRegion>> {
        if let Some(carried) = carried {
            require_length("carried", self.points.len(), "one per vertex", carried.len())?;
        }
        let centre = DVec3::from_array(centre);
        let is_near = |triangle: &[u32; 3]| {
            let middle = triangle
                .iter()
                .map(|&vertex| self.points[vertex as usize])
                .sum::<DVec3>()
                / 3.0;
            middle.distance(centre) < radius_m
        };
        let is_carried = |triangle: &[u32; 3]| {
            carried.is_none_or(|carried| triangle.iter().any(|&vertex| carried[vertex as usize]))
        };
        let chosen: Vec<u32> = (0..self.triangles.len() as u32)
            .filter(|&face| {
                let triangle = &self.triangles[face as usize];
                is_near(triangle) && is_carried(triangle)
            })
            .collect();
        let faces = largest_component(&chosen, &self.triangles);
        Ok((!faces.is_empty()).then(|| SurfaceRegion::new(faces, &self.points, &self.triangles)))
    }

    /// The whole surface as one region.
    pub fn whole(&self) -> SurfaceRegion {
        SurfaceRegion::new(
            (0..self.triangles.len() as u32).collect(),
            &self.points,
            &self.triangles,
        )
    }

    /// A deformed state: the positions of the vertices, m, in the same space.
    ///
    /// # Errors
    /// [`Error::Length`] for a number of vertices other than at rest.
    pub fn deformed(&self, points: &[[f32; 3]]) -> Result<DeformedSurface> {
        require_length(
            "points",
            self.points.len(),
            "one per vertex at rest",
            points.len(),
        )?;
        let points = wide(points);
        let (inverted, intersections) = rayon::join(
            || {
                let position_in = |points: &[DVec3], vertex: u32| points[vertex as usize];
                let all: Vec<u32> = (0..self.triangles.len() as u32).collect();
                self.neighbourhoods.inverted(
                    &all,
                    &self.triangles,
                    |vertex| position_in(&self.points, vertex),
                    |vertex| position_in(&points, vertex),
                )
            },
            || self_intersections(&points, &self.triangles),
        );
        Ok(DeformedSurface {
            inverted,
            new_intersections: new_intersections(&intersections, &self.rest_intersections),
            points,
        })
    }

    /// The quality of a region of this surface in a deformed state.
    pub fn quality(&self, deformed: &DeformedSurface, region: &SurfaceRegion) -> SkinQuality {
        let (rest, posed) = (&self.points, &deformed.points);
        let volumes = region.volumes(posed);
        let mut is_inside = vec![false; self.triangles.len()];
        for &face in &region.faces {
            is_inside[face as usize] = true;
        }
        let is_inside = |face: u32| is_inside[face as usize];
        SkinQuality {
            union: volumes.union,
            overlap: volumes.overlap,
            inside_out: volumes.inside_out,
            unreadable: volumes.unreadable,
            volume: volumes.signed,
            edge: edge_stretch(rest, posed, &region.edges),
            area_p99: area_stretch_p99(rest, posed, &region.triangles),
            inverted: region
                .faces
                .iter()
                .filter(|&&face| deformed.inverted[face as usize])
                .count(),
            new_intersections: deformed
                .new_intersections
                .iter()
                .filter(|&&[a, b]| is_inside(a) || is_inside(b))
                .count(),
            bend_p99: bend_p99(
                &region.rest_degrees,
                posed,
                &region.triangles,
                &region.inner_edges,
            ),
        }
    }

    /// For each vertex, length over rest length of the edge at it that changed most; for heat maps.
    pub fn vertex_stretch(&self, deformed: &DeformedSurface) -> Vec<f32> {
        vertex_stretch(&self.points, &deformed.points, &self.edges)
    }
}

fn both_ways(edges: &[[u32; 2]]) -> Vec<(u32, u32)> {
    edges.iter().flat_map(|&[a, b]| [(a, b), (b, a)]).collect()
}

fn wide(points: &[[f32; 3]]) -> Vec<DVec3> {
    points
        .iter()
        .map(|point| DVec3::from_array(point.map(f64::from)))
        .collect()
}
