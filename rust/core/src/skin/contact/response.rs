//! How a push goes on into the skin around it: smoothly over some rings of neighbours, never less than what was pushed.

use glam::Vec3A;

use crate::skin::contact::contact::Contact;
use crate::skin::contact::narrowphase::{ClosestPoint, ContactPoints};

/// Rings of neighbours that a push reaches, and rounds of smoothing.
const RINGS: usize = 5;

/// Share of a corner in the point of its triangle that is pushed, from which it is pushed fully: that of each in the middle.
const FULL_SHARE: f32 = 1.0 / 3.0;

/// How far what skin pushes off pushes a vertex itself: the corner of a wide triangle may lie clear of the finger that dips
/// into its middle.
#[derive(Debug, Clone, Copy, Default)]
struct PushedBack {
    /// The pushes, by `weight`: the farther, and the nearer to the corner, the more.
    sum: Vec3A,
    weight: f32,
    /// The largest share of the corner in any of them.
    share: f32,
}

impl PushedBack {
    fn add(&mut self, push: Vec3A, share: f32) {
        let weight = share * push.length();
        self.sum += push * weight;
        self.weight += weight;
        self.share = self.share.max(share);
    }

    /// Smooth as a place that is pushed moves into the triangles around the corner and out of them.
    fn push(self) -> Vec3A {
        if self.weight == 0.0 {
            return Vec3A::ZERO;
        }
        self.sum * ((self.share / FULL_SHARE).min(1.0) / self.weight)
    }
}

/// The pushes of one pass.
#[derive(Debug)]
pub(crate) struct ContactResponse {
    /// What each vertex must go at least.
    wanted: Vec<Vec3A>,
    pushed_back: Vec<PushedBack>,
    push: Vec<Vec3A>,
    next: Vec<Vec3A>,
    /// Vertices that are pushed, ring after ring.
    reached: Vec<u32>,
    is_reached: Vec<bool>,
}

impl ContactResponse {
    pub fn new(vertices: usize) -> Self {
        Self {
            wanted: vec![Vec3A::ZERO; vertices],
            pushed_back: vec![PushedBack::default(); vertices],
            push: vec![Vec3A::ZERO; vertices],
            next: vec![Vec3A::ZERO; vertices],
            reached: vec![],
            is_reached: vec![false; vertices],
        }
    }

    /// The vertices that are pushed, and how far.
    pub fn pushes(&self) -> impl Iterator<Item = (usize, Vec3A)> {
        let reached = self.reached.iter().map(|&vertex| vertex as usize);
        reached.map(|vertex| (vertex, self.push[vertex]))
    }

    /// Finds what each vertex must go at least: those that meet other skin, and the corners of the triangles that they meet.
    fn want(&mut self, contact: &Contact, meetings: &ContactPoints) {
        for meeting in meetings.iter() {
            self.reach(meeting.vertex);
            let ClosestPoint { corners, shares } = meeting.closest;
            for (corner, share) in corners.into_iter().zip(shares).filter(|(_, share)| *share > 0.0) {
                self.reach(corner);
                self.pushed_back[corner as usize].add(-meeting.push, share);
            }
        }
        for &vertex in &self.reached {
            let vertex = vertex as usize;
            self.wanted[vertex] = self.pushed_back[vertex].push() * contact.strength[vertex];
        }
        for meeting in meetings.iter() {
            let vertex = meeting.vertex as usize;
            self.wanted[vertex] = at_least(self.wanted[vertex], meeting.push * contact.strength[vertex]);
        }
        for &vertex in &self.reached {
            self.push[vertex as usize] = self.wanted[vertex as usize];
        }
    }

    fn reach(&mut self, vertex: u32) {
        let is_reached = &mut self.is_reached[vertex as usize];
        if !*is_reached {
            *is_reached = true;
            self.reached.push(vertex);
        }
    }

    /// Spreads the pushes of `meetings` over the skin around them.
    pub fn spread(&mut self, contact: &Contact, meetings: &ContactPoints) {
        for &vertex in &self.reached {
            let vertex = vertex as usize;
            self.wanted[vertex] = Vec3A::ZERO;
            self.pushed_back[vertex] = PushedBack::default();
            self.push[vertex] = Vec3A::ZERO;
            self.next[vertex] = Vec3A::ZERO;
            self.is_reached[vertex] = false;
        }
        self.reached.clear();
        self.want(contact, meetings);
        let mut first = 0;
        for _ in 0..RINGS {
            let last = self.reached.len();
            for index in first..last {
                for &neighbour in contact.edges.neighbours(self.reached[index] as usize) {
                    let at = neighbour as usize;
                    if !self.is_reached[at] {
                        self.is_reached[at] = true;
                        self.reached.push(neighbour);
                    }
                }
            }
            first = last;
        }
        for _ in 0..RINGS {
            for &vertex in &self.reached {
                let vertex = vertex as usize;
                let neighbours = contact.edges.neighbours(vertex);
                let sum: Vec3A = neighbours
                    .iter()
                    .map(|&neighbour| self.push[neighbour as usize])
                    .sum();
                let mean = (sum + self.push[vertex]) / (neighbours.len() as f32 + 1.0);
                self.next[vertex] = at_least(mean, self.wanted[vertex]);
            }
            for &vertex in &self.reached {
                self.push[vertex as usize] = self.next[vertex as usize];
            }
        }
    }
}

/// `push`, with what it lacks along `wanted` added.
fn at_least(push: Vec3A, wanted: Vec3A) -> Vec3A {
    let square = wanted.length_squared();
    if square == 0.0 {
        return push;
    }
    let lacking = 1.0 - push.dot(wanted) / square;
    push + wanted * lacking.max(0.0)
}
