//! Narrow phase: for each vertex of a close pair of clusters, its contact point on the nearest skin of
//! the other cluster that faces it (mathematics/contact.md, Skin contact).

use std::ops::Range;

use glam::{Vec3A, Vec4};
use rayon::prelude::*;

use crate::math::smoothstep::smooth_step_single;
use crate::math::vec3x4::LANES;
use crate::skin::contact::broadphase::PosedCluster;
use crate::skin::contact::contact::Contact;
use crate::skin::contact::facing::{FACING, FACING_FADE};
use crate::skin::contact::midphase::ClosePair;
use crate::skin::contact::points_soa::PointsSoa;

/// Distance at rest over the present distance above which two points count as having met. Below it they
/// are neighbours on the skin.
const APPROACH_RATIO: f32 = 1.5;
/// Distance at rest, in margins, below which skin is left alone: lips, eyelids, the inside of a mouth.
const LEAST_REST_OF_MARGIN: f32 = 6.0;
/// Largest margin, as a fraction of the distance at rest: skin that is close at rest may stay close.
const MARGIN_OF_REST: f32 = 0.4;
/// Depth, as a fraction of the reach, from which the displacement fades to 0 at the full reach, so that
/// contact ends smoothly.
const FADE_START: f32 = 0.35;
/// Fraction of the penetration that a vertex moves in a pass. The opposing skin moves the other half.
const SIDE_FRACTION: f32 = 0.5;

/// The posed skin. Lists are per vertex, positions in m, armature space.
pub(crate) struct PosedSkin<'a> {
    pub positions: &'a [Vec3A],
    /// The positions of clusters that are close to others.
    pub points_soa: &'a PointsSoa,
    /// Whether each vertex has a position.
    pub has_position: &'a [bool],
    pub clusters: &'a [PosedCluster],
    /// Largest fade of each vertex: that of the first pass. A vertex that moved half of its way is less
    /// deep in the next pass and would otherwise move all of it.
    pub max_fade: &'a [f32],
}

impl PosedSkin<'_> {
    /// The normal of the triangle of a vertex and two others, of twice its area, m².
    fn normal(&self, vertex: usize, others: [u32; 2]) -> Vec3A {
        let origin = self.positions[vertex];
        let [b, c] = others.map(|corner| self.positions[corner as usize] - origin);
        b.cross(c)
    }

    fn position_of(&self, closest: ClosestPoint) -> Vec3A {
        blend(
            closest.corners.map(|corner| self.positions[corner as usize]),
            closest.weights,
        )
    }
}

/// A vertex in contact. The opposing skin gets the opposite displacement.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPoint {
    pub vertex: u32,
    pub displacement: Vec3A,
    /// Factor of the displacement for its depth, 0 to 1.
    pub fade: f32,
    /// The closest point on the opposing skin.
    pub closest: ClosestPoint,
}

/// A point of the posed skin: in a triangle, by the barycentric weights of its corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClosestPoint {
    pub corners: [u32; 3],
    pub weights: [f32; 3],
}

/// The contact points of one pass.
#[derive(Debug, Default)]
pub(crate) struct ContactPoints {
    /// For each cluster in a close pair, the range of its pairs.
    rows: Vec<Range<usize>>,
    points: Vec<Vec<ContactPoint>>,
}

impl ContactPoints {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// The contact points, in a fixed order.
    pub fn iter(&self) -> impl Iterator<Item = &ContactPoint> {
        self.points[..self.rows.len().min(self.points.len())]
            .iter()
            .flatten()
    }

    /// Finds the contact points of the `close` pairs (sorted by cluster) in the posed skin.
    pub fn find(&mut self, contact: &Contact, close: &[ClosePair], skin: &PosedSkin) {
        self.rows.clear();
        let mut first = 0;
        for row in close.chunk_by(|a, b| a.cluster == b.cluster) {
            self.rows.push(first..first + row.len());
            first += row.len();
        }
        if self.points.len() < self.rows.len() {
            self.points.resize_with(self.rows.len(), Vec::new);
        }
        let work = self.points[..self.rows.len()].par_iter_mut().zip(&self.rows);
        work.for_each(|(points, row)| {
            points.clear();
            let close = &close[row.clone()];
            for vertex in contact.clusters[close[0].cluster as usize].vertices.clone() {
                points.extend(contact.contact_point(vertex, close, skin));
            }
        });
    }
}

impl Contact {
    /// The contact point of a vertex on the nearest opposing skin of its `close` pairs; `None` if it is
    /// not in contact.
    fn contact_point(&self, vertex: usize, close: &[ClosePair], skin: &PosedSkin) -> Option<ContactPoint> {
        let position = skin.positions[vertex];
        let scale = skin.clusters[close[0].cluster as usize].scale;
        if self.strength[vertex] == 0.0
            || !close
                .iter()
                .any(|pair| pair.may_meet(position, pair.within_squared))
        {
            return None;
        }
        let normal = self.normal(vertex, skin);
        if normal == Vec3A::ZERO {
            return None;
        }
        let smallest_rest_squared = (LEAST_REST_OF_MARGIN * self.margin_m * scale).powi(2);
        let (mut nearest, mut best) = (None, f32::INFINITY);
        for pair in close {
            let posed = &skin.clusters[pair.other as usize];
            let mut least_of_pair = if pair.within_squared < best {
                pair.within_squared
            } else {
                best
            };
            if !pair.may_meet(position, least_of_pair) || !self.may_face(normal, pair.other, posed) {
                continue;
            }
            let first = self.clusters[pair.other as usize].vertices.start;
            for (lanes, at) in skin
                .points_soa
                .of(pair.other)
                .iter()
                .zip((first..).step_by(LANES))
            {
                let squares = lanes.distances_squared(position);
                if !squares.cmplt(Vec4::splat(least_of_pair)).any() {
                    continue;
                }
                for (at, square) in (at..).zip(squares.to_array()) {
                    if square < least_of_pair {
                        let rest = self.rest[vertex].distance_squared(self.rest[at]) * scale * scale;
                        let has_met =
                            rest > (APPROACH_RATIO * APPROACH_RATIO * square).max(smallest_rest_squared);
                        if has_met && self.normal(at, skin).dot(normal) < FACING {
                            (best, least_of_pair) = (square, square);
                            nearest = Some((at, pair.reach_m));
                        }
                    }
                }
            }
        }
        let (nearest, reach_m) = nearest?;
        let (closest, facing) = self.closest(position, nearest, skin);
        let height_m = (position - skin.position_of(closest)).dot(facing);
        let rest_m = self.rest[vertex].distance(self.rest[nearest]) * scale;
        let margin_m = (self.margin_m * scale).min(MARGIN_OF_REST * rest_m);
        let penetration_m = margin_m - height_m;
        if penetration_m <= 0.0 {
            return None;
        }
        let depth = -height_m / reach_m;
        let depth_fade = 1.0 - smooth_step_single((depth - FADE_START) / (1.0 - FADE_START));
        // skin that turns to face other skin counts gradually, so that nothing jumps
        let opposing = smooth_step_single((FACING - normal.dot(facing)) / FACING_FADE);
        let fade = depth_fade.min(skin.max_fade[vertex]);
        Some(ContactPoint {
            vertex: vertex as u32,
            displacement: facing * (SIDE_FRACTION * penetration_m * fade * opposing),
            fade,
            closest,
        })
    }

    /// The point of the triangles around `nearest` that is closest to `position`, and the interpolated
    /// unit normal there.
    fn closest(&self, position: Vec3A, nearest: usize, skin: &PosedSkin) -> (ClosestPoint, Vec3A) {
        let normal_there = self.normal(nearest, skin);
        let mut smallest_square = position.distance_squared(skin.positions[nearest]);
        let mut best = None;
        for &[b, c] in self.around(nearest) {
            let corners = [nearest as u32, b, c];
            let weights =
                nearest_in_triangle(position, corners.map(|corner| skin.positions[corner as usize]));
            let closest = ClosestPoint { corners, weights };
            let square = position.distance_squared(skin.position_of(closest));
            if square < smallest_square {
                smallest_square = square;
                best = Some(closest);
            }
        }
        let Some(closest) = best else {
            let closest = ClosestPoint {
                corners: [nearest as u32; 3],
                weights: [1.0, 0.0, 0.0],
            };
            return (closest, normal_there);
        };
        let [_, b, c] = closest.corners.map(|corner| corner as usize);
        let normals = [
            normal_there,
            self.normal_of_corner(b, skin),
            self.normal_of_corner(c, skin),
        ];
        (
            closest,
            blend(normals, closest.weights).normalize_or(normal_there),
        )
    }

    /// The unit normal of the posed skin at a vertex of a close cluster, whose neighbours all have
    /// positions; 0 without a triangle.
    fn normal(&self, vertex: usize, skin: &PosedSkin) -> Vec3A {
        let normals = self
            .around(vertex)
            .iter()
            .map(|&others| skin.normal(vertex, others));
        normals.sum::<Vec3A>().normalize_or_zero()
    }

    /// The same at any vertex that has a position, from those of its triangles that have positions.
    fn normal_of_corner(&self, vertex: usize, skin: &PosedSkin) -> Vec3A {
        let has_position =
            |others: &&[u32; 2]| others.iter().all(|&corner| skin.has_position[corner as usize]);
        let placed = self.around(vertex).iter().filter(has_position);
        let normals = placed.map(|&others| skin.normal(vertex, others));
        normals.sum::<Vec3A>().normalize_or_zero()
    }
}

fn blend([a, b, c]: [Vec3A; 3], weights: [f32; 3]) -> Vec3A {
    a * weights[0] + b * weights[1] + c * weights[2]
}

/// Barycentric weights of the point of a triangle that is closest to `position` (Ericson 2004, 5.1.5: by
/// the Voronoi region of the position).
fn nearest_in_triangle(position: Vec3A, [a, b, c]: [Vec3A; 3]) -> [f32; 3] {
    let (ab, ac, ap) = (b - a, c - a, position - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = position - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 - d3 > 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = position - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 - d6 > 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    let (to_b, to_c) = (d4 - d3, d5 - d6);
    if va <= 0.0 && to_b >= 0.0 && to_c >= 0.0 && to_b + to_c > 0.0 {
        let t = to_b / (to_b + to_c);
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    if sum == 0.0 {
        return [1.0, 0.0, 0.0]; // no area
    }
    [va / sum, vb / sum, vc / sum]
}
