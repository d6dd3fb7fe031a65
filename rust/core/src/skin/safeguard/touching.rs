//! Pairs of faces that touch where the file splits a vertex into several that nearly coincide. Whether such faces
//! intersect in a pose is decided by rounding (mathematics/safeguard.md, Faults).

use glam::Vec3A;

use crate::math::rows::Rows;

/// The pairs of faces, rising, that share a welded vertex, of which the file has two at positions that are not
/// equal to the bit. `welded` is the welded vertex of each vertex, `faces_at` are the faces at each welded vertex.
pub(crate) fn doubtful_pairs(
    points: &[Vec3A],
    triangles: &[[u32; 3]],
    welded: &[u32],
    faces_at: &Rows<u32>,
) -> Vec<[u32; 2]> {
    let corner_at = |face: u32, vertex: usize| {
        let corners = triangles[face as usize].into_iter();
        corners.filter(move |&corner| welded[corner as usize] as usize == vertex)
    };
    let mut pairs = vec![];
    for (vertex, faces) in faces_at.rows().enumerate() {
        let positions = || {
            faces
                .iter()
                .flat_map(|&face| corner_at(face, vertex))
                .map(|corner| points[corner as usize])
        };
        let mut all = positions();
        let Some(first) = all.next() else { continue };
        if all.all(|position| position == first) {
            continue;
        }
        for (index, &one) in faces.iter().enumerate() {
            for &other in &faces[index + 1..] {
                let is_apart =
                    |a: u32| corner_at(other, vertex).any(|b| points[a as usize] != points[b as usize]);
                let is_joined = triangles[one as usize]
                    .iter()
                    .any(|corner| triangles[other as usize].contains(corner));
                if !is_joined && corner_at(one, vertex).any(is_apart) {
                    pairs.push([one, other]);
                }
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
