//! The quality of a deformed skin against its rest pose: volume really occupied, strain, inverted faces, self-hits,
//! smoothness, jitter and pop. Knows nothing of bones or of what deformed the skin, so it measures any deformer.
//!
//! Same bits on any number of threads. Degenerate input is measured as what it is: faces without area, loose vertices,
//! edges of three and more faces, open surfaces.

mod dihedral;
mod inverted;
mod motion;
mod percentile;
mod region;
mod self_intersections;
mod stretch;
mod topology;
mod volume;
mod winding;

use glam::DVec3;

pub use self::motion::{Jitter, Motion, Pop};
pub use self::region::SurfaceRegion;
pub use self::stretch::EdgeStretch;

use self::dihedral::bend_p99;
use self::inverted::Neighbourhoods;
use self::self_intersections::{new_hits, self_hits};
use self::stretch::{area_stretch_p99, edge_stretch, vertex_stretch};
use self::topology::{edges, largest_part};
use crate::error::require_length;
use crate::error::require_triangles;
use crate::error::{Error, Result};

/// A triangulated skin in the rest pose, that deformed states of it are measured against.
#[derive(Debug)]
pub struct RestSurface {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    neighbourhoods: Neighbourhoods,
    rest_hits: Vec<[u32; 2]>,
}

/// One deformed state of a [`RestSurface`], with what is measured on all of it at once.
#[derive(Debug)]
pub struct DeformedSurface {
    points: Vec<DVec3>,
    /// Whether each triangle points against the skin around it.
    pub inverted: Vec<bool>,
    /// Pairs of triangles that cut each other and did not at rest, lower place first, rising.
    pub new_hits: Vec<[u32; 2]>,
}

/// The quality of one region in one deformed state. Ratios are over rest; 1 is as at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinQuality {
    /// Volume really occupied: what lies inside once or more often (by winding number).
    pub union: f64,
    /// Volume occupied once too often, over the volume occupied at rest.
    pub overlap: f64,
    /// Volume turned inside out, over the volume occupied at rest.
    pub inside_out: f64,
    /// Share of the rays that could not be read, as through a hole; 0 for a region of a sound mesh.
    pub unreadable: f64,
    /// Signed volume; counts folds twice.
    pub volume: f64,
    /// Stretch of the edges.
    pub edge: EdgeStretch,
    /// What 99 of 100 triangles do not exceed of `max(A / A0, A0 / A)`.
    pub area_p99: f64,
    /// Inverted triangles.
    pub inverted: usize,
    /// New self-hits of which at least one triangle lies in the region.
    pub new_hits: usize,
    /// What 99 of 100 edges do not exceed of the change of the angle between their two faces, degrees.
    pub bend_p99: f64,
}

impl RestSurface {
    /// The surface of `triangles` over rest `points`, metres.
    ///
    /// # Errors
    /// [`Error::NoVertices`], or [`Error::Index`] for a corner that is no vertex.
    pub fn new(points: &[[f32; 3]], triangles: &[[i32; 3]]) -> Result<Self> {
        if points.is_empty() {
            return Err(Error::NoVertices);
        }
        let triangles = require_triangles(triangles, points.len())?;
        let (points, edges) = (wide(points), edges(&triangles));
        Ok(Self {
            neighbourhoods: Neighbourhoods::new(&points, &triangles, &edges),
            rest_hits: self_hits(&points, &triangles),
            points,
            triangles,
            edges,
        })
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.points.len()
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Number of pairs of triangles that cut each other at rest.
    pub fn rest_hit_count(&self) -> usize {
        self.rest_hits.len()
    }

    /// The skin around a joint: of the triangles whose rest middle is nearer to `centre` than `radius_m`, and that have
    /// one of the `carried` vertices, the largest part that hangs together; `None` where there is no such triangle.
    ///
    /// # Errors
    /// [`Error::Length`] where `carried` is not one a vertex.
    pub fn region(
        &self,
        centre: [f64; 3],
        radius_m: f64,
        carried: Option<&[bool]>,
    ) -> Result<Option<SurfaceRegion>> {
        if let Some(carried) = carried {
            require_length("carried", self.points.len(), "one a vertex", carried.len())?;
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
        let faces = largest_part(&chosen, &self.triangles);
        Ok((!faces.is_empty()).then(|| SurfaceRegion::new(faces, &self.points, &self.triangles)))
    }

    /// All of the surface as one region.
    pub fn whole(&self) -> SurfaceRegion {
        SurfaceRegion::new(
            (0..self.triangles.len() as u32).collect(),
            &self.points,
            &self.triangles,
        )
    }

    /// A deformed state: where the vertices are, in the same space.
    ///
    /// # Errors
    /// [`Error::Length`] for another number of vertices than at rest.
    pub fn deformed(&self, points: &[[f32; 3]]) -> Result<DeformedSurface> {
        require_length("points", self.points.len(), "one a vertex at rest", points.len())?;
        let points = wide(points);
        let (inverted, hits) = rayon::join(
            || {
                self.neighbourhoods
                    .inverted(&self.points, &points, &self.triangles)
            },
            || self_hits(&points, &self.triangles),
        );
        Ok(DeformedSurface {
            inverted,
            new_hits: new_hits(&hits, &self.rest_hits),
            points,
        })
    }

    /// The quality of a region of this surface in a deformed state of it.
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
            new_hits: deformed
                .new_hits
                .iter()
                .filter(|&&[a, b]| is_inside(a) || is_inside(b))
                .count(),
            bend_p99: bend_p99(&region.rest_degrees, posed, &region.triangles, &region.creases),
        }
    }

    /// For each vertex the length over rest length of that edge at it which changed most: what a heat map shows.
    pub fn vertex_stretch(&self, deformed: &DeformedSurface) -> Vec<f32> {
        vertex_stretch(&self.points, &deformed.points, &self.edges)
    }
}

fn wide(points: &[[f32; 3]]) -> Vec<DVec3> {
    points
        .iter()
        .map(|point| DVec3::from_array(point.map(f64::from)))
        .collect()
}
