//! Inverted faces: those whose normal opposes that of the surrounding skin.

use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

use crate::math::eigen::SymmetricEigen;
use crate::math::outer::outer;
use crate::math::rows::Rows;

/// Rings of neighbours around each corner that count as the surrounding skin of a face.
const RINGS: usize = 3;
/// Marks a vertex that is not a corner of the faces.
const NONE: u32 = u32::MAX;

/// Some faces, and the neighbourhood of each of their corners.
#[derive(Debug)]
pub(crate) struct Neighbourhoods {
    faces: Vec<u32>,
    /// Index of each vertex in `around`, or [`NONE`].
    slots: Vec<u32>,
    /// The vertices around each corner, including itself.
    around: Rows<u32>,
}

/// Sums over the neighbourhood of one vertex.
struct Moments {
    count: usize,
    rest: DVec3,
    posed: DVec3,
    /// Sum of `rest posedᵀ` over the neighbourhood.
    both: DMat3,
}

impl Neighbourhoods {
    /// The neighbourhoods of some `faces`, indices of `triangles`. `beside` are the neighbours of each vertex.
    pub fn new(faces: Vec<u32>, triangles: &[[u32; 3]], beside: &Rows<u32>) -> Self {
        let mut slots = vec![NONE; beside.len()];
        let mut corners = vec![];
        for corner in faces.iter().flat_map(|&face| triangles[face as usize]) {
            let slot = &mut slots[corner as usize];
            if *slot == NONE {
                *slot = corners.len() as u32;
                corners.push(corner);
            }
        }
        let rings: Vec<Vec<u32>> = corners
            .into_par_iter()
            .with_min_len(256)
            .map_init(
                || vec![NONE; beside.len()],
                |seen_by, vertex| within_rings(vertex, beside, seen_by),
            )
            .collect();
        Self {
            faces,
            slots,
            around: Rows::from_rows(rings),
        }
    }

    /// Whether each of the faces is inverted: its normal opposes its rest normal as rotated by the rigid fit
    /// of the surrounding skin, which is three rings around its three corners (the criterion of Kabsch, solved
    /// by Horn's quaternions). A face without area is not inverted.
    /// `rest` and `posed` give the position of a vertex.
    pub fn inverted(
        &self,
        rest: impl Fn(u32) -> DVec3 + Sync,
        posed: impl Fn(u32) -> DVec3 + Sync,
        triangles: &[[u32; 3]],
    ) -> Vec<bool> {
        let moments: Vec<Moments> = (0..self.around.len())
            .into_par_iter()
            .with_min_len(64)
            .map(|slot| Moments::new(self.around.row(slot), &rest, &posed))
            .collect();
        let is_inverted = |&face: &u32| {
            let triangle = &triangles[face as usize];
            let rotation_there = rotation(self.covariance(triangle, &moments));
            (rotation_there * normal(triangle.map(&rest))).dot(normal(triangle.map(&posed))) < 0.0
        };
        self.faces.par_iter().with_min_len(64).map(is_inverted).collect()
    }

    /// The covariance of rest and posed positions around a face. A vertex counts once for each corner whose
    /// neighbourhood contains it.
    fn covariance(&self, triangle: &[u32; 3], moments: &[Moments]) -> DMat3 {
        let (mut count, mut rest, mut posed, mut both) = (0, DVec3::ZERO, DVec3::ZERO, DMat3::ZERO);
        for vertex in triangle {
            let there = &moments[self.slots[*vertex as usize] as usize];
            count += there.count;
            rest += there.rest;
            posed += there.posed;
            both += there.both;
        }
        let count = count as f64;
        both * (1.0 / count) - outer(rest / count, posed / count)
    }
}

impl Moments {
    fn new(around: &[u32], rest: impl Fn(u32) -> DVec3, posed: impl Fn(u32) -> DVec3) -> Self {
        let mut sums = Self {
            count: around.len(),
            rest: DVec3::ZERO,
            posed: DVec3::ZERO,
            both: DMat3::ZERO,
        };
        for &neighbour in around {
            let (then, now) = (rest(neighbour), posed(neighbour));
            sums.rest += then;
            sums.posed += now;
            sums.both += outer(then, now);
        }
        sums
    }
}

/// The unit normal of a triangle; 0 if it has no area.
pub(crate) fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The vertex and its rings. `seen_by` has, for each vertex, the last vertex whose search found it.
fn within_rings(vertex: u32, beside: &Rows<u32>, seen_by: &mut [u32]) -> Vec<u32> {
    seen_by[vertex as usize] = vertex;
    let (mut found, mut first) = (vec![vertex], 0);
    for _ in 0..RINGS {
        let last = found.len();
        for index in first..last {
            for &neighbour in beside.row(found[index] as usize) {
                if std::mem::replace(&mut seen_by[neighbour as usize], vertex) != vertex {
                    found.push(neighbour);
                }
            }
        }
        first = last;
    }
    found.sort_unstable();
    found
}

/// The rotation that maps rest positions best to posed ones (Horn 1987): the eigenvector of the largest
/// eigenvalue.
fn rotation(covariance: DMat3) -> DQuat {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = covariance.to_cols_array_2d();
    #[rustfmt::skip]
    let quaternions = [
        [xx + yy + zz, yz - zy,      zx - xz,      xy - yx],
        [yz - zy,      xx - yy - zz, xy + yx,      zx + xz],
        [zx - xz,      xy + yx,      yy - xx - zz, yz + zy],
        [xy - yx,      zx + xz,      yz + zy,      zz - xx - yy],
    ];
    let Some(eigen) = SymmetricEigen::new(quaternions) else {
        return DQuat::IDENTITY;
    };
    let [w, x, y, z] = eigen.vectors[eigen.largest()];
    DQuat::from_xyzw(x, y, z, w)
}
