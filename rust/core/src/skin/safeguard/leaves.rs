//! Which triangles of a skin cross each other in a pose. Triangles that lie together are looked at in leaves: a box and the normals of
//! a few. Leaves that touch and all of whose normals lie in one half-space do not cross (P. Volino, N. Magnenat-Thalmann, "Efficient
//! self-collision detection on smoothly discretized surface animations", 1994), which is nearly all of them.

use std::ops::Range;

use glam::Vec3A;
use rayon::prelude::*;

use crate::skin::safeguard::crossing::crossing_m;

/// Triangles of a leaf.
const LEAF: usize = 16;
/// Least cosine of the normals of two leaves that touch with their mean, for neither to cross the other.
const HALF_SPACE: f32 = 0.1;
/// Angle between any two normals of two leaves that touch up to which neither crosses the other, radians: a little below a half turn
/// less what a fold of few triangles hides.
const ONE_WAY: f32 = 2.6;

/// Cosine of the normals of two triangles of leaves that touch, below which the skin between them may be folded so that they cross.
const FOLDED: f32 = 0.8;

/// Two triangles that cross.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    pub one: u32,
    pub other: u32,
    /// Length of the segment in which they cross, m.
    pub length_m: f32,
}

/// The leaves of a mesh.
#[derive(Debug)]
pub(crate) struct Leaves {
    triangles: Vec<[u32; 3]>,
    /// The leaves that share a vertex with each, itself among them; rising.
    touching: Vec<Vec<u32>>,
}

/// A leaf in a pose.
#[derive(Debug, Clone, Copy)]
struct PosedLeaf {
    leaf: u32,
    low: Vec3A,
    high: Vec3A,
}

/// The normals of a leaf: within `angle` of `axis`.
#[derive(Debug, Clone, Copy, Default)]
struct NormalCone {
    axis: Vec3A,
    angle: f32,
}

impl NormalCone {
    fn new(normals: &[Vec3A]) -> Self {
        let axis = normals.iter().sum::<Vec3A>().normalize_or_zero();
        let sized = normals.iter().filter(|normal| **normal != Vec3A::ZERO);
        let least = sized.map(|normal| normal.dot(axis)).fold(1.0, f32::min);
        Self {
            axis,
            angle: least.clamp(-1.0, 1.0).acos(),
        }
    }

    fn is_one_way(&self, other: &Self) -> bool {
        let between = self.axis.dot(other.axis).clamp(-1.0, 1.0).acos();
        self.angle + between + other.angle < ONE_WAY
    }
}

impl Leaves {
    /// Leaves of `triangles`, of which those that follow each other lie together.
    pub fn new(triangles: Vec<[u32; 3]>, vertices: usize) -> Self {
        let mut leaves_of: Vec<Vec<u32>> = vec![vec![]; vertices];
        for (index, triangle) in triangles.iter().enumerate() {
            for &vertex in triangle {
                let leaf = (index / LEAF) as u32;
                if leaves_of[vertex as usize].last() != Some(&leaf) {
                    leaves_of[vertex as usize].push(leaf);
                }
            }
        }
        let touching = triangles.chunks(LEAF).map(|own| {
            let corners = own.iter().flatten();
            let mut found: Vec<u32> = corners
                .flat_map(|&vertex| &leaves_of[vertex as usize])
                .copied()
                .collect();
            found.sort_unstable();
            found.dedup();
            found
        });
        Self {
            touching: touching.collect(),
            triangles,
        }
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The leaves that any of some triangles lie in, rising.
    pub fn of(&self, triangles: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut found: Vec<u32> = triangles.map(|triangle| triangle / LEAF as u32).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The crossings of the triangles of the `active` leaves, rising, with any, in a fixed order; the vertices are at `places`.
    pub fn crossings(&self, active: &[u32], places: &[Vec3A]) -> Vec<Crossing> {
        let all: Vec<PosedLeaf> = (0..self.touching.len() as u32)
            .into_par_iter()
            .with_min_len(64)
            .map(|leaf| self.posed(leaf, places))
            .collect();
        let mut is_active = vec![false; all.len()];
        active.iter().for_each(|&leaf| is_active[leaf as usize] = true);
        let own = active.iter().map(|&leaf| &all[leaf as usize]);
        let low = own.clone().map(|own| own.low).fold(Vec3A::INFINITY, Vec3A::min);
        let high = own.map(|own| own.high).fold(Vec3A::NEG_INFINITY, Vec3A::max);
        let is_near = |leaf: &PosedLeaf| leaf.low.cmple(high).all() && low.cmple(leaf.high).all();
        let near: Vec<PosedLeaf> = all.iter().copied().filter(is_near).collect();
        let pairs = pairs(near, &is_active);
        let (normals, cones) = self.normals(&pairs, places);
        let mut crossings: Vec<Crossing> = pairs
            .par_iter()
            .with_min_len(64)
            .flat_map_iter(|&(one, other)| {
                let mut found = vec![];
                let touches = self.touching[one as usize].binary_search(&other).is_ok();
                let is_one_way = || {
                    cones[one as usize].is_one_way(&cones[other as usize])
                        || is_one_way(&normals[self.range(one)], &normals[self.range(other)])
                };
                if !(touches && is_one_way()) {
                    let pair = (&all[one as usize], &all[other as usize]);
                    let most = if touches { FOLDED } else { 2.0 };
                    let may_cross = |a: usize, b: usize| normals[a].dot(normals[b]) < most;
                    self.cross(pair, places, may_cross, &mut found);
                }
                found
            })
            .collect();
        crossings.sort_unstable_by_key(|crossing| (crossing.one, crossing.other));
        crossings
    }

    fn range(&self, leaf: u32) -> Range<usize> {
        let first = leaf as usize * LEAF;
        first..(first + LEAF).min(self.triangles.len())
    }

    fn corners(&self, triangle: usize, places: &[Vec3A]) -> [Vec3A; 3] {
        self.triangles[triangle].map(|vertex| places[vertex as usize])
    }

    fn posed(&self, leaf: u32, places: &[Vec3A]) -> PosedLeaf {
        let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for triangle in self.range(leaf) {
            for corner in self.corners(triangle, places) {
                (low, high) = (low.min(corner), high.max(corner));
            }
        }
        PosedLeaf { leaf, low, high }
    }

    /// The unit normals of the triangles of the leaves in some pairs, and the cones that they lie in; 0 and nothing for all others.
    fn normals(&self, pairs: &[(u32, u32)], places: &[Vec3A]) -> (Vec<Vec3A>, Vec<NormalCone>) {
        let mut is_due = vec![false; self.touching.len()];
        for &(one, other) in pairs {
            (is_due[one as usize], is_due[other as usize]) = (true, true);
        }
        let mut normals = vec![Vec3A::ZERO; self.triangles.len()];
        let mut cones = vec![NormalCone::default(); self.touching.len()];
        let work = normals
            .par_chunks_mut(LEAF)
            .zip(&mut cones)
            .zip(is_due)
            .enumerate();
        work.with_min_len(16)
            .filter(|(_, (_, is_due))| *is_due)
            .for_each(|(leaf, ((normals, cone), _))| {
                for (triangle, normal) in self.range(leaf as u32).zip(&mut *normals) {
                    let [a, b, c] = self.corners(triangle, places);
                    *normal = (b - a).cross(c - a).normalize_or_zero();
                }
                *cone = NormalCone::new(normals);
            });
        (normals, cones)
    }

    fn cross(
        &self,
        (one, other): (&PosedLeaf, &PosedLeaf),
        places: &[Vec3A],
        may_cross: impl Fn(usize, usize) -> bool,
        found: &mut Vec<Crossing>,
    ) {
        let (low, high) = (one.low.max(other.low), one.high.min(other.high));
        let within = |leaf: u32| {
            let boxes = self.range(leaf).map(|triangle| {
                let [a, b, c] = self.corners(triangle, places);
                (triangle, a.min(b).min(c), a.max(b).max(c))
            });
            boxes.filter(|own| own.1.cmple(high).all() && low.cmple(own.2).all())
        };
        let mut others = [(0, Vec3A::ZERO, Vec3A::ZERO); LEAF];
        let mut count = 0;
        for (slot, own) in others.iter_mut().zip(within(other.leaf)) {
            *slot = own;
            count += 1;
        }
        if count == 0 {
            return;
        }
        for (index, low, high) in within(one.leaf) {
            let vertices = self.triangles[index];
            for &(other_index, other_low, other_high) in &others[..count] {
                let is_new = one.leaf != other.leaf || other_index > index;
                let meets = low.cmple(other_high).all() && other_low.cmple(high).all();
                if !(is_new && meets && may_cross(index, other_index)) {
                    continue;
                }
                let shares = |vertex: &u32| vertices.contains(vertex);
                if self.triangles[other_index].iter().any(shares) {
                    continue;
                }
                let (corners, others) = (self.corners(index, places), self.corners(other_index, places));
                let length_m = crossing_m(&corners, &others);
                if length_m > 0.0 {
                    found.push(Crossing {
                        one: index as u32,
                        other: other_index as u32,
                        length_m,
                    });
                }
            }
        }
    }
}

/// Whether all of some normals are within a quarter turn of their mean.
fn is_one_way(one: &[Vec3A], other: &[Vec3A]) -> bool {
    let mean = (one.iter().sum::<Vec3A>() + other.iter().sum::<Vec3A>()).normalize_or_zero();
    let mut all = one.iter().chain(other);
    all.all(|&normal| normal == Vec3A::ZERO || normal.dot(mean) > HALF_SPACE)
}

/// The pairs of leaves, one of them active, whose boxes meet, by a sweep along the longest side of all.
fn pairs(mut posed: Vec<PosedLeaf>, is_active: &[bool]) -> Vec<(u32, u32)> {
    let low = posed.iter().map(|own| own.low).fold(Vec3A::INFINITY, Vec3A::min);
    let high = posed
        .iter()
        .map(|own| own.high)
        .fold(Vec3A::NEG_INFINITY, Vec3A::max);
    let axis = (high - low).max_position();
    posed.sort_unstable_by(|a, b| a.low[axis].total_cmp(&b.low[axis]).then(a.leaf.cmp(&b.leaf)));
    let active: Vec<&PosedLeaf> = posed.iter().filter(|own| is_active[own.leaf as usize]).collect();
    let meets = |one: &PosedLeaf, other: &PosedLeaf| {
        one.low.cmple(other.high).all() && other.low.cmple(one.high).all()
    };
    let pair = |one: &PosedLeaf, other: &PosedLeaf| (one.leaf.min(other.leaf), one.leaf.max(other.leaf));
    let work = posed.par_iter().enumerate().with_min_len(64);
    work.flat_map_iter(|(index, one)| {
        let mut found = vec![];
        if is_active[one.leaf as usize] {
            let after = posed[index..].iter();
            let after = after.take_while(|other| other.low[axis] <= one.high[axis]);
            found.extend(
                after
                    .filter(|other| meets(one, other))
                    .map(|other| pair(one, other)),
            );
        } else {
            let key = (one.low[axis], one.leaf);
            let first = active.partition_point(|other| (other.low[axis], other.leaf) < key);
            let after = active[first..].iter();
            let after = after.take_while(|other| other.low[axis] <= one.high[axis]);
            found.extend(
                after
                    .filter(|other| meets(one, other))
                    .map(|other| pair(one, other)),
            );
        }
        found
    })
    .collect()
}
