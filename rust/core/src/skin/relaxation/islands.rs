//! Which joints must be relaxed together, and which of these islands have to be computed anew.

use crate::skin::dirty::Dirty;
use crate::skin::relaxation::elastic::ElasticJoint;

/// No island: the joint stands as at rest.
const INACTIVE: u32 = u32::MAX;

/// The islands of one frame.
#[derive(Debug)]
pub(crate) struct Islands {
    /// The first joint of the island of each joint.
    first: Vec<u32>,
    /// The same in the frame before.
    first_before: Vec<u32>,
    /// Whether each joint has to be computed anew.
    pub is_stale: Vec<bool>,
    open: Vec<u32>,
}

impl Islands {
    pub fn new(joints: usize) -> Self {
        Self {
            first: vec![INACTIVE; joints],
            first_before: vec![INACTIVE; joints],
            is_stale: vec![false; joints],
            open: Vec::with_capacity(joints),
        }
    }

    /// Groups the joints that are awake (`activity` above 0), and finds those whose island is not as in the frame before in
    /// the same buffers. A joint that fell asleep is stale, too.
    pub fn find(&mut self, joints: &[ElasticJoint], activity: &[f32], dirty: &Dirty) {
        std::mem::swap(&mut self.first, &mut self.first_before);
        self.first.fill(INACTIVE);
        self.is_stale.fill(false);
        for start in 0..joints.len() {
            if activity[start] == 0.0 || self.first[start] != INACTIVE {
                continue;
            }
            self.first[start] = start as u32;
            self.open.clear();
            self.open.push(start as u32);
            let mut next = 0;
            while let Some(&joint) = self.open.get(next) {
                next += 1;
                for &other in &joints[joint as usize].touching {
                    let at = other as usize;
                    if activity[at] > 0.0 && self.first[at] == INACTIVE {
                        self.first[at] = start as u32;
                        self.open.push(other);
                    }
                }
            }
            let has_moved = |joint: &ElasticJoint| dirty.any_of(&joint.bones, &joint.carriers);
            let is_other = |&joint: &u32| self.first_before[joint as usize] != start as u32;
            let size_before = self
                .first_before
                .iter()
                .filter(|&&first| first == start as u32)
                .count();
            let is_stale = size_before != self.open.len()
                || self.open.iter().any(is_other)
                || self.open.iter().any(|&joint| has_moved(&joints[joint as usize]));
            self.open
                .iter()
                .for_each(|&joint| self.is_stale[joint as usize] = is_stale);
        }
        for (joint, is_stale) in self.is_stale.iter_mut().enumerate() {
            *is_stale |= self.first[joint] == INACTIVE && self.first_before[joint] != INACTIVE;
        }
    }
}
