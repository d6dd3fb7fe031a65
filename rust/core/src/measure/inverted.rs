//! Inverted faces: those that point against where the skin around them points.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix4, SymmetricEigen};
use rayon::prelude::*;

use super::dihedral::normal;

/// How many rings of neighbours around each corner make up the skin around a face.
const RINGS: usize = 3;
/// Rounds after which the search for a rotation gives up; a few are enough.
const MOST_ROUNDS: usize = 100;

/// The vertices around each vertex, itself included, and what their rest places come to.
#[derive(Debug)]
pub(super) struct Neighbourhoods {
    offsets: Vec<usize>,
    around: Vec<u32>,
    rest_sums: Vec<DVec3>,
    rest_normals: Vec<DVec3>,
}

/// Sums over the vertices around one vertex.
struct Moments {
    posed: DVec3,
    /// Rest place times posed place: entry (row, column) is rest[row] · posed[column].
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
        let mut offsets = vec![0];
        offsets.extend(rings.iter().scan(0, |total, ring| {
            *total += ring.len();
            Some(*total)
        }));
        let sum = |ring: &Vec<u32>| ring.iter().map(|&vertex| rest[vertex as usize]).sum();
        Self {
            offsets,
            rest_sums: rings.iter().map(sum).collect(),
            rest_normals: triangles.iter().map(|triangle| normal(rest, triangle)).collect(),
            around: rings.concat(),
        }
    }

    /// Whether each face is inverted: its normal points against its rest normal, turned as the skin around it turned: by the
    /// rigid fit (Kabsch; Horn's quaternion) of the three rings around its three corners. A face without area is not.
    pub fn inverted(&self, rest: &[DVec3], posed: &[DVec3], triangles: &[[u32; 3]]) -> Vec<bool> {
        let moments: Vec<Moments> = (0..rest.len())
            .into_par_iter()
            .map(|vertex| self.moments(vertex, rest, posed))
            .collect();
        let is_inverted = |(triangle, rest_normal): (&[u32; 3], &DVec3)| {
            let turn = rotation(self.covariance(triangle, &moments));
            (turn * *rest_normal).dot(normal(posed, triangle)) < 0.0
        };
        triangles
            .par_iter()
            .zip(&self.rest_normals)
            .map(is_inverted)
            .collect()
    }

    fn around(&self, vertex: usize) -> &[u32] {
        &self.around[self.offsets[vertex]..self.offsets[vertex + 1]]
    }

    fn moments(&self, vertex: usize, rest: &[DVec3], posed: &[DVec3]) -> Moments {
        let mut sums = Moments {
            posed: DVec3::ZERO,
            both: DMat3::ZERO,
        };
        for &other in self.around(vertex) {
            let (then, now) = (rest[other as usize], posed[other as usize]);
            sums.posed += now;
            sums.both += outer(then, now);
        }
        sums
    }

    /// Of rest and posed places around a face, each about its mean; a vertex around several corners counts as often.
    fn covariance(&self, triangle: &[u32; 3], moments: &[Moments]) -> DMat3 {
        let (mut count, mut rest, mut posed, mut both) = (0, DVec3::ZERO, DVec3::ZERO, DMat3::ZERO);
        for vertex in triangle.map(|vertex| vertex as usize) {
            count += self.around(vertex).len();
            rest += self.rest_sums[vertex];
            posed += moments[vertex].posed;
            both += moments[vertex].both;
        }
        let count = count as f64;
        both * (1.0 / count) - outer(rest / count, posed / count)
    }
}

/// The vertex and its rings; `seen_by` marks, for each vertex, by whose search it was last found.
fn within_rings(vertex: u32, beside: &[Vec<u32>], seen_by: &mut [u32]) -> Vec<u32> {
    seen_by[vertex as usize] = vertex;
    let (mut found, mut first) = (vec![vertex], 0);
    for _ in 0..RINGS {
        let last = found.len();
        for place in first..last {
            for &other in &beside[found[place] as usize] {
                if std::mem::replace(&mut seen_by[other as usize], vertex) != vertex {
                    found.push(other);
                }
            }
        }
        first = last;
    }
    found.sort_unstable();
    found
}

fn outer(row: DVec3, column: DVec3) -> DMat3 {
    DMat3::from_cols(row * column.x, row * column.y, row * column.z)
}

/// The rotation that carries rest places best to posed ones (Horn 1987): the eigenvector of the largest eigenvalue.
fn rotation(covariance: DMat3) -> DQuat {
    let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = covariance.to_cols_array_2d();
    #[rustfmt::skip]
    let quaternions = Matrix4::new(
        xx + yy + zz, yz - zy,      zx - xz,      xy - yx,
        yz - zy,      xx - yy - zz, xy + yx,      zx + xz,
        zx - xz,      xy + yx,      yy - xx - zz, yz + zy,
        xy - yx,      zx + xz,      yz + zy,      zz - xx - yy,
    );
    let Some(eigen) = SymmetricEigen::try_new(quaternions, f64::EPSILON, MOST_ROUNDS) else {
        return DQuat::IDENTITY;
    };
    let [w, x, y, z] = eigen
        .eigenvectors
        .column(eigen.eigenvalues.imax())
        .into_owned()
        .data
        .0[0];
    DQuat::from_xyzw(x, y, z, w)
}
