//! What a skin's elasticity is told: the mesh's faces, the body's segments, and how firmly each region holds on to what.

use crate::error::Result;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::regional::{Regional, strengths};
use crate::skin::mesh::vertex_order::VertexOrder;
use crate::skin::settings::segments::Segments;

/// What a relaxed skin keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Energy {
    /// Its shape around each vertex, turned as it may be (O. Sorkine and M. Alexa, "As-Rigid-As-Possible Surface Modeling", 2007).
    #[default]
    AsRigidAsPossible,
    /// The length of each edge (Wilhelms 1997).
    Springs,
}

/// What makes a skin elastic around the joints that it bends at.
#[derive(Debug, Clone, Copy)]
pub struct Elasticity<'a> {
    /// The mesh's edges and the diagonals of its faces, as pairs of vertices: what [`Energy::Springs`] has springs along.
    pub struts: &'a [[i32; 2]],
    /// The mesh's faces, cut into triangles.
    pub triangles: &'a [[i32; 3]],
    /// Which bones are one segment of the body, and how long they are.
    pub segments: Segments<'a>,
    /// Rounds of relaxation a frame.
    pub iterations: usize,
    /// What the skin keeps as it is relaxed.
    pub energy: Energy,
    /// Factor on how firmly a vertex holds on to its anchor.
    pub anchor_stiffness: Regional<'a>,
    /// Factor on how firmly a vertex holds on to its neighbours.
    pub edge_stiffness: Regional<'a>,
    /// Slack: distance that a vertex may lie from its anchor before it is pulled there, m.
    pub rest_distance_m: Regional<'a>,
    /// Share of the iterations that a vertex takes part in; above 1 counts as 1.
    pub relaxation: Regional<'a>,
    /// How freely the skin slides along itself over what lies beneath: 0 not at all; above 1 counts as 1.
    pub fat_sliding: Regional<'a>,
    /// How fully the joint at the head of each bone keeps its volume, 0..1; `None` for 1 everywhere.
    pub volume: Option<&'a [f32]>,
    /// How fully the crease plane of the joint at the head of each bone acts, 0..1; `None` for 1 everywhere.
    pub crease: Option<&'a [f32]>,
    /// How fully the skin of each bone keeps off other skin, 0..1; `None` for 1 everywhere.
    pub contact: Option<&'a [f32]>,
    /// Whether tissues push the skin out.
    pub collides: bool,
    /// Whether skin pushes other skin away.
    pub contacts: bool,
    /// Whether a joint whose skin is worse than the modifier's returns to that; of [`Energy::AsRigidAsPossible`] alone.
    pub safeguards: bool,
}

impl<'a> Elasticity<'a> {
    /// An elasticity that is the same everywhere: factors 1, no slack, no sliding, everything on.
    pub const fn new(
        struts: &'a [[i32; 2]],
        triangles: &'a [[i32; 3]],
        segments: Segments<'a>,
        iterations: usize,
    ) -> Self {
        Self {
            struts,
            triangles,
            segments,
            iterations,
            energy: Energy::AsRigidAsPossible,
            anchor_stiffness: Regional::of_body(1.0),
            edge_stiffness: Regional::of_body(1.0),
            rest_distance_m: Regional::of_body(0.0),
            relaxation: Regional::of_body(1.0),
            fat_sliding: Regional::of_body(0.0),
            volume: None,
            crease: None,
            contact: None,
            collides: true,
            contacts: true,
            safeguards: true,
        }
    }

    /// The settings at each vertex, by their numbers in `order` as `weights` are, and at each of `bones` bones.
    ///
    /// # Errors
    /// A setting outside its limits, a list of another length than bones or vertices.
    pub(crate) fn settings(
        &self,
        weights: &BoneWeights,
        bones: usize,
        order: &VertexOrder,
    ) -> Result<ElasticSettings> {
        let resolved = |setting, regional: &Regional| regional.resolve(setting, weights, bones, order);
        let share = |setting, regional: &Regional| {
            resolved(setting, regional).map(|values| values.into_iter().map(|value| value.min(1.0)).collect())
        };
        Ok(ElasticSettings {
            energy: self.energy,
            anchor_stiffness: resolved("anchor_stiffness", &self.anchor_stiffness)?,
            edge_stiffness: resolved("edge_stiffness", &self.edge_stiffness)?,
            rest_distance_m: resolved("rest_distance", &self.rest_distance_m)?,
            relaxation: share("relaxation", &self.relaxation)?,
            fat_sliding: share("fat_sliding", &self.fat_sliding)?,
            volume: strengths("volume", self.volume, bones)?,
            crease: strengths("crease", self.crease, bones)?,
            contact: strengths("contact", self.contact, bones)?,
            collides: self.collides,
            contacts: self.contacts,
        })
    }
}

/// An elasticity's settings, as they are at each vertex and bone; see [`Elasticity`] for what each means.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ElasticSettings {
    pub energy: Energy,
    /// One a vertex.
    pub anchor_stiffness: Vec<f32>,
    /// One a vertex.
    pub edge_stiffness: Vec<f32>,
    /// One a vertex, m.
    pub rest_distance_m: Vec<f32>,
    /// One a vertex, 0..1.
    pub relaxation: Vec<f32>,
    /// One a vertex, 0..1.
    pub fat_sliding: Vec<f32>,
    /// One a bone, 0..1.
    pub volume: Vec<f32>,
    /// One a bone, 0..1.
    pub crease: Vec<f32>,
    /// One a bone, 0..1.
    pub contact: Vec<f32>,
    pub collides: bool,
    pub contacts: bool,
}
