//! Finds which positions mirror each other, and which parts, so that a character does not lose one eye first (docs/decisions/0075).

use crate::behind::diagonal;
use crate::quadrics::{dot, sub};

/// No mirror image.
pub(crate) const NO_PARTNER: u32 = u32::MAX;

/// How far a position may lie from its mirror image's place, as a share of the diagonal.
const TOLERANCE_SHARE: f32 = 1.0e-4;
/// Share of the positions that must have a partner for the mesh to count as symmetric.
const SYMMETRIC_SHARE: f32 = 0.5;
/// Positions looked at where many lie together; bounds the work on a hostile heap.
const SEARCHED_POSITIONS: usize = 64;

/// For each position the one that mirrors it in bind pose (itself on the mirror plane), or [`NO_PARTNER`].
///
/// Tries the planes across each axis through the middle of the box around the mesh and through the origin, and takes
/// the one with the most partners, the first of equals (x first: characters face along z). All are without partner where fewer
/// than half find one. Partners are mutual.
pub(crate) fn find_partners(places: &[[f32; 3]]) -> Vec<u32> {
    let tolerance = TOLERANCE_SHARE * diagonal(places);
    let mut best = vec![NO_PARTNER; places.len()];
    if tolerance <= 0.0 || !tolerance.is_finite() {
        return best;
    }
    let cells = Cells::new(places, tolerance);
    let mut most = (SYMMETRIC_SHARE * places.len() as f32) as usize;
    for axis in 0..3 {
        let along = places.iter().map(|p| p[axis]);
        let (low, high) = along.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        for middle in [0.5 * (low + high), 0.0] {
            let found = pair_up(places, &cells, axis, middle, tolerance);
            let count = found.iter().filter(|&&partner| partner != NO_PARTNER).count();
            if count > most {
                (best, most) = (found, count);
            }
        }
    }
    best
}

/// For each part the one that mirrors it, or [`NO_PARTNER`]: all positions of both have their partner in the other. A part is named by its
/// lowest position. A part that mirrors itself is none's.
pub(crate) fn pair_parts(part_of_position: &[u32], partners: &[u32]) -> Vec<u32> {
    let mut twins: Vec<Option<u32>> = vec![None; part_of_position.len()];
    for (p, &part) in part_of_position.iter().enumerate() {
        let there = partners.get(p).filter(|&&partner| partner != NO_PARTNER);
        let there = there.map_or(NO_PARTNER, |&partner| part_of_position[partner as usize]);
        let twin = twins[part as usize].get_or_insert(there);
        if *twin != there {
            *twin = NO_PARTNER;
        }
    }
    let twin = |part: u32| twins[part as usize].unwrap_or(NO_PARTNER);
    let mutual =
        |part: u32| Some(twin(part)).filter(|&other| other != NO_PARTNER && other != part && twin(other) == part);
    (0..twins.len() as u32).map(|part| mutual(part).unwrap_or(NO_PARTNER)).collect()
}

fn pair_up(places: &[[f32; 3]], cells: &Cells, axis: usize, middle: f32, tolerance: f32) -> Vec<u32> {
    let nearest = |place: &[f32; 3]| {
        let mut mirrored = *place;
        mirrored[axis] = 2.0 * middle - place[axis];
        cells.nearest(places, mirrored, tolerance)
    };
    let mut partners: Vec<u32> = places.iter().map(nearest).collect();
    for p in 0..partners.len() {
        let partner = partners[p];
        // One-sided ones go; both ends of a pair were found by now.
        if partner != NO_PARTNER && partners[partner as usize] != p as u32 {
            partners[p] = NO_PARTNER;
        }
    }
    partners
}

/// Positions by cells of space.
struct Cells {
    size: f32,
    /// Cell and position, sorted.
    entries: Vec<([i32; 3], u32)>,
    /// A bit for each hash of a cell that holds something: most questions end there.
    taken: Vec<u64>,
}

/// Bits for cells.
const CELL_BITS: usize = 1 << 20;

/// Word and bit of a cell in `taken`.
fn bit_of([x, y, z]: [i32; 3]) -> (usize, u64) {
    let mixed = [(x, 0x9e37_79b9_u32), (y, 0x85eb_ca6b), (z, 0xc2b2_ae35)];
    let hash = mixed.into_iter().fold(0_u32, |hash, (c, by)| (hash ^ c as u32).wrapping_mul(by).rotate_left(13));
    let bit = hash as usize % CELL_BITS;
    (bit / 64, 1 << (bit % 64))
}

impl Cells {
    fn new(places: &[[f32; 3]], tolerance: f32) -> Self {
        let size = 4.0 * tolerance;
        let mut entries: Vec<([i32; 3], u32)> =
            places.iter().enumerate().map(|(p, place)| (place.map(|c| (c / size).floor() as i32), p as u32)).collect();
        entries.sort_unstable();
        let mut taken = vec![0; CELL_BITS / 64];
        for (word, bit) in entries.iter().map(|&(cell, _)| bit_of(cell)) {
            taken[word] |= bit;
        }
        Self { size, entries, taken }
    }

    /// The position nearest to a place, the lowest of equals.
    fn nearest(&self, places: &[[f32; 3]], place: [f32; 3], tolerance: f32) -> u32 {
        let ends = [-tolerance, tolerance].map(|by| place.map(|c| ((c + by) / self.size).floor() as i32));
        let mut best = (tolerance * tolerance, NO_PARTNER);
        for x in ends[0][0]..=ends[1][0] {
            for y in ends[0][1]..=ends[1][1] {
                for z in ends[0][2]..=ends[1][2] {
                    let (word, bit) = bit_of([x, y, z]);
                    if self.taken[word] & bit == 0 {
                        continue;
                    }
                    let from = self.entries.partition_point(|entry| entry.0 < [x, y, z]);
                    let here = self.entries[from..].iter().take_while(|entry| entry.0 == [x, y, z]);
                    for &(_, p) in here.take(SEARCHED_POSITIONS) {
                        let off = sub(places[p as usize], place);
                        let distance = dot(off, off);
                        if distance < best.0 || (distance == best.0 && p < best.1) {
                            best = (distance, p);
                        }
                    }
                }
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten places to each side of x = `middle`, and three on it.
    fn mirrored(middle: f32) -> Vec<[f32; 3]> {
        let mut places = Vec::new();
        for i in 0..10 {
            let (x, y, z) = (0.1 + 0.03 * i as f32, 0.17 * i as f32, libm::sinf(i as f32));
            places.push([middle - x, y, z]);
            places.push([middle + x, y, z]);
        }
        places.extend([[middle, 0.0, 0.5], [middle, 0.4, 0.1], [middle, 1.0, -0.2]]);
        places
    }

    #[test]
    fn both_sides_find_each_other_and_the_middle_itself() {
        for middle in [0.0, 0.7] {
            let places = mirrored(middle);
            let partners = find_partners(&places);
            let expected: Vec<u32> = (0..20).map(|p| p ^ 1).chain(20..23).collect();
            assert_eq!(partners, expected, "plane at {middle}");
        }
    }

    #[test]
    fn what_is_on_one_side_only_has_no_partner() {
        let mut places = mirrored(0.0);
        places.push([0.3, 0.9, 0.9]);
        places[4][1] += 0.01;
        let partners = find_partners(&places);
        assert_eq!((partners[23], partners[4], partners[5]), (NO_PARTNER, NO_PARTNER, NO_PARTNER));
        assert_eq!(partners[6], 7);
    }

    #[test]
    fn parts_are_paired_when_all_of_both_mirrors() {
        // Parts 0 and 2 mirror each other; 4 mirrors itself; of 6 and 8 one position has its image elsewhere, or none.
        let parts = [0, 0, 2, 2, 4, 4, 6, 6, 8, 8];
        let paired = |partners: [u32; 10]| {
            let found = pair_parts(&parts, &partners);
            [0, 2, 4, 6, 8].map(|part| found[part])
        };
        let none = NO_PARTNER;
        assert_eq!(paired([3, 2, 1, 0, 5, 4, 8, none, 6, none]), [2, 0, none, none, none]);
        assert_eq!(paired([3, 2, 1, 0, 4, 9, 8, 7, 6, 5]), [2, 0, none, none, none]);
        assert_eq!(paired([2, 3, 0, 1, 4, 5, 9, 8, 7, 6]), [2, 0, none, 8, 6]);
        assert_eq!(pair_parts(&parts, &[]), [none; 10]);
    }

    #[test]
    fn crooked_and_empty_meshes_have_no_partners() {
        let crooked: Vec<[f32; 3]> =
            (0..40).map(|i| [1.0, 1.7, 2.9].map(|k| libm::sinf(k * (i * i) as f32 + k))).collect();
        assert!(find_partners(&crooked).iter().all(|&p| p == NO_PARTNER));
        assert!(find_partners(&[]).is_empty());
        assert_eq!(find_partners(&[[1.0; 3]; 3]), [NO_PARTNER; 3]);
    }

    #[test]
    fn a_heap_at_one_place_is_answered_in_time() {
        let mut places = mirrored(0.0);
        places.extend(vec![[0.2, 0.2, 0.2]; 20_000]);
        let partners = find_partners(&places);
        assert_eq!(partners.len(), places.len());
        for (p, &partner) in partners.iter().enumerate() {
            assert!(partner == NO_PARTNER || partners[partner as usize] == p as u32, "mutual");
        }
    }
}
