//! A mesh bound to a musculature (mathematics/binding.md), then deformed or corrected in every frame.

use std::sync::{Arc, Mutex};

use fixedbitset::FixedBitSet;
use glam::{Mat3A, Vec3A};

use crate::error::{Error, Result, require_length, require_triangles};
use crate::math::norm::frobenius_squared;
use crate::math::rows::Rows;
use crate::muscles::musculature::Musculature;
use crate::pose::{ColumnMajor, Palette};
use crate::skin::binding::anchor::Anchors;
use crate::skin::binding::bind::Binding;
use crate::skin::binding::influence::Influence;
use crate::skin::chunk_needs::ChunkNeeds;
use crate::skin::contact::contact::Contact;
use crate::skin::contact::contact_mesh::ContactMesh;
use crate::skin::frame_report::FrameReport;
use crate::skin::mesh::adjacency::{Adjacency, require_edges};
use crate::skin::mesh::bone_weights::BoneWeights;
use crate::skin::mesh::normals::normals;
use crate::skin::mesh::rest_mesh::{RestMesh, Spaces, require_rows};
use crate::skin::mesh::vertex_order::VertexOrder;
use crate::skin::mesh::welded::WeldedVertices;
use crate::skin::relaxation::elastic::Elastic;
use crate::skin::relaxation::elastic_mesh::ElasticMesh;
use crate::skin::safeguard::guard::Guard;
use crate::skin::safeguard::sampler::Sampler;
use crate::skin::settings::bind::{SkinOptions, Skinning};
use crate::skin::settings::elasticity::{Elasticity, Energy};
use crate::skin::skinning::displacement::Displacement;
use crate::skin::skinning::modifier::BoneMaps;
use crate::skin::skinning::posed_modifier::PosedModifier;
use crate::skin::workspace::Workspace;

/// A mesh bound to a musculature in the rest pose.
///
/// ```
/// use std::sync::Arc;
///
/// use sinew_core::{Musculature, RestMesh, Skeleton, Skin, SkinOptions, Tissue, TissueDescription, TissueKind};
///
/// let at = |x| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, 0.0, 0.0, 1.0];
/// let skeleton = Skeleton::new(vec!["upper".into(), "lower".into()], &[-1, 0], &[at(0.0); 2])?;
/// let biceps = Tissue::new(TissueDescription {
///     name: "biceps".into(),
///     kind: TissueKind::Muscle,
///     origin_bone: 0,
///     insertion_bone: 1,
///     centre: [0.0; 3],
///     rotation: [1.0, 0.0, 0.0, 0.0],
///     semi_axes: [0.02, 0.02, 0.1],
///     origin_tendon_m: 0.0,
///     insertion_tendon_m: 0.0,
///     volume_keeping: 1.0,
///     via_points: vec![],
///     wraps: vec![],
/// })?;
/// let mesh = RestMesh {
///     points: &[[0.025, 0.0, 0.0]],
///     edges: &[],
///     mesh_to_armature: &at(0.0),
///     weight_offsets: &[0, 1],
///     weight_bones: &[0],
///     weights: &[1.0],
/// };
/// let musculature = Arc::new(Musculature::new(skeleton, vec![biceps])?);
/// let skin = Skin::new(musculature, &mesh, &SkinOptions::default())?;
///
/// // without tension the skin moves with its bones, here by 2 m
/// let mut positions = [[0.0; 3]];
/// skin.deform(&[at(2.0); 2], &[0.0], &mut positions)?;
/// assert!((positions[0][0] - 2.025).abs() < 1e-6);
/// // in the rest pose nothing needs correction
/// skin.correct(&[at(0.0); 2], &[0.0], &mut positions)?;
/// assert_eq!(positions, [[0.0; 3]]);
/// # Ok::<(), sinew_core::Error>(())
/// ```
#[derive(Debug)]
pub struct Skin {
    pub(crate) musculature: Arc<Musculature>,
    /// The order of the vertices, here and in all bind data.
    pub(crate) order: VertexOrder,
    pub(crate) mesh_points: Vec<Vec3A>,
    pub(crate) points: Vec<Vec3A>,
    pub(crate) armature_to_mesh: Mat3A,
    pub(crate) bone_weights: BoneWeights,
    pub(crate) welded: WeldedVertices,
    /// The influences on every vertex.
    pub(crate) influences: Rows<Influence>,
    pub(crate) needs: ChunkNeeds,
    /// The bones that each tissue depends on.
    pub(crate) bones_of_tissue: Vec<FixedBitSet>,
    pub(crate) anchors: Anchors,
    pub(crate) skinning: Skinning,
    /// Fraction of Preserve Volume at each vertex, if both skinnings are blended.
    pub(crate) preserved: Option<Vec<f32>>,
    pub(crate) elastic: Option<Elastic>,
    pub(crate) contact: Option<Contact>,
    pub(crate) guard: Option<Guard>,
    pub(crate) garment: Option<Box<dyn Garment>>,
    /// Buffers that no frame uses: usually one, more after frames that were computed at the same time. No lock
    /// is held while a frame is computed.
    pub(crate) workspaces: Mutex<Vec<Workspace>>,
    /// Buffers of the safeguard that no sample uses.
    pub(crate) samplers: Mutex<Vec<Sampler>>,
}

/// What a garment computes in place of the stages of a frame (mathematics/garments.md).
pub(crate) trait Garment: std::fmt::Debug + Send + Sync {
    /// As [`Skin::correct`], for the garment `skin`.
    fn correct(
        &self,
        skin: &Skin,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
    ) -> Result<FrameReport>;

    /// As [`Skin::deform`], for the garment `skin`.
    fn deform(
        &self,
        skin: &Skin,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
    ) -> Result<FrameReport>;

    /// Whether each vertex follows the body, in sorted order.
    fn following(&self) -> Vec<bool>;
}

impl Skin {
    /// Binds `mesh` to `musculature`.
    ///
    /// # Errors
    /// A mesh without vertices, a musculature without tissues, an option outside its limits, a
    /// `mesh_to_armature` that is singular, lists whose lengths do not match.
    pub fn new(musculature: Arc<Musculature>, mesh: &RestMesh, options: &SkinOptions) -> Result<Self> {
        if musculature.is_empty() {
            return Err(Error::NoTissues);
        }
        options.require_valid()?;
        require_rows(mesh)?;
        options.require_fractions(mesh.points.len())?;
        let spaces = Spaces::new(mesh.mesh_to_armature)?;
        let bones = musculature.skeleton().len();
        let bone_weights = BoneWeights::new(mesh, bones)?;
        let points = spaces.to_armature(mesh.points);
        let order = VertexOrder::new(&points, &bone_weights, bones);
        let welded = WeldedVertices::new(&order, mesh.points, &points, &bone_weights);
        let (points, bone_weights) = (order.sorted(&points), order.sorted_weights(&bone_weights));
        let adjacency = Adjacency::new(&order, mesh.edges)?;
        let binding = Binding {
            musculature: &musculature,
            points: &points,
            adjacency: &adjacency,
            bone_weights: &bone_weights,
            options,
        };
        let influences = binding.influences();
        let muscle_influence =
            options
                .muscle_influence
                .resolve("muscle_influence", &bone_weights, bones, &order)?;
        let anchors = Anchors::new(&binding, &influences, &muscle_influence);
        let needs = ChunkNeeds::new(&bone_weights, &anchors, bones, musculature.carriers().len());
        Ok(Self {
            anchors,
            elastic: None,
            contact: None,
            guard: None,
            garment: None,
            workspaces: Mutex::new(vec![]),
            samplers: Mutex::new(vec![]),
            skinning: options.skinning,
            preserved: options
                .preserved_fractions
                .map(|fractions| order.sorted(fractions)),
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
            welded,
            influences,
            order,
            musculature,
        })
    }

    /// The same skin with elasticity. `mesh` is the mesh that it was bound from.
    ///
    /// # Errors
    /// A mesh with another number of vertices, a spring edge or a triangle with a vertex that does not exist,
    /// a list whose length is not the number of bones or vertices, a setting outside its limits.
    pub fn with_elasticity(mut self, mesh: &RestMesh, elasticity: &Elasticity) -> Result<Self> {
        require_length(
            "points",
            self.len(),
            "one per vertex of the bound mesh",
            mesh.points.len(),
        )?;
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
        let points_of_file = Spaces::new(mesh.mesh_to_armature)?.to_armature(mesh.points);
        let points = self.order.sorted(&points_of_file);
        let edges = Adjacency::new(&self.order, mesh.edges)?;
        require_edges(&self.order, elasticity.spring_edges)?;
        let spring_edges = match elasticity.energy {
            // rotations keep faces square; with edges alone an iteration costs half and converges further
            Energy::AsRigidAsPossible => None,
            Energy::Springs => Some(Adjacency::new(&self.order, elasticity.spring_edges)?),
        };
        let triangles_from = self
            .order
            .triangles(require_triangles(elasticity.triangles, self.len())?);
        let triangles = triangles_from.entries();
        let settings = elasticity.settings(&self.bone_weights, bones, &self.order)?;
        let normals = normals(&points, triangles);
        let elastic = Elastic::new(
            &self.musculature,
            &ElasticMesh {
                points: &points,
                edges: &edges,
                energy_edges: spring_edges.as_ref().unwrap_or(&edges),
                triangles,
                triangles_from: &triangles_from,
                normals: &normals,
                weights: &self.bone_weights,
                carriers_of: &|vertex| self.anchors.carriers_of(vertex),
            },
            &elasticity.segments,
            elasticity.iterations,
            &settings,
        );
        self.workspaces = Mutex::new(vec![]);
        self.samplers = Mutex::new(vec![]);
        self.contact = settings.contacts.then(|| {
            let mesh = ContactMesh {
                points: &points,
                edges: &edges,
                triangles,
                weights: &self.bone_weights,
                segments: &elasticity.segments,
                clusters: self.order.clusters(),
            };
            Contact::new(&mesh, &normals, &settings.contact)
        });
        // length springs are as in Wilhelms 1997 and are not guarded
        let is_guarded = elasticity.safeguards && elasticity.energy == Energy::AsRigidAsPossible;
        let corners = |triangle: &[i32; 3]| triangle.map(|corner| corner as u32);
        self.guard = is_guarded.then(|| {
            let triangles = elasticity.triangles.iter().map(corners).collect();
            let file_points = points_of_file.iter().map(|point| point.as_vec3a()).collect();
            Guard::new(
                self.musculature.skeleton(),
                &self.moving_bones(),
                file_points,
                triangles,
            )
        });
        self.elastic = elastic;
        Ok(self)
    }

    /// The bones that carry skin, or move a tissue that moves it.
    fn moving_bones(&self) -> FixedBitSet {
        let mut moving = FixedBitSet::with_capacity(self.musculature.skeleton().len());
        self.needs.bones.iter().for_each(|bones| moving.union_with(bones));
        for carrier in self.needs.carriers.iter().flat_map(FixedBitSet::ones) {
            moving.union_with(&self.bones_of_tissue[self.musculature.carriers()[carrier].tissue]);
        }
        moving
    }

    /// The Armature modifier's map of a vertex by sorted index.
    pub(crate) fn modifier_map(&self, maps: &BoneMaps, vertex: usize) -> Displacement {
        maps.blend(self.bone_weights.of(vertex), self.preserved_fraction(vertex))
    }

    /// The fraction of Preserve Volume at a vertex by sorted index, if both skinnings are blended; else 0.
    pub(crate) fn preserved_fraction(&self, vertex: usize) -> f32 {
        self.preserved.as_ref().map_or(0.0, |fractions| fractions[vertex])
    }

    /// Number of the mesh's vertices.
    pub fn len(&self) -> usize {
        self.order.mesh_len()
    }

    /// False, since a mesh without vertices is refused.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The musculature that the skin is bound to.
    pub fn musculature(&self) -> &Musculature {
        &self.musculature
    }

    /// Number of the mesh's vertices that a tissue moves, or of a garment's vertices that follow the body.
    pub fn anchored(&self) -> usize {
        if let Some(garment) = &self.garment {
            let following = garment.following();
            let sorted_index = |vertex: usize| self.order.sorted_index(vertex as u32) as usize;
            return (0..self.len())
                .filter(|&vertex| following[sorted_index(vertex)])
                .count();
        }
        let sorted_indices = (0..self.len()).map(|vertex| self.order.sorted_index(vertex as u32) as usize);
        sorted_indices
            .filter(|&sorted_index| self.anchors.is_occupied(sorted_index))
            .count()
    }

    /// Influence of each tissue on each vertex, (vertices × tissues), row by row. The sum of a row is 0 to 1,
    /// by the distance of the tissues (mathematics/binding.md, Influence weights).
    pub fn tissue_weights(&self) -> Vec<f32> {
        let tissues = self.musculature.len();
        let mut dense = vec![0.0; self.len() * tissues];
        for vertex in 0..self.len() {
            let row = self
                .influences
                .row(self.order.sorted_index(vertex as u32) as usize);
            let weights = &mut dense[vertex * tissues..][..tissues];
            for entry in row {
                weights[self.musculature.carriers()[entry.carrier as usize].tissue] += entry.weight;
            }
        }
        dense
    }

    /// The mesh's Armature modifier in `pose`.
    ///
    /// # Errors
    /// A number of matrices that is not the number of bones, or a matrix that is not affine.
    pub fn posed_modifier(&self, pose: &[ColumnMajor]) -> Result<PosedModifier> {
        let skeleton = self.musculature.skeleton();
        let palette = Palette::new(skeleton, pose)?;
        let mut all = FixedBitSet::with_capacity(skeleton.len());
        all.insert_range(..);
        let mut maps = BoneMaps::at_rest(self.skinning, self.preserved.is_some(), skeleton.len());
        maps.set(skeleton, &palette, &all);
        // an uneven scale between mesh and armature space lengthens, too
        let to_mesh = self.armature_to_mesh;
        let uneven = (frobenius_squared(&to_mesh) * frobenius_squared(&to_mesh.inverse())).sqrt() / 3.0;
        let max_lengthening = maps.max_lengthening() * if uneven < 1.001 { 1.001 } else { 3.0 * uneven };
        Ok(PosedModifier {
            maps,
            max_lengthening,
        })
    }

    /// The offset after the modifier of a vertex that has `offset` before it, both in mesh space.
    pub fn posed_offset(&self, modifier: &PosedModifier, vertex: usize, offset: Vec3A) -> Vec3A {
        let sorted_index = self.order.sorted_index(vertex as u32) as usize;
        let weights = self.welded.of_vertex(vertex);
        let map = modifier.maps.blend(
            weights.unwrap_or(self.bone_weights.of(sorted_index)),
            self.preserved_fraction(sorted_index),
        );
        let offset = self.armature_to_mesh.inverse() * offset;
        self.armature_to_mesh * (offset + map.linear * offset)
    }
}
