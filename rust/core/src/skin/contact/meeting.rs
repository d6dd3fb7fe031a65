//! Where the skin of two parts meets: for each vertex, the nearest skin of the other part that faces it.

use glam::Vec3A;
use rayon::prelude::*;

use super::Contact;
use super::clusters::{Pair, PosedCluster};

/// Cosine of two normals below which skin faces skin.
pub(super) const FACING: f32 = -0.3;
/// Square of how much farther skin may lie from the middle of its cluster than at rest.
const LOOSE_BALL: f32 = 1.4;
/// How far beyond that skin faces it fully.
const FACING_FULLY: f32 = 0.3;
/// Distance at rest, over the present one, from which two places count as having met; below, they are neighbours on the skin.
const APPROACHED: f32 = 1.5;
/// Distance at rest over the margin below which skin is left as it is: lips, eyelids, what lies in a mouth.
const LEAST_REST_OF_MARGIN: f32 = 6.0;
/// Share of the distance at rest that places keep at most: what is close at rest may be close.
const MARGIN_OF_REST: f32 = 0.4;
/// Share of the reach from which the push fades with the depth.
const FADES_FROM: f32 = 0.35;
/// Share of the way apart that a vertex goes in a pass; the skin that it meets does the same.
const SHARE: f32 = 0.5;

/// The posed skin.
pub(super) struct PosedSkin<'a> {
    pub places: &'a [Vec3A],
    pub normals: &'a [Vec3A],
    pub clusters: &'a [PosedCluster],
    /// Largest share of its way that each vertex goes: that of the first pass, since what was pushed half of its way out is less deep
    /// in the next and would go on all of it.
    pub most: &'a [f32],
}

/// A vertex that is to be moved off other skin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    pub vertex: u32,
    pub push: Vec3A,
    /// Share of its way that it goes, for its depth.
    pub share: f32,
}

/// All of them.
#[derive(Debug, Default)]
pub(super) struct Meetings {
    /// Each cluster with the clusters that it may meet, as a range of `others`.
    rows: Vec<(u32, u32, u32)>,
    others: Vec<(u32, u32)>,
    found: Vec<Vec<Meeting>>,
}

impl Meetings {
    /// True where none was found.
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// The meetings, in a fixed order.
    pub fn iter(&self) -> impl Iterator<Item = &Meeting> {
        self.found[..self.rows.len().min(self.found.len())]
            .iter()
            .flatten()
    }

    /// Finds the meetings of the pairs of clusters in the posed skin.
    pub fn find(&mut self, contact: &Contact, pairs: &[Pair], skin: &PosedSkin) {
        self.others.clear();
        self.others.extend(
            pairs
                .iter()
                .flat_map(|pair| [(pair.one, pair.other), (pair.other, pair.one)]),
        );
        self.others.sort_unstable();
        self.others.dedup();
        self.rows.clear();
        let mut first = 0;
        for row in self.others.chunk_by(|a, b| a.0 == b.0) {
            self.rows.push((row[0].0, first, first + row.len() as u32));
            first += row.len() as u32;
        }
        if self.found.len() < self.rows.len() {
            self.found.resize_with(self.rows.len(), Vec::new);
        }
        let (rows, others) = (&self.rows, &self.others);
        let work = self.found[..rows.len()].par_iter_mut().zip(rows);
        work.for_each(|(found, &(cluster, first, last))| {
            found.clear();
            let others = &others[first as usize..last as usize];
            for &vertex in &contact.clusters[cluster as usize].vertices {
                if let Some((push, share)) = contact.push(vertex as usize, cluster, others, skin) {
                    found.push(Meeting { vertex, push, share });
                }
            }
        });
    }
}

impl Contact {
    /// How far a vertex must go to clear its part of the way to the nearest skin of some clusters that faces it, and what share of
    /// that its depth lets it go; `None` where it is clear.
    fn push(
        &self,
        vertex: usize,
        cluster: u32,
        others: &[(u32, u32)],
        skin: &PosedSkin,
    ) -> Option<(Vec3A, f32)> {
        let (place, normal) = (skin.places[vertex], skin.normals[vertex]);
        let scale = skin.clusters[cluster as usize].scale;
        let mut reach_m = self.reach_of_m[vertex] * scale;
        let strength = self.strength[vertex];
        if normal == Vec3A::ZERO || strength == 0.0 {
            return None;
        }
        let least = (LEAST_REST_OF_MARGIN * self.margin_m * scale).powi(2);
        let (mut nearest, mut best) = (None, reach_m * reach_m);
        for &(_, other) in others {
            let cluster = &self.clusters[other as usize];
            let posed = &skin.clusters[other as usize];
            let near_m = cluster.radius_m * posed.scale + reach_m;
            if place.distance_squared(posed.centre) > near_m * near_m * LOOSE_BALL
                || !self.may_face(normal, other, posed)
            {
                continue;
            }
            for &candidate in &cluster.vertices {
                let at = candidate as usize;
                let square = place.distance_squared(skin.places[at]);
                if square < best && skin.normals[at].dot(normal) < FACING {
                    let rest = self.rest[vertex].distance_squared(self.rest[at]) * scale * scale;
                    if rest > (APPROACHED * APPROACHED * square).max(least) {
                        best = square;
                        nearest = Some(at);
                    }
                }
            }
        }
        let nearest = nearest?;
        reach_m = reach_m.min(self.reach_of_m[nearest] * scale);
        let (foot, facing) = self.foot(place, nearest, skin);
        let height_m = (place - foot).dot(facing);
        let rest_m = self.rest[vertex].distance(self.rest[nearest]) * scale;
        let margin_m = (self.margin_m * scale).min(MARGIN_OF_REST * rest_m);
        let lacking_m = margin_m - height_m;
        if lacking_m <= 0.0 {
            return None;
        }
        let depth = -height_m / reach_m;
        let fading = 1.0 - smooth((depth - FADES_FROM) / (1.0 - FADES_FROM));
        // what turns to face other skin comes to count smoothly, so that nothing jumps
        let turned = smooth((FACING - normal.dot(facing)) / FACING_FULLY);
        let share = fading.min(skin.most[vertex]);
        Some((facing * (SHARE * lacking_m * share * turned * strength), share))
    }

    /// The point of the triangles around `nearest` that is nearest to `place`, and the skin's normal there.
    fn foot(&self, place: Vec3A, nearest: usize, skin: &PosedSkin) -> (Vec3A, Vec3A) {
        let mut best = (skin.places[nearest], skin.normals[nearest]);
        let mut least = place.distance_squared(best.0);
        for &triangle in self.triangles_of(nearest) {
            let corners = self.triangles[triangle as usize].map(|corner| corner as usize);
            let shares = nearest_in_triangle(place, corners.map(|corner| skin.places[corner]));
            let blend = |list: &[Vec3A]| {
                list[corners[0]] * shares[0] + list[corners[1]] * shares[1] + list[corners[2]] * shares[2]
            };
            let foot = blend(skin.places);
            let square = place.distance_squared(foot);
            if square < least {
                least = square;
                best = (foot, blend(skin.normals).normalize_or(best.1));
            }
        }
        best
    }
}

/// Shares of the corners in the point of a triangle that is nearest to `place` (C. Ericson, Real-Time Collision Detection,
/// 2005, 5.1.5: by the region of the plane that it lies over).
fn nearest_in_triangle(place: Vec3A, [a, b, c]: [Vec3A; 3]) -> [f32; 3] {
    let (ab, ac, ap) = (b - a, c - a, place - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = place - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 - d3 > 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = place - c;
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

/// 0 below 0, 1 above 1, smooth between.
fn smooth(value: f32) -> f32 {
    let t = value.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
