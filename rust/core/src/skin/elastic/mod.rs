//! The elastic skin: as-rigid-as-possible relaxation around the joints that muscles cross, with regional volume and crease
//! planes (ALGORITHM 5 and 8; O. Sorkine and M. Alexa, "As-Rigid-As-Possible Surface Modeling", 2007).
//!
//! Every frame starts from that frame's anchors: dual quaternions of the mesh's own weights, with the swelling of the muscles.
//! Nothing is kept from one frame to the next. A joint that stands as at rest costs nothing and changes nothing.

mod crease;
mod joints;
mod region;
mod relax;

use glam::DVec3;

pub use self::joints::Segments;

use self::crease::Crease;
use self::joints::{Joint, JointSkin, joints};
use self::region::Region;
use self::relax::Springs;
use super::mesh::Adjacency;
use super::weights::BoneWeights;
use crate::musculature::Musculature;

pub(super) use self::relax::Relaxation;

/// Radii from a joint between which its skin passes from relaxed to its own anchors.
const BLENDS: std::ops::Range<f64> = 1.5..2.0;
/// How firmly a vertex holds on to its anchor, an iteration.
const ANCHORING: f64 = 0.1;
/// Share of that which a joint's crook gives up, fully within half its radius.
const YIELDING: f64 = 0.97;

/// A joint with all that acts on its skin.
#[derive(Debug)]
pub(super) struct ElasticJoint {
    joint: Joint,
    region: Option<Region>,
    crease: Option<Crease>,
    /// Places in the patch, and how fully the joint's relaxation shows there, 0..1.
    shown: Vec<(u32, f32)>,
}

/// What an elastic skin was bound from.
#[derive(Debug)]
pub(super) struct Elastic {
    /// Vertices that any joint may move, rising; the other lists go by places in it.
    vertices: Vec<u32>,
    /// The place of each of the mesh's vertices in `vertices`, `u32::MAX` for none.
    places: Vec<u32>,
    joints: Vec<ElasticJoint>,
    springs: Springs,
    iterations: usize,
}

/// The mesh as the elastic skin needs it.
pub(super) struct ElasticMesh<'a> {
    pub points: &'a [DVec3],
    pub edges: &'a Adjacency,
    /// Edges and the diagonals of faces.
    pub struts: &'a Adjacency,
    pub triangles: &'a [[u32; 3]],
    pub weights: &'a BoneWeights,
}

impl Elastic {
    /// The elastic skin of `mesh`, or `None` where no muscle crosses a joint that the skin shows.
    pub fn new(
        musculature: &Musculature,
        mesh: &ElasticMesh,
        segments: &Segments,
        iterations: usize,
    ) -> Option<Self> {
        let found = joints(musculature, mesh.points, mesh.edges, mesh.weights, segments);
        let mut vertices: Vec<u32> = found
            .iter()
            .flat_map(|found| found.patch.iter().copied())
            .collect();
        vertices.sort_unstable();
        vertices.dedup();
        if vertices.is_empty() {
            return None;
        }
        let mut places = vec![u32::MAX; mesh.points.len()];
        for (place, &vertex) in vertices.iter().enumerate() {
            places[vertex as usize] = place as u32;
        }
        let areas = areas(mesh.points, mesh.triangles);
        let mut anchoring = vec![ANCHORING as f32; vertices.len()];
        let joints = found
            .iter()
            .map(|found| {
                soften(&mut anchoring, found, mesh.points, &places);
                ElasticJoint {
                    joint: found.joint,
                    region: Region::new(found, mesh, &places),
                    crease: Crease::new(found, mesh.points, &areas, &places),
                    shown: shown(found, mesh.points, &places),
                }
            })
            .collect();
        Some(Self {
            springs: Springs::new(mesh.points, mesh.struts, &vertices, &places, anchoring),
            vertices,
            places,
            joints,
            iterations,
        })
    }

    /// Vertices that may be relaxed, rising.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The place of a vertex among them.
    pub fn place_of(&self, vertex: usize) -> Option<usize> {
        let place = self.places[vertex];
        (place != u32::MAX).then_some(place as usize)
    }
}

/// Lets the anchors of a joint's crook yield.
fn soften(anchoring: &mut [f32], found: &JointSkin, points: &[DVec3], places: &[u32]) {
    for &vertex in &found.patch {
        let distance = found.joint.radii_to(points[vertex as usize]);
        let yielding = YIELDING * (1.0 - (distance - 0.5) / 0.5).clamp(0.0, 1.0);
        let own = &mut anchoring[places[vertex as usize] as usize];
        *own = own.min((ANCHORING * (1.0 - yielding)) as f32);
    }
}

fn shown(found: &JointSkin, points: &[DVec3], places: &[u32]) -> Vec<(u32, f32)> {
    let shown_at = |&vertex: &u32| {
        let distance = found.joint.radii_to(points[vertex as usize]);
        let t = ((BLENDS.end - distance) / (BLENDS.end - BLENDS.start)).clamp(0.0, 1.0);
        (places[vertex as usize], (t * t * (3.0 - 2.0 * t)) as f32)
    };
    found.patch.iter().map(shown_at).collect()
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
