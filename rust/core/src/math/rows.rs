//! Lists of different lengths, stored one after another (compressed sparse rows).

use std::ops::Range;

use rayon::prelude::*;

/// Rows of one task of [`Rows::computed`].
const ROWS_OF_PART: usize = 512;

/// Rows of entries. Row `i` is `entries[offsets[i]..offsets[i + 1]]`; offsets are `u32` to halve their memory.
#[derive(Debug, Clone)]
pub(crate) struct Rows<T> {
    offsets: Vec<u32>,
    entries: Vec<T>,
}

impl<T> Rows<T> {
    /// One row for each item of `rows`, in order.
    pub fn from_rows<R: IntoIterator<Item = T>>(rows: impl IntoIterator<Item = R>) -> Self {
        let mut all = Self::default();
        rows.into_iter().for_each(|row| all.push(row));
        all
    }

    /// The entries of `pairs` (row, entry), sorted into `rows` rows. The entries of a row keep the order of the pairs.
    pub fn from_pairs(rows: usize, pairs: &[(u32, T)]) -> Self
    where
        T: Copy,
    {
        let mut counts = vec![0; rows];
        pairs.iter().for_each(|&(row, _)| counts[row as usize] += 1);
        let offsets = offsets_of(&counts);
        let mut next = offsets.clone();
        let mut entries: Vec<T> = pairs.iter().map(|&(_, entry)| entry).collect();
        for &(row, entry) in pairs {
            let slot = &mut next[row as usize];
            entries[*slot as usize] = entry;
            *slot += 1;
        }
        Self { offsets, entries }
    }

    /// As [`Rows::from_pairs`], each row in rising order and without repetitions.
    pub fn from_set(rows: usize, pairs: Vec<(u32, T)>) -> Self
    where
        T: Copy + Ord,
    {
        let Self { offsets, mut entries } = Self::from_pairs(rows, &pairs);
        let mut set = Self::default();
        for ends in offsets.windows(2) {
            let row = &mut entries[ends[0] as usize..ends[1] as usize];
            row.sort_unstable();
            set.push(row.chunk_by(|one, next| one == next).map(|equal| equal[0]));
        }
        set
    }

    /// `rows` rows, computed in parallel: `write` appends the entries of a row to its last argument. `scratch` makes
    /// the buffers of a thread.
    pub fn computed<S>(
        rows: usize,
        scratch: impl Fn() -> S + Send + Sync,
        write: impl Fn(&mut S, usize, &mut Vec<T>) + Sync,
    ) -> Self
    where
        T: Send,
    {
        let part = |scratch: &mut S, part: usize| {
            let mut found = Self::default();
            for row in part * ROWS_OF_PART..rows.min((part + 1) * ROWS_OF_PART) {
                write(scratch, row, &mut found.entries);
                found.offsets.push(found.entries.len() as u32);
            }
            found
        };
        let parts: Vec<Self> = (0..rows.div_ceil(ROWS_OF_PART))
            .into_par_iter()
            .map_init(scratch, part)
            .collect();
        let mut all = Self {
            offsets: Vec::with_capacity(rows + 1),
            entries: Vec::with_capacity(parts.iter().map(|part| part.entries.len()).sum()),
        };
        all.offsets.push(0);
        for part in parts {
            let first = all.entries.len() as u32;
            all.offsets
                .extend(part.offsets[1..].iter().map(|end| first + end));
            all.entries.extend(part.entries);
        }
        all
    }

    /// Appends a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = T>) {
        self.entries.extend(row);
        self.offsets.push(self.entries.len() as u32);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Where row `row` is in [`Rows::entries`].
    pub fn range(&self, row: usize) -> Range<usize> {
        self.offsets[row] as usize..self.offsets[row + 1] as usize
    }

    /// The entries of row `row`.
    pub fn row(&self, row: usize) -> &[T] {
        &self.entries[self.range(row)]
    }

    /// All rows, in order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[T]> {
        (0..self.len()).map(|row| self.row(row))
    }

    /// All entries, row after row.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }

    /// As [`Rows::entries`], without the rows.
    pub fn into_entries(self) -> Vec<T> {
        self.entries
    }

    /// Where each row starts in [`Rows::entries`], and the number of entries; one more than rows.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }
}

impl<A, B> Rows<(A, B)> {
    /// The first part of each entry in rows, and the second parts in the same order.
    pub fn unzip(self) -> (Rows<A>, Vec<B>) {
        let (entries, others) = self.entries.into_iter().unzip();
        let offsets = self.offsets;
        (Rows { offsets, entries }, others)
    }
}

/// No rows.
impl<T> Default for Rows<T> {
    fn default() -> Self {
        Self {
            offsets: vec![0],
            entries: vec![],
        }
    }
}

/// Where rows with these numbers of entries start, and their sum.
fn offsets_of(counts: &[u32]) -> Vec<u32> {
    let mut offsets = Vec::with_capacity(counts.len() + 1);
    offsets.push(0);
    offsets.extend(counts.iter().scan(0, |sum, count| {
        *sum += count;
        Some(*sum)
    }));
    offsets
}

#[cfg(test)]
mod tests {
    use super::Rows;

    #[test]
    fn rows_are_returned_as_they_were_pushed() {
        let rows = Rows::from_rows([vec![3, 1], vec![], vec![2]]);
        assert_eq!(rows.rows().collect::<Vec<_>>(), [&[3, 1][..], &[], &[2]]);
        assert_eq!(rows.offsets(), [0, 2, 2, 3]);
        assert_eq!(rows.entries(), [3, 1, 2]);
        assert_eq!(Rows::<u32>::default().len(), 0);
    }

    #[test]
    fn pairs_keep_their_order_within_a_row_and_a_set_is_sorted() {
        let pairs = vec![(2, 9), (0, 5), (2, 1), (0, 5), (2, 4)];
        let rows = Rows::from_pairs(3, &pairs);
        assert_eq!(rows.rows().collect::<Vec<_>>(), [&[5, 5][..], &[], &[9, 1, 4]]);
        let rows = Rows::from_set(3, pairs);
        assert_eq!(rows.rows().collect::<Vec<_>>(), [&[5][..], &[], &[1, 4, 9]]);
    }

    #[test]
    fn rows_are_computed_in_order() {
        let rows = Rows::computed(1300, || (), |(), row, entries| entries.extend(0..row % 3));
        assert_eq!(rows.len(), 1300);
        assert!(
            rows.rows()
                .enumerate()
                .all(|(row, entries)| entries.iter().copied().eq(0..row % 3))
        );
    }
}
