//! Groups joints whose patches touch into islands, and finds the islands that must be computed again
//! (mathematics/relaxation.md, Islands).

use crate::skin::dirty::Dirty;
use crate::skin::relaxation::elastic::ElasticJoint;

/// Island of a joint in its rest pose.
const INACTIVE: u32 = u32::MAX;

/// The islands of one frame. An island is named by its first joint.
#[derive(Debug)]
pub(crate) struct Islands {
    /// The island of each joint.
    island: Vec<u32>,
    /// The island of each joint in the frame before.
    previous: Vec<u32>,
    /// Whether each joint must be computed again.
    pub is_dirty: Vec<bool>,
    queue: Vec<u32>,
}

impl Islands {
    pub fn new(joints: usize) -> Self {
        Self {
            island: vec![INACTIVE; joints],
            previous: vec![INACTIVE; joints],
            is_dirty: vec![false; joints],
            queue: Vec::with_capacity(joints),
        }
    }

    /// Groups the active joints (`activity` above 0) and finds the dirty ones: those whose island differs
    /// from the frame before in the same buffers, and those that became inactive.
    pub fn find(&mut self, joints: &[ElasticJoint], activity: &[f32], dirty: &Dirty) {
        std::mem::swap(&mut self.island, &mut self.previous);
        self.island.fill(INACTIVE);
        self.is_dirty.fill(false);
        for start in 0..joints.len() {
            if activity[start] == 0.0 || self.island[start] != INACTIVE {
                continue;
            }
            self.island[start] = start as u32;
            self.queue.clear();
            self.queue.push(start as u32);
            let mut next = 0;
            while let Some(&joint) = self.queue.get(next) {
                next += 1;
                for &other in &joints[joint as usize].touching {
                    let at = other as usize;
                    if activity[at] > 0.0 && self.island[at] == INACTIVE {
                        self.island[at] = start as u32;
                        self.queue.push(other);
                    }
                }
            }
            let has_moved = |joint: &ElasticJoint| dirty.any_of(&joint.bones, &joint.carriers);
            let is_other = |&joint: &u32| self.previous[joint as usize] != start as u32;
            let size_before = self
                .previous
                .iter()
                .filter(|&&island| island == start as u32)
                .count();
            let is_dirty = size_before != self.queue.len()
                || self.queue.iter().any(is_other)
                || self.queue.iter().any(|&joint| has_moved(&joints[joint as usize]));
            self.queue
                .iter()
                .for_each(|&joint| self.is_dirty[joint as usize] = is_dirty);
        }
        for (joint, is_dirty) in self.is_dirty.iter_mut().enumerate() {
            *is_dirty |= self.island[joint] == INACTIVE && self.previous[joint] != INACTIVE;
        }
    }
}
