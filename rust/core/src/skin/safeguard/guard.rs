//! Bind data of the safeguard: the skin that belongs to each joint.

use std::collections::HashMap;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::relaxation::elastic::ElasticJoint;
use crate::skin::safeguard::faults::RestFace;
use crate::skin::safeguard::posed_positions::PosedPositions;
use crate::skin::safeguard::triangle_clusters::{Crossing, TriangleClusters};

/// Length of an edge, over the size of the mesh, up to which its stretch is ignored.
const SHORTEST_OF_SIZE: f64 = 1e-4;

/// How fully a joint's relaxation shows at a vertex, 0 to 1, from which the vertex returns fully with the
/// joint. Below it the return fades, so that the skin stays continuous at the rim.
const RETURNS_FROM: f32 = 0.1;

/// The bind data of the safeguard.
#[derive(Debug)]
pub(crate) struct Guard {
    pub joints: Vec<GuardedJoint>,
    pub faces: Vec<RestFace>,
    pub clusters: TriangleClusters,
    /// The faces at each vertex.
    faces_at: Vec<Vec<u32>>,
    /// The joints that own each face, rising.
    pub joints_of: Vec<Vec<u32>>,
    /// Pairs of faces that intersect at rest, rising.
    crossing_at_rest: Vec<(u32, u32)>,
    /// Mean length of an edge of each face at rest, m.
    edge_m: Vec<f32>,
}

/// The skin that a joint owns.
#[derive(Debug)]
pub(crate) struct GuardedJoint {
    /// The faces with a vertex in `shown`.
    pub faces: Vec<u32>,
    /// The vertices at which its relaxation shows, and how fully each returns with it, 0 to 1.
    pub shown: Vec<(u32, f32)>,
}

impl Guard {
    /// The guard of a mesh with `points`, armature space, m. Consecutive `triangles` are near each other.
    pub fn new(joints: &[ElasticJoint], points: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let position_of = |vertex: u32| points[vertex as usize].as_vec3a();
        let shown_of = |joint: &ElasticJoint| -> Vec<(u32, f32)> {
            let shown = joint.patch.iter().filter(|entry| entry.shown > 0.0);
            shown
                .map(|entry| (entry.vertex, (entry.shown / RETURNS_FROM).min(1.0)))
                .collect()
        };
        let mut joints_at: Vec<Vec<u32>> = vec![vec![]; points.len()];
        for (index, joint) in joints.iter().enumerate() {
            for (vertex, _) in shown_of(joint) {
                joints_at[vertex as usize].push(index as u32);
            }
        }
        let (mut joints_of, mut faces_of) = (Vec::with_capacity(triangles.len()), vec![vec![]; joints.len()]);
        for (face, triangle) in triangles.iter().enumerate() {
            let mut owners: Vec<u32> = triangle
                .iter()
                .flat_map(|&vertex| &joints_at[vertex as usize])
                .copied()
                .collect();
            owners.sort_unstable();
            owners.dedup();
            for &joint in &owners {
                faces_of[joint as usize].push(face as u32);
            }
            joints_of.push(owners);
        }
        let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let shortest_m = (SHORTEST_OF_SIZE * (high - low).max_element()) as f32;
        let face = |&corners: &[u32; 3]| RestFace::new(corners, corners.map(position_of), shortest_m);
        let edge_m = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(position_of);
            (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0
        };
        let joint = |(joint, faces): (&ElasticJoint, Vec<u32>)| GuardedJoint {
            faces,
            shown: shown_of(joint),
        };
        let joints = joints.iter().zip(faces_of).map(joint).collect();
        let (faces, edge_m) = (
            triangles.iter().map(face).collect(),
            triangles.iter().map(edge_m).collect(),
        );
        let mut faces_at = vec![vec![]; points.len()];
        for (face, triangle) in triangles.iter().enumerate() {
            for &vertex in triangle {
                faces_at[vertex as usize].push(face as u32);
            }
        }
        let clusters = TriangleClusters::new(triangles.to_vec(), points.len());
        let positions: Vec<Vec3A> = (0..points.len() as u32).map(position_of).collect();
        let all = clusters.of(0..clusters.triangles().len() as u32);
        let mut crossing_at_rest: Vec<(u32, u32)> = clusters
            .crossings(&all, &positions)
            .iter()
            .map(|crossing| (crossing.one, crossing.other))
            .collect();
        crossing_at_rest.sort_unstable();
        Self {
            joints,
            faces,
            clusters,
            faces_at,
            joints_of,
            crossing_at_rest,
            edge_m,
        }
    }

    /// Whether two faces intersect at rest.
    fn cross_at_rest(&self, one: u32, other: u32) -> bool {
        self.crossing_at_rest.binary_search(&(one, other)).is_ok()
    }

    /// The faces at a vertex.
    pub fn faces_at(&self, vertex: u32) -> &[u32] {
        &self.faces_at[vertex as usize]
    }

    /// How fully an intersection counts, 0 to 1: 0 if the faces intersect at rest, and 1 from a fraction of
    /// their edge length on.
    pub fn counted(&self, crossing: &Crossing) -> f32 {
        if self.cross_at_rest(crossing.one, crossing.other) {
            return 0.0;
        }
        let edge_m = 0.5 * (self.edge_m[crossing.one as usize] + self.edge_m[crossing.other as usize]);
        (crossing.length_m / (FULLY_CROSSED * edge_m)).min(1.0)
    }

    /// Counts the intersections at each of the `active` joints, and at each bone of the faces in `others` by
    /// their `weights`. `slots` are the indices in `active` by joint.
    pub fn crossed(
        &self,
        active: &[usize],
        slots: &HashMap<u32, usize>,
        others: &Others,
        weights: &BoneWeights,
        positions: &[Vec3A],
    ) -> Crossed {
        let faces = active.iter().flat_map(|&joint| &self.joints[joint].faces);
        let clusters = self.clusters.of(faces.chain(&others.faces).copied());
        let mut sums = Crossed::none(active.len(), others.bones);
        for crossing in self.clusters.crossings(&clusters, positions) {
            let counted = self.counted(&crossing);
            let joints = |face: u32| &self.joints_of[face as usize];
            let (one, other) = (joints(crossing.one), joints(crossing.other));
            let beside = other.iter().filter(|joint| !one.contains(joint));
            for joint in one.iter().chain(beside) {
                if let Some(&slot) = slots.get(joint) {
                    sums.joints[slot] += counted;
                }
            }
            let faces = [crossing.one, crossing.other].into_iter();
            for face in faces.filter(|&face| others.is_other[face as usize]) {
                self.add_to_bones(face, counted, weights, &mut sums.bones);
            }
        }
        sums
    }

    /// Adds `counted` to the bones of a face, by the weights of its corners.
    pub fn add_to_bones(&self, face: u32, counted: f32, weights: &BoneWeights, bones: &mut [f32]) {
        let corners = self.faces[face as usize].corners.into_iter();
        for entry in corners.flat_map(|corner| weights.of(corner as usize)) {
            bones[entry.bone as usize] += counted * entry.weight / 3.0;
        }
    }

    /// The faces that tissues move and no `active` joint owns.
    pub fn others(&self, active: &[usize], bones: usize, positions: &PosedPositions) -> Others {
        let mut is_other = vec![true; self.faces.len()];
        for &face in active.iter().flat_map(|&joint| &self.joints[joint].faces) {
            is_other[face as usize] = false;
        }
        let is_moved = |face: usize| {
            let least_m = MOVED * self.edge_m[face];
            self.faces[face].corners.iter().any(|&vertex| {
                let vertex = vertex as usize;
                positions.relaxed[vertex].distance_squared(positions.modifier[vertex]) > least_m * least_m
            })
        };
        let work = is_other.par_iter_mut().enumerate().with_min_len(1024);
        work.for_each(|(face, is_other)| *is_other = *is_other && is_moved(face));
        Others {
            faces: (0..is_other.len() as u32)
                .filter(|&face| is_other[face as usize])
                .collect(),
            is_other,
            bones,
        }
    }
}

/// The faces that tissues move and no active joint owns.
pub(crate) struct Others {
    pub faces: Vec<u32>,
    is_other: Vec<bool>,
    bones: usize,
}

/// Counts of intersections, per active joint and per bone.
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

/// Displacement of a corner, over the face's edge length, from which the face counts as moved.
const MOVED: f32 = 0.003;
/// Length of the segment in which two faces intersect, over their edge length, from which they count fully.
/// A vertex that only touches a face counts less.
const FULLY_CROSSED: f32 = 0.05;
