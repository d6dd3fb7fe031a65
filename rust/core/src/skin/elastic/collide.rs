//! Skin stays on its tissues: no vertex goes deeper into an ellipsoid than it was at rest (Wilhelms 1997, collision).
//!
//! In the crook of a closing joint flesh gives way as the anchors do, bone and joint spheres never: ellipsoids keep their
//! shape where real muscles are squashed, and hard ones there tore the crook of a knee at 140° open, with 20 new cuts.
//!
//! The broad phase runs once a frame over boxes of moving vertices and boxes of the tissues near them; the rounds then look at
//! what it found.

use fixedbitset::FixedBitSet;
use glam::{DMat3, DVec3, Mat3A, Vec3A};
use rayon::prelude::*;

use super::relax::CHUNK;
use crate::ellipsoid::Ellipsoid;
use crate::musculature::Musculature;
use crate::skin::frame::CarryChange;
use crate::tissue::TissueKind;

/// Way, over the radius of the largest joint that is relaxed, that skin may come in the rounds to a tissue it was outside of.
const APPROACH_OF_RADIUS: f32 = 0.2;

/// An ellipsoid that skin may collide with, as it stands at rest.
#[derive(Debug)]
struct Obstacle {
    carrier: u32,
    /// Whether it gives way where a joint closes: flesh, not bone.
    is_soft: bool,
    /// Axes of its carrier's frame at rest.
    carrier_axes: Mat3A,
    carrier_centre: Vec3A,
    /// From the carrier's frame to the unit sphere.
    to_unit: Mat3A,
    from_unit: Mat3A,
    unit_shift: Vec3A,
}

/// All ellipsoids of a musculature.
#[derive(Debug)]
pub(super) struct Obstacles {
    obstacles: Vec<Obstacle>,
    /// The vertices at rest.
    rest: Vec<Vec3A>,
}

/// An ellipsoid in a pose.
#[derive(Debug, Clone, Copy)]
struct Posed {
    obstacle: u32,
    linear: Mat3A,
    shift: Vec3A,
    low: Vec3A,
    high: Vec3A,
}

/// A vertex that may come into an ellipsoid.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    vertex: u32,
    posed: u32,
    /// Distance from the centre in the unit sphere's space that it must keep, 1 on the surface.
    least: f32,
}

/// The buffers of a frame.
#[derive(Debug)]
pub(super) struct Collisions {
    posed: Vec<Posed>,
    candidates: Vec<Vec<Candidate>>,
}

impl Obstacles {
    pub fn new(musculature: &Musculature, points: &[DVec3]) -> Self {
        let carriers = musculature.carriers().iter().enumerate();
        let obstacles = carriers.flat_map(|(index, carrier)| {
            let narrow = |matrix: DMat3| Mat3A::from(matrix.as_mat3());
            musculature
                .ellipsoids_of(index)
                .iter()
                .map(move |ellipsoid: &Ellipsoid| {
                    let from_unit =
                        carrier.axes.transpose() * ellipsoid.axes * DMat3::from_diagonal(ellipsoid.semi_axes);
                    let to_unit = from_unit.inverse();
                    let apart = carrier.axes.transpose() * (carrier.centre - ellipsoid.centre);
                    Obstacle {
                        carrier: index as u32,
                        is_soft: matches!(
                            musculature.tissues()[carrier.tissue].kind(),
                            TissueKind::Muscle | TissueKind::Stuffing
                        ),
                        carrier_axes: narrow(carrier.axes),
                        carrier_centre: carrier.centre.as_vec3a(),
                        to_unit: narrow(to_unit),
                        from_unit: narrow(from_unit),
                        unit_shift: (to_unit * apart).as_vec3a(),
                    }
                })
        });
        Self {
            obstacles: obstacles.collect(),
            rest: points.iter().map(|point| point.as_vec3a()).collect(),
        }
    }
}

impl Collisions {
    pub fn new(obstacles: &Obstacles) -> Self {
        Self {
            posed: Vec::with_capacity(obstacles.obstacles.len()),
            candidates: vec![vec![]; obstacles.rest.len().div_ceil(CHUNK)],
        }
    }

    /// Finds what may collide: the vertices that `moves`, at `anchors`, with the ellipsoids of `near` carriers. `radius_m` is that
    /// of the largest joint that is relaxed, `yielding` how far each vertex gives way.
    pub fn find(
        &mut self,
        obstacles: &Obstacles,
        carriers: &[CarryChange],
        near: &FixedBitSet,
        radius_m: f32,
        moves: &[bool],
        anchors: &[Vec3A],
        yielding: &[f32],
    ) {
        let approach = Vec3A::splat(APPROACH_OF_RADIUS * radius_m);
        self.posed.clear();
        let own = obstacles.obstacles.iter().enumerate();
        let own = own.filter(|(_, obstacle)| near.contains(obstacle.carrier as usize));
        self.posed.extend(own.filter_map(|(index, obstacle)| {
            let change = &carriers[obstacle.carrier as usize];
            obstacle.posed(index as u32, change, approach)
        }));
        let posed = &self.posed;
        let work = self.candidates.par_iter_mut().enumerate();
        work.for_each(|(chunk, found)| {
            found.clear();
            let first = chunk * CHUNK;
            let vertices = || (first..(first + CHUNK).min(moves.len())).filter(|&vertex| moves[vertex]);
            let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
            for vertex in vertices() {
                low = low.min(anchors[vertex]);
                high = high.max(anchors[vertex]);
            }
            for (index, own) in posed.iter().enumerate() {
                if !(own.low.cmple(high).all() && own.high.cmpge(low).all()) {
                    continue;
                }
                for vertex in vertices() {
                    let place = anchors[vertex];
                    if own.low.cmple(place).all() && own.high.cmpge(place).all() {
                        let is_soft = obstacles.obstacles[own.obstacle as usize].is_soft;
                        let giving_way = if is_soft { yielding[vertex] } else { 0.0 };
                        let at_rest = obstacles.rest_depth(own.obstacle, vertex).min(1.0);
                        let least = at_rest * (1.0 - giving_way);
                        found.push(Candidate {
                            vertex: vertex as u32,
                            posed: index as u32,
                            least,
                        });
                    }
                }
            }
            found.sort_unstable_by_key(|found| (found.vertex, found.posed));
        });
    }

    /// Moves every vertex that has come too deep into an ellipsoid out along its normal.
    pub fn resolve(&self, skin: &mut [Vec3A]) {
        let chunks = skin.par_chunks_mut(CHUNK).zip(&self.candidates).enumerate();
        chunks.for_each(|(chunk, (skin, candidates))| {
            for found in candidates {
                let place = &mut skin[found.vertex as usize - chunk * CHUNK];
                let posed = &self.posed[found.posed as usize];
                let unit = posed.linear * *place + posed.shift;
                let square = unit.length_squared();
                let least = found.least * found.least;
                if square < least {
                    // a Newton step of |unit|² along its gradient
                    let gradient = posed.linear.transpose() * unit * 2.0;
                    let size = gradient.length_squared();
                    if size > 0.0 {
                        *place += gradient * ((least - square) / size);
                    }
                }
            }
        });
    }
}

impl Obstacles {
    /// Distance of a vertex from the centre of an ellipsoid at rest, 1 on its surface.
    fn rest_depth(&self, obstacle: u32, vertex: usize) -> f32 {
        let own = &self.obstacles[obstacle as usize];
        let local = own.carrier_axes.transpose() * (self.rest[vertex] - own.carrier_centre);
        (own.to_unit * local + own.unit_shift).length()
    }
}

impl Obstacle {
    /// The ellipsoid in a pose, its box grown by `approach`; `None` where it is flat.
    fn posed(&self, index: u32, change: &CarryChange, approach: Vec3A) -> Option<Posed> {
        let stretch = self.carrier_axes + change.stretch;
        let centre = self.carrier_centre + change.shift;
        if stretch.determinant().abs() < f32::MIN_POSITIVE {
            return None;
        }
        let linear = self.to_unit * stretch.inverse();
        let from_unit = stretch * self.from_unit;
        let middle = centre - from_unit * self.unit_shift;
        let half = Vec3A::new(
            from_unit.row(0).length(),
            from_unit.row(1).length(),
            from_unit.row(2).length(),
        );
        let posed = Posed {
            obstacle: index,
            linear,
            shift: self.unit_shift - linear * centre,
            low: middle - half - approach,
            high: middle + half + approach,
        };
        (posed.low.is_finite() && posed.high.is_finite() && posed.shift.is_finite()).then_some(posed)
    }
}
