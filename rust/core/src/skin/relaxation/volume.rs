//! The volume constraint of a joint: its skin keeps the volume that it has at rest (position-based
//! dynamics, Müller et al. 2007; mathematics/volume.md, Volume constraint).

use glam::{DVec3, Vec3A};

use crate::math::union_find::UnionFind;
use crate::skin::relaxation::elastic_mesh::ElasticMesh;
use crate::skin::relaxation::joint::JointSkin;

/// Distance from the joint, in its radii, up to which a vertex has the full inverse mass. It falls
/// linearly to 0 at the radius, so that the border of a region does not move.
const FULL_MASS_RADII: f64 = 0.6;
/// Weight on a bone from which a vertex belongs to that side of the joint. It excludes weights that are
/// painting noise.
const SMALLEST_WEIGHT: f32 = 0.01;
/// Fewest triangles of a region. The volume of fewer is mostly that of the fans over the boundary loops.
const FEWEST_TRIANGLES: usize = 16;

/// The triangles around a joint, closed by a fan over each boundary loop.
#[derive(Debug, Clone)]
pub(crate) struct Region {
    /// Vertices and their inverse masses, 0 to 1.
    vertices: Vec<(u32, f32)>,
    /// Triangles, as indices into `vertices`.
    triangles: Vec<[u32; 3]>,
    /// The directed edges that bound the triangles, loop by loop, as indices into `vertices`.
    boundary_loops: Vec<Vec<[u32; 2]>>,
    rest_volume: f64,
}

impl Region {
    /// The region of a joint, or `None` if it has too few triangles.
    pub fn new(skin: &JointSkin, mesh: &ElasticMesh) -> Option<Self> {
        let (joint, points) = (&skin.joint, mesh.points);
        let weighs = |(vertex, child_weight): (u32, f32)| {
            let mut weights = mesh.weights.of(vertex as usize).iter();
            child_weight > SMALLEST_WEIGHT
                || weights.any(|entry| entry.bone as usize == joint.parent && entry.weight > SMALLEST_WEIGHT)
        };
        let is_in_region = |triangle: &&[u32; 3]| {
            let middle = triangle
                .iter()
                .map(|&vertex| points[vertex as usize])
                .sum::<DVec3>()
                / 3.0;
            let child_weight = |&vertex: &u32| skin.child_weight(vertex).map(|weight| (vertex, weight));
            joint.radii_to(middle) < 1.0
                && triangle
                    .iter()
                    .all(|vertex| skin.patch.binary_search(vertex).is_ok())
                && triangle.iter().filter_map(child_weight).any(weighs)
        };
        // a triangle of the patch is listed at its lowest corner
        let of_patch = skin
            .patch
            .iter()
            .flat_map(|&vertex| mesh.triangles_from.row(vertex as usize));
        let selected = largest_part(&of_patch.filter(is_in_region).copied().collect::<Vec<_>>());
        if selected.len() < FEWEST_TRIANGLES {
            return None;
        }
        let mut used: Vec<u32> = selected.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let slot = |vertex: u32| used.partition_point(|&other| other < vertex) as u32;
        let triangles: Vec<[u32; 3]> = selected.iter().map(|triangle| triangle.map(slot)).collect();
        let inverse_mass = |vertex: u32| {
            let distance = joint.radii_to(points[vertex as usize]);
            (1.0 - (distance - FULL_MASS_RADII) / (1.0 - FULL_MASS_RADII)).clamp(0.0, 1.0) as f32
        };
        let mut region = Self {
            vertices: used
                .iter()
                .map(|&vertex| (vertex, inverse_mass(vertex)))
                .collect(),
            boundary_loops: boundary_loops(&triangles),
            triangles,
            rest_volume: 0.0,
        };
        let mut rest = vec![Vec3A::ZERO; used.len()];
        region.gather(|vertex| points[vertex].as_vec3a(), &mut rest);
        region.rest_volume = region.measure(&rest, &mut vec![Vec3A::ZERO; used.len()]);
        Some(region)
    }

    /// The vertices and their inverse masses, 0 to 1.
    pub fn vertices(&self) -> &[(u32, f32)] {
        &self.vertices
    }

    /// Writes the positions of its vertices, by `swollen_position`, to `positions`. They are relative to
    /// its first vertex, so that f32 has enough digits.
    pub fn gather(&self, swollen_position: impl Fn(usize) -> Vec3A, positions: &mut [Vec3A]) {
        let from = swollen_position(self.vertices[0].0 as usize);
        for (&(vertex, _), position) in self.vertices.iter().zip(positions) {
            *position = swollen_position(vertex as usize) - from;
        }
    }

    /// The multiplier lambda of the constraint: times `gradient` and the inverse masses, it restores
    /// `scale³` times the rest volume to first order. The vertices are at `positions`. Writes the
    /// gradient, times 6, to `gradient`.
    pub fn lambda(&self, positions: &[Vec3A], scale: f64, gradient: &mut [Vec3A]) -> f32 {
        let missing = self.rest_volume * scale.powi(3) - self.measure(positions, gradient);
        let weighted = self.vertices.iter().zip(&*gradient);
        let denominator: f64 = weighted
            .map(|((_, inverse_mass), gradient)| f64::from(inverse_mass * gradient.length_squared()))
            .sum();
        if denominator > 0.0 {
            (6.0 * missing / denominator) as f32
        } else {
            0.0
        }
    }

    /// Adds the correction, lambda times inverse mass times `gradient`, to the `displacements` of the
    /// vertices.
    pub fn project(&self, displacements: &mut [Vec3A], gradient: &[Vec3A], lambda: f32) {
        for (&(vertex, inverse_mass), &gradient) in self.vertices.iter().zip(gradient) {
            displacements[vertex as usize] += gradient * (inverse_mass * lambda);
        }
    }

    /// The region's volume, m³. Writes 6 times its derivative by the position of each vertex to
    /// `gradient`, m².
    fn measure(&self, positions: &[Vec3A], gradient: &mut [Vec3A]) -> f64 {
        gradient.fill(Vec3A::ZERO);
        let mut sum = Vec3A::ZERO;
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|slot| positions[slot as usize]);
            let area = (b - a).cross(c - a);
            sum += area * a;
            for &slot in triangle {
                gradient[slot as usize] += area;
            }
        }
        let mut volume = f64::from(sum.element_sum());
        let position = |slot: u32| positions[slot as usize];
        for boundary in &self.boundary_loops {
            let middle = boundary.iter().map(|edge| position(edge[0])).sum::<Vec3A>() / boundary.len() as f32;
            let fan = |&[a, b]: &[u32; 2]| position(b).dot(position(a).cross(middle));
            volume += f64::from(boundary.iter().map(fan).sum::<f32>());
        }
        volume / 6.0
    }
}

/// The triangles of the largest part that is connected over edges.
fn largest_part(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<([u32; 2], u32)> = triangles
        .iter()
        .zip(0..)
        .flat_map(|(&[a, b, c], index)| [[a, b], [b, c], [c, a]].map(|[a, b]| ([a.min(b), a.max(b)], index)))
        .collect();
    edges.sort_unstable();
    let mut parts = UnionFind::new(triangles.len());
    for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        parts.join(pair[0].1, pair[1].1);
    }
    let mut sizes = vec![0_usize; triangles.len()];
    let roots = parts.roots();
    roots.iter().for_each(|&root| sizes[root as usize] += 1);
    let largest = (0..sizes.len()).rev().max_by_key(|&index| sizes[index]);
    (0..triangles.len())
        .filter(|&index| Some(roots[index] as usize) == largest)
        .map(|index| triangles[index])
        .collect()
}

/// The directed edges without a counterpart, grouped into loops.
fn boundary_loops(triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 2]>> {
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    edges.sort_unstable();
    let mut unused: Vec<[u32; 2]> = edges
        .iter()
        .filter(|[a, b]| edges.binary_search(&[*b, *a]).is_err())
        .copied()
        .collect();
    let mut boundary_loops = vec![];
    while let Some(first) = unused.pop() {
        let mut boundary = vec![first];
        let mut end = first[1];
        while let Some(next) = unused.iter().position(|edge| edge[0] == end) {
            let edge = unused.swap_remove(next);
            end = edge[1];
            boundary.push(edge);
        }
        boundary_loops.push(boundary);
    }
    boundary_loops
}
