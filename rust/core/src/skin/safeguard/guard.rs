//! The skin that each joint answers for, as it is at rest.

use std::collections::HashMap;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::relaxation::elastic::ElasticJoint;
use crate::skin::safeguard::faults::RestFace;
use crate::skin::safeguard::leaves::{Crossing, Leaves};
use crate::skin::safeguard::places::PosedPlaces;

/// Length of an edge over the size of the mesh up to which it has no length that could be stretched.
const SHORTEST_OF_SIZE: f64 = 1e-4;

/// How fully a joint's relaxation shows at a vertex that returns with it fully; less, and it fades, so that nothing tears at the rim.
const RETURNS_FROM: f32 = 0.1;

/// The faces of all joints.
#[derive(Debug)]
pub(crate) struct Guard {
    /// False where the skin is left as it comes.
    pub is_on: bool,
    pub joints: Vec<GuardedJoint>,
    pub faces: Vec<RestFace>,
    pub leaves: Leaves,
    /// The faces at each vertex.
    faces_at: Vec<Vec<u32>>,
    /// The joints that each face is of.
    pub joints_of: Vec<Vec<u32>>,
    /// Pairs of faces that cross at rest, rising.
    crossing_at_rest: Vec<(u32, u32)>,
    /// Mean length of an edge of each face at rest, m.
    edge_m: Vec<f32>,
}

/// What a joint answers for.
#[derive(Debug)]
pub(crate) struct GuardedJoint {
    /// The faces at them.
    pub faces: Vec<u32>,
    /// The vertices that its relaxation shows at, and how fully each returns with it.
    pub shown: Vec<(u32, f32)>,
}

impl Guard {
    /// The guard of a mesh whose `triangles` come cluster by cluster; where it is not on, it knows no more than faces.
    pub fn new(is_on: bool, joints: &[ElasticJoint], points: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let place = |vertex: u32| points[vertex as usize].as_vec3a();
        let shown_of = |joint: &ElasticJoint| -> Vec<(u32, f32)> {
            let shown = joint.patch.iter().filter(|own| own.shown > 0.0);
            shown
                .map(|own| (own.vertex, (own.shown / RETURNS_FROM).min(1.0)))
                .collect()
        };
        let mut joints_at: Vec<Vec<u32>> = vec![vec![]; points.len()];
        for (index, joint) in joints.iter().enumerate() {
            for (vertex, _) in shown_of(joint) {
                joints_at[vertex as usize].push(index as u32);
            }
        }
        let (mut guarded, mut joints_of, mut faces_of) = (vec![], vec![], vec![vec![]; joints.len()]);
        for &triangle in triangles {
            let mut own: Vec<u32> = triangle
                .iter()
                .flat_map(|&vertex| &joints_at[vertex as usize])
                .copied()
                .collect();
            own.sort_unstable();
            own.dedup();
            for &joint in &own {
                faces_of[joint as usize].push(guarded.len() as u32);
            }
            guarded.push(triangle);
            joints_of.push(own);
        }
        let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let shortest_m = (SHORTEST_OF_SIZE * (high - low).max_element()) as f32;
        let face = |&corners: &[u32; 3]| RestFace::new(corners, corners.map(place), shortest_m);
        let edge_m = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(place);
            (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0
        };
        let joint = |(joint, faces): (&ElasticJoint, Vec<u32>)| GuardedJoint {
            faces,
            shown: shown_of(joint),
        };
        let found = joints.iter().zip(faces_of).map(joint).collect();
        let (faces, edge_m) = (
            guarded.iter().map(face).collect(),
            guarded.iter().map(edge_m).collect(),
        );
        let mut faces_at = vec![vec![]; points.len()];
        for (face, triangle) in guarded.iter().enumerate() {
            for &vertex in triangle {
                faces_at[vertex as usize].push(face as u32);
            }
        }
        let leaves = Leaves::new(guarded, points.len());
        let places: Vec<Vec3A> = (0..points.len() as u32).map(place).collect();
        let all = leaves.of(0..leaves.triangles().len() as u32);
        let mut crossing_at_rest: Vec<(u32, u32)> = leaves
            .crossings(&all, &places)
            .iter()
            .map(|crossing| (crossing.one, crossing.other))
            .collect();
        crossing_at_rest.sort_unstable();
        Self {
            is_on,
            joints: found,
            faces,
            leaves,
            faces_at,
            joints_of,
            crossing_at_rest,
            edge_m,
        }
    }

    /// Whether two faces cross at rest.
    fn cross_at_rest(&self, one: u32, other: u32) -> bool {
        self.crossing_at_rest.binary_search(&(one, other)).is_ok()
    }

    /// The faces at a vertex.
    pub fn faces_at(&self, vertex: u32) -> &[u32] {
        &self.faces_at[vertex as usize]
    }

    /// How fully a crossing counts, 0..1: not at all where the faces cross at rest, and fully from a share of their edges on.
    pub fn counted(&self, crossing: &Crossing) -> f32 {
        if self.cross_at_rest(crossing.one, crossing.other) {
            return 0.0;
        }
        let edge_m = 0.5 * (self.edge_m[crossing.one as usize] + self.edge_m[crossing.other as usize]);
        (crossing.length_m / (FULLY_CROSSED * edge_m)).min(1.0)
    }

    /// How much crosses at each of the `active` joints, of which `slots` tells the places, and at each bone of the faces in `others`, by
    /// their `weights`.
    pub fn crossed(
        &self,
        active: &[usize],
        slots: &HashMap<u32, usize>,
        others: &Others,
        weights: &BoneWeights,
        places: &[Vec3A],
    ) -> Crossed {
        let faces = active.iter().flat_map(|&joint| &self.joints[joint].faces);
        let leaves = self.leaves.of(faces.chain(&others.faces).copied());
        let mut sums = Crossed::none(active.len(), others.bones);
        for crossing in self.leaves.crossings(&leaves, places) {
            let counted = self.counted(&crossing);
            let joints = |face: u32| &self.joints_of[face as usize];
            let (one, other) = (joints(crossing.one), joints(crossing.other));
            let beside = other.iter().filter(|joint| !one.contains(joint));
            for joint in one.iter().chain(beside) {
                if let Some(&slot) = slots.get(joint) {
                    sums.joints[slot] += counted;
                }
            }
            let own = [crossing.one, crossing.other].into_iter();
            for face in own.filter(|&face| others.is_one[face as usize]) {
                self.add_to_bones(face, counted, weights, &mut sums.bones);
            }
        }
        sums
    }

    /// Adds `counted` to the bones of a face, by the weights of its corners.
    pub fn add_to_bones(&self, face: u32, counted: f32, weights: &BoneWeights, bones: &mut [f32]) {
        let corners = self.faces[face as usize].corners.into_iter();
        for own in corners.flat_map(|corner| weights.of(corner as usize)) {
            bones[own.bone as usize] += counted * own.weight / 3.0;
        }
    }

    /// The faces that no `active` joint answers for and that tissues move.
    pub fn others(&self, active: &[usize], bones: usize, places: &PosedPlaces) -> Others {
        let mut is_one = vec![true; self.faces.len()];
        for &face in active.iter().flat_map(|&joint| &self.joints[joint].faces) {
            is_one[face as usize] = false;
        }
        let is_moved = |face: usize| {
            let least_m = MOVED * self.edge_m[face];
            self.faces[face].corners.iter().any(|&vertex| {
                let vertex = vertex as usize;
                places.relaxed[vertex].distance_squared(places.modifier[vertex]) > least_m * least_m
            })
        };
        let work = is_one.par_iter_mut().enumerate().with_min_len(1024);
        work.for_each(|(face, is_one)| *is_one = *is_one && is_moved(face));
        Others {
            faces: (0..is_one.len() as u32)
                .filter(|&face| is_one[face as usize])
                .collect(),
            is_one,
            bones,
        }
    }
}

/// Faces that tissues move and no joint answers for.
pub(crate) struct Others {
    pub faces: Vec<u32>,
    is_one: Vec<bool>,
    bones: usize,
}

/// How much crosses, at joints and at bones.
pub(crate) struct Crossed {
    pub joints: Vec<f32>,
    pub bones: Vec<f32>,
}

impl Crossed {
    pub fn none(joints: usize, bones: usize) -> Self {
        Self {
            joints: vec![0.0; joints],
            bones: vec![0.0; bones],
        }
    }
}

/// Way over its edges that a corner must be moved for a face to count as moved.
const MOVED: f32 = 0.003;
/// Length of the segment in which two faces cross, over their edges, from which they count fully: a vertex that only touches does not.
const FULLY_CROSSED: f32 = 0.05;
