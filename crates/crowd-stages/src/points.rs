//! Points of characters' surfaces, which [`crate::Technique::Points`] draws in the place of far ones.
//!
//! What Dong 2019 (§6.2) compares with: far characters as points, in a few densities, each point one pixel. They do not say how
//! points are chosen; here they lie evenly over the surface, and those of a coarser density are the first of a finer one's.

use crate::dispatch::POINT_LEVELS;
use crate::surface_colors::{SurfaceColor, color_at, roots, texels_of};
use crate::{CrowdData, InstanceRecord, LodChoice, PointRecord, cpu};
use crowd_pack::{CharacterRecord, VertexRecord, decode_normal, encode_normal};
use glam::Vec3;
use rayon::prelude::*;

/// Points of the densities, the coarsest first.
pub const POINT_COUNTS: [u32; POINT_LEVELS as usize] = [64, 256, 1024, MOST_POINTS];
/// Points of the densest, and how many places each character has.
pub const MOST_POINTS: u32 = 4096;

/// The density whose points' colours are means of as much texture as each stands for.
const MEAN_OF_COUNT: f32 = 1024.0;
/// Candidates for a point that is there: of what is cut out one in so many must be left.
const MOST_TRIES: u32 = 16;
/// Of a sequence that fills a cube evenly (Roberts 2018, R3): powers of the inverse of the root of x^4 = x + 1.
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];

/// Points of each character, [`MOST_POINTS`]; none where its surface has no area or nearly all of it is cut out.
pub fn surface_points(data: &CrowdData) -> Vec<Option<Vec<PointRecord>>> {
    (0..data.characters.len() as u32).into_par_iter().map(|number| points_of(data, number)).collect()
}

fn points_of(data: &CrowdData, number: u32) -> Option<Vec<PointRecord>> {
    let character = &data.characters[number as usize];
    // Areas are those of a pose: bind spaces may be stretched.
    let instance =
        InstanceRecord { scale: 1.0, character: number, clip: character.clip_offset, ..InstanceRecord::default() };
    let all = LodChoice { vertex_count: character.vertex_count, triangle_count: character.triangle_count };
    let posed = cpu::pose_instance(data, &instance, all, 0.0);
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| Vec3::from_array(posed.positions[corner as usize]));
        f64::from((b - a).cross(c - a).length())
    };
    let mut sum = 0.0;
    let mut end = |corners: &[u32; 3]| {
        sum += area(corners);
        sum
    };
    let ends: Vec<f64> = posed.triangles.iter().map(&mut end).collect();
    if !(sum > 0.0 && sum.is_finite()) {
        return None;
    }
    let mut points = Vec::with_capacity(MOST_POINTS as usize);
    for candidate in 0..MOST_POINTS * MOST_TRIES {
        let [along, s, t] = STEPS.map(|step| (0.5 + f64::from(candidate) * step).fract());
        let triangle = ends.partition_point(|end| *end <= along * sum).min(ends.len() - 1);
        let corners = &posed.triangles[triangle];
        let (root, t) = (s.sqrt() as f32, t as f32);
        let shares = Vec3::new(1.0 - root, root * (1.0 - t), root * t);
        let part = sum / f64::from(MEAN_OF_COUNT) / area(corners).max(f64::MIN_POSITIVE);
        let texels = texels_of(data, character, corners) * part as f32;
        let looks = color_at(data, character, corners, shares, texels);
        if looks.color.w >= looks.alpha_cutoff {
            points.push(point(data, character, corners, shares, &looks));
        }
        if points.len() == MOST_POINTS as usize {
            break;
        }
    }
    let is_thin = points.len() < POINT_COUNTS[0] as usize;
    (!is_thin).then(|| points.iter().copied().cycle().take(MOST_POINTS as usize).collect())
}

fn point(
    data: &CrowdData,
    character: &CharacterRecord,
    corners: &[u32; 3],
    shares: Vec3,
    looks: &SurfaceColor,
) -> PointRecord {
    let vertices = corners.map(|corner| &data.vertices[(character.vertex_offset + corner) as usize]);
    let between = |of: &dyn Fn(&VertexRecord) -> Vec3| {
        vertices.iter().zip(shares.to_array()).map(|(vertex, share)| of(vertex) * share).sum::<Vec3>()
    };
    let normal = between(&|vertex| Vec3::from_array(decode_normal(vertex.normal_oct)));
    let (joints, weights) = shared_weights(&vertices, shares);
    let [r, g, b] = roots(looks.color.truncate());
    PointRecord {
        position: between(&|vertex| Vec3::from_array(vertex.position)).to_array(),
        normal_oct: encode_normal(normal.normalize_or(Vec3::Y).to_array()),
        color: [r, g, b, if looks.is_unlit { 0 } else { 255 }],
        is_double_sided: looks.is_double_sided.into(),
        joints,
        weights,
        ..PointRecord::default()
    }
}

/// The four joints that move the point most, and their weights, 65,535 in all.
fn shared_weights(vertices: &[&VertexRecord; 3], shares: Vec3) -> ([u32; 2], [u32; 2]) {
    let mut sums: Vec<(u32, f32)> = Vec::new();
    for (vertex, share) in vertices.iter().zip(shares.to_array()) {
        for influence in 0..4 {
            let half = |words: [u32; 2]| words[influence / 2] >> (16 * (influence % 2)) & 0xffff;
            let (joint, weight) = (half(vertex.joints), half(vertex.weights) as f32 * share);
            match sums.iter_mut().find(|(known, _)| *known == joint) {
                Some((_, sum)) => *sum += weight,
                None => sums.push((joint, weight)),
            }
        }
    }
    sums.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    sums.truncate(4);
    let all: f32 = sums.iter().map(|(_, weight)| weight).sum();
    let mut kept = [(0, 0); 4];
    for (kept, (joint, weight)) in kept.iter_mut().zip(sums) {
        *kept = (joint, (weight / all.max(f32::MIN_POSITIVE) * 65_535.0) as u32);
    }
    // What rounding down has left goes to the first.
    kept[0].1 = 65_535 - kept[1..].iter().map(|(_, weight)| weight).sum::<u32>();
    let words = |of: [u32; 4]| [of[0] | of[1] << 16, of[2] | of[3] << 16];
    (words(kept.map(|(joint, _)| joint)), words(kept.map(|(_, weight)| weight)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_pack::{ClipRecord, LodRecord, MaterialRecord, NONE, material_flags};

    /// Two squares above each other: a red one a metre wide, and a blue one with three times its area, on a joint of its own.
    fn two_squares() -> CrowdData {
        let corner = |i: usize, y: f32, color: u32, joint: u32| VertexRecord {
            position: [[0.0, y, 0.0], [1.0, y, 0.0], [1.0, y, 1.0], [0.0, y, 1.0]][i],
            normal_oct: encode_normal([0.0, 1.0, 0.0]),
            color,
            joints: [joint, 0],
            weights: [65_535, 0],
            ..VertexRecord::default()
        };
        let mut vertices: Vec<VertexRecord> = (0..4).map(|i| corner(i, 0.0, 0xff00_00ff, 0)).collect();
        vertices.extend((0..4).map(|i| corner(i, 1.0, 0xffff_0000, 1)));
        vertices[4..].iter_mut().for_each(|vertex| vertex.position[0] *= 3.0);
        let character = CharacterRecord {
            vertex_count: 8,
            triangle_count: 4,
            min_vertex_count: 8,
            joint_count: 2,
            clip_count: 1,
            ..CharacterRecord::default()
        };
        let still = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        CrowdData {
            characters: vec![character],
            collapse_map: (0..8).collect(),
            vertices,
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            lods: vec![LodRecord { vertex_count: 8, triangle_count: 4 }; 9],
            clips: vec![ClipRecord { frame_count: 1, ..ClipRecord::default() }],
            animation: [still, still].as_flattened().iter().map(|row| row.map(f32::to_bits)).collect(),
            materials: vec![MaterialRecord { base_color: [1.0; 4], image: NONE, ..MaterialRecord::default() }],
            ..CrowdData::default()
        }
    }

    fn points(data: &CrowdData) -> Vec<PointRecord> {
        surface_points(data).remove(0).expect("it has points")
    }

    #[test]
    fn every_density_is_spread_over_the_area() {
        let points = points(&two_squares());
        assert_eq!(points.len(), MOST_POINTS as usize);
        for count in POINT_COUNTS.map(|count| count as usize) {
            let blue = points[..count].iter().filter(|point| point.color == [0, 0, 255, 255]).count();
            assert!(blue.abs_diff(count * 3 / 4) <= 3, "{blue} of {count}");
            let left = points[..count].iter().filter(|point| point.position[2] < 0.5).count();
            assert!(left.abs_diff(count / 2) <= count / 16, "{left} of {count}");
        }
    }

    #[test]
    fn a_point_moves_with_its_triangle() {
        for point in points(&two_squares()) {
            let is_upper = point.position[1] > 0.5;
            assert_eq!((point.joints, point.weights), ([u32::from(is_upper), 0], [65_535, 0]));
        }
        let mut mixed = two_squares();
        mixed.vertices[0].joints = [1, 0];
        let between: Vec<PointRecord> = points(&mixed).into_iter().filter(|point| point.weights[0] >> 16 > 0).collect();
        assert!(between.len() > 500, "{}", between.len());
        assert!(between.iter().all(|point| (point.weights[0] & 0xffff) + (point.weights[0] >> 16) == 65_535));
    }

    #[test]
    fn what_is_cut_out_has_no_points_and_what_has_no_area_none_at_all() {
        let mut cut = two_squares();
        cut.materials[0].alpha_cutoff = 0.5;
        cut.materials[0].flags = material_flags::DOUBLE_SIDED;
        cut.vertices[4..].iter_mut().for_each(|vertex| vertex.color = 0x00ff_0000);
        let red = points(&cut);
        assert!(red.iter().filter(|point| point.position[1] > 0.5).count() == 0 && red.len() == MOST_POINTS as usize);
        assert!(red.iter().all(|point| point.is_double_sided == 1));
        cut.vertices.iter_mut().for_each(|vertex| vertex.color = 0);
        assert_eq!(surface_points(&cut), [None]);
        let mut flat = two_squares();
        flat.vertices.iter_mut().for_each(|vertex| vertex.position = [f32::NAN; 3]);
        assert_eq!(surface_points(&flat), [None]);
    }
}
