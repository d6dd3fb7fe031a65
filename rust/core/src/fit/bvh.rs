//! A bounding volume hierarchy for rays and nearest points.
//! (docs/mathematics/fitting.md, Fit under the skin)
//!
//! No crate fits: `bvh` 0.13 needs a newer Rust and breaks ties by its layout; `parry3d-f64` 0.31 adds a second glam and eleven
//! more crates, and its triangle meshes do not support polygons. Here a box only serves to skip items. It is rounded outward,
//! so the result of a query depends neither on the order of the items nor on the splits of the tree, and has the same bits for
//! any number of threads.

use glam::DVec3;

use super::triangle::Ray;

/// Largest number of items in a leaf.
const LARGEST_LEAF: usize = 2;
/// Nodes deeper than this are split by number, not by position, so that the depth is bounded for any input.
const DEEPEST_BY_POSITION: usize = 48;
/// Depth of the deepest node: one more level for each halving of 2^32 items.
const DEEPEST: usize = DEEPEST_BY_POSITION + 32;
/// Smallest number of items that are worth another thread.
const FEWEST_FOR_THREADS: usize = 16_384;
/// Relative rounding error of a distance along a ray (T. Ize, "Robust BVH Ray Traversal", 2013).
const ROUNDING: f64 = 1e-15;

/// An axis-aligned box, rounded outward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aabb {
    low: [f32; 3],
    high: [f32; 3],
}

/// A node. The nodes of its first half follow it; those of its second half start `first_or_second` entries after it.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    /// The first item of a leaf; otherwise the number of entries from this node to its second half.
    first_or_second: u32,
    /// Number of items of a leaf; 0 for a node that is split.
    count: u32,
}

#[derive(Debug, Clone, Copy)]
struct Item {
    centre: [f32; 3],
    /// Index in the input of [`Bvh::new`].
    index: u32,
}

/// The tree. Queries number items by their position in the second result of [`Bvh::new`].
#[derive(Debug, Clone, Default)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
}

impl Aabb {
    const EMPTY: Self = Self {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    /// The smallest box around some points.
    pub(super) fn around(points: impl Iterator<Item = DVec3>) -> Self {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for point in points {
            low = low.min(point);
            high = high.max(point);
        }
        Self {
            low: low.to_array().map(rounded_down),
            high: high.to_array().map(|number| -rounded_down(-number)),
        }
    }

    fn joined(&self, other: &Self) -> Self {
        let mut union = *self;
        for axis in 0..3 {
            union.low[axis] = union.low[axis].min(other.low[axis]);
            union.high[axis] = union.high[axis].max(other.high[axis]);
        }
        union
    }

    fn centre(&self) -> [f32; 3] {
        [0, 1, 2].map(|axis| 0.5 * self.low[axis] + 0.5 * self.high[axis])
    }

    /// The distance along a ray at which it enters the box; `None` if it misses the box or enters beyond `farthest`.
    fn entry(&self, ray: &Ray, farthest: f64) -> Option<f64> {
        let (mut enter, mut leave) = (0.0_f64, farthest);
        for axis in 0..3 {
            let to_low = (f64::from(self.low[axis]) - ray.origin[axis]) * ray.inverse[axis];
            let to_high = (f64::from(self.high[axis]) - ray.origin[axis]) * ray.inverse[axis];
            enter = enter.max(to_low.min(to_high));
            leave = leave.min(to_low.max(to_high) * (1.0 + ROUNDING));
        }
        (enter <= leave).then_some(enter)
    }

    /// The squared distance of a point to the box, m², at most that to anything in it.
    fn distance_squared(&self, point: DVec3) -> f64 {
        let mut sum = 0.0;
        for axis in 0..3 {
            let outside =
                (f64::from(self.low[axis]) - point[axis]).max(point[axis] - f64::from(self.high[axis]));
            sum += outside.max(0.0) * outside.max(0.0);
        }
        sum * (1.0 - 8.0 * ROUNDING)
    }
}

/// The largest f32 that is at most `number`.
fn rounded_down(number: f64) -> f32 {
    let rounded = number as f32;
    if f64::from(rounded) > number {
        rounded.next_down()
    } else {
        rounded
    }
}

impl Bvh {
    /// The tree of items with these bounds, and for each item of the tree its index in `bounds`.
    pub(super) fn new(bounds: &[Aabb]) -> (Self, Vec<u32>) {
        let mut items: Vec<Item> = bounds
            .iter()
            .zip(0..)
            .map(|(bounds, index)| Item {
                centre: bounds.centre(),
                index,
            })
            .collect();
        let mut nodes = Vec::with_capacity(bounds.len());
        if !items.is_empty() {
            build(&mut items, bounds, 0, 0, &mut nodes);
        }
        let order = items.iter().map(|item| item.index).collect();
        (Self { nodes }, order)
    }

    /// Calls `visit` with the items whose boxes a ray hits, those in nearer boxes first. `visit` gets and returns the distance
    /// along the ray up to which the search continues.
    pub(super) fn along(&self, ray: &Ray, visit: impl FnMut(usize, f64) -> f64) {
        self.search(|bounds, farthest| bounds.entry(ray, farthest), visit);
    }

    /// Calls `visit` with the items whose boxes can contain the point nearest to `point`, those in nearer boxes first. `visit`
    /// gets and returns the squared distance up to which the search continues, m².
    pub(super) fn around(&self, point: DVec3, visit: impl FnMut(usize, f64) -> f64) {
        let distance = |bounds: &Aabb, farthest: f64| {
            let squared = bounds.distance_squared(point);
            (squared <= farthest).then_some(squared)
        };
        self.search(distance, visit);
    }

    fn search(&self, nearness: impl Fn(&Aabb, f64) -> Option<f64>, mut visit: impl FnMut(usize, f64) -> f64) {
        let mut farthest = f64::INFINITY;
        let mut waiting = [(0.0, 0_usize); DEEPEST];
        let mut depth = 0;
        let mut next = self
            .nodes
            .first()
            .and_then(|root| nearness(&root.bounds, farthest))
            .map(|near| (near, 0));
        while let Some((near, index)) = next {
            let node = &self.nodes[index];
            if near > farthest {
                // something nearer has been found in the meantime
            } else if node.count > 0 {
                let first = node.first_or_second as usize;
                for item in first..first + node.count as usize {
                    farthest = visit(item, farthest);
                }
            } else {
                let (left, right) = (index + 1, index + node.first_or_second as usize);
                let near =
                    |index: usize| nearness(&self.nodes[index].bounds, farthest).map(|near| (near, index));
                match (near(left), near(right)) {
                    (Some(first), Some(second)) => {
                        let (nearer, farther) = if first.0 <= second.0 {
                            (first, second)
                        } else {
                            (second, first)
                        };
                        waiting[depth] = farther;
                        depth += 1;
                        next = Some(nearer);
                        continue;
                    }
                    (Some(only), None) | (None, Some(only)) => {
                        next = Some(only);
                        continue;
                    }
                    (None, None) => {}
                }
            }
            next = depth.checked_sub(1).map(|last| {
                depth = last;
                waiting[last]
            });
        }
    }
}

/// Adds the nodes of some items, the first of which is number `first`, to `nodes`; sorts the items into the order of the tree.
fn build(items: &mut [Item], bounds: &[Aabb], first: usize, depth: usize, nodes: &mut Vec<Node>) {
    if items.len() <= LARGEST_LEAF {
        let around = |sum: Aabb, item: &Item| sum.joined(&bounds[item.index as usize]);
        nodes.push(Node {
            bounds: items.iter().fold(Aabb::EMPTY, around),
            first_or_second: first as u32,
            count: items.len() as u32,
        });
        return;
    }
    let middle = split(items, depth);
    let node = nodes.len();
    nodes.push(Node {
        bounds: Aabb::EMPTY,
        first_or_second: 0,
        count: 0,
    });
    let is_large = items.len() >= FEWEST_FOR_THREADS;
    let (left, right) = items.split_at_mut(middle);
    let second = if is_large {
        let mut second_half = Vec::with_capacity(right.len());
        rayon::join(
            || build(left, bounds, first, depth + 1, nodes),
            || build(right, bounds, first + middle, depth + 1, &mut second_half),
        );
        let second = nodes.len();
        nodes.append(&mut second_half);
        second
    } else {
        build(left, bounds, first, depth + 1, nodes);
        let second = nodes.len();
        build(right, bounds, first + middle, depth + 1, nodes);
        second
    };
    nodes[node].bounds = nodes[node + 1].bounds.joined(&nodes[second].bounds);
    nodes[node].first_or_second = (second - node) as u32;
}

/// Sorts items to both sides of the middle of their extent, along its longest axis; returns the number on the first side.
fn split(items: &mut [Item], depth: usize) -> usize {
    let half = items.len() / 2;
    if depth >= DEEPEST_BY_POSITION {
        return half;
    }
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in items.iter() {
        for axis in 0..3 {
            low[axis] = low[axis].min(item.centre[axis]);
            high[axis] = high[axis].max(item.centre[axis]);
        }
    }
    let extent = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let longest = |best: usize, axis: usize| if extent[axis] > extent[best] { axis } else { best };
    let axis = [1, 2].into_iter().fold(0, longest);
    let middle = 0.5 * low[axis] + 0.5 * high[axis];
    let mut count = 0;
    for index in 0..items.len() {
        if items[index].centre[axis] < middle {
            items.swap(index, count);
            count += 1;
        }
    }
    if count == 0 || count == items.len() {
        half
    } else {
        count
    }
}
