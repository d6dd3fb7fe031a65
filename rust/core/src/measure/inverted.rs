//! Inverted faces: those whose normal opposes that of the surrounding skin.

use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

use super::dihedral::normal;
use crate::math::eigen::SymmetricEigen;
use crate::math::outer::outer;
use crate::math::rows::Rows;

/// Rings of neighbours around each corner that count as the surrounding skin of a face.
const RINGS: usize = 3;

/// The neighbourhood of each vertex, including itself, and sums over its rest positions.
#[derive(Debug)]
pub(super) struct Neighbourhoods {
    around: Rows<u32>,
    rest_sums: Vec<DVec3>,
    rest_normals: Vec<DVec3>,
}

/// Sums over the neighbourhood of one vertex.
struct Moments {
    posed: DVec3,
    /// Sum of `rest posedᵀ` over the neighbourhood.
    both: DMat3,
}

impl Neighbourhoods {
    pub fn new(rest: &[DVec3], triangles: &[[u32; 3]], edges: &[[u32; 2]]) -> Self {
        let mut beside = vec![vec![]; rest.len()];
        for &[a, b] in edges {
            beside[a as usize].push(b);
            beside[b as usize].push(a);
        }
        let rings: Vec<Vec<u32>> = (0..rest.len())
            .into_par_iter()
            .map_init(
                || vec![u32::MAX; rest.len()],
                |seen_by, vertex| within_rings(vertex as u32, &beside, seen_by),
            )
            .collect();
        let sum = |ring: &Vec<u32>| ring.iter().map(|&vertex| rest[vertex as usize]).sum();
        Self {
            rest_sums: rings.iter().map(sum).collect(),
            rest_normals: triangles.iter().map(|triangle| normal(rest, triangle)).collect(),
            around: Rows::from_rows(rings),
        }
    }

    /// Whether each face is inverted: its normal opposes its rest normal as rotated by the rigid fit of the
    /// surrounding skin, which is three rings around its three corners (the criterion of Kabsch, solved by
    /// Horn's quaternions). A face without area is not inverted.
    pub fn inverted(&self, rest: &[DVec3], posed: &[DVec3], triangles: &[[u32; 3]]) -> Vec<bool> {
        let moments: Vec<Moments> = (0..rest.len())
            .into_par_iter()
            .map(|vertex| self.moments(vertex, rest, posed))
            .collect();
        let is_inverted = |(triangle, rest_normal): (&[u32; 3], &DVec3)| {
            let rotation_there = rotation(self.covariance(triangle, &moments));
            (rotation_there * *rest_normal).dot(normal(posed, triangle)) < 0.0
        };
        triangles
            .par_iter()
            .zip(&self.rest_normals)
            .map(is_inverted)
            .collect()
    }

    fn moments(&self, vertex: usize, rest: &[DVec3], posed: &[DVec3]) -> Moments {
        let mut sums = Moments {
            posed: DVec3::ZERO,
            both: DMat3::ZERO,
        };
        for &neighbour in self.around.row(vertex) {
            let (then, now) = (rest[neighbour as usize], posed[neighbour as usize]);
            sums.posed += now;
            sums.both += outer(then, now);
        }
        sums
    }

    /// The covariance of rest and posed positions around a face. A vertex counts once for each corner whose
    /// neighbourhood contains it.
    fn covariance(&self, triangle: &[u32; 3], moments: &[Moments]) -> DMat3 {
        let (mut count, mut rest, mut posed, mut both) = (0, DVec3::ZERO, DVec3::ZERO, DMat3::ZERO);
        for vertex in triangle.map(|vertex| vertex as usize) {
            count += self.around.row(vertex).len();
            rest += self.rest_sums[vertex];
            posed += moments[vertex].posed;
            both += moments[vertex].both;
        }
        let count = count as f64;
        both * (1.0 / count) - outer(rest / count, posed / count)
    }
}

/// The vertex and its rings. `seen_by` has, for each vertex, the last vertex whose search found it.
fn within_rings(vertex: u32, beside: &[Vec<u32>], seen_by: &mut [u32]) -> Vec<u32> {
    seen_by[vertex as usize] = vertex;
    let (mut found, mut first) = (vec![vertex], 0);
    for _ in 0..RINGS {
        let last = found.len();
        for index in first..last {
            for &neighbour in &beside[found[index] as usize] {
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
