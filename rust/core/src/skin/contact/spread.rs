//! How a push goes on into the skin around it: smoothly over some rings of neighbours, never less than what was pushed.

use glam::Vec3A;

use super::Contact;
use super::meeting::Meetings;

/// Rings of neighbours that a push reaches, and rounds of smoothing.
const RINGS: usize = 5;

/// The pushes of one pass.
#[derive(Debug)]
pub(super) struct Spread {
    /// What each vertex must go at least.
    wanted: Vec<Vec3A>,
    push: Vec<Vec3A>,
    next: Vec<Vec3A>,
    /// Vertices that are pushed, ring after ring.
    reached: Vec<u32>,
    is_reached: Vec<bool>,
}

impl Spread {
    pub fn new(vertices: usize) -> Self {
        Self {
            wanted: vec![Vec3A::ZERO; vertices],
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

    /// Spreads the pushes of `meetings` over the skin around them.
    pub fn spread(&mut self, contact: &Contact, meetings: &Meetings) {
        for &vertex in &self.reached {
            let vertex = vertex as usize;
            self.wanted[vertex] = Vec3A::ZERO;
            self.push[vertex] = Vec3A::ZERO;
            self.next[vertex] = Vec3A::ZERO;
            self.is_reached[vertex] = false;
        }
        self.reached.clear();
        for meeting in meetings.iter() {
            let vertex = meeting.vertex as usize;
            self.wanted[vertex] = meeting.push;
            self.push[vertex] = meeting.push;
            if !self.is_reached[vertex] {
                self.is_reached[vertex] = true;
                self.reached.push(meeting.vertex);
            }
        }
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
