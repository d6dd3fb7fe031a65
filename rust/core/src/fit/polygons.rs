//! A checked polygon mesh in one space. Each polygon is a fan of triangles.
//! (docs/mathematics/fitting.md, Fit under the skin)

use glam::{DAffine3, DVec3};

use crate::error::{Error, Result};
use crate::pose::{ColumnMajor, affine};

/// Smallest number of corners of a polygon.
const FEWEST_CORNERS: i64 = 3;

/// The polygons of a mesh, as Blender stores them.
#[derive(Debug, Clone, Copy)]
pub struct PolygonMesh<'a> {
    /// Vertex positions, mesh space.
    pub points: &'a [[f32; 3]],
    /// The vertex of each corner, polygon after polygon.
    pub corners: &'a [i32],
    /// Index of the first corner of each polygon, then the number of corners.
    pub face_offsets: &'a [i32],
    /// Transform from mesh space to the space in which the mesh is used; `None` if they are the same.
    pub to_space: Option<&'a ColumnMajor>,
}

/// A checked polygon mesh.
///
/// A polygon of more than three corners is a fan of triangles around the mean of its corners. Unlike a quad that is split
/// along a diagonal, the fan is the same on the left and on the right of a symmetric body.
#[derive(Debug, Clone, Default)]
pub struct Polygons {
    pub(super) points: Vec<DVec3>,
    corners: Vec<u32>,
    offsets: Vec<u32>,
}

impl Polygons {
    /// The polygons of `mesh`, in the space in which it is used, m.
    ///
    /// # Errors
    /// [`Error::Value`] for a position that is not finite. [`Error::FaceOffsets`] for offsets that do not rise by 3 or more
    /// from 0 to the number of corners. [`Error::Index`] for a corner that is not a vertex. [`Error::Projective`] for a matrix
    /// that is not affine.
    pub fn new(mesh: &PolygonMesh) -> Result<Self> {
        let to_space = match mesh.to_space {
            Some(matrix) => affine(matrix, || "The mesh's matrix".to_owned())?,
            None => DAffine3::IDENTITY,
        };
        Ok(Self {
            points: points_of(mesh.points, &to_space)?,
            corners: corners_of(mesh.corners, mesh.points.len())?,
            offsets: offsets_of(mesh.face_offsets, mesh.corners.len())?,
        })
    }

    /// Triangles of these points, m.
    pub(crate) fn of_triangles(points: Vec<DVec3>, triangles: &[[u32; 3]]) -> Self {
        Self {
            points,
            corners: triangles.as_flattened().to_vec(),
            offsets: (0..=triangles.len() as u32)
                .map(|triangle| 3 * triangle)
                .collect(),
        }
    }

    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are no polygons.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Vertex positions, m.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Number of corners of all polygons.
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// A polygon's corners, as indices of all corners.
    pub(super) fn corner_range(&self, face: usize) -> std::ops::Range<usize> {
        self.offsets[face] as usize..self.offsets[face + 1] as usize
    }

    /// The vertices of a polygon's corners.
    pub(super) fn vertices(&self, face: usize) -> &[u32] {
        &self.corners[self.corner_range(face)]
    }

    /// The positions of a polygon's corners, m.
    pub(super) fn corner_points(&self, face: usize) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.vertices(face)
            .iter()
            .map(|&vertex| self.points[vertex as usize])
    }

    /// The mean of a polygon's corners, m.
    pub(super) fn middle(&self, face: usize) -> DVec3 {
        self.corner_points(face).sum::<DVec3>() / self.vertices(face).len() as f64
    }

    /// Calls `each` with the corners of every triangle of a polygon's fan.
    pub(super) fn for_each_triangle(&self, face: usize, each: impl FnMut([DVec3; 3])) {
        self.for_each_triangle_in(face, |point| point, each);
    }

    /// The same in another space; `map` is the linear map to it.
    pub(super) fn for_each_triangle_in(
        &self,
        face: usize,
        map: impl Fn(DVec3) -> DVec3,
        mut each: impl FnMut([DVec3; 3]),
    ) {
        let at = |vertex: u32| map(self.points[vertex as usize]);
        match *self.vertices(face) {
            [a, b, c] => each([at(a), at(b), at(c)]),
            [a, b, c, d] => {
                let corners = [at(a), at(b), at(c), at(d)];
                let middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4.0;
                let mut from = corners[3];
                for corner in corners {
                    each([from, corner, middle]);
                    from = corner;
                }
            }
            [.., last] => {
                let middle = map(self.middle(face));
                let mut from = at(last);
                for &vertex in self.vertices(face) {
                    let corner = at(vertex);
                    each([from, corner, middle]);
                    from = corner;
                }
            }
            [] => {}
        }
    }

    /// Adds the polygons of another mesh, with their normals flipped if `reversed`.
    pub(super) fn append(&mut self, other: &Self, reversed: bool) {
        let (vertex_count, corner_count) = (self.points.len() as u32, self.corners.len() as u32);
        let first = self.corners.len();
        self.points.extend_from_slice(&other.points);
        self.corners
            .extend(other.corners.iter().map(|vertex| vertex_count + vertex));
        if reversed {
            for face in 0..other.len() {
                let corners = other.corner_range(face);
                self.corners[first + corners.start..first + corners.end].reverse();
            }
        }
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        self.offsets
            .extend(other.offsets.iter().skip(1).map(|offset| corner_count + offset));
    }

    /// The same polygons in another order, with vertices in the order of first use, so that neighbours in space are close in
    /// memory.
    pub(super) fn reordered(&self, order: &[u32]) -> Self {
        let mut new_index = vec![u32::MAX; self.points.len()];
        let mut reordered = Self {
            points: Vec::with_capacity(self.points.len()),
            corners: Vec::with_capacity(self.corners.len()),
            offsets: Vec::with_capacity(self.offsets.len()),
        };
        reordered.offsets.push(0);
        for &face in order {
            for &vertex in self.vertices(face as usize) {
                let index = &mut new_index[vertex as usize];
                if *index == u32::MAX {
                    *index = reordered.points.len() as u32;
                    reordered.points.push(self.points[vertex as usize]);
                }
                reordered.corners.push(*index);
            }
            reordered.offsets.push(reordered.corners.len() as u32);
        }
        reordered
    }

    /// Six times the volume that the polygons enclose, m³; negative if their normals point inward. The volume of an open mesh
    /// is that of the cones from its faces to the mean of its vertices and of its polygons' middles.
    pub(super) fn signed_volume_times_6(&self) -> f64 {
        let middles: DVec3 = (0..self.len()).map(|face| self.middle(face)).sum();
        let count = (self.points.len() + self.len()).max(1);
        let mean = (self.points.iter().sum::<DVec3>() + middles) / count as f64;
        let mut volume = 0.0;
        for face in 0..self.len() {
            self.for_each_triangle(face, |[a, b, c]| {
                volume += (a - mean).dot((b - mean).cross(c - mean))
            });
        }
        volume
    }

    /// Lowest and highest coordinates of all vertices, m; `None` if there are no vertices.
    pub(super) fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.points.first()?;
        let grown = |(low, high): (DVec3, DVec3), point: &DVec3| (low.min(*point), high.max(*point));
        Some(self.points.iter().fold((first, first), grown))
    }
}

fn points_of(points: &[[f32; 3]], to_space: &DAffine3) -> Result<Vec<DVec3>> {
    let checked = points.iter().enumerate().map(|(vertex, point)| {
        match point.iter().find(|coordinate| !coordinate.is_finite()) {
            None => Ok(to_space.transform_point3(DVec3::from_array(point.map(f64::from)))),
            Some(&found) => Err(Error::Value {
                thing: format!("Vertex {vertex}"),
                quantity: "coordinate",
                found: found.into(),
                limit: "finite",
            }),
        }
    });
    checked.collect()
}

fn corners_of(corners: &[i32], limit: usize) -> Result<Vec<u32>> {
    let checked = corners.iter().enumerate().map(|(position, &found)| {
        let vertex = u32::try_from(found)
            .ok()
            .filter(|&vertex| (vertex as usize) < limit);
        vertex.ok_or(Error::Index {
            list: "corners",
            position,
            found: found.into(),
            limit,
            of: "vertices",
        })
    });
    checked.collect()
}

fn offsets_of(offsets: &[i32], limit: usize) -> Result<Vec<u32>> {
    let refused = |position, found| Error::FaceOffsets {
        position,
        found,
        limit,
    };
    if offsets.first().is_none_or(|&first| first != 0) {
        return Err(refused(0, offsets.first().map_or(-1, |&first| first.into())));
    }
    for (position, pair) in offsets.windows(2).enumerate() {
        let [from, to] = [i64::from(pair[0]), i64::from(pair[1])];
        if to - from < FEWEST_CORNERS || to > limit as i64 {
            return Err(refused(position + 1, to));
        }
    }
    match offsets.last() {
        Some(&last) if last as usize != limit => Err(refused(offsets.len() - 1, last.into())),
        _ => Ok(offsets.iter().map(|&offset| offset as u32).collect()),
    }
}
