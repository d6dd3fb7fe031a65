//! Skin on skin: what two parts of a body press into each other is moved apart, half of the way each, and the skin around it
//! goes along (an arm on the chest, a calf on the thigh, a finger on the palm).
//!
//! It acts on the skin as bones, tissues and relaxation have left it, from that alone. Only parts that came nearer to each other
//! than they are at rest are looked at, in bounded time: [`PASSES`] times, each vertex against the skin within [`REACH`].
//! Deeper than that, nothing is moved: the pose itself is at fault, and the push ends smoothly before.

mod clusters;
mod meeting;
mod parted;
mod spread;
mod thickness;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use self::clusters::{BoneClusters, Cluster, Pair, PosedCluster};
use self::meeting::Meetings;
use self::parted::Parted;
use self::spread::Spread;
use super::elastic::Segments;
use super::mesh::Adjacency;
use super::regional::mean;
use super::weights::BoneWeights;
use crate::pose::{Palette, Skeleton};

/// Times that the skin is looked at and moved apart.
const PASSES: usize = 3;
/// Depth up to which parts are moved apart, over the size of the body.
const REACH: f64 = 0.015;
/// Distance that parts keep, over the size of the body.
const MARGIN: f64 = 0.00025;

/// What skin on skin needs of a mesh.
#[derive(Debug)]
pub(super) struct Contact {
    clusters: Vec<Cluster>,
    bones: Vec<BoneClusters>,
    /// Clusters of one segment that face each other at rest.
    facing: Vec<Pair>,
    rest: Vec<Vec3A>,
    triangles: Vec<[u32; 3]>,
    /// Where the triangles of each vertex start in `around`.
    offsets: Vec<u32>,
    around: Vec<u32>,
    edges: Adjacency,
    /// How fully each vertex is moved, 0..1.
    strength: Vec<f32>,
    /// Depth up to which each vertex is moved, m.
    reach_of_m: Vec<f32>,
    /// The largest of these, m.
    reach_m: f32,
    margin_m: f32,
}

/// The mesh as contact needs it.
pub(super) struct ContactMesh<'a> {
    pub points: &'a [DVec3],
    pub edges: &'a Adjacency,
    pub triangles: &'a [[u32; 3]],
    pub weights: &'a BoneWeights,
    pub skeleton: &'a Skeleton,
    pub segments: &'a Segments<'a>,
}

impl ContactMesh<'_> {
    /// The bone that moves a vertex most; of equals the first.
    fn strongest_bone(&self, vertex: usize) -> Option<usize> {
        let own = self.weights.of(vertex).iter();
        let strongest = own.max_by(|a, b| a.weight.total_cmp(&b.weight).then(b.bone.cmp(&a.bone)));
        strongest.map(|own| own.bone as usize)
    }
}

impl Contact {
    /// The contact of a mesh with itself; `normals` are those of its vertices at rest, `strength` is how fully the skin of
    /// each bone is moved, 0..1.
    pub fn new(mesh: &ContactMesh, normals: &[Vec3A], strength: &[f32]) -> Self {
        let clusters = clusters::clusters(mesh, normals);
        let mut offsets = vec![0_u32; mesh.points.len() + 1];
        for &vertex in mesh.triangles.iter().flatten() {
            offsets[vertex as usize + 1] += 1;
        }
        for vertex in 0..mesh.points.len() {
            offsets[vertex + 1] += offsets[vertex];
        }
        let (mut next, mut around) = (offsets.clone(), vec![0; 3 * mesh.triangles.len()]);
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            for &vertex in triangle {
                around[next[vertex as usize] as usize] = index as u32;
                next[vertex as usize] += 1;
            }
        }
        let low = mesh.points.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = mesh.points.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let size_m = (high - low).max_element();
        Self {
            reach_of_m: thickness::reach_of(mesh, &clusters, normals, (REACH * size_m) as f32),
            facing: clusters::facing(mesh, &clusters, normals, (REACH * size_m) as f32),
            bones: clusters::by_bone(&clusters),
            clusters,
            rest: mesh.points.iter().map(|point| point.as_vec3a()).collect(),
            triangles: mesh.triangles.to_vec(),
            offsets,
            around,
            edges: mesh.edges.clone(),
            strength: (0..mesh.points.len())
                .map(|vertex| mean(strength, mesh.weights, vertex) as f32)
                .collect(),
            reach_m: (REACH * size_m) as f32,
            margin_m: (MARGIN * size_m) as f32,
        }
    }

    fn triangles_of(&self, vertex: usize) -> &[u32] {
        &self.around[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}

/// The buffers of a frame.
#[derive(Debug)]
pub(super) struct ContactFrame {
    pairs: Vec<Pair>,
    posed: Vec<PosedCluster>,
    /// Vertices of the parts that meet, rising, and whether each vertex is one of them.
    meeting: Vec<u32>,
    is_meeting: Vec<bool>,
    places: Vec<Vec3A>,
    normals: Vec<Vec3A>,
    /// Largest share of its way that each vertex goes.
    most: Vec<f32>,
    parted: Parted,
    meetings: Meetings,
    spread: Spread,
    /// How far each vertex is moved in this frame, m.
    shift: Vec<Vec3A>,
    /// The vertices that are moved in this frame, and those of the frame before.
    pub shifted: Vec<u32>,
    pub shifted_before: Vec<u32>,
}

impl ContactFrame {
    pub fn new(contact: &Contact) -> Self {
        let vertices = contact.rest.len();
        Self {
            pairs: vec![],
            posed: vec![PosedCluster::default(); contact.clusters.len()],
            meeting: vec![],
            is_meeting: vec![false; vertices],
            places: vec![Vec3A::ZERO; vertices],
            normals: vec![Vec3A::ZERO; vertices],
            most: vec![1.0; vertices],
            parted: Parted::new(contact.clusters.len()),
            meetings: Meetings::default(),
            spread: Spread::new(vertices),
            shift: vec![Vec3A::ZERO; vertices],
            shifted: vec![],
            shifted_before: vec![],
        }
    }

    /// How far a vertex is moved, m; `None` for not at all.
    pub fn shift(&self, vertex: usize) -> Option<Vec3A> {
        let shift = self.shift[vertex];
        (shift != Vec3A::ZERO).then_some(shift)
    }

    /// Moves apart what meets in a pose; `is_relaxed` says whether the elastic skin moves a vertex,
    /// `place_of` where it lies before contact, m, armature space.
    pub fn part(
        &mut self,
        contact: &Contact,
        palette: &Palette,
        is_relaxed: impl Fn(usize) -> bool,
        place_of: impl Fn(usize) -> Vec3A + Sync,
    ) {
        std::mem::swap(&mut self.shifted, &mut self.shifted_before);
        for vertex in self.shifted_before.iter() {
            self.shift[*vertex as usize] = Vec3A::ZERO;
        }
        self.shifted.clear();
        contact.find_pairs(palette, is_relaxed, &mut self.posed, &mut self.pairs);
        if self.pairs.is_empty() {
            return;
        }
        self.gather(contact, |cluster| &cluster.vertices);
        self.place(&place_of);
        self.parted
            .drop_from(contact, &self.posed, &self.places, &mut self.pairs);
        if self.pairs.is_empty() {
            return;
        }
        self.gather(contact, |cluster| &cluster.with_corners);
        self.place(&place_of);
        for pass in 0..PASSES {
            self.find_normals(contact);
            let skin = meeting::PosedSkin {
                places: &self.places,
                normals: &self.normals,
                clusters: &self.posed,
                most: &self.most,
            };
            self.meetings.find(contact, &self.pairs, &skin);
            if self.meetings.is_empty() {
                break;
            }
            if pass == 0 {
                for meeting in self.meetings.iter() {
                    self.most[meeting.vertex as usize] = meeting.share;
                }
            }
            self.spread.spread(contact, &self.meetings);
            for (vertex, push) in self.spread.pushes() {
                self.places[vertex] += push;
                if self.shift[vertex] == Vec3A::ZERO {
                    self.shifted.push(vertex as u32);
                }
                self.shift[vertex] += push;
            }
        }
    }

    /// Collects the vertices of all clusters in pairs, those that `of` gives.
    fn gather(&mut self, contact: &Contact, of: impl Fn(&Cluster) -> &Vec<u32>) {
        for &vertex in &self.meeting {
            self.is_meeting[vertex as usize] = false;
            self.most[vertex as usize] = 1.0;
        }
        self.meeting.clear();
        let clusters = self.pairs.iter().flat_map(|pair| [pair.one, pair.other]);
        for cluster in clusters {
            for &vertex in of(&contact.clusters[cluster as usize]) {
                let is_meeting = &mut self.is_meeting[vertex as usize];
                if !*is_meeting {
                    *is_meeting = true;
                    self.meeting.push(vertex);
                }
            }
        }
        self.meeting.sort_unstable();
    }

    fn place(&mut self, place_of: &(impl Fn(usize) -> Vec3A + Sync)) {
        let is_meeting = &self.is_meeting;
        let places = self.places.par_iter_mut().enumerate().with_min_len(256);
        places
            .filter(|(vertex, _)| is_meeting[*vertex])
            .for_each(|(vertex, place)| *place = place_of(vertex));
    }

    fn find_normals(&mut self, contact: &Contact) {
        let (is_meeting, places) = (&self.is_meeting, &self.places);
        let normals = self.normals.par_iter_mut().enumerate().with_min_len(256);
        normals
            .filter(|(vertex, _)| is_meeting[*vertex])
            .for_each(|(vertex, normal)| {
                let mut sum = Vec3A::ZERO;
                for &triangle in contact.triangles_of(vertex) {
                    let corners = contact.triangles[triangle as usize];
                    if corners.iter().all(|&corner| is_meeting[corner as usize]) {
                        let [a, b, c] = corners.map(|corner| places[corner as usize]);
                        sum += (b - a).cross(c - a);
                    }
                }
                *normal = sum.normalize_or_zero();
            });
    }
}
