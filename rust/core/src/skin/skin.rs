//! A mesh bound to a musculature: bind once (ALGORITHM 3), then deform (4) or correct (6) every frame.

use std::sync::{Arc, Mutex};

use fixedbitset::FixedBitSet;
use glam::{Mat3A, Vec3A};

use crate::error::{Error, Result, require_length, require_triangles};
use crate::math::norm::frobenius_squared;
use crate::muscles::musculature::Musculature;
use crate::pose::{ColumnMajor, Palette};
use crate::skin::binding::anchor::Anchors;
use crate::skin::binding::bind::Binding;
use crate::skin::binding::influence::Row;
use crate::skin::chunk_needs::ChunkNeeds;
use crate::skin::contact::contact::Contact;
use crate::skin::contact::contact_mesh::ContactMesh;
use crate::skin::mesh::adjacency::Adjacency;
use crate::skin::mesh::aliases::Aliases;
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::normals::normals;
use crate::skin::mesh::rest_mesh::{RestMesh, Spaces, require_rows};
use crate::skin::mesh::vertex_order::VertexOrder;
use crate::skin::relaxation::elastic::Elastic;
use crate::skin::relaxation::elastic_mesh::ElasticMesh;
use crate::skin::safeguard::guard::Guard;
use crate::skin::settings::bind::{SkinOptions, Skinning};
use crate::skin::settings::elasticity::{Elasticity, Energy};
use crate::skin::skinning::modifier::BoneMaps;
use crate::skin::skinning::posed_modifier::PosedModifier;
use crate::skin::workspace::Workspace;

/// A mesh bound to a musculature in the rest pose.
#[derive(Debug)]
pub struct Skin {
    pub(crate) musculature: Arc<Musculature>,
    /// By this all vertices are numbered, here and in what follows from it.
    pub(crate) order: VertexOrder,
    pub(crate) mesh_points: Vec<Vec3A>,
    pub(crate) points: Vec<Vec3A>,
    pub(crate) armature_to_mesh: Mat3A,
    pub(crate) bone_weights: BoneWeights,
    pub(crate) aliases: Aliases,
    pub(crate) rows: Vec<Row>,
    pub(crate) needs: ChunkNeeds,
    /// The bones that each tissue hangs on.
    pub(crate) bones_of_tissue: Vec<FixedBitSet>,
    pub(crate) anchors: Anchors,
    pub(crate) skinning: Skinning,
    pub(crate) elastic: Option<Elastic>,
    pub(crate) contact: Option<Contact>,
    pub(crate) guard: Option<Guard>,
    /// Buffers not in use: one, but for frames computed at the same time. No lock is held while computing.
    pub(crate) workspaces: Mutex<Vec<Workspace>>,
}

impl Skin {
    /// Binds `mesh` to `musculature`.
    ///
    /// # Errors
    /// A mesh without vertices, a musculature without tissues, an option outside its limits, a `mesh_to_armature` that is
    /// singular, lists that do not fit each other.
    pub fn new(musculature: Arc<Musculature>, mesh: &RestMesh, options: &SkinOptions) -> Result<Self> {
        if musculature.is_empty() {
            return Err(Error::NoTissues);
        }
        options.require_valid()?;
        require_rows(mesh)?;
        let spaces = Spaces::new(mesh.mesh_to_armature)?;
        let bones = musculature.skeleton().len();
        let bone_weights = BoneWeights::new(mesh, bones)?;
        let points = spaces.to_armature(mesh.points);
        let order = VertexOrder::new(&points, &bone_weights, bones);
        let aliases = Aliases::new(&order, mesh.points, &points, &bone_weights);
        let (points, bone_weights) = (order.sorted(&points), order.sorted_weights(&bone_weights));
        let adjacency = Adjacency::new(&order, mesh.edges)?;
        let rows = Binding {
            musculature: &musculature,
            points: &points,
            adjacency: &adjacency,
            bone_weights: &bone_weights,
            options,
        }
        .influences();
        let needs = ChunkNeeds::new(&bone_weights, &rows, bones, musculature.carriers().len());
        let influence = options
            .muscle_influence
            .resolve("muscle_influence", &bone_weights, bones, &order)?;
        Ok(Self {
            anchors: Anchors::new(&musculature, &points, &rows, &influence, options),
            elastic: None,
            contact: None,
            guard: None,
            workspaces: Mutex::new(vec![]),
            skinning: options.skinning,
            mesh_points: order
                .vertices()
                .map(|vertex| Vec3A::from_array(mesh.points[vertex]))
                .collect(),
            points: points.iter().map(|point| point.as_vec3a()).collect(),
            armature_to_mesh: Mat3A::from(spaces.armature_to_mesh.matrix3.as_mat3()),
            bones_of_tissue: (0..musculature.len())
                .map(|tissue| musculature.needs_of(tissue))
                .collect(),
            needs,
            bone_weights,
            aliases,
            rows,
            order,
            musculature,
        })
    }

    /// The same skin, elastic; `mesh` is what it was bound from.
    ///
    /// # Errors
    /// A strut or a triangle with a vertex that is not there, lists of another length than the rig's bones or the mesh's
    /// vertices, a setting outside its limits.
    pub fn with_elasticity(mut self, mesh: &RestMesh, elasticity: &Elasticity) -> Result<Self> {
        let bones = self.musculature.skeleton().len();
        require_length(
            "segments",
            bones,
            "one per bone",
            elasticity.segments.of_bone.len(),
        )?;
        require_length(
            "bone_lengths",
            bones,
            "one per bone",
            elasticity.segments.lengths_m.len(),
        )?;
        let points = Spaces::new(mesh.mesh_to_armature)?.to_armature(mesh.points);
        let points = self.order.sorted(&points);
        let edges = Adjacency::new(&self.order, mesh.edges)?;
        let spring_edges = Adjacency::new(&self.order, elasticity.spring_edges)?;
        let triangles = self
            .order
            .triangles(require_triangles(elasticity.triangles, self.len())?);
        let settings = elasticity.settings(&self.bone_weights, bones, &self.order)?;
        let normals = normals(&points, &triangles);
        let elastic = Elastic::new(
            &self.musculature,
            &ElasticMesh {
                points: &points,
                edges: &edges,
                energy_edges: match elasticity.energy {
                    // turns hold faces square, and along edges alone the rounds cost half and come further
                    Energy::AsRigidAsPossible => &edges,
                    Energy::Springs => &spring_edges,
                },
                triangles: &triangles,
                normals: &normals,
                weights: &self.bone_weights,
                carriers_of: &|vertex| {
                    self.rows[vertex]
                        .entries()
                        .iter()
                        .map(|own| own.carrier)
                        .collect()
                },
            },
            &elasticity.segments,
            elasticity.iterations,
            &settings,
        );
        self.workspaces = Mutex::new(vec![]);
        self.contact = settings.contacts.then(|| {
            let mesh = ContactMesh {
                points: &points,
                edges: &edges,
                triangles: &triangles,
                weights: &self.bone_weights,
                segments: &elasticity.segments,
                clusters: self.order.clusters(),
            };
            Contact::new(&mesh, &normals, &settings.contact)
        });
        // springs are there as the paper has them, and are not held to more than it promises
        let is_guarded = elasticity.safeguards && elasticity.energy == Energy::AsRigidAsPossible;
        let joints = elastic.as_ref().map_or(&[][..], |elastic| &elastic.joints);
        self.guard = Some(Guard::new(is_guarded, joints, &points, &triangles));
        self.elastic = elastic;
        Ok(self)
    }

    /// Number of the mesh's vertices.
    pub fn len(&self) -> usize {
        self.order.mesh_len()
    }

    /// False: a skin has vertices.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// What the skin is bound to.
    pub fn musculature(&self) -> &Musculature {
        &self.musculature
    }

    /// Number of vertices that a tissue moves.
    pub fn anchored(&self) -> usize {
        let numbers = (0..self.len()).map(|vertex| self.order.sorted_index(vertex as u32) as usize);
        numbers.filter(|&number| self.anchors.is_occupied(number)).count()
    }

    /// Influence of each tissue on each vertex, row by row; a row sums to how near the tissues are, 0..1.
    pub fn tissue_weights(&self) -> Vec<f32> {
        let tissues = self.musculature.len();
        let mut dense = vec![0.0; self.len() * tissues];
        for vertex in 0..self.len() {
            let row = &self.rows[self.order.sorted_index(vertex as u32) as usize];
            let weights = &mut dense[vertex * tissues..][..tissues];
            for entry in row.entries() {
                weights[self.musculature.carriers()[entry.carrier as usize].tissue] += entry.weight;
            }
        }
        dense
    }

    /// What the mesh's Armature modifier does in `pose`.
    ///
    /// # Errors
    /// Another number of matrices than bones, or one that is not affine.
    pub fn posed_modifier(&self, pose: &[ColumnMajor]) -> Result<PosedModifier> {
        let skeleton = self.musculature.skeleton();
        let palette = Palette::new(skeleton, pose)?;
        let mut all = FixedBitSet::with_capacity(skeleton.len());
        all.insert_range(..);
        let mut maps = BoneMaps::at_rest(self.skinning, skeleton.len());
        maps.set(skeleton, &palette, &all);
        // a mesh whose own axes are uneven in armature space lengthens by those, too
        let own = self.armature_to_mesh;
        let uneven = (frobenius_squared(&own) * frobenius_squared(&own.inverse())).sqrt() / 3.0;
        let max_lengthening = maps.max_lengthening() * if uneven < 1.001 { 1.001 } else { 3.0 * uneven };
        Ok(PosedModifier {
            maps,
            max_lengthening,
        })
    }

    /// Where the modifier takes an offset of a vertex of the mesh, both in mesh space.
    pub fn posed_offset(&self, modifier: &PosedModifier, vertex: usize, offset: Vec3A) -> Vec3A {
        let number = self.order.sorted_index(vertex as u32) as usize;
        let alias = self.aliases.of_vertex(vertex);
        let map = modifier.maps.blend(alias.unwrap_or(self.bone_weights.of(number)));
        let own = self.armature_to_mesh.inverse() * offset;
        self.armature_to_mesh * (own + map.linear * own)
    }
}
