//! Where vertices come from when their level comes, in the words in which the vertex shader wants it.

use crate::cpu::surviving;
use crate::{Buckets, CrowdData, OriginRecord};
use crowd_pack::VertexRecord;

impl Buckets {
    /// Of each vertex of the data: where it comes from when the coarsest quantised level that has it comes.
    ///
    /// No vertex is new in more than one level, so this is all that a morph needs to know. Joints stand where the vertex has them, as far as
    /// four places hold those of both; otherwise they begin with one that is not the vertex's first.
    pub fn origins(&self, data: &CrowdData) -> Vec<OriginRecord> {
        let mut origins = vec![OriginRecord::default(); data.vertices.len()];
        for (number, character) in data.characters.iter().enumerate() {
            let range = character.vertex_offset as usize..(character.vertex_offset + character.vertex_count) as usize;
            let (vertices, collapse_map) = (&data.vertices[range.clone()], &data.collapse_map[range.clone()]);
            let counts: Vec<u32> = (0..self.sets[number].level_count)
                .map(|level| self.records[self.at(number as u32, level) as usize].vertex_count)
                .collect();
            for (v, origin) in (0..).zip(&mut origins[range]) {
                let coarser = counts.partition_point(|count| *count <= v).checked_sub(1).map(|level| counts[level]);
                let from = coarser.map_or(v, |count| surviving(collapse_map, v, count));
                let VertexRecord { position, normal_oct, uv, color, .. } = vertices[from as usize];
                let (joints, weights) = beside(&vertices[v as usize], &vertices[from as usize]);
                *origin = OriginRecord { position, normal_oct, uv, color, vertex: v, joints, weights };
            }
        }
        origins
    }
}

/// Joints and weights of an origin beside those of the vertex that comes from there: the joints of both in the places of the vertex, with the
/// origin's weights, so that one walk over them serves both. Two neighbours mostly share theirs. Where four places are too few: the origin's
/// own, turned so that they do not begin with the first joint of the vertex, by which `skin_matrix` in `shaders/shared/skin.wgsl` tells them.
fn beside(vertex: &VertexRecord, origin: &VertexRecord) -> ([u32; 2], [u32; 2]) {
    let (mut joints, own_weights) = (halves(vertex.joints), halves(vertex.weights));
    let (mut from, mut from_weights) = (halves(origin.joints), halves(origin.weights));
    // The first place tells, even of a vertex that has no weight there.
    let mut is_taken = own_weights.map(|weight| weight > 0);
    is_taken[0] = true;
    let mut weights = [0; 4];
    for (joint, weight) in from.into_iter().zip(from_weights).filter(|(_, weight)| *weight > 0) {
        let own = (0..4).find(|place| is_taken[*place] && joints[*place] == joint);
        let Some(place) = own.or_else(|| is_taken.iter().position(|is_taken| !is_taken)) else {
            let other = (0..4).find(|place| from_weights[*place] > 0 && from[*place] != joints[0]).unwrap_or(0);
            from.rotate_left(other);
            from_weights.rotate_left(other);
            return (words(from), words(from_weights));
        };
        (joints[place], is_taken[place]) = (joint, true);
        // A pack's weights come to 65535; those of data made by hand may come to more on a joint that is there twice, and would reach into the next place.
        weights[place] = (weights[place] + weight).min(0xffff);
    }
    (words(joints), words(weights))
}

fn halves(words: [u32; 2]) -> [u32; 4] {
    [words[0] & 0xffff, words[0] >> 16, words[1] & 0xffff, words[1] >> 16]
}

fn words(halves: [u32; 4]) -> [u32; 2] {
    [halves[0] | halves[1] << 16, halves[2] | halves[3] << 16]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skin(joints: [u32; 4], weights: [u32; 4]) -> VertexRecord {
        VertexRecord { joints: words(joints), weights: words(weights), ..Default::default() }
    }

    #[test]
    fn joints_of_both_stand_where_the_vertex_has_them() {
        let vertex = skin([7, 3, 0, 0], [40_000, 25_535, 0, 0]);
        let of = |joints, weights| {
            let (joints, weights) = beside(&vertex, &skin(joints, weights));
            (halves(joints), halves(weights))
        };
        // The same joints in another order, one of them, one more, two more.
        assert_eq!(of([3, 7, 0, 0], [50_000, 15_535, 0, 0]), ([7, 3, 0, 0], [15_535, 50_000, 0, 0]));
        assert_eq!(of([3, 0, 0, 0], [65_535, 0, 0, 0]), ([7, 3, 0, 0], [0, 65_535, 0, 0]));
        assert_eq!(of([9, 7, 0, 0], [60_000, 5_535, 0, 0]), ([7, 3, 9, 0], [5_535, 0, 60_000, 0]));
        assert_eq!(of([0, 9, 0, 0], [60_000, 5_535, 0, 0]), ([7, 3, 0, 9], [0, 0, 60_000, 5_535]));
    }

    #[test]
    fn an_origin_for_which_there_is_no_place_stands_alone_and_can_be_told() {
        let vertex = skin([7, 3, 0, 0], [40_000, 25_535, 0, 0]);
        let crowded = skin([7, 4, 5, 6], [30_000, 20_000, 10_000, 5_535]);
        let (joints, weights) = beside(&vertex, &crowded);
        assert_eq!((halves(joints), halves(weights)), ([4, 5, 6, 7], [20_000, 10_000, 5_535, 30_000]));
        assert_ne!(joints[0] & 0xffff, 7);
        // A vertex without weight in the first place.
        let odd = skin([7, 3, 2, 1], [0, 25_535, 30_000, 10_000]);
        let (joints, weights) = beside(&odd, &skin([9, 3, 0, 0], [35_535, 30_000, 0, 0]));
        assert_eq!((halves(joints), halves(weights)), ([9, 3, 0, 0], [35_535, 30_000, 0, 0]));
    }

    #[test]
    fn weights_of_a_joint_that_is_there_twice_do_not_reach_into_the_next_place() {
        let vertex = skin([7, 3, 0, 0], [40_000, 25_535, 0, 0]);
        for (odd, even) in [([40_000, 30_000, 0, 0], [0xffff, 0, 0, 0]), ([30_000, 35_535, 0, 0], [0xffff, 0, 0, 0])] {
            let (joints, weights) = beside(&vertex, &skin([7, 7, 3, 0], odd));
            assert_eq!((halves(joints), halves(weights)), ([7, 3, 0, 0], even));
        }
        let (_, weights) = beside(&vertex, &skin([3, 3, 3, 3], [0xffff; 4]));
        assert_eq!(halves(weights), [0, 0xffff, 0, 0]);
    }
}
