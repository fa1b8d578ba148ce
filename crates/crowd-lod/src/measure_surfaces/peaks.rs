//! Looks for the largest distance between the points that were looked at: splits the triangles whose points lie farthest.
//!
//! Where a level's triangle cuts across a fold of full detail, the distance rises to a ridge half way between the sheets of the fold, as
//! narrow as the triangle is. No spread of points finds its top.

use super::points::Target;
use crate::closest::{corners_of, distances_squared};
use crate::quadrics::{dot, sub};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Triangles of one side that are split in a frame.
const TRIANGLES: usize = 8;
/// Pieces whose distance is searched, in a frame and on one side.
const PIECES: u32 = 96;
/// A triangle is of interest when a point of it lies more than half as far as the farthest.
const LEAST_SHARE_SQUARED: f32 = 0.25;
/// A piece is let go when nothing in it lies farther than this many times the largest distance found: less than a bound adds.
const FAR_ENOUGH: f32 = 1.1;

/// The triangles whose points lie farthest in a frame, as far as is known.
#[derive(Default)]
pub(super) struct Peaks {
    /// Squared distances and triangles.
    highest: Vec<(f32, u32)>,
}

impl Peaks {
    /// Whether nothing is noted: then there is nothing to climb.
    pub fn is_empty(&self) -> bool {
        self.highest.is_empty()
    }

    /// The squared distance that a point must exceed to be of interest, when `largest` is that of the farthest so far.
    pub fn least(largest: f32) -> f32 {
        LEAST_SHARE_SQUARED * largest
    }

    /// The squared distance up to which a point changes nothing: neither what is noted nor the largest distance, `largest`. No less than
    /// [`Self::least`].
    pub fn bar(&self, largest: f32) -> f32 {
        let least = Self::least(largest);
        if self.highest.len() < TRIANGLES {
            return least;
        }
        let lowest = self.highest.iter().map(|peak| peak.0).fold(f32::INFINITY, f32::min);
        // Who is as far off as the farthest may yet name another frame.
        lowest.min(largest.next_down()).max(least)
    }

    /// Notes a point of a triangle, by its squared distance; `largest`: of the farthest so far.
    pub fn note(&mut self, triangle: u32, squared: f32, largest: f32) {
        if squared <= Self::least(largest) {
            return;
        }
        if let Some(known) = self.highest.iter_mut().find(|peak| peak.1 == triangle) {
            known.0 = known.0.max(squared);
        } else if self.highest.len() < TRIANGLES {
            self.highest.push((squared, triangle));
        } else if let Some(lowest) =
            self.highest.iter_mut().min_by(|a, b| a.0.total_cmp(&b.0)).filter(|l| l.0 < squared)
        {
            *lowest = (squared, triangle);
        }
    }

    /// The largest squared distance on the triangles noted, or `largest` where none is farther. They are split in two, the piece that
    /// may hold the farthest point first, until none can hold one much farther or enough have been looked at.
    pub fn climb(self, mut largest: f32, positions: &[[f32; 3]], triangles: &[[u32; 3]], to: &Target<'_>) -> f32 {
        let mut pieces = BinaryHeap::new();
        let mut number = 0;
        for (_, triangle) in self.highest {
            let corners = corners_of(triangles[triangle as usize], positions);
            pieces.extend(Piece::new(corners, triangle, number, &mut largest, to));
            number += 1;
        }
        while let Some(piece) = pieces.pop().filter(|piece| piece.may_reach > FAR_ENOUGH * largest.sqrt()) {
            if number >= PIECES {
                break;
            }
            for corners in halves(piece.corners) {
                pieces.extend(Piece::new(corners, piece.closest, number, &mut largest, to));
                number += 1;
            }
        }
        largest
    }
}

/// A part of a triangle.
struct Piece {
    corners: [[f32; 3]; 3],
    /// No point of it lies farther, metres.
    may_reach: f32,
    /// Triangle of the other mesh that is closest to its middle.
    closest: u32,
    /// One that no other piece has.
    number: u32,
}

impl Piece {
    /// Searches the middle of a piece, and raises `largest` to its squared distance. `None` when there is nothing to measure against.
    fn new(corners: [[f32; 3]; 3], hint: u32, number: u32, largest: &mut f32, to: &Target<'_>) -> Option<Self> {
        let middle = [0, 1, 2].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
        let (closest, squared) = to.tree.closest(middle, to.positions, to.triangles, hint)?;
        *largest = largest.max(squared);
        let span = corners.map(|c| sub(c, middle)).map(|s| dot(s, s)).into_iter().fold(0.0, f32::max);
        // The distance to one triangle is convex, so that it is largest at a corner.
        let other = corners_of(to.triangles[closest as usize], to.positions);
        let from_one = distances_squared(&corners, &[other; 3]).into_iter().fold(0.0, f32::max);
        let may_reach = (squared.sqrt() + span.sqrt()).min(from_one.sqrt());
        Some(Self { corners, may_reach, closest, number })
    }
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.may_reach.total_cmp(&other.may_reach).then(other.number.cmp(&self.number))
    }
}

/// A triangle cut in two at the middle of its longest edge.
fn halves([a, b, c]: [[f32; 3]; 3]) -> [[[f32; 3]; 3]; 2] {
    let length = |from: [f32; 3], to: [f32; 3]| dot(sub(to, from), sub(to, from));
    let (ab, bc, ca) = (length(a, b), length(b, c), length(c, a));
    let [a, b, c] = if ab >= bc && ab >= ca {
        [a, b, c]
    } else if bc >= ca {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let middle = [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0);
    [[a, middle, c], [middle, b, c]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closest::ClosestTriangles;

    /// A roof without a floor, and a narrow board that cuts through under its ridge.
    ///
    /// ```text
    ///      /\
    ///  ---/--\---   the board is farthest from the roof in the middle between the sides
    ///    /    \
    /// ```
    #[test]
    fn a_ridge_between_two_sheets_is_climbed() {
        let roof = [
            [-1.0, 0.0, -1.0],
            [1.0, 0.0, -1.0],
            [-1.0, 4.0, -1.0],
            [1.0, 4.0, -1.0],
            [0.0, 0.0, 1.0],
            [0.0, 4.0, 1.0],
        ];
        let sides = [[0, 2, 4], [2, 5, 4], [1, 4, 3], [3, 4, 5]];
        let mut tree = ClosestTriangles::new(&roof, &sides);
        tree.refit(&roof, &sides);
        let to = Target { positions: &roof, triangles: &sides, tree: &tree };
        // Both ends lie in a side, at height 0: half as wide as the roof there.
        let board = [[-0.5, 2.0, 0.0], [0.5, 2.0, 0.0], [0.5, 2.01, 0.0]];
        let mut peaks = Peaks::default();
        peaks.note(0, 0.01, 0.0);
        let found = peaks.climb(0.0, &board, &[[0, 1, 2]], &to).sqrt();
        let top = 1.0 / 5.0_f32.sqrt();
        assert!(found * FAR_ENOUGH >= top && found <= top + 1.0e-6, "{found} {top}");
        // Nothing is looked for below what is known.
        let mut peaks = Peaks::default();
        peaks.note(0, 0.01, 1.0);
        assert!(peaks.highest.is_empty());
        assert_eq!(peaks.climb(1.0, &board, &[[0, 1, 2]], &to), 1.0);
    }

    #[test]
    fn what_lies_up_to_the_bar_changes_nothing() {
        let mut peaks = Peaks::default();
        for t in 0..TRIANGLES as u32 {
            assert_eq!(peaks.bar(10.0), 2.5, "there is room for more");
            peaks.note(t, 4.0 + t as f32, 10.0);
        }
        assert_eq!((peaks.bar(10.0), peaks.bar(20.0)), (4.0, 5.0));
        let before = peaks.highest.clone();
        for t in 0..20 {
            peaks.note(t, peaks.bar(10.0), 10.0);
        }
        assert_eq!(peaks.highest, before);
        peaks.note(30, peaks.bar(10.0).next_up(), 10.0);
        assert_ne!(peaks.highest, before);
        // All are as far as the farthest: one more may be so in a later frame.
        peaks.highest.fill((10.0, 0));
        assert!(peaks.bar(10.0) < 10.0);
        assert_eq!(Peaks::default().bar(0.0), 0.0);
    }

    #[test]
    fn the_highest_are_kept_each_once() {
        let mut peaks = Peaks::default();
        for t in 0..20 {
            peaks.note(t, 1.0 + t as f32, 1.0);
            peaks.note(t, 0.5, 1.0);
        }
        let mut kept: Vec<u32> = peaks.highest.iter().map(|peak| peak.1).collect();
        kept.sort_unstable();
        assert_eq!(kept, (12..20).collect::<Vec<u32>>());
    }
}
