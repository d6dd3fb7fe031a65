//! The edges of triangles, the inner edges between two of them, and the boundary loops.

use std::collections::HashMap;

/// An edge that exactly two triangles share.
#[derive(Debug, Clone, Copy)]
pub(super) struct InnerEdge {
    /// Its ends, in the direction of the first triangle.
    pub ends: [u32; 2],
    /// The indices of the two triangles.
    pub faces: [u32; 2],
}

/// The directed edges of all triangles: the first edge of each, then all second edges, then all third.
fn half_edges(triangles: &[[u32; 3]]) -> impl Iterator<Item = ([u32; 2], u32)> {
    (0..3).flat_map(move |corner| {
        let numbered = triangles.iter().enumerate();
        numbered.map(move |(face, triangle)| ([triangle[corner], triangle[(corner + 1) % 3]], face as u32))
    })
}

fn undirected([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Each edge once, sorted, the lower end first.
pub(super) fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<_> = half_edges(triangles).map(|(edge, _)| undirected(edge)).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// The edges that exactly two triangles share, without boundary edges and edges of three and more.
pub(super) fn inner_edges(triangles: &[[u32; 3]]) -> Vec<InnerEdge> {
    let mut sorted: Vec<_> = half_edges(triangles).collect();
    sorted.sort_by_key(|&(edge, _)| undirected(edge)); // stable, so that the first face is the same on any machine
    let same = |a: &([u32; 2], u32), b: &([u32; 2], u32)| undirected(a.0) == undirected(b.0);
    let pairs = sorted.chunk_by(same).filter(|shared| shared.len() == 2);
    let edge = |shared: &[([u32; 2], u32)]| InnerEdge {
        ends: shared[0].0,
        faces: [shared[0].1, shared[1].1],
    };
    pairs.map(edge).collect()
}

/// The boundary loops: loops of vertices along the directed edges that no triangle has in the opposite
/// direction.
///
/// Where several loops meet in a vertex, the split is arbitrary. If faces are not oriented consistently, a
/// loop may be open.
pub(super) fn boundary_loops(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut present: Vec<[u32; 2]> = half_edges(triangles).map(|(edge, _)| edge).collect();
    present.sort_unstable();
    let mut starts = vec![];
    let mut ends_of: HashMap<u32, Vec<u32>> = HashMap::new();
    for ([start, end], _) in half_edges(triangles) {
        if present.binary_search(&[end, start]).is_err() {
            let ends = ends_of.entry(start).or_default();
            if ends.is_empty() {
                starts.push(start);
            }
            ends.push(end);
        }
    }
    let mut loops = vec![];
    for start in starts {
        while ends_of.contains_key(&start) {
            loops.push(walk(start, &mut ends_of));
        }
    }
    loops
}

/// One loop from `start`. Removes its edges.
fn walk(start: u32, ends_of: &mut HashMap<u32, Vec<u32>>) -> Vec<u32> {
    let (mut vertex, mut along) = (start, vec![]);
    while let Some(ends) = ends_of.get_mut(&vertex) {
        along.push(vertex);
        let next = ends.pop();
        if ends.is_empty() {
            ends_of.remove(&vertex);
        }
        match next {
            Some(next) => vertex = next,
            None => break,
        }
    }
    along
}

/// The largest part of `faces` that is connected over their inner edges, sorted; the first of equal ones.
pub(super) fn largest_component(faces: &[u32], triangles: &[[u32; 3]]) -> Vec<u32> {
    let chosen: Vec<[u32; 3]> = faces.iter().map(|&face| triangles[face as usize]).collect();
    let mut neighbours = vec![vec![]; chosen.len()];
    for InnerEdge { faces: [a, b], .. } in inner_edges(&chosen) {
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(a);
    }
    let (mut is_seen, mut largest) = (vec![false; chosen.len()], vec![]);
    for first in 0..chosen.len() {
        if is_seen[first] {
            continue;
        }
        is_seen[first] = true;
        let mut part = vec![first as u32];
        let mut at = 0;
        while at < part.len() {
            for &beside in &neighbours[part[at] as usize] {
                if !std::mem::replace(&mut is_seen[beside as usize], true) {
                    part.push(beside);
                }
            }
            at += 1;
        }
        if part.len() > largest.len() {
            largest = part;
        }
    }
    largest.sort_unstable();
    largest.into_iter().map(|index| faces[index as usize]).collect()
}
