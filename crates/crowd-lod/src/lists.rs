//! A short list for each of many owners, all in one piece of memory: what a sort by owner gives, by counting.

use std::ops::Range;

/// The entries of owners 0, 1, 2, ..., one owner's after the other's.
#[derive(Debug, Clone)]
pub(crate) struct Lists<T> {
    /// Where each owner's entries begin, and where the last one's end.
    first: Vec<u32>,
    entries: Vec<T>,
}

impl<T: Copy + Default> Lists<T> {
    /// Hands each entry to its owner, one of `count`; those of one owner keep the order in which they come.
    pub fn fill(count: usize, entries: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut first = vec![0_u32; count + 1];
        for (owner, _) in entries.clone() {
            first[owner as usize + 1] += 1;
        }
        for owner in 1..first.len() {
            first[owner] += first[owner - 1];
        }
        let mut next = first.clone();
        let mut listed = vec![T::default(); first[count] as usize];
        for (owner, entry) in entries {
            let at = &mut next[owner as usize];
            listed[*at as usize] = entry;
            *at += 1;
        }
        Self { first, entries: listed }
    }

    /// Where an owner's entries lie among [`entries`](Self::entries).
    pub fn range(&self, owner: usize) -> Range<usize> {
        self.first[owner] as usize..self.first[owner + 1] as usize
    }

    /// The entries of an owner.
    pub fn at(&self, owner: usize) -> &[T] {
        &self.entries[self.range(owner)]
    }

    /// All entries, by owner.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }

    /// Sorts each owner's entries.
    pub fn sort_each(&mut self)
    where
        T: Ord,
    {
        for owner in 0..self.first.len() - 1 {
            let range = self.range(owner);
            self.entries[range].sort_unstable();
        }
    }

    /// Sorts each owner's entries and leaves out those that it has already.
    pub fn sort_and_dedup_each(&mut self)
    where
        T: Ord,
    {
        self.sort_each();
        let mut kept = 0;
        let mut begin = 0;
        for owner in 0..self.first.len() - 1 {
            let end = self.first[owner + 1] as usize;
            let of_owner = kept;
            for i in begin..end {
                let entry = self.entries[i];
                if kept == of_owner || self.entries[kept - 1] != entry {
                    self.entries[kept] = entry;
                    kept += 1;
                }
            }
            begin = end;
            self.first[owner + 1] = kept as u32;
        }
        self.entries.truncate(kept);
    }
}

impl Lists<u32> {
    /// For each of `count` owners (positions, variants), the triangles that have it at a corner, ascending.
    pub fn incident(count: usize, triangles: impl Iterator<Item = [u32; 3]> + Clone) -> Self {
        let corners = |(t, owners): (usize, [u32; 3])| owners.map(|owner| (owner, t as u32));
        Self::fill(count, triangles.enumerate().flat_map(corners))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENTRIES: [(u32, i32); 8] = [(3, 5), (0, 9), (3, 1), (0, 9), (4, -2), (3, 5), (0, 2), (3, 4)];

    fn lists(lists: &Lists<i32>) -> Vec<&[i32]> {
        (0..6).map(|owner| lists.at(owner)).collect()
    }

    #[test]
    fn owners_get_their_entries_in_the_order_they_came() {
        let filled = Lists::fill(6, ENTRIES.into_iter());
        assert_eq!(lists(&filled), [&[9, 9, 2][..], &[], &[], &[5, 1, 5, 4], &[-2], &[]]);
        assert_eq!(filled.entries(), [9, 9, 2, 5, 1, 5, 4, -2]);
        assert_eq!(filled.range(4), 7..8);
    }

    #[test]
    fn entries_are_sorted_and_said_once_within_an_owner_alone() {
        let mut sorted = Lists::fill(6, ENTRIES.into_iter());
        sorted.sort_each();
        assert_eq!(lists(&sorted), [&[2, 9, 9][..], &[], &[], &[1, 4, 5, 5], &[-2], &[]]);
        sorted.sort_and_dedup_each();
        assert_eq!(lists(&sorted), [&[2, 9][..], &[], &[], &[1, 4, 5], &[-2], &[]]);
        assert_eq!(sorted.entries(), [2, 9, 1, 4, 5, -2]);
        // The last of one owner and the first of the next may be equal.
        let mut equal = Lists::fill(2, [(0, 7), (1, 7), (1, 7)].into_iter());
        equal.sort_and_dedup_each();
        assert_eq!([equal.at(0), equal.at(1)], [[7], [7]]);
    }

    #[test]
    fn nobody_and_nothing_are_fine() {
        assert!(Lists::<u32>::fill(0, std::iter::empty()).entries().is_empty());
        assert!(Lists::<u32>::incident(2, std::iter::empty()).at(1).is_empty());
    }
}
