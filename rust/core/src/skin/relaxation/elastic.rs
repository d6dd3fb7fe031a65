//! The elastic skin: relaxation around every joint that the muscles or the weights show, with regional volume and crease
//! planes (ALGORITHM 5 and 8).
//!
//! Every frame starts from that frame's anchors: dual quaternions of the mesh's own weights, with the swelling of the muscles.
//! Nothing of a frame depends on another: what has been computed for the same inputs is kept, nothing else. A joint that
//! stands as at rest costs nothing and changes nothing.

use fixedbitset::FixedBitSet;
use rayon::prelude::*;

use crate::math::smoothstep::smooth_step;
use crate::muscles::musculature::Musculature;
use crate::parallel::RELAXATION_CHUNK;
use crate::skin::mesh::normals::areas;
use crate::skin::relaxation::anchor_springs::AnchorSprings;
use crate::skin::relaxation::arap::Arap;
use crate::skin::relaxation::crease_plane::Crease;
use crate::skin::relaxation::edges::EdgeWeights;
use crate::skin::relaxation::elastic_mesh::ElasticMesh;
use crate::skin::relaxation::joint;
use crate::skin::relaxation::joint::{Joint, JointSkin};
use crate::skin::relaxation::tissue_collision::Obstacles;
use crate::skin::relaxation::volume::Region;
use crate::skin::settings::elasticity::ElasticSettings;
use crate::skin::settings::segments::Segments;

/// Radii from a joint between which its skin passes from relaxed to its own anchors.
const SHOWN_RADII: std::ops::Range<f64> = 1.1..1.3;
/// How firmly a vertex holds on to its anchor, a round.
const ANCHOR_STIFFNESS: f64 = 0.1;
/// Share of that which the crook of a closed joint gives up, and the radii from the joint between which it passes to none.
const YIELDING: f64 = 0.97;
const YIELDING_RADII: std::ops::Range<f64> = 0.75..1.25;
/// How strongly the turns of neighbours are held together: more opens a crook and lengthens edges at its back.
const BENDING: f64 = 0.18;

/// A joint with all that acts on its skin.
#[derive(Debug)]
pub(crate) struct ElasticJoint {
    pub joint: Joint,
    /// How fully its volume is kept, and its plane acts, 0..1.
    pub volume_strength: f32,
    pub crease_strength: f32,
    pub region: Option<Region>,
    pub crease: Option<Crease>,
    pub patch: Vec<PatchVertex>,
    /// The chunks of vertices, of [`RELAXATION_CHUNK`], that have any of it; rising.
    pub chunks: Vec<u32>,
    /// Vertices beside the patch, which its springs pull at.
    pub rim: Vec<u32>,
    /// Bones that its frame depends on.
    pub bones: FixedBitSet,
    /// Carriers that its frame depends on.
    pub carriers: FixedBitSet,
    /// Joints whose patches touch its own, rising.
    pub touching: Vec<u32>,
    /// Joints whose regions have vertices in common with its own, and the share of its own that these are.
    pub shared: Vec<(u32, f32)>,
    /// Joints of one colour keep their volumes at the same time: their regions have no vertex in common.
    pub colour: usize,
}

/// A vertex that a joint may move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PatchVertex {
    pub vertex: u32,
    /// How fully the joint's relaxation shows there, 0..1.
    pub shown: f32,
    /// Share of its anchoring that it gives up when the joint is closed.
    pub yielding: f32,
}

/// What an elastic skin was bound from.
#[derive(Debug)]
pub(crate) struct Elastic {
    pub joints: Vec<ElasticJoint>,
    pub obstacles: Option<Obstacles>,
    pub arap: Arap,
}

impl Elastic {
    /// The elastic skin of `mesh`, or `None` where it shows no joint.
    pub fn new(
        musculature: &Musculature,
        mesh: &ElasticMesh,
        segments: &Segments,
        iterations: usize,
        settings: &ElasticSettings,
    ) -> Option<Self> {
        let areas = areas(mesh.points, mesh.triangles);
        let found = joint::joints(musculature, mesh.points, mesh.edges, mesh.weights, segments);
        let mut joints: Vec<ElasticJoint> = found
            .into_par_iter()
            .map(|found| ElasticJoint::new(&found, musculature, mesh, &areas, settings))
            .collect();
        if joints.is_empty() {
            return None;
        }
        link_joints(&mut joints, mesh.points.len());
        Some(Self {
            joints,
            obstacles: settings
                .collides
                .then(|| Obstacles::new(musculature, mesh.points, mesh.carriers_of)),
            arap: Arap {
                edge_weights: EdgeWeights::new(mesh, &settings.edge_stiffness, BENDING),
                anchor_springs: AnchorSprings::new(settings, ANCHOR_STIFFNESS as f32, iterations, mesh.normals.to_vec()),
                energy: settings.energy,
                iterations,
            },
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
            .flat_map(|&vertex| mesh.energy_edges.neighbours(vertex as usize))
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
                shown: smooth_step((SHOWN_RADII.end - distance) / (SHOWN_RADII.end - SHOWN_RADII.start)) as f32,
                yielding: (YIELDING * (YIELDING_RADII.end - distance) / (YIELDING_RADII.end - YIELDING_RADII.start))
                    .clamp(0.0, YIELDING) as f32,
            }
        });
        Self {
            joint: found.joint,
            volume_strength: settings.volume[found.joint.child],
            crease_strength: settings.crease[found.joint.child],
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

/// The chunks, of [`RELAXATION_CHUNK`], that vertices lie in.
fn chunks_of(vertices: &[u32]) -> Vec<u32> {
    let mut chunks: Vec<u32> = vertices
        .iter()
        .map(|vertex| vertex / RELAXATION_CHUNK as u32)
        .collect();
    chunks.sort_unstable();
    chunks.dedup();
    chunks
}

/// Finds which patches touch, and colours the joints by their regions.
fn link_joints(joints: &mut [ElasticJoint], vertices: usize) {
    let patches: Vec<FixedBitSet> = joints
        .iter()
        .map(|joint| set(joint.patch.iter().map(|own| own.vertex), vertices))
        .collect();
    let regions: Vec<Option<FixedBitSet>> = joints
        .iter()
        .map(|joint| {
            let own = joint.region.as_ref()?.vertices().iter();
            Some(set(own.map(|&(vertex, _)| vertex), vertices))
        })
        .collect();
    for index in 0..joints.len() {
        let reached = set(joints[index].rim.iter().copied(), vertices);
        for other in 0..index {
            let is_touching =
                !patches[index].is_disjoint(&patches[other]) || !reached.is_disjoint(&patches[other]);
            if is_touching {
                joints[index].touching.push(other as u32);
                joints[other].touching.push(index as u32);
            }
        }
        let Some(region) = &regions[index] else {
            continue;
        };
        let is_taken = |colour: usize| {
            (0..index).any(|other| {
                let overlaps = |other: &FixedBitSet| !region.is_disjoint(other);
                joints[other].colour == colour && regions[other].as_ref().is_some_and(overlaps)
            })
        };
        joints[index].colour = (0..).find(|&colour| !is_taken(colour)).unwrap_or(0);
    }
    for index in 0..joints.len() {
        let Some(region) = &regions[index] else {
            continue;
        };
        let size = region.count_ones(..) as f32;
        let share = |other: usize| {
            let found = regions[other].as_ref()?;
            let share = region.intersection_count(found) as f32 / size;
            (other != index && share > 0.0).then_some((other as u32, share))
        };
        joints[index].shared = (0..joints.len()).filter_map(share).collect();
    }
}

fn set(vertices: impl Iterator<Item = u32>, count: usize) -> FixedBitSet {
    let mut found = FixedBitSet::with_capacity(count);
    found.extend(vertices.map(|vertex| vertex as usize));
    found
}
