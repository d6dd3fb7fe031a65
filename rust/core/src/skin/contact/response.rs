//! Contact response: displacements of contact points spread smoothly over rings of neighbours, and never
//! below the wanted displacement (mathematics/contact.md, Skin contact).

use glam::Vec3A;

use crate::skin::contact::contact::Contact;
use crate::skin::contact::narrowphase::{ClosestPoint, ContactPoints};

/// Rings of neighbours that a displacement reaches, and passes of smoothing. Their width in metres
/// depends on the density of the mesh.
const RINGS: usize = 5;

/// Barycentric weight from which a corner of a touched triangle moves fully: its weight at the centre of
/// the triangle.
const FULL_CORNER_WEIGHT: f32 = 1.0 / 3.0;

/// The displacement of a corner of touched triangles, opposite to those of the touching vertices. The
/// corner of a wide triangle may be clear of a finger that dips into its middle.
#[derive(Debug, Clone, Copy, Default)]
struct OpposingDisplacement {
    /// Sum of the displacements, weighted by their length and by the corner's barycentric weight.
    sum: Vec3A,
    weight: f32,
    /// Largest barycentric weight of the corner.
    corner_weight: f32,
}

impl OpposingDisplacement {
    fn add(&mut self, displacement: Vec3A, corner_weight: f32) {
        let weight = corner_weight * displacement.length();
        self.sum += displacement * weight;
        self.weight += weight;
        self.corner_weight = self.corner_weight.max(corner_weight);
    }

    /// The weighted mean. It changes smoothly as a point of contact enters and leaves the triangles
    /// around the corner.
    fn displacement(self) -> Vec3A {
        if self.weight == 0.0 {
            return Vec3A::ZERO;
        }
        self.sum * ((self.corner_weight / FULL_CORNER_WEIGHT).min(1.0) / self.weight)
    }
}

/// The displacements of one pass.
#[derive(Debug)]
pub(crate) struct ContactResponse {
    /// Smallest displacement of each vertex, m.
    wanted: Vec<Vec3A>,
    opposing: Vec<OpposingDisplacement>,
    displacement: Vec<Vec3A>,
    next: Vec<Vec3A>,
    /// The displaced vertices, ring by ring.
    reached: Vec<u32>,
    is_reached: Vec<bool>,
}

impl ContactResponse {
    pub fn new(vertices: usize) -> Self {
        Self {
            wanted: vec![Vec3A::ZERO; vertices],
            opposing: vec![OpposingDisplacement::default(); vertices],
            displacement: vec![Vec3A::ZERO; vertices],
            next: vec![Vec3A::ZERO; vertices],
            reached: vec![],
            is_reached: vec![false; vertices],
        }
    }

    /// The displaced vertices and their displacements, m.
    pub fn displacements(&self) -> impl Iterator<Item = (usize, Vec3A)> {
        let reached = self.reached.iter().map(|&vertex| vertex as usize);
        reached.map(|vertex| (vertex, self.displacement[vertex]))
    }

    /// Finds the wanted displacements: of vertices in contact, and of the corners of the triangles that
    /// they touch.
    fn find_wanted(&mut self, contact: &Contact, contact_points: &ContactPoints) {
        for contact_point in contact_points.iter() {
            self.reach(contact_point.vertex);
            let ClosestPoint { corners, weights } = contact_point.closest;
            for (corner, corner_weight) in corners
                .into_iter()
                .zip(weights)
                .filter(|(_, corner_weight)| *corner_weight > 0.0)
            {
                self.reach(corner);
                self.opposing[corner as usize].add(-contact_point.displacement, corner_weight);
            }
        }
        for &vertex in &self.reached {
            let vertex = vertex as usize;
            self.wanted[vertex] = self.opposing[vertex].displacement() * contact.strength[vertex];
        }
        for contact_point in contact_points.iter() {
            let vertex = contact_point.vertex as usize;
            self.wanted[vertex] = at_least(
                self.wanted[vertex],
                contact_point.displacement * contact.strength[vertex],
            );
        }
        for &vertex in &self.reached {
            self.displacement[vertex as usize] = self.wanted[vertex as usize];
        }
    }

    fn reach(&mut self, vertex: u32) {
        let is_reached = &mut self.is_reached[vertex as usize];
        if !*is_reached {
            *is_reached = true;
            self.reached.push(vertex);
        }
    }

    /// Spreads the displacements of `contact_points` over the skin around them.
    pub fn spread(&mut self, contact: &Contact, contact_points: &ContactPoints) {
        for &vertex in &self.reached {
            let vertex = vertex as usize;
            self.wanted[vertex] = Vec3A::ZERO;
            self.opposing[vertex] = OpposingDisplacement::default();
            self.displacement[vertex] = Vec3A::ZERO;
            self.next[vertex] = Vec3A::ZERO;
            self.is_reached[vertex] = false;
        }
        self.reached.clear();
        self.find_wanted(contact, contact_points);
        let mut first = 0;
        for _ in 0..RINGS {
            let last = self.reached.len();
            for index in first..last {
                for &neighbour in contact.edges.neighbours(self.reached[index] as usize) {
                    let at = neighbour as usize;
                    if !self.is_reached[at] {
                        self.is_reached[at] = true;
                        self.reached.push(neighbour);
                    }
                }
            }
            first = last;
        }
        for _ in 0..RINGS {
            for &vertex in &self.reached {
                let vertex = vertex as usize;
                let neighbours = contact.edges.neighbours(vertex);
                let sum: Vec3A = neighbours
                    .iter()
                    .map(|&neighbour| self.displacement[neighbour as usize])
                    .sum();
                let mean = (sum + self.displacement[vertex]) / (neighbours.len() as f32 + 1.0);
                self.next[vertex] = at_least(mean, self.wanted[vertex]);
            }
            for &vertex in &self.reached {
                self.displacement[vertex as usize] = self.next[vertex as usize];
            }
        }
    }
}

/// `displacement`, plus the part that is missing along `wanted`.
fn at_least(displacement: Vec3A, wanted: Vec3A) -> Vec3A {
    let square = wanted.length_squared();
    if square == 0.0 {
        return displacement;
    }
    let missing = 1.0 - displacement.dot(wanted) / square;
    displacement + wanted * missing.max(0.0)
}
