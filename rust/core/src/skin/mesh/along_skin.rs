//! Distances along the skin (E. W. Dijkstra, "A note on two problems in connexion with graphs", 1959).

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The distance of each of `vertices` vertices along the skin from the nearest of the `sources`, m; infinite from
/// `limit_m` on. `beside` gives the neighbours of a vertex, `step_m` the distance between two neighbours, m, and
/// `may_cross` whether a path may lead through a vertex.
pub(crate) fn distances_along_skin<'a>(
    vertices: usize,
    sources: impl IntoIterator<Item = u32>,
    limit_m: f64,
    beside: impl Fn(usize) -> &'a [u32],
    step_m: impl Fn(usize, usize) -> f64,
    may_cross: impl Fn(usize) -> bool,
) -> Vec<f64> {
    let mut along_m = vec![f64::INFINITY; vertices];
    let mut queue = BinaryHeap::new();
    for vertex in sources {
        along_m[vertex as usize] = 0.0;
        queue.push(Reached(0.0, vertex));
    }
    while let Some(Reached(reached_m, vertex)) = queue.pop() {
        let from = vertex as usize;
        if reached_m > along_m[from] {
            continue;
        }
        for &neighbour in beside(from) {
            let to = neighbour as usize;
            let next_m = reached_m + step_m(from, to);
            if next_m < along_m[to] && next_m < limit_m && may_cross(to) {
                along_m[to] = next_m;
                queue.push(Reached(next_m, neighbour));
            }
        }
    }
    along_m
}

/// A vertex and its distance along the skin, m. The nearest is the greatest, since the heap returns the
/// greatest first.
#[derive(PartialEq)]
struct Reached(f64, u32);

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
