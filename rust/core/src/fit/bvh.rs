//! A hierarchy of boxes: which of many things a ray, or the surroundings of a point, can meet.
//!
//! Own, because no crate fits: `bvh` 0.13 needs a newer Rust than ours and breaks ties by its own layout, and `parry3d-f64`
//! 0.31 brings a second glam and eleven more crates for its triangle meshes, which know no polygons. Here a box is only a
//! reason to skip something. It is rounded outward, so what a query finds depends neither on the order of the things nor on
//! how the tree was split, and is the same bits on any number of threads.

use glam::DVec3;

use super::triangle::Ray;

/// Most things in a box that is not split further.
const LARGEST_LEAF: usize = 2;
/// Boxes as deep as this are split by number, so that the depth is bounded for any input.
const DEEPEST_BY_PLACE: usize = 48;
/// Deepest box: one more level for each halving of 2^32 things.
const DEEPEST: usize = DEEPEST_BY_PLACE + 32;
/// Fewest things that are worth another thread.
const FEWEST_FOR_THREADS: usize = 16_384;
/// What rounding may take from a distance along a ray (T. Ize, "Robust BVH Ray Traversal", 2013).
const ROUNDING: f64 = 1e-15;

/// An axis-aligned box, rounded outward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aabb {
    low: [f32; 3],
    high: [f32; 3],
}

/// A box, followed by the boxes of its first half; those of its second half start `second` entries on.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    /// Of a leaf its first thing, else how far on the second half starts.
    first_or_second: u32,
    /// How many things a leaf holds; 0 where the box is split.
    count: u32,
}

#[derive(Debug, Clone, Copy)]
struct Item {
    centre: [f32; 3],
    thing: u32,
}

/// The tree. Queries number things by their place in [`Bvh::new`]'s second result.
#[derive(Debug, Clone, Default)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
}

impl Aabb {
    const EMPTY: Self = Self {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    /// The box around some points.
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
        let mut made = *self;
        for axis in 0..3 {
            made.low[axis] = made.low[axis].min(other.low[axis]);
            made.high[axis] = made.high[axis].max(other.high[axis]);
        }
        made
    }

    fn centre(&self) -> [f32; 3] {
        [0, 1, 2].map(|axis| 0.5 * self.low[axis] + 0.5 * self.high[axis])
    }

    /// How far along a ray the box starts; `None` where the ray misses it, or meets it beyond `farthest`.
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

    /// The square of a point's distance to the box, m², never above that to anything in it.
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

/// The largest f32 that is not above a number.
fn rounded_down(number: f64) -> f32 {
    let rounded = number as f32;
    if f64::from(rounded) > number {
        rounded.next_down()
    } else {
        rounded
    }
}

impl Bvh {
    /// The tree of `bounds`, and the order in which it numbers their things.
    pub(super) fn new(bounds: &[Aabb]) -> (Self, Vec<u32>) {
        let mut items: Vec<Item> = bounds
            .iter()
            .zip(0..)
            .map(|(own, thing)| Item {
                centre: own.centre(),
                thing,
            })
            .collect();
        let mut nodes = Vec::with_capacity(bounds.len());
        if !items.is_empty() {
            build(&mut items, bounds, 0, 0, &mut nodes);
        }
        let order = items.iter().map(|item| item.thing).collect();
        (Self { nodes }, order)
    }

    /// Calls `visit` with the things whose boxes a ray meets, those in nearer boxes first. `visit` gets and returns how far
    /// along the ray it still looks.
    pub(super) fn along(&self, ray: &Ray, visit: impl FnMut(usize, f64) -> f64) {
        self.search(|bounds, farthest| bounds.entry(ray, farthest), visit);
    }

    /// Calls `visit` with the things in whose boxes the nearest to `point` can be, those in nearer boxes first. `visit` gets
    /// and returns the square of the distance up to which it still looks, m².
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
        while let Some((near, place)) = next {
            let node = &self.nodes[place];
            if near > farthest {
                // something nearer was found since
            } else if node.count > 0 {
                let first = node.first_or_second as usize;
                for thing in first..first + node.count as usize {
                    farthest = visit(thing, farthest);
                }
            } else {
                let (left, right) = (place + 1, place + node.first_or_second as usize);
                let near =
                    |place: usize| nearness(&self.nodes[place].bounds, farthest).map(|near| (near, place));
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

/// Adds the boxes of some items, whose first is number `first`, to `nodes`; sorts the items into the tree's order.
fn build(items: &mut [Item], bounds: &[Aabb], first: usize, depth: usize, nodes: &mut Vec<Node>) {
    if items.len() <= LARGEST_LEAF {
        let around = |sum: Aabb, item: &Item| sum.joined(&bounds[item.thing as usize]);
        nodes.push(Node {
            bounds: items.iter().fold(Aabb::EMPTY, around),
            first_or_second: first as u32,
            count: items.len() as u32,
        });
        return;
    }
    let middle = split(items, depth);
    let own = nodes.len();
    nodes.push(Node {
        bounds: Aabb::EMPTY,
        first_or_second: 0,
        count: 0,
    });
    let is_large = items.len() >= FEWEST_FOR_THREADS;
    let (left, right) = items.split_at_mut(middle);
    let second = if is_large {
        let mut others = Vec::with_capacity(right.len());
        rayon::join(
            || build(left, bounds, first, depth + 1, nodes),
            || build(right, bounds, first + middle, depth + 1, &mut others),
        );
        let second = nodes.len();
        nodes.append(&mut others);
        second
    } else {
        build(left, bounds, first, depth + 1, nodes);
        let second = nodes.len();
        build(right, bounds, first + middle, depth + 1, nodes);
        second
    };
    nodes[own].bounds = nodes[own + 1].bounds.joined(&nodes[second].bounds);
    nodes[own].first_or_second = (second - own) as u32;
}

/// Sorts items to both sides of the middle of their extent along its longest axis; returns how many are on the first side.
fn split(items: &mut [Item], depth: usize) -> usize {
    let half = items.len() / 2;
    if depth >= DEEPEST_BY_PLACE {
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
    for place in 0..items.len() {
        if items[place].centre[axis] < middle {
            items.swap(place, count);
            count += 1;
        }
    }
    if count == 0 || count == items.len() {
        half
    } else {
        count
    }
}
