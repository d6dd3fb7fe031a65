//! Skin on skin: what two parts of a body press into each other is moved apart, half of the way each, and the skin around it
//! goes along (an arm on the chest, a calf on the thigh, a finger on the palm).
//!
//! It acts on the skin as bones, tissues and relaxation have left it, from that alone. Only parts that came nearer to each other
//! than they are at rest are looked at, in bounded time: [`PASSES`] times, each vertex against the skin within [`REACH`].
//! Deeper than that, nothing is moved: the pose itself is at fault, and the push ends smoothly before.

mod close;
mod clusters;
mod fours;
mod meeting;
mod spread;
mod thickness;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use self::close::{Boxes, Close};
use self::clusters::{BoneClusters, Cluster, Pair, PosedBone, PosedCluster};
use self::fours::Fours;
use self::meeting::Meetings;
use self::spread::Spread;
use super::elastic::Segments;
use super::mesh::Adjacency;
use super::order;
use super::regional::mean;
use super::weights::BoneWeights;
use crate::pose::Palette;

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
    /// The cluster of each vertex; past the last where it is in none.
    cluster_of: Vec<u32>,
    bones: Vec<BoneClusters>,
    /// Clusters of one segment that face each other at rest.
    facing: Vec<Pair>,
    /// The clusters of these pairs, rising.
    faced: Vec<u32>,
    rest: Vec<Vec3A>,
    /// Where the triangles of each vertex start in `around`.
    offsets: Vec<u32>,
    /// The other two corners of each triangle, in turn.
    around: Vec<[u32; 2]>,
    edges: Adjacency,
    /// How fully each vertex is moved, 0..1.
    strength: Vec<f32>,
    /// Depth up to which the skin of each cluster is moved, m.
    reaches_m: Vec<f32>,
    /// The largest that any may have, m.
    reach_m: f32,
    margin_m: f32,
}

/// The mesh as contact needs it.
pub(super) struct ContactMesh<'a> {
    pub points: &'a [DVec3],
    pub edges: &'a Adjacency,
    pub triangles: &'a [[u32; 3]],
    pub weights: &'a BoneWeights,
    pub segments: &'a Segments<'a>,
    pub clusters: &'a [order::Cluster],
}

impl Contact {
    /// The contact of a mesh with itself; `normals` are those of its vertices at rest, `strength` is how fully the skin of
    /// each bone is moved, 0..1.
    pub fn new(mesh: &ContactMesh, normals: &[Vec3A], strength: &[f32]) -> Self {
        let clusters = clusters::clusters(mesh, normals);
        let low = mesh.points.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = mesh.points.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let size_m = (high - low).max_element();
        let reaches_m = thickness::reaches(mesh, &clusters, normals, (REACH * size_m) as f32);
        let facing = clusters::facing(mesh, &clusters, normals, (REACH * size_m) as f32);
        let mut faced: Vec<u32> = facing.iter().flat_map(|pair| [pair.one, pair.other]).collect();
        faced.sort_unstable();
        faced.dedup();
        let bones = clusters::by_bone(&clusters);
        let mut offsets = vec![0_u32; mesh.points.len() + 1];
        for &vertex in mesh.triangles.iter().flatten() {
            offsets[vertex as usize + 1] += 1;
        }
        for vertex in 0..mesh.points.len() {
            offsets[vertex + 1] += offsets[vertex];
        }
        let (mut next, mut around) = (offsets.clone(), vec![[0; 2]; 3 * mesh.triangles.len()]);
        for &[a, b, c] in mesh.triangles {
            for (vertex, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                around[next[vertex as usize] as usize] = others;
                next[vertex as usize] += 1;
            }
        }
        Self {
            reaches_m,
            facing,
            faced,
            bones,
            cluster_of: clusters::cluster_of(&clusters, mesh.points.len()),
            clusters,
            rest: mesh.points.iter().map(|point| point.as_vec3a()).collect(),
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

    /// The other two corners of each triangle at a vertex.
    fn around(&self, vertex: usize) -> &[[u32; 2]] {
        &self.around[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }
}

/// The buffers of a frame.
#[derive(Debug)]
pub(super) struct ContactFrame {
    pairs: Vec<Pair>,
    posed: Vec<PosedCluster>,
    bones: Vec<PosedBone>,
    /// Whether any skin of each cluster that faces another is relaxed.
    relaxed: Vec<bool>,
    /// Whether skin of each cluster was pushed in the pass before.
    is_pushed: Vec<bool>,
    /// Whether a pair with each cluster was come across.
    is_listed: Vec<bool>,
    boxes: Boxes,
    close: Vec<Close>,
    /// Vertices of the parts that may meet and around them, and whether each vertex is one of them.
    placed: Vec<u32>,
    is_placed: Vec<bool>,
    places: Vec<Vec3A>,
    fours: Fours,
    /// The places of those that were placed last.
    fresh: Vec<Vec3A>,
    /// Largest share of its way that each vertex goes.
    most: Vec<f32>,
    meetings: Meetings,
    spread: Spread,
    /// How far each vertex is moved in this frame, m.
    shift: Vec<Vec3A>,
    /// The vertices that are moved in this frame, and those of the frame before.
    pub shifted: Vec<u32>,
    shifted_before: Vec<u32>,
}

impl ContactFrame {
    pub fn new(contact: &Contact) -> Self {
        let vertices = contact.rest.len();
        Self {
            pairs: vec![],
            posed: vec![PosedCluster::default(); contact.clusters.len()],
            bones: Vec::with_capacity(contact.bones.len()),
            relaxed: vec![false; contact.clusters.len()],
            is_pushed: vec![false; contact.clusters.len()],
            is_listed: vec![false; contact.clusters.len()],
            boxes: Boxes::new(contact.clusters.len()),
            close: vec![],
            placed: vec![],
            is_placed: vec![false; vertices],
            places: vec![Vec3A::ZERO; vertices],
            fours: Fours::new(&contact.clusters),
            fresh: vec![],
            most: vec![1.0; vertices],
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
        contact.find_pairs(
            palette,
            is_relaxed,
            &mut self.relaxed,
            &mut self.posed,
            &mut self.bones,
            &mut self.pairs,
        );
        for &vertex in &self.placed {
            self.is_placed[vertex as usize] = false;
            self.most[vertex as usize] = 1.0;
        }
        self.placed.clear();
        self.place(contact, |cluster| cluster.vertices.clone(), &place_of);
        for pass in 0..PASSES {
            if pass > 0 {
                self.keep_pushed(contact);
            }
            self.boxes.find_close(
                contact,
                &self.posed,
                &self.places,
                &mut self.pairs,
                &mut self.close,
            );
            if pass == 0 {
                self.place(contact, Cluster::with_corners, &place_of);
            }
            for own in self.close.chunk_by(|a, b| a.cluster == b.cluster) {
                let cluster = own[0].cluster;
                let vertices = contact.clusters[cluster as usize].vertices.clone();
                self.fours.set(cluster, &self.places[vertices]);
            }
            let skin = meeting::PosedSkin {
                places: &self.places,
                fours: &self.fours,
                is_placed: &self.is_placed,
                clusters: &self.posed,
                most: &self.most,
            };
            self.meetings.find(contact, &self.close, &skin);
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

    /// Keeps the pairs of which either was pushed in the pass before: the others stand as they stood, and meet nothing.
    fn keep_pushed(&mut self, contact: &Contact) {
        self.is_pushed.fill(false);
        for (vertex, _) in self.spread.pushes() {
            if let Some(is_pushed) = self.is_pushed.get_mut(contact.cluster_of[vertex] as usize) {
                *is_pushed = true;
            }
        }
        let is_pushed = |cluster: u32| self.is_pushed[cluster as usize];
        self.pairs
            .retain(|pair| is_pushed(pair.one) || is_pushed(pair.other));
    }

    /// Finds the places of what `of` gives of each cluster in pairs, where they are not known yet.
    fn place<'a, Vertices: Iterator<Item = usize>>(
        &mut self,
        contact: &'a Contact,
        of: impl Fn(&'a Cluster) -> Vertices,
        place_of: &(impl Fn(usize) -> Vec3A + Sync),
    ) {
        let first = self.placed.len();
        self.is_listed.fill(false);
        for cluster in self.pairs.iter().flat_map(|pair| [pair.one, pair.other]) {
            if std::mem::replace(&mut self.is_listed[cluster as usize], true) {
                continue;
            }
            for vertex in of(&contact.clusters[cluster as usize]) {
                let is_placed = &mut self.is_placed[vertex];
                if !*is_placed {
                    *is_placed = true;
                    self.placed.push(vertex as u32);
                }
            }
        }
        let due = &self.placed[first..];
        self.fresh.resize(due.len(), Vec3A::ZERO);
        let work = self.fresh.par_iter_mut().zip(due).with_min_len(256);
        work.for_each(|(fresh, &vertex)| *fresh = place_of(vertex as usize));
        for (&vertex, &fresh) in due.iter().zip(&self.fresh) {
            self.places[vertex as usize] = fresh;
        }
    }
}
