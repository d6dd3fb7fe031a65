//! The skin around one joint keeps the volume that it has at rest (ALGORITHM 5, regional volume).

use glam::{DVec3, Vec3A};

use crate::math::union_find::UnionFind;
use crate::skin::relaxation::elastic_mesh::ElasticMesh;
use crate::skin::relaxation::joint::JointSkin;

/// Share of the radius from the joint within which a vertex gives way fully; at the radius none does.
const FULL_MASS_RADII: f64 = 0.6;
/// Share of a bone that counts as weighing.
const SMALLEST_WEIGHT: f32 = 0.01;
/// Fewest triangles of a region worth keeping the volume of.
const FEWEST_TRIANGLES: usize = 16;

/// The triangles around a joint, closed by fans over their rims.
#[derive(Debug, Clone)]
pub(crate) struct Region {
    /// Vertices, and how far each gives way.
    vertices: Vec<(u32, f32)>,
    /// Triangles, as positions in `vertices`.
    triangles: Vec<[u32; 3]>,
    /// Rims: the directed edges that bound the triangles, loop by loop, as positions in `vertices`.
    boundary_loops: Vec<Vec<[u32; 2]>>,
    rest_volume: f64,
}

impl Region {
    /// The region of a joint, or `None` where there is too little skin.
    pub fn new(found: &JointSkin, mesh: &ElasticMesh) -> Option<Self> {
        let (joint, points) = (&found.joint, mesh.points);
        let weighs = |vertex: usize| {
            let mut own = mesh.weights.of(vertex).iter();
            found.child_weight[vertex] > SMALLEST_WEIGHT
                || own.any(|own| own.bone as usize == joint.parent && own.weight > SMALLEST_WEIGHT)
        };
        let is_own = |triangle: &&[u32; 3]| {
            let corners = triangle.map(|vertex| vertex as usize);
            let middle = corners.iter().map(|&vertex| points[vertex]).sum::<DVec3>() / 3.0;
            joint.radii_to(middle) < 1.0
                && triangle
                    .iter()
                    .all(|vertex| found.patch.binary_search(vertex).is_ok())
                && corners.iter().any(|&vertex| weighs(vertex))
        };
        let triangles = mesh.triangles;
        let own = largest_part(&triangles.iter().filter(is_own).copied().collect::<Vec<_>>());
        if own.len() < FEWEST_TRIANGLES {
            return None;
        }
        let mut used: Vec<u32> = own.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let slot = |vertex: u32| used.partition_point(|&other| other < vertex) as u32;
        let triangles: Vec<[u32; 3]> = own.iter().map(|triangle| triangle.map(slot)).collect();
        let inverse_mass = |vertex: u32| {
            let distance = joint.radii_to(points[vertex as usize]);
            (1.0 - (distance - FULL_MASS_RADII) / (1.0 - FULL_MASS_RADII)).clamp(0.0, 1.0) as f32
        };
        let mut region = Self {
            vertices: used.iter().map(|&vertex| (vertex, inverse_mass(vertex))).collect(),
            boundary_loops: boundary_loops(&triangles),
            triangles,
            rest_volume: 0.0,
        };
        let mut rest = vec![Vec3A::ZERO; used.len()];
        region.gather(|vertex| points[vertex].as_vec3a(), &mut rest);
        region.rest_volume = region.measure(&rest, &mut vec![Vec3A::ZERO; used.len()]);
        Some(region)
    }

    /// The vertices, and how far each gives way.
    pub fn vertices(&self) -> &[(u32, f32)] {
        &self.vertices
    }

    /// Writes where its vertices lie, `swollen`, to `positions`: as seen from one of them, so that f32 has digits enough.
    pub fn gather(&self, swollen: impl Fn(usize) -> Vec3A, positions: &mut [Vec3A]) {
        let from = swollen(self.vertices[0].0 as usize);
        for (&(vertex, _), place) in self.vertices.iter().zip(positions) {
            *place = swollen(vertex as usize) - from;
        }
    }

    /// Length of the step along `gradient`, written here, that brings the region's volume back to `scale³` of its rest volume,
    /// to first order; its vertices lie at `positions`.
    pub fn lambda(&self, positions: &[Vec3A], scale: f64, gradient: &mut [Vec3A]) -> f32 {
        let missing = self.rest_volume * scale.powi(3) - self.measure(positions, gradient);
        let own = self.vertices.iter().zip(&*gradient);
        let effect: f64 = own
            .map(|((_, inverse_mass), gradient)| f64::from(inverse_mass * gradient.length_squared()))
            .sum();
        if effect > 0.0 {
            (6.0 * missing / effect) as f32
        } else {
            0.0
        }
    }

    /// Adds a step along `gradient` to the `displacements` of the vertices.
    pub fn project(&self, displacements: &mut [Vec3A], gradient: &[Vec3A], lambda: f32) {
        for (&(vertex, inverse_mass), &gradient) in self.vertices.iter().zip(gradient) {
            displacements[vertex as usize] += gradient * (inverse_mass * lambda);
        }
    }

    /// The region's volume, m³, and six times how it grows with the place of each vertex.
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
            let hub = boundary.iter().map(|edge| position(edge[0])).sum::<Vec3A>() / boundary.len() as f32;
            let fan = |&[a, b]: &[u32; 2]| position(b).dot(position(a).cross(hub));
            volume += f64::from(boundary.iter().map(fan).sum::<f32>());
        }
        volume / 6.0
    }
}

/// The triangles of the largest part that hangs together over edges.
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

/// The directed edges that have no counterpart, grouped into loops.
fn boundary_loops(triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 2]>> {
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    edges.sort_unstable();
    let mut open: Vec<[u32; 2]> = edges
        .iter()
        .filter(|[a, b]| edges.binary_search(&[*b, *a]).is_err())
        .copied()
        .collect();
    let mut boundary_loops = vec![];
    while let Some(first) = open.pop() {
        let mut boundary = vec![first];
        let mut end = first[1];
        while let Some(next) = open.iter().position(|edge| edge[0] == end) {
            let edge = open.swap_remove(next);
            end = edge[1];
            boundary.push(edge);
        }
        boundary_loops.push(boundary);
    }
    boundary_loops
}
