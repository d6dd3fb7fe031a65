//! Union-find: sets of connected items.

/// Disjoint sets of items. Each set is named by its smallest item.
#[derive(Debug)]
pub(crate) struct UnionFind(Vec<u32>);

impl UnionFind {
    /// `items` items, each in a set of one.
    pub fn new(items: usize) -> Self {
        Self((0..items as u32).collect())
    }

    /// The smallest item of the set that contains `item`.
    pub fn root(&mut self, mut item: u32) -> u32 {
        while self.0[item as usize] != item {
            let above = self.0[self.0[item as usize] as usize];
            self.0[item as usize] = above;
            item = above;
        }
        item
    }

    /// Joins the sets of two items.
    pub fn join(&mut self, one: u32, other: u32) {
        let (a, b) = (self.root(one), self.root(other));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// The smallest item of each item's set.
    pub fn roots(&mut self) -> Vec<u32> {
        (0..self.0.len() as u32).map(|item| self.root(item)).collect()
    }
}
