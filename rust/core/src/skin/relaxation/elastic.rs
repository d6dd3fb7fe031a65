//! Bind data of the elastic skin: its joints with everything that acts on their skin
//! (mathematics/relaxation.md; mathematics/volume.md; mathematics/contact.md, Crease plane).
//!
//! Every frame starts from the anchors of that frame: blended dual quaternions of the mesh's bone weights,
//! plus the swelling of the muscles. No frame depends on another; only results of equal inputs are kept. A
//! joint in its rest pose costs nothing and changes nothing.

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
use crate::skin::relaxation::volume::Region;
use crate::skin::settings::elasticity::ElasticSettings;
use crate::skin::settings::segments::Segments;

/// Distances from a joint, in its radii, between which the relaxed skin fades to the anchors. The largest is
/// the radius of the patch, so that the border of a patch does not move.
const SHOWN_RADII: std::ops::Range<f64> = 1.1..1.3;
/// Stiffness of an anchor over that of the edges, if all settings are 1. Small, so that the edges decide the
/// shape; above 0, so that the skin follows its bones.
const ANCHOR_STIFFNESS: f64 = 0.1;
/// Fraction of the anchor stiffness that the skin of a closed joint loses, because anchors on the inner side
/// of the joint are inside each other; and the distances from the joint, in its radii, between which the
/// fraction fades to 0.
const YIELDING: f64 = 0.97;
const YIELDING_RADII: std::ops::Range<f64> = 0.75..1.25;
/// Weight of the bending term, over that of the edges. A larger weight opens the inner side of a joint and
/// lengthens edges on its outer side.
const BENDING: f64 = 0.18;

/// A joint with everything that acts on its skin.
#[derive(Debug)]
pub(crate) struct ElasticJoint {
    pub joint: Joint,
    /// Strengths of its volume constraint and of its crease plane, 0 to 1.
    pub volume_strength: f32,
    pub crease_strength: f32,
    pub region: Option<Region>,
    pub crease: Option<Crease>,
    pub patch: Vec<PatchVertex>,
    /// The chunks, of [`RELAXATION_CHUNK`] vertices, that contain a vertex of the patch; rising.
    pub chunks: Vec<u32>,
    /// Vertices just outside the patch that its edges reach. The joint does not move them.
    pub rim: Vec<u32>,
    /// The bones that its result depends on.
    pub bones: FixedBitSet,
    /// The carriers that its result depends on.
    pub carriers: FixedBitSet,
    /// The joints whose patches touch its patch or its rim; rising.
    pub touching: Vec<u32>,
    /// The joints whose regions have vertices in common with its region, and the fraction of its region
    /// that is shared.
    pub shared: Vec<(u32, f32)>,
    /// Regions of one colour have no vertex in common, so their volumes are corrected at the same time.
    pub colour: usize,
}

/// A vertex that a joint may move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PatchVertex {
    pub vertex: u32,
    /// How fully the relaxed skin shows there, 0 to 1, if the joint is fully active.
    pub shown: f32,
    /// Fraction of its anchor stiffness that it loses if the joint is closed, 0 to 1.
    pub yielding: f32,
}

/// The bind data of an elastic skin.
#[derive(Debug)]
pub(crate) struct Elastic {
    pub joints: Vec<ElasticJoint>,
    pub arap: Arap,
}

impl Elastic {
    /// The elastic skin of `mesh`, or `None` if the skin has no joint.
    pub fn new(
        musculature: &Musculature,
        mesh: &ElasticMesh,
        segments: &Segments,
        iterations: usize,
        settings: &ElasticSettings,
    ) -> Option<Self> {
        let areas = areas(mesh.points, mesh.triangles);
        let joint_skins = joint::joints(musculature, mesh.points, mesh.edges, mesh.weights, segments);
        let mut joints: Vec<ElasticJoint> = joint_skins
            .into_par_iter()
            .map(|skin| ElasticJoint::new(&skin, musculature, mesh, &areas, settings))
            .collect();
        if joints.is_empty() {
            return None;
        }
        link_joints(&mut joints, mesh.points.len());
        Some(Self {
            joints,
            arap: Arap {
                edge_weights: EdgeWeights::new(mesh, &settings.edge_stiffness, BENDING),
                anchor_springs: AnchorSprings::new(
                    settings,
                    ANCHOR_STIFFNESS as f32,
                    iterations,
                    mesh.normals,
                ),
                energy: settings.energy,
                iterations,
            },
        })
    }
}

impl ElasticJoint {
    fn new(
        skin: &JointSkin,
        musculature: &Musculature,
        mesh: &ElasticMesh,
        areas: &[f64],
        settings: &ElasticSettings,
    ) -> Self {
        let mut in_patch = FixedBitSet::with_capacity(mesh.points.len());
        skin.patch
            .iter()
            .for_each(|&vertex| in_patch.insert(vertex as usize));
        let mut rim: Vec<u32> = skin
            .patch
            .iter()
            .flat_map(|&vertex| mesh.energy_edges.neighbours(vertex as usize))
            .filter(|&&vertex| !in_patch.contains(vertex as usize))
            .copied()
            .collect();
        rim.sort_unstable();
        rim.dedup();
        let mut bones = FixedBitSet::with_capacity(musculature.skeleton().len());
        bones.extend([skin.joint.child, skin.joint.parent]);
        let mut carriers = FixedBitSet::with_capacity(musculature.carriers().len());
        for &vertex in skin.patch.iter().chain(&rim) {
            bones.extend(
                mesh.weights
                    .of(vertex as usize)
                    .iter()
                    .map(|entry| entry.bone as usize),
            );
            carriers.extend(
                (mesh.carriers_of)(vertex as usize)
                    .into_iter()
                    .map(|carrier| carrier as usize),
            );
        }
        let patch = skin.patch.iter().map(|&vertex| {
            let distance = skin.joint.radii_to(mesh.points[vertex as usize]);
            PatchVertex {
                vertex,
                shown: smooth_step((SHOWN_RADII.end - distance) / (SHOWN_RADII.end - SHOWN_RADII.start))
                    as f32,
                yielding: (YIELDING * (YIELDING_RADII.end - distance)
                    / (YIELDING_RADII.end - YIELDING_RADII.start))
                    .clamp(0.0, YIELDING) as f32,
            }
        });
        Self {
            joint: skin.joint,
            volume_strength: settings.volume[skin.joint.child],
            crease_strength: settings.crease[skin.joint.child],
            region: Region::new(skin, mesh),
            crease: Crease::new(skin, mesh, areas),
            chunks: chunks_of(&skin.patch),
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

/// The chunks, of [`RELAXATION_CHUNK`] vertices, that contain some vertices; rising.
fn chunks_of(vertices: &[u32]) -> Vec<u32> {
    let mut chunks: Vec<u32> = vertices
        .iter()
        .map(|vertex| vertex / RELAXATION_CHUNK as u32)
        .collect();
    chunks.sort_unstable();
    chunks.dedup();
    chunks
}

/// Finds which patches touch, and gives the joints colours by their regions (greedy colouring).
fn link_joints(joints: &mut [ElasticJoint], vertices: usize) {
    let patches: Vec<FixedBitSet> = joints
        .iter()
        .map(|joint| set(joint.patch.iter().map(|entry| entry.vertex), vertices))
        .collect();
    let regions: Vec<Option<FixedBitSet>> = joints
        .iter()
        .map(|joint| {
            let vertices_of = joint.region.as_ref()?.vertices().iter();
            Some(set(vertices_of.map(|&(vertex, _)| vertex), vertices))
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
        let fraction = |other: usize| {
            let other_region = regions[other].as_ref()?;
            let fraction = region.intersection_count(other_region) as f32 / size;
            (other != index && fraction > 0.0).then_some((other as u32, fraction))
        };
        joints[index].shared = (0..joints.len()).filter_map(fraction).collect();
    }
}

fn set(vertices: impl Iterator<Item = u32>, count: usize) -> FixedBitSet {
    let mut set = FixedBitSet::with_capacity(count);
    set.extend(vertices.map(|vertex| vertex as usize));
    set
}
