//! A mesh bound to a musculature: bind once (ALGORITHM 3), then deform (4) or correct (6) every frame.

mod anchor;
mod awake;
mod bind;
mod contact;
mod correction;
mod deform;
mod dual_quaternion;
mod elastic;
mod elasticity;
mod fitted;
mod frame;
mod frobenius;
mod influence;
mod lanes;
mod linear;
mod mesh;
mod options;
mod order;
mod posed_modifier;
mod preserve_volume;
mod regional;
mod skinning;
mod weights;

use std::sync::{Arc, Mutex, PoisonError};

use fixedbitset::FixedBitSet;
use glam::{Mat3A, Vec3A};

pub use self::elastic::Segments;
pub use self::elasticity::{Elasticity, Energy};
pub use self::fitted::WeightRows;
pub use self::linear::LinearSkin;
pub use self::mesh::RestMesh;
pub(crate) use self::mesh::require_triangles;
pub use self::options::{Anchoring, Carrying, SkinOptions, Skinning};
pub use self::posed_modifier::PosedModifier;
pub use self::regional::Regional;

use self::anchor::Anchors;
use self::awake::awake;
use self::bind::Binding;
use self::contact::{Contact, ContactMesh};
use self::deform::ChunkNeeds;
use self::elastic::{Elastic, ElasticMesh};
use self::frame::Workspace;
use self::influence::Row;
use self::mesh::{Adjacency, Spaces, require_rows};
use self::order::Order;
use self::weights::BoneWeights;
use crate::error::{Error, Result};
use crate::musculature::Musculature;
use crate::pose::{ColumnMajor, require_length};

/// What one frame met.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FrameReport {
    /// Indices of the muscles whose belly came near its floor.
    pub clamped: Vec<usize>,
    /// Vertices whose correction is damped or bounded.
    pub damped: usize,
}

/// A mesh bound to a musculature in the rest pose.
#[derive(Debug)]
pub struct Skin {
    musculature: Arc<Musculature>,
    /// By this all vertices are numbered, here and in what follows from it.
    order: Order,
    mesh_points: Vec<Vec3A>,
    points: Vec<Vec3A>,
    armature_to_mesh: Mat3A,
    bone_weights: BoneWeights,
    rows: Vec<Row>,
    needs: ChunkNeeds,
    /// The bones that each tissue hangs on.
    bones_of_tissue: Vec<FixedBitSet>,
    anchors: Anchors,
    skinning: Skinning,
    elastic: Option<Elastic>,
    contact: Option<Contact>,
    /// Buffers not in use: one, but for frames computed at the same time. No lock is held while computing.
    workspaces: Mutex<Vec<Workspace>>,
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
        let order = Order::new(&points, &bone_weights, bones);
        let (points, bone_weights) = (order.sorted(&points), bone_weights.sorted(&order));
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
        require_length("segments", bones, "one a bone", elasticity.segments.of_bone.len())?;
        require_length(
            "bone_lengths",
            bones,
            "one a bone",
            elasticity.segments.lengths_m.len(),
        )?;
        let points = Spaces::new(mesh.mesh_to_armature)?.to_armature(mesh.points);
        let points = self.order.sorted(&points);
        let edges = Adjacency::new(&self.order, mesh.edges)?;
        let struts = Adjacency::new(&self.order, elasticity.struts)?;
        let triangles = self
            .order
            .triangles(require_triangles(elasticity.triangles, points.len())?);
        let settings = elasticity.settings(&self.bone_weights, bones, &self.order)?;
        let normals = elastic::normals(&points, &triangles);
        let elastic = Elastic::new(
            &self.musculature,
            &ElasticMesh {
                points: &points,
                edges: &edges,
                springs: match elasticity.energy {
                    // turns hold faces square, and along edges alone the rounds cost half and come further
                    Energy::AsRigidAsPossible => &edges,
                    Energy::Springs => &struts,
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
        self.elastic = elastic;
        Ok(self)
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.points.len()
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
        self.anchors.occupied()
    }

    /// Influence of each tissue on each vertex, row by row; a row sums to how near the tissues are, 0..1.
    pub fn tissue_weights(&self) -> Vec<f32> {
        let tissues = self.musculature.len();
        let mut dense = vec![0.0; self.rows.len() * tissues];
        for (row, vertex) in self.rows.iter().zip(self.order.vertices()) {
            let weights = &mut dense[vertex * tissues..][..tissues];
            for entry in row.entries() {
                weights[self.musculature.carriers()[entry.carrier as usize].tissue] += entry.weight;
            }
        }
        dense
    }

    /// Writes the correction of one frame to `out`: what to add to the rest points, mesh space, before the Armature
    /// modifier; exactly 0 where no tissue is near. `tension` 0..1, one a tissue.
    ///
    /// # Errors
    /// Lists that do not fit the rig or the mesh, a pose that is not affine, a tension outside 0..1; `out` is then as it was.
    pub fn correct(
        &self,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
    ) -> Result<FrameReport> {
        self.frame(pose, tension, out, |frame| self.write_correction(frame))
    }

    /// Writes the deformed skin of one frame to `out`, mesh space, as it stands after the Armature modifier.
    ///
    /// # Errors
    /// As [`Skin::correct`].
    pub fn deform(&self, pose: &[ColumnMajor], tension: &[f32], out: &mut [[f32; 3]]) -> Result<FrameReport> {
        self.frame(pose, tension, out, |frame| {
            self.write_deformed(frame);
            0
        })
    }

    fn frame(
        &self,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
        write: impl FnOnce(&mut Workspace) -> usize + Send,
    ) -> Result<FrameReport> {
        require_length("out", self.len(), "one a vertex", out.len())?;
        let mut workspace = self.borrow_workspace();
        let report = awake(|| self.frame_in(&mut workspace, pose, tension, out, write));
        self.workspaces
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(workspace);
        report
    }

    fn frame_in(
        &self,
        workspace: &mut Workspace,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
        write: impl FnOnce(&mut Workspace) -> usize,
    ) -> Result<FrameReport> {
        let mut clamped = Vec::new();
        workspace.set(
            &self.musculature,
            &self.bones_of_tissue,
            self.elastic.as_ref(),
            pose,
            tension,
            &mut clamped,
        )?;
        self.relax(workspace);
        let damped = write(workspace);
        self.order.give(&workspace.output, out);
        Ok(FrameReport { clamped, damped })
    }

    fn borrow_workspace(&self) -> Workspace {
        let idle = self
            .workspaces
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        idle.unwrap_or_else(|| {
            let elastic = self.elastic.as_ref();
            Workspace::new(
                &self.musculature,
                self.skinning,
                elastic,
                self.contact.as_ref(),
                self.len(),
                self.needs.len(),
            )
        })
    }
}
