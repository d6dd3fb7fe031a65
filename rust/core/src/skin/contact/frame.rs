//! The contact of one frame.

use glam::Vec3A;
use rayon::prelude::*;

use crate::pose::Palette;
use crate::skin::contact::broadphase::{PosedBone, PosedCluster};
use crate::skin::contact::cluster::{Cluster, Pair};
use crate::skin::contact::contact::Contact;
use crate::skin::contact::midphase::{Boxes, Close};
use crate::skin::contact::narrowphase;
use crate::skin::contact::narrowphase::ContactPoints;
use crate::skin::contact::points_soa::PointsSoa;
use crate::skin::contact::response::ContactResponse;

/// Times that the skin is looked at and moved apart.
const PASSES: usize = 3;

/// The buffers of a frame.
#[derive(Debug)]
pub(crate) struct ContactFrame {
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
    fours: PointsSoa,
    /// The places of those that were placed last.
    fresh: Vec<Vec3A>,
    /// Largest share of its way that each vertex goes.
    most: Vec<f32>,
    meetings: ContactPoints,
    response: ContactResponse,
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
            fours: PointsSoa::new(&contact.clusters),
            fresh: vec![],
            most: vec![1.0; vertices],
            meetings: ContactPoints::default(),
            response: ContactResponse::new(vertices),
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

    /// The vertices that are moved, and how far each vertex is moved.
    pub fn moved(&mut self) -> (&[u32], &mut [Vec3A]) {
        (&self.shifted, &mut self.shift)
    }

    /// Moves apart what meets in a pose; `is_relaxed` says whether the elastic skin moves a vertex,
    /// `place_of` where it lies before contact, m, armature space.
    pub fn resolve(
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
            let skin = narrowphase::PosedSkin {
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
            self.response.spread(contact, &self.meetings);
            for (vertex, push) in self.response.pushes() {
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
        for (vertex, _) in self.response.pushes() {
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
