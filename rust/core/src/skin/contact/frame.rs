//! The contact of one frame.

use glam::Vec3A;
use rayon::prelude::*;

use crate::pose::Palette;
use crate::skin::contact::broadphase::{PosedBone, PosedCluster};
use crate::skin::contact::cluster::{Cluster, Pair};
use crate::skin::contact::contact::Contact;
use crate::skin::contact::midphase::{Boxes, ClosePair};
use crate::skin::contact::narrowphase;
use crate::skin::contact::narrowphase::ContactPoints;
use crate::skin::contact::points_soa::PointsSoa;
use crate::skin::contact::response::ContactResponse;

/// Passes of finding contact and moving skin apart.
const PASSES: usize = 3;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct ContactFrame {
    pairs: Vec<Pair>,
    posed: Vec<PosedCluster>,
    bones: Vec<PosedBone>,
    /// Whether any skin of each cluster that faces another is relaxed.
    relaxed: Vec<bool>,
    /// Whether the last pass moved a vertex of each cluster.
    was_displaced: Vec<bool>,
    /// Whether a pair with each cluster was already listed.
    is_listed: Vec<bool>,
    boxes: Boxes,
    close: Vec<ClosePair>,
    /// Vertices that have a position in this frame.
    positioned: Vec<u32>,
    has_position: Vec<bool>,
    positions: Vec<Vec3A>,
    points_soa: PointsSoa,
    /// The positions that were found last.
    new_positions: Vec<Vec3A>,
    /// Largest fade of each vertex (see narrowphase.rs).
    max_fade: Vec<f32>,
    contact_points: ContactPoints,
    response: ContactResponse,
    /// Displacement of each vertex, m.
    shift: Vec<Vec3A>,
    /// The vertices that are displaced in this frame, and those of the frame before.
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
            was_displaced: vec![false; contact.clusters.len()],
            is_listed: vec![false; contact.clusters.len()],
            boxes: Boxes::new(contact.clusters.len()),
            close: vec![],
            positioned: vec![],
            has_position: vec![false; vertices],
            positions: vec![Vec3A::ZERO; vertices],
            points_soa: PointsSoa::new(&contact.clusters),
            new_positions: vec![],
            max_fade: vec![1.0; vertices],
            contact_points: ContactPoints::default(),
            response: ContactResponse::new(vertices),
            shift: vec![Vec3A::ZERO; vertices],
            shifted: vec![],
            shifted_before: vec![],
        }
    }

    /// Displacement of a vertex, m; `None` if it is not displaced.
    pub fn shift(&self, vertex: usize) -> Option<Vec3A> {
        let shift = self.shift[vertex];
        (shift != Vec3A::ZERO).then_some(shift)
    }

    /// Resolves contact in a pose. `is_relaxed` is whether relaxation moves a vertex. `position_of` gives the
    /// position before contact, m, armature space.
    pub fn resolve(
        &mut self,
        contact: &Contact,
        palette: &Palette,
        is_relaxed: impl Fn(usize) -> bool,
        position_of: impl Fn(usize) -> Vec3A + Sync,
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
        for &vertex in &self.positioned {
            self.has_position[vertex as usize] = false;
            self.max_fade[vertex as usize] = 1.0;
        }
        self.positioned.clear();
        self.find_positions(contact, |cluster| cluster.vertices.clone(), &position_of);
        for pass in 0..PASSES {
            if pass > 0 {
                self.keep_displaced(contact);
            }
            self.boxes.find_close(
                contact,
                &self.posed,
                &self.positions,
                &mut self.pairs,
                &mut self.close,
            );
            if pass == 0 {
                self.find_positions(contact, Cluster::with_corners, &position_of);
            }
            for pairs in self.close.chunk_by(|a, b| a.cluster == b.cluster) {
                let cluster = pairs[0].cluster;
                let vertices = contact.clusters[cluster as usize].vertices.clone();
                self.points_soa.set(cluster, &self.positions[vertices]);
            }
            let skin = narrowphase::PosedSkin {
                positions: &self.positions,
                points_soa: &self.points_soa,
                has_position: &self.has_position,
                clusters: &self.posed,
                max_fade: &self.max_fade,
            };
            self.contact_points.find(contact, &self.close, &skin);
            if self.contact_points.is_empty() {
                break;
            }
            if pass == 0 {
                for contact_point in self.contact_points.iter() {
                    self.max_fade[contact_point.vertex as usize] = contact_point.fade;
                }
            }
            self.response.spread(contact, &self.contact_points);
            for (vertex, displacement) in self.response.displacements() {
                self.positions[vertex] += displacement;
                if self.shift[vertex] == Vec3A::ZERO {
                    self.shifted.push(vertex as u32);
                }
                self.shift[vertex] += displacement;
            }
        }
    }

    /// Keeps the pairs in which a cluster moved in the last pass; the others have no new contact.
    fn keep_displaced(&mut self, contact: &Contact) {
        self.was_displaced.fill(false);
        for (vertex, _) in self.response.displacements() {
            if let Some(was_displaced) = self.was_displaced.get_mut(contact.cluster_of[vertex] as usize) {
                *was_displaced = true;
            }
        }
        let was_displaced = |cluster: u32| self.was_displaced[cluster as usize];
        self.pairs
            .retain(|pair| was_displaced(pair.one) || was_displaced(pair.other));
    }

    /// Finds the positions, unless known, of the vertices that `of` gives for each cluster in a pair.
    fn find_positions<'a, Vertices: Iterator<Item = usize>>(
        &mut self,
        contact: &'a Contact,
        of: impl Fn(&'a Cluster) -> Vertices,
        position_of: &(impl Fn(usize) -> Vec3A + Sync),
    ) {
        let first = self.positioned.len();
        self.is_listed.fill(false);
        for cluster in self.pairs.iter().flat_map(|pair| [pair.one, pair.other]) {
            if std::mem::replace(&mut self.is_listed[cluster as usize], true) {
                continue;
            }
            for vertex in of(&contact.clusters[cluster as usize]) {
                let has_position = &mut self.has_position[vertex];
                if !*has_position {
                    *has_position = true;
                    self.positioned.push(vertex as u32);
                }
            }
        }
        let new_vertices = &self.positioned[first..];
        self.new_positions.resize(new_vertices.len(), Vec3A::ZERO);
        let work = self
            .new_positions
            .par_iter_mut()
            .zip(new_vertices)
            .with_min_len(256);
        work.for_each(|(position, &vertex)| *position = position_of(vertex as usize));
        for (&vertex, &position) in new_vertices.iter().zip(&self.new_positions) {
            self.positions[vertex as usize] = position;
        }
    }
}
