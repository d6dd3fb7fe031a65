//! Settings of an elastic skin: the mesh's faces, the body's segments, and stiffness and strength by
//! region.

use crate::error::Result;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::regional::{Regional, strengths};
use crate::skin::mesh::vertex_order::VertexOrder;
use crate::skin::settings::segments::Segments;

/// The energy that relaxation minimises (mathematics/relaxation.md, Energy).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Energy {
    /// As-rigid-as-possible (Sorkine and Alexa 2007): the neighbourhood of each vertex keeps its shape
    /// except for a rotation.
    #[default]
    AsRigidAsPossible,
    /// Length springs (Wilhelms 1997): each edge keeps its length.
    Springs,
}

/// Settings of the skin around the joints that bend. N is the number of vertices, B of bones.
#[derive(Debug, Clone, Copy)]
pub struct Elasticity<'a> {
    /// Pairs of vertices: the mesh's edges and the diagonals of its faces. [`Energy::Springs`] acts along
    /// them.
    pub spring_edges: &'a [[i32; 2]],
    /// The mesh's faces as triangles.
    pub triangles: &'a [[i32; 3]],
    /// The segments of the body and the lengths of bones.
    pub segments: Segments<'a>,
    /// Iterations of the relaxation per frame.
    pub iterations: usize,
    /// The energy that relaxation minimises.
    pub energy: Energy,
    /// Factor of the stiffness of anchors.
    pub anchor_stiffness: Regional<'a>,
    /// Factor of the stiffness of edges.
    pub edge_stiffness: Regional<'a>,
    /// Slack: distance from the anchor below which a vertex is not pulled back, m.
    pub slack_m: Regional<'a>,
    /// Fraction of the iterations that a vertex takes part in; above 1 counts as 1.
    pub relaxation: Regional<'a>,
    /// How freely the skin slides along itself over what is below it: 0 not at all; above 1 counts as 1.
    pub fat_sliding: Regional<'a>,
    /// (B) strength of the volume constraint of the joint at each bone's head, 0 to 1; `None` is 1
    /// everywhere.
    pub volume: Option<&'a [f32]>,
    /// (B) strength of the crease plane of the joint at each bone's head, 0 to 1; `None` is 1 everywhere.
    pub crease: Option<&'a [f32]>,
    /// (B) strength of skin contact for the skin of each bone, 0 to 1; `None` is 1 everywhere.
    pub contact: Option<&'a [f32]>,
    /// Whether skin pushes skin (skin contact).
    pub contacts: bool,
    /// Whether a joint whose skin is worse than the Armature modifier's returns to the modifier's skin.
    /// [`Energy::Springs`] ignores it.
    pub safeguards: bool,
}

impl<'a> Elasticity<'a> {
    /// Settings that are equal everywhere: factors 1, no slack, no sliding, all constraints on.
    pub const fn new(
        spring_edges: &'a [[i32; 2]],
        triangles: &'a [[i32; 3]],
        segments: Segments<'a>,
        iterations: usize,
    ) -> Self {
        Self {
            spring_edges,
            triangles,
            segments,
            iterations,
            energy: Energy::AsRigidAsPossible,
            anchor_stiffness: Regional::of_body(1.0),
            edge_stiffness: Regional::of_body(1.0),
            slack_m: Regional::of_body(0.0),
            relaxation: Regional::of_body(1.0),
            fat_sliding: Regional::of_body(0.0),
            volume: None,
            crease: None,
            contact: None,
            contacts: true,
            safeguards: true,
        }
    }

    /// The settings at each vertex, by sorted index as `weights`, and at each of `bones` bones.
    ///
    /// # Errors
    /// A setting outside its limits, or a list whose length is not the number of bones or vertices.
    pub(crate) fn settings(
        &self,
        weights: &BoneWeights,
        bones: usize,
        order: &VertexOrder,
    ) -> Result<ElasticSettings> {
        let resolved = |setting, regional: &Regional| regional.resolve(setting, weights, bones, order);
        let capped = |setting, regional: &Regional| {
            resolved(setting, regional).map(|values| values.into_iter().map(|value| value.min(1.0)).collect())
        };
        Ok(ElasticSettings {
            energy: self.energy,
            anchor_stiffness: resolved("anchor_stiffness", &self.anchor_stiffness)?,
            edge_stiffness: resolved("edge_stiffness", &self.edge_stiffness)?,
            slack_m: resolved("slack", &self.slack_m)?,
            relaxation: capped("relaxation", &self.relaxation)?,
            fat_sliding: capped("fat_sliding", &self.fat_sliding)?,
            volume: strengths("volume", self.volume, bones)?,
            crease: strengths("crease", self.crease, bones)?,
            contact: strengths("contact", self.contact, bones)?,
            contacts: self.contacts,
        })
    }
}

/// The settings of an [`Elasticity`] at each vertex (by sorted index) and bone.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ElasticSettings {
    pub energy: Energy,
    /// One per vertex.
    pub anchor_stiffness: Vec<f32>,
    /// One per vertex.
    pub edge_stiffness: Vec<f32>,
    /// One per vertex, m.
    pub slack_m: Vec<f32>,
    /// One per vertex, 0 to 1.
    pub relaxation: Vec<f32>,
    /// One per vertex, 0 to 1.
    pub fat_sliding: Vec<f32>,
    /// One per bone, 0 to 1.
    pub volume: Vec<f32>,
    /// One per bone, 0 to 1.
    pub crease: Vec<f32>,
    /// One per bone, 0 to 1.
    pub contact: Vec<f32>,
    pub contacts: bool,
}
