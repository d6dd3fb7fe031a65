//! Inverted faces: those whose normal opposes that of the surrounding skin.

use std::sync::OnceLock;

use fixedbitset::FixedBitSet;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::math::outer::outer;
use crate::math::rows::Rows;
use crate::math::superposition::best_rotation;

/// Rings of neighbours around each corner that count as the surrounding skin of a face.
const RINGS: usize = 3;
/// Marks a vertex that is not a corner of the faces.
const NONE: u32 = u32::MAX;

/// The neighbourhood of each vertex: the vertex and its rings.
#[derive(Debug)]
pub(crate) struct Neighbourhoods {
    /// The neighbours of each vertex.
    beside: Rows<u32>,
    /// Found when first needed.
    around: Vec<OnceLock<Box<[u32]>>>,
}

/// Sums over the neighbourhood of one vertex.
struct Moments {
    count: usize,
    rest: DVec3,
    posed: DVec3,
    /// Sum of `rest posedᵀ` over the neighbourhood.
    both: DMat3,
}

impl Neighbourhoods {
    /// The neighbourhoods in a surface. `beside` are the neighbours of each vertex.
    pub fn new(beside: Rows<u32>) -> Self {
        let around = (0..beside.len()).map(|_| OnceLock::new()).collect();
        Self { beside, around }
    }

    /// Whether each of the `faces`, indices of `triangles`, is inverted: its normal opposes its rest normal as
    /// rotated by the rigid fit of the surrounding skin, which is three rings around its three corners (the
    /// criterion of Kabsch, solved by Horn's quaternions). A face without area is not inverted.
    /// `rest` and `posed` give the position of a vertex.
    pub fn inverted(
        &self,
        faces: &[u32],
        triangles: &[[u32; 3]],
        rest: impl Fn(u32) -> DVec3 + Sync,
        posed: impl Fn(u32) -> DVec3 + Sync,
    ) -> Vec<bool> {
        let mut slots = vec![NONE; self.around.len()];
        let mut corners = vec![];
        for corner in faces.iter().flat_map(|&face| triangles[face as usize]) {
            let slot = &mut slots[corner as usize];
            if *slot == NONE {
                *slot = corners.len() as u32;
                corners.push(corner);
            }
        }
        let moments: Vec<Moments> = corners
            .into_par_iter()
            .with_min_len(64)
            .map(|corner| Moments::new(self.around(corner), &rest, &posed))
            .collect();
        let is_inverted = |&face: &u32| {
            let triangle = &triangles[face as usize];
            let there = triangle.map(|corner| &moments[slots[corner as usize] as usize]);
            let rotation = best_rotation(covariance(there));
            (rotation * normal(triangle.map(&rest))).dot(normal(triangle.map(&posed))) < 0.0
        };
        faces.par_iter().with_min_len(64).map(is_inverted).collect()
    }

    /// Adds to `vertices` those whose neighbourhood contains one of them.
    pub fn grow(&self, vertices: &mut FixedBitSet) {
        let mut rim: Vec<u32> = vertices.ones().map(|vertex| vertex as u32).collect();
        for _ in 0..RINGS {
            let beside = rim.iter().flat_map(|&vertex| self.beside.row(vertex as usize));
            rim = beside
                .copied()
                .filter(|&vertex| !vertices.put(vertex as usize))
                .collect();
        }
    }

    /// The vertex and its rings, rising.
    fn around(&self, vertex: u32) -> &[u32] {
        self.around[vertex as usize].get_or_init(|| {
            let mut found = vec![vertex];
            for _ in 0..RINGS {
                let beside = found.iter().flat_map(|&found| self.beside.row(found as usize));
                let beside: Vec<u32> = beside.copied().collect();
                found.extend(beside);
                found.sort_unstable();
                found.dedup();
            }
            found.into()
        })
    }
}

/// The covariance of rest and posed positions around a face, from the moments at its corners. A vertex counts
/// once for each corner whose neighbourhood contains it.
fn covariance(corners: [&Moments; 3]) -> DMat3 {
    let (mut count, mut rest, mut posed, mut both) = (0, DVec3::ZERO, DVec3::ZERO, DMat3::ZERO);
    for there in corners {
        count += there.count;
        rest += there.rest;
        posed += there.posed;
        both += there.both;
    }
    let count = count as f64;
    both * (1.0 / count) - outer(rest / count, posed / count)
}

impl Moments {
    fn new(around: &[u32], rest: impl Fn(u32) -> DVec3, posed: impl Fn(u32) -> DVec3) -> Self {
        let mut sums = Self {
            count: around.len(),
            rest: DVec3::ZERO,
            posed: DVec3::ZERO,
            both: DMat3::ZERO,
        };
        for &neighbour in around {
            let (then, now) = (rest(neighbour), posed(neighbour));
            sums.rest += then;
            sums.posed += now;
            sums.both += outer(then, now);
        }
        sums
    }
}

/// The unit normal of a triangle; 0 if it has no area.
pub(crate) fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}
