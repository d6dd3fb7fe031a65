//! Union-find: which items hang together.

/// Sets of items, each named by its least item.
#[derive(Debug)]
pub(crate) struct UnionFind(Vec<u32>);

impl UnionFind {
    /// `items` items, each a set of its own.
    pub fn new(items: usize) -> Self {
        Self((0..items as u32).collect())
    }

    /// The least item of the set that `item` is in.
    pub fn root(&mut self, mut item: u32) -> u32 {
        while self.0[item as usize] != item {
            let above = self.0[self.0[item as usize] as usize];
            self.0[item as usize] = above;
            item = above;
        }
        item
    }

    /// Makes one set of those that two items are in.
    pub fn join(&mut self, one: u32, other: u32) {
        let (a, b) = (self.root(one), self.root(other));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// The least item of the set of each item.
    pub fn roots(&mut self) -> Vec<u32> {
        (0..self.0.len() as u32).map(|item| self.root(item)).collect()
    }
}
