//! Nodes and the matrices that vertices are bound to them by: which of them may be like another one, without a look at all.
//!
//! A file may bind one node by thousands of matrices. They are kept by one number each, a weighted sum of a matrix's numbers: those that differ
//! by little have sums that differ by little.

use glam::{DMat4, DVec3};
use std::collections::{BTreeMap, BTreeSet};

/// How far the columns of two matrices may lie apart to count as equal, as a share of their size.
const TOLERANCE: f64 = 1e-5;
/// Weights of the numbers of a matrix, column by column, in the sum: all different, so that matrices that differ have sums that differ.
const WEIGHTS: [DVec3; 4] = [
    DVec3::new(0.731, -0.413, 0.577),
    DVec3::new(-0.619, 0.887, 0.349),
    DVec3::new(0.467, 0.283, -0.953),
    DVec3::new(0.839, -0.677, 0.523),
];
/// What rounding may add to a sum, as a share of the matrix's size: generous.
const ROUNDING: f64 = 1e-12;

/// Bound nodes, each with an index of its own.
#[derive(Default)]
pub(super) struct BoundNodes {
    /// By node: the sum as ordered bits, and the index.
    on_node: BTreeMap<u32, BTreeSet<(u64, u32)>>,
}

impl BoundNodes {
    pub(super) fn insert(&mut self, node: u32, inverse_bind: &DMat4, index: u32) {
        self.on_node.entry(node).or_default().insert((ordered(weighted_sum(inverse_bind)), index));
    }

    pub(super) fn remove(&mut self, node: u32, inverse_bind: &DMat4, index: u32) {
        if let Some(on_node) = self.on_node.get_mut(&node) {
            on_node.remove(&(ordered(weighted_sum(inverse_bind)), index));
        }
    }

    /// Indices on a node, all of those among them whose matrices are [`are_equal`] to this one; in no order that means anything.
    pub(super) fn candidates(&self, node: u32, inverse_bind: &DMat4) -> impl Iterator<Item = u32> + '_ {
        let (linear, shift) = sizes(inverse_bind);
        let of_linear: f64 = WEIGHTS[..3].iter().map(|weights| weights.length()).sum();
        let of_shift = WEIGHTS[3].length();
        let reach = TOLERANCE * (of_linear * linear + of_shift * shift.max(linear)) + ROUNDING * (linear + shift);
        let sum = weighted_sum(inverse_bind);
        let (low, high) = (sum - reach, sum + reach);
        // Numbers beyond all numbers have no sum to go by.
        let range =
            if low.is_finite() && high.is_finite() { ordered(low)..=ordered(high) } else { u64::MIN..=u64::MAX };
        let on_node = self.on_node.get(&node).into_iter();
        on_node.flat_map(move |on_node| on_node.range((*range.start(), 0)..=(*range.end(), u32::MAX))).map(|at| at.1)
    }
}

/// Within 1e-5 of their size.
pub(super) fn are_equal(other: &DMat4, inverse_bind: &DMat4) -> bool {
    let (linear, shift) = sizes(inverse_bind);
    let off = (0..3).map(|c| (other.col(c) - inverse_bind.col(c)).truncate().length()).fold(0.0, f64::max);
    let off_shift = (other.w_axis - inverse_bind.w_axis).truncate().length();
    off <= TOLERANCE * linear && off_shift <= TOLERANCE * shift.max(linear)
}

/// The longest of the first three columns, and the length of the last.
fn sizes(inverse_bind: &DMat4) -> (f64, f64) {
    let linear = (0..3).map(|c| inverse_bind.col(c).truncate().length()).fold(0.0, f64::max);
    (linear, inverse_bind.w_axis.truncate().length())
}

fn weighted_sum(matrix: &DMat4) -> f64 {
    (0..4).map(|c| WEIGHTS[c].dot(matrix.col(c).truncate())).sum()
}

/// Bits that sort as the number does; not a number at either end.
fn ordered(number: f64) -> u64 {
    // Both zeros are one.
    let bits = (number + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that look thrown, the same each time.
    fn thrown(count: u32) -> impl Iterator<Item = f64> {
        (0..count).scan(12_345_u64, |state, _| {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            Some((*state >> 40) as f64 / (1_u64 << 23) as f64 - 1.0)
        })
    }

    fn matrices(count: u32, linear: f64, shift: f64) -> Vec<DMat4> {
        let numbers: Vec<f64> = thrown(count * 12).collect();
        let matrix = |n: &[f64]| {
            let mut columns = DMat4::IDENTITY.to_cols_array();
            (0..12).for_each(|i| columns[i / 3 * 4 + i % 3] = n[i] * if i < 9 { linear } else { shift });
            DMat4::from_cols_array(&columns)
        };
        numbers.chunks_exact(12).map(matrix).collect()
    }

    #[test]
    fn all_that_are_equal_are_candidates() {
        for (linear, shift) in [(1.0, 1.0), (100.0, 0.01), (1e-6, 50.0), (0.0, 1.0), (1e30, 1e38)] {
            let mut all = matrices(200, linear, shift);
            // Beside each, one at a distance about that of the tolerance.
            let near: Vec<DMat4> = matrices(200, linear, shift);
            for i in 0..200 {
                let by = 4e-6 + 2e-8 * i as f64;
                let mut apart = near[i] * by;
                apart.w_axis.w = 0.0;
                all.push(all[i] + apart);
            }
            let mut bound = BoundNodes::default();
            all.iter().enumerate().for_each(|(i, matrix)| bound.insert(7, matrix, i as u32));
            let mut equal = 0;
            for query in &all {
                let candidates: Vec<u32> = bound.candidates(7, query).collect();
                for i in (0..all.len()).filter(|&i| are_equal(&all[i], query)) {
                    assert!(candidates.contains(&(i as u32)));
                    equal += 1;
                }
            }
            assert!(equal > 410, "pairs are found, too: {equal}");
            assert_eq!(bound.candidates(8, &all[0]).count(), 0);
        }
    }

    /// Counted, not timed: one look at each of 4,096 would be eight million.
    #[test]
    fn many_matrices_on_one_node_are_hardly_looked_at() {
        for (linear, shift) in [(0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (1.0, 100.0)] {
            let mut bound = BoundNodes::default();
            let mut looks = 0;
            for (i, matrix) in matrices(4_096, linear, shift).iter().enumerate() {
                looks += bound.candidates(0, matrix).count();
                bound.insert(0, matrix, i as u32);
            }
            assert!(looks < 4_096, "{looks} looks");
        }
    }

    #[test]
    fn numbers_beyond_all_numbers_are_looked_at_one_by_one() {
        let mut bound = BoundNodes::default();
        for (i, number) in [f64::INFINITY, f64::NAN, f64::MAX, 1.0].into_iter().enumerate() {
            let matrix = DMat4::from_scale(DVec3::splat(number));
            bound.insert(0, &matrix, i as u32);
            assert!(bound.candidates(0, &matrix).count() > i || number == 1.0);
        }
        assert_eq!(bound.candidates(0, &DMat4::IDENTITY).collect::<Vec<_>>(), [3]);
        bound.remove(0, &DMat4::IDENTITY, 3);
        assert_eq!(bound.candidates(0, &DMat4::IDENTITY).count(), 0);
    }
}
