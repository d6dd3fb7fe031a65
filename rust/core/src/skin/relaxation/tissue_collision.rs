//! Tissue collision: no vertex goes deeper into an ellipsoid that influences it than it is at rest
//! (Wilhelms 1997; mathematics/contact.md, Tissue collision).
//!
//! A vertex collides only with carriers that influence it. Skin of other parts of the body meets it in
//! skin contact. In a closed joint, muscles and stuffing yield as the anchors do; bones and spheres do
//! not. Ellipsoids keep their shape where real muscles are squashed: without yielding, the inner side of
//! a knee tore open at 140°, with 20 new self-intersections.
//!
//! Each frame first finds the moving vertices that are near an ellipsoid. The iterations then test only
//! those.

use fixedbitset::FixedBitSet;
use glam::{DMat3, DVec3, Mat3A, Vec3A};
use rayon::prelude::*;

use crate::ellipsoid::Ellipsoid;
use crate::math::rows::Rows;
use crate::muscles::musculature::Musculature;
use crate::muscles::tissue::TissueKind;
use crate::parallel::RELAXATION_CHUNK;
use crate::skin::relaxation::arap::JacobiSolver;
use crate::skin::tissue_change::TissueChange;

/// Distance from the centre of an ellipsoid, 1 on its surface, up to which a vertex is tested. An
/// iteration rarely brings skin in from farther out; a vertex that does come from there is missed.
const NEAR_RADIUS: f32 = 1.6;

/// An ellipsoid that skin may collide with, at rest.
#[derive(Debug)]
struct Obstacle {
    carrier: u32,
    /// Whether it yields in a closed joint: muscle or stuffing.
    yields: bool,
    /// Axes of its carrier at rest.
    carrier_axes: Mat3A,
    carrier_centre: Vec3A,
    /// Map from the carrier's axes to the unit sphere.
    to_unit: Mat3A,
    unit_shift: Vec3A,
}

/// The ellipsoids of a musculature, and the vertices that they influence.
#[derive(Debug)]
pub(crate) struct Obstacles {
    obstacles: Vec<Obstacle>,
    /// The candidates of each vertex.
    candidates: Rows<Candidate>,
}

/// An ellipsoid that influences a vertex.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    obstacle: u32,
    /// Distance of the vertex from the centre at rest, in the space of the unit sphere; at most 1.
    rest_radius: f32,
}

/// The map of an ellipsoid in a pose to the unit sphere.
#[derive(Debug, Clone, Copy)]
struct PosedEllipsoid {
    linear: Mat3A,
    shift: Vec3A,
}

/// A vertex that may enter an ellipsoid.
#[derive(Debug, Clone, Copy)]
struct Constraint {
    vertex: u32,
    obstacle: u32,
    /// Smallest distance from the centre, in the space of the unit sphere.
    least_radius: f32,
}

/// The buffers of one frame.
#[derive(Debug)]
pub(crate) struct Collisions {
    /// Of the obstacles near active joints; `None` for others and for flat ones.
    posed: Vec<Option<PosedEllipsoid>>,
    constraints: Vec<Vec<Constraint>>,
}

impl Obstacles {
    /// The ellipsoids of `musculature` and their candidates among `points`. `carriers_of` returns the
    /// carriers that influence a vertex.
    pub fn new(
        musculature: &Musculature,
        points: &[DVec3],
        carriers_of: &(dyn Fn(usize) -> Vec<u32> + Sync),
    ) -> Self {
        let (mut obstacles, mut first_of_carrier) = (vec![], vec![0]);
        for index in 0..musculature.carriers().len() {
            let ellipsoids = musculature.ellipsoids_of(index).iter();
            obstacles.extend(ellipsoids.map(|ellipsoid| Obstacle::new(musculature, index, ellipsoid)));
            first_of_carrier.push(obstacles.len() as u32);
        }
        let mut candidates = Rows::default();
        for (vertex, point) in points.iter().enumerate() {
            let of_carrier =
                |carrier: u32| first_of_carrier[carrier as usize]..first_of_carrier[carrier as usize + 1];
            let influencing = carriers_of(vertex).into_iter().flat_map(of_carrier);
            candidates.push(influencing.map(|obstacle| {
                Candidate {
                    obstacle,
                    rest_radius: obstacles[obstacle as usize]
                        .rest_radius(point.as_vec3a())
                        .min(1.0),
                }
            }));
        }
        Self {
            obstacles,
            candidates,
        }
    }

    fn candidates(&self, vertex: usize) -> &[Candidate] {
        self.candidates.row(vertex)
    }
}

impl Collisions {
    pub fn new(obstacles: &Obstacles) -> Self {
        let vertices = obstacles.candidates.len();
        Self {
            posed: vec![None; obstacles.obstacles.len()],
            constraints: vec![vec![]; vertices.div_ceil(RELAXATION_CHUNK)],
        }
    }

    /// Finds the constraints of a frame: vertices that move and whose anchors are near an ellipsoid, of
    /// the carriers in `near`, that influences them.
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
        work.for_each(|(chunk, constraints)| {
            constraints.clear();
            if !solver.moving_chunks[chunk] {
                return;
            }
            let first = chunk * RELAXATION_CHUNK;
            let last = (first + RELAXATION_CHUNK).min(solver.moves.len());
            for vertex in (first..last).filter(|&vertex| solver.moves[vertex]) {
                for candidate in obstacles.candidates(vertex) {
                    let Some(posed) = &posed[candidate.obstacle as usize] else {
                        continue;
                    };
                    if posed.unit(solver.anchors[vertex]).length_squared() < NEAR_RADIUS * NEAR_RADIUS {
                        let yields = obstacles.obstacles[candidate.obstacle as usize].yields;
                        let yielding = if yields { solver.yielding[vertex] } else { 0.0 };
                        constraints.push(Constraint {
                            vertex: vertex as u32,
                            obstacle: candidate.obstacle,
                            least_radius: candidate.rest_radius * (1.0 - yielding),
                        });
                    }
                }
            }
        });
    }

    /// Moves every vertex that is too deep in an ellipsoid, with swelling, out along the gradient.
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
            for constraint in constraints {
                let vertex = constraint.vertex as usize;
                let displacement = &mut displacements[vertex - chunk * RELAXATION_CHUNK];
                let Some(posed) = &self.posed[constraint.obstacle as usize] else {
                    continue;
                };
                let unit = posed.unit(swollen_anchors[vertex] + *displacement);
                let square = unit.length_squared();
                let least_radius = constraint.least_radius * constraint.least_radius;
                if square < least_radius {
                    // one Newton step of |unit|² along its gradient
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

    /// Distance of a point from the centre at rest, 1 on the surface.
    fn rest_radius(&self, point: Vec3A) -> f32 {
        let local = self.carrier_axes.transpose() * (point - self.carrier_centre);
        (self.to_unit * local + self.unit_shift).length()
    }

    /// The ellipsoid in a pose; `None` if it is flat.
    fn posed(&self, change: &TissueChange) -> Option<PosedEllipsoid> {
        let stretch = self.carrier_axes + change.stretch;
        let linear = self.to_unit * stretch.inverse();
        let shift = self.unit_shift - linear * (self.carrier_centre + change.shift);
        (linear.is_finite() && shift.is_finite()).then_some(PosedEllipsoid { linear, shift })
    }
}

impl PosedEllipsoid {
    /// A point in the space of the unit sphere.
    fn unit(&self, point: Vec3A) -> Vec3A {
        self.linear * point + self.shift
    }
}
