//! Skin stays on its tissues: no vertex goes deeper into an ellipsoid that it lies on than it was at rest (Wilhelms 1997,
//! collision).
//!
//! A vertex lies on the carriers that move it; what other parts of the body press against it, meets it as skin (contact). In the
//! crook of a closing joint flesh gives way as the anchors do, bone and joint spheres never: ellipsoids keep their shape where
//! real muscles are squashed, and hard ones there tore the crook of a knee at 140° open, with 20 new cuts.
//!
//! Each frame first looks which moving vertices are near which of their tissues; the solver then look at those alone.

use fixedbitset::FixedBitSet;
use glam::{DMat3, DVec3, Mat3A, Vec3A};
use rayon::prelude::*;

use crate::ellipsoid::Ellipsoid;
use crate::muscles::musculature::Musculature;
use crate::muscles::tissue::TissueKind;
use crate::parallel::RELAXATION_CHUNK;
use crate::skin::relaxation::arap::JacobiSolver;
use crate::skin::tissue_change::TissueChange;

/// Distance from the centre of an ellipsoid, 1 on its surface, up to which the solver may bring skin into it.
const NEAR_RADIUS: f32 = 1.6;

/// An ellipsoid that skin may collide with, as it stands at rest.
#[derive(Debug)]
struct Obstacle {
    carrier: u32,
    /// Whether it gives way where a joint closes: flesh, not bone.
    yields: bool,
    /// Axes of its carrier's frame at rest.
    carrier_axes: Mat3A,
    carrier_centre: Vec3A,
    /// From the carrier's frame to the unit sphere.
    to_unit: Mat3A,
    unit_shift: Vec3A,
}

/// All ellipsoids of a musculature, and what lies on them.
#[derive(Debug)]
pub(crate) struct Obstacles {
    obstacles: Vec<Obstacle>,
    /// Where the ellipsoids of each vertex start in `candidates`.
    offsets: Vec<u32>,
    candidates: Vec<Candidate>,
}

/// An ellipsoid that a vertex lies on.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    obstacle: u32,
    /// Distance of the vertex from its centre at rest in the unit sphere's space, 1 on and outside the surface.
    rest_radius: f32,
}

/// An ellipsoid in a pose: to the unit sphere.
#[derive(Debug, Clone, Copy)]
struct PosedEllipsoid {
    linear: Mat3A,
    shift: Vec3A,
}

/// A vertex that may come into an ellipsoid.
#[derive(Debug, Clone, Copy)]
struct Constraint {
    vertex: u32,
    obstacle: u32,
    /// Distance from the centre in the unit sphere's space that it must keep, 1 on the surface.
    least_radius: f32,
}

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct Collisions {
    /// Of the obstacles near the joints that are relaxed; `None` for the others, and where one is flat.
    posed: Vec<Option<PosedEllipsoid>>,
    constraints: Vec<Vec<Constraint>>,
}

impl Obstacles {
    /// The ellipsoids of `musculature` candidates `points`; `carriers_of` gives the carriers that move a vertex.
    pub fn new(
        musculature: &Musculature,
        points: &[DVec3],
        carriers_of: &(dyn Fn(usize) -> Vec<u32> + Sync),
    ) -> Self {
        let (mut obstacles, mut first_of_carrier) = (vec![], vec![0]);
        for index in 0..musculature.carriers().len() {
            let own = musculature.ellipsoids_of(index).iter();
            obstacles.extend(own.map(|ellipsoid| Obstacle::new(musculature, index, ellipsoid)));
            first_of_carrier.push(obstacles.len() as u32);
        }
        let (mut offsets, mut candidates) = (vec![0], vec![]);
        for (vertex, point) in points.iter().enumerate() {
            for carrier in carriers_of(vertex) {
                let own = first_of_carrier[carrier as usize]..first_of_carrier[carrier as usize + 1];
                candidates.extend(own.map(|obstacle| Candidate {
                    obstacle,
                    rest_radius: obstacles[obstacle as usize].rest_radius(point.as_vec3a()).min(1.0),
                }));
            }
            offsets.push(candidates.len() as u32);
        }
        Self {
            obstacles,
            offsets,
            candidates,
        }
    }

    fn candidates(&self, vertex: usize) -> &[Candidate] {
        &self.candidates[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}

impl Collisions {
    pub fn new(obstacles: &Obstacles) -> Self {
        let vertices = obstacles.offsets.len() - 1;
        Self {
            posed: vec![None; obstacles.obstacles.len()],
            constraints: vec![vec![]; vertices.div_ceil(RELAXATION_CHUNK)],
        }
    }

    /// Finds what may collide: the vertices that move in `solver`, on their anchors, with the ellipsoids of `near` carriers that
    /// they lie on.
    pub fn find(
        &mut self,
        obstacles: &Obstacles,
        carriers: &[TissueChange],
        near: &FixedBitSet,
        solver: &JacobiSolver,
    ) {
        for (posed, obstacle) in self.posed.iter_mut().zip(&obstacles.obstacles) {
            let carrier = obstacle.carrier as usize;
            *posed = near
                .contains(carrier)
                .then(|| obstacle.posed(&carriers[carrier]))
                .flatten();
        }
        let posed = &self.posed;
        let work = self.constraints.par_iter_mut().enumerate();
        work.for_each(|(chunk, found)| {
            found.clear();
            if !solver.moving_chunks[chunk] {
                return;
            }
            let first = chunk * RELAXATION_CHUNK;
            let last = (first + RELAXATION_CHUNK).min(solver.moves.len());
            for vertex in (first..last).filter(|&vertex| solver.moves[vertex]) {
                for candidates in obstacles.candidates(vertex) {
                    let Some(posed) = &posed[candidates.obstacle as usize] else {
                        continue;
                    };
                    if posed.unit(solver.anchors[vertex]).length_squared() < NEAR_RADIUS * NEAR_RADIUS {
                        let yields = obstacles.obstacles[candidates.obstacle as usize].yields;
                        let yielding = if yields { solver.yielding[vertex] } else { 0.0 };
                        found.push(Constraint {
                            vertex: vertex as u32,
                            obstacle: candidates.obstacle,
                            least_radius: candidates.rest_radius * (1.0 - yielding),
                        });
                    }
                }
            }
        });
    }

    /// Moves every vertex that has come too deep into an ellipsoid, swollen, out along its normal.
    pub fn resolve(&self, solver: &mut JacobiSolver) {
        let JacobiSolver {
            displacements,
            swollen_anchors,
            ..
        } = solver;
        let chunks = displacements
            .par_chunks_mut(RELAXATION_CHUNK)
            .zip(&self.constraints)
            .enumerate();
        chunks.for_each(|(chunk, (displacements, constraints))| {
            for found in constraints {
                let vertex = found.vertex as usize;
                let displacement = &mut displacements[vertex - chunk * RELAXATION_CHUNK];
                let Some(posed) = &self.posed[found.obstacle as usize] else {
                    continue;
                };
                let unit = posed.unit(swollen_anchors[vertex] + *displacement);
                let square = unit.length_squared();
                let least_radius = found.least_radius * found.least_radius;
                if square < least_radius {
                    // a Newton step of |unit|² along its gradient
                    let gradient = posed.linear.transpose() * unit * 2.0;
                    let size = gradient.length_squared();
                    if size > 0.0 {
                        *displacement += gradient * ((least_radius - square) / size);
                    }
                }
            }
        });
    }
}

impl Obstacle {
    fn new(musculature: &Musculature, index: usize, ellipsoid: &Ellipsoid) -> Self {
        let carrier = &musculature.carriers()[index];
        let narrow = |matrix: DMat3| Mat3A::from(matrix.as_mat3());
        let to_carrier = carrier.axes.transpose();
        let to_unit = (to_carrier * ellipsoid.axes * DMat3::from_diagonal(ellipsoid.semi_axes)).inverse();
        Self {
            carrier: index as u32,
            yields: matches!(
                musculature.tissues()[carrier.tissue].kind(),
                TissueKind::Muscle | TissueKind::Stuffing
            ),
            carrier_axes: narrow(carrier.axes),
            carrier_centre: carrier.centre.as_vec3a(),
            to_unit: narrow(to_unit),
            unit_shift: (to_unit * to_carrier * (carrier.centre - ellipsoid.centre)).as_vec3a(),
        }
    }

    /// Distance of a point from its centre at rest, 1 on its surface.
    fn rest_radius(&self, point: Vec3A) -> f32 {
        let local = self.carrier_axes.transpose() * (point - self.carrier_centre);
        (self.to_unit * local + self.unit_shift).length()
    }

    /// The ellipsoid in a pose; `None` where it is flat.
    fn posed(&self, change: &TissueChange) -> Option<PosedEllipsoid> {
        let stretch = self.carrier_axes + change.stretch;
        let linear = self.to_unit * stretch.inverse();
        let shift = self.unit_shift - linear * (self.carrier_centre + change.shift);
        (linear.is_finite() && shift.is_finite()).then_some(PosedEllipsoid { linear, shift })
    }
}

impl PosedEllipsoid {
    /// A point in the unit sphere's space.
    fn unit(&self, point: Vec3A) -> Vec3A {
        self.linear * point + self.shift
    }
}
