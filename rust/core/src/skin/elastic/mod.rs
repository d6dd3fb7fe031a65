//! The elastic skin: relaxation around every joint that the muscles or the weights show, with regional volume and crease
//! planes (ALGORITHM 5 and 8).
//!
//! Every frame starts from that frame's anchors: dual quaternions of the mesh's own weights, with the swelling of the muscles.
//! Nothing of a frame depends on another: what has been computed for the same inputs is kept, nothing else. A joint that
//! stands as at rest costs nothing and changes nothing.

mod collide;
mod crease;
mod frame;
mod hold;
mod islands;
mod joints;
mod region;
mod relax;
mod springs;
mod turn;

use fixedbitset::FixedBitSet;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;

pub use self::joints::Segments;

use self::collide::Obstacles;
use self::crease::Crease;
use self::hold::Hold;
use self::joints::{Joint, JointSkin};
use self::region::Region;
use self::relax::CHUNK;
use self::springs::Springs;
use super::elasticity::{ElasticSettings, Energy};
use super::mesh::Adjacency;
use super::weights::BoneWeights;
use crate::musculature::Musculature;
use crate::smooth::smooth_step;

pub(super) use self::frame::Relaxation;
pub(super) use self::relax::Anchor;

/// Radii from a joint between which its skin passes from relaxed to its own anchors.
const BLENDS: std::ops::Range<f64> = 1.1..1.3;
/// How firmly a vertex holds on to its anchor, a round.
const ANCHORING: f64 = 0.1;
/// Share of that which the crook of a closed joint gives up, and the radii from the joint between which it passes to none.
const YIELDING: f64 = 0.97;
const YIELDS: std::ops::Range<f64> = 0.75..1.25;
/// How strongly the turns of neighbours are held together: more opens a crook and lengthens edges at its back.
const BENDING: f64 = 0.18;

/// A joint with all that acts on its skin.
#[derive(Debug)]
pub(super) struct ElasticJoint {
    joint: Joint,
    /// How fully its volume is kept, and its plane acts, 0..1.
    volume_keeping: f32,
    creasing: f32,
    region: Option<Region>,
    crease: Option<Crease>,
    patch: Vec<PatchVertex>,
    /// The chunks of vertices, of [`CHUNK`], that have any of it; rising.
    chunks: Vec<u32>,
    /// Vertices beside the patch, which its springs pull at.
    rim: Vec<u32>,
    /// Bones that its frame depends on.
    bones: FixedBitSet,
    /// Carriers that its frame depends on.
    carriers: FixedBitSet,
    /// Joints whose patches touch its own, rising.
    touching: Vec<u32>,
    /// Joints whose regions have vertices in common with its own, and the share of its own that these are.
    shared: Vec<(u32, f32)>,
    /// Joints of one colour keep their volumes at the same time: their regions have no vertex in common.
    colour: usize,
}

/// A vertex that a joint may move.
#[derive(Debug, Clone, Copy)]
pub(super) struct PatchVertex {
    vertex: u32,
    /// How fully the joint's relaxation shows there, 0..1.
    shown: f32,
    /// Share of its anchoring that it gives up when the joint is closed.
    yielding: f32,
}

/// What an elastic skin was bound from.
#[derive(Debug)]
pub(super) struct Elastic {
    joints: Vec<ElasticJoint>,
    springs: Springs,
    obstacles: Option<Obstacles>,
    hold: Hold,
    energy: Energy,
    rounds: usize,
}

/// The mesh as the elastic skin needs it.
pub(super) struct ElasticMesh<'a> {
    pub points: &'a [DVec3],
    pub edges: &'a Adjacency,
    /// What springs lie along.
    pub springs: &'a Adjacency,
    pub triangles: &'a [[u32; 3]],
    /// Unit normals, 0 where a vertex has no face.
    pub normals: &'a [Vec3A],
    pub weights: &'a BoneWeights,
    /// The carriers that move each vertex.
    pub carriers_of: &'a (dyn Fn(usize) -> Vec<u32> + Sync),
}

impl Elastic {
    /// The elastic skin of `mesh`, or `None` where it shows no joint.
    pub fn new(
        musculature: &Musculature,
        mesh: &ElasticMesh,
        segments: &Segments,
        rounds: usize,
        settings: &ElasticSettings,
    ) -> Option<Self> {
        let areas = areas(mesh.points, mesh.triangles);
        let found = joints::joints(musculature, mesh.points, mesh.edges, mesh.weights, segments);
        let mut joints: Vec<ElasticJoint> = found
            .into_par_iter()
            .map(|found| ElasticJoint::new(&found, musculature, mesh, &areas, settings))
            .collect();
        if joints.is_empty() {
            return None;
        }
        islands::link(&mut joints, mesh.points.len());
        Some(Self {
            joints,
            obstacles: settings
                .collides
                .then(|| Obstacles::new(musculature, mesh.points, mesh.carriers_of)),
            springs: Springs::new(mesh, &settings.edge_stiffness, BENDING),
            hold: Hold::new(settings, ANCHORING as f32, rounds, mesh.normals.to_vec()),
            energy: settings.energy,
            rounds,
        })
    }
}

impl ElasticJoint {
    fn new(
        found: &JointSkin,
        musculature: &Musculature,
        mesh: &ElasticMesh,
        areas: &[f64],
        settings: &ElasticSettings,
    ) -> Self {
        let mut in_patch = FixedBitSet::with_capacity(mesh.points.len());
        found
            .patch
            .iter()
            .for_each(|&vertex| in_patch.insert(vertex as usize));
        let mut rim: Vec<u32> = found
            .patch
            .iter()
            .flat_map(|&vertex| mesh.springs.neighbours(vertex as usize))
            .filter(|&&vertex| !in_patch.contains(vertex as usize))
            .copied()
            .collect();
        rim.sort_unstable();
        rim.dedup();
        let mut bones = FixedBitSet::with_capacity(musculature.skeleton().len());
        bones.extend([found.joint.child, found.joint.parent]);
        let mut carriers = FixedBitSet::with_capacity(musculature.carriers().len());
        for &vertex in found.patch.iter().chain(&rim) {
            bones.extend(
                mesh.weights
                    .of(vertex as usize)
                    .iter()
                    .map(|own| own.bone as usize),
            );
            carriers.extend(
                (mesh.carriers_of)(vertex as usize)
                    .into_iter()
                    .map(|carrier| carrier as usize),
            );
        }
        let patch = found.patch.iter().map(|&vertex| {
            let distance = found.joint.radii_to(mesh.points[vertex as usize]);
            PatchVertex {
                vertex,
                shown: smooth_step((BLENDS.end - distance) / (BLENDS.end - BLENDS.start)) as f32,
                yielding: (YIELDING * (YIELDS.end - distance) / (YIELDS.end - YIELDS.start))
                    .clamp(0.0, YIELDING) as f32,
            }
        });
        Self {
            joint: found.joint,
            volume_keeping: settings.volume[found.joint.child],
            creasing: settings.crease[found.joint.child],
            region: Region::new(found, mesh),
            crease: Crease::new(found, mesh, areas),
            chunks: chunks_of(&found.patch),
            patch: patch.collect(),
            rim,
            bones,
            carriers,
            touching: vec![],
            shared: vec![],
            colour: 0,
        }
    }
}

/// The chunks, of [`CHUNK`], that vertices lie in.
fn chunks_of(vertices: &[u32]) -> Vec<u32> {
    let mut chunks: Vec<u32> = vertices.iter().map(|vertex| vertex / CHUNK as u32).collect();
    chunks.sort_unstable();
    chunks.dedup();
    chunks
}

/// A third of the area of its triangles, for each vertex.
fn areas(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
    let mut areas = vec![0.0; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        triangle
            .iter()
            .for_each(|&vertex| areas[vertex as usize] += third);
    }
    areas
}

/// The unit normal of each vertex, 0 where it has no face.
pub(super) fn normals(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Vec3A> {
    let mut normals = vec![DVec3::ZERO; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| points[vertex as usize]);
        let normal = (b - a).cross(c - a);
        triangle
            .iter()
            .for_each(|&vertex| normals[vertex as usize] += normal);
    }
    normals
        .into_iter()
        .map(|normal| normal.normalize_or_zero().as_vec3a())
        .collect()
}
