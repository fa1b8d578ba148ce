//! What a character comes to when it is a few pixels high: one, two, four, eight or sixteen dots, each a triangle turned to the
//! eye with the colour and the size of a part of the character as it is seen from around.
//!
//! Levels below the coarsest mesh, for crowds that the coarsest meshes alone would not fit. Points in the place of far characters
//! are Dong 2019's comparison (§6.2), which keep holes between them; dots have area.

use crate::dispatch::{DOT_LEVELS, DOT_VERTICES};
use crate::surface_colors::{SurfaceColor, color_at, roots, texels_of};
use crate::{CrowdData, DotCorner, InstanceRecord, LodChoice, cpu};
use crowd_pack::{CharacterRecord, NONE};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Dots of the levels, the coarsest first.
pub const DOT_COUNTS: [u32; DOT_LEVELS as usize] = [1, 2, 4, 8, 16];

/// Directions from which a character is looked at.
const VIEWS: u32 = 8;
/// Rows of such a picture.
const ROWS: usize = 64;
/// Dots of one character lie over each other and leave parts bare: with a fifth more area the mean of a picture is that of the
/// meshes (on the shipped cast, 4 to 12 pixels high).
const AREA_FACTOR: f32 = 1.2;
/// Rounds of moving the dots to the middles of what they stand for.
const ROUNDS: u32 = 8;

/// Whether so many dots have fewer vertices than a character's coarsest mesh, and no more triangles; else it has no such level.
pub(crate) fn dots_are_coarser(character: &CharacterRecord, dots: u32) -> bool {
    let CharacterRecord { min_vertex_count, min_triangle_count, .. } = *character;
    dots * DOT_VERTICES < min_vertex_count && dots <= min_triangle_count.max(1)
}

/// Below how many vertices [`crate::Buckets::quantized_lods`] gives every character who may be dots the same levels: the most dots that have no more
/// vertices. 0 where one has no dots. There stages need no table.
pub fn dot_reach(characters: &[CharacterRecord]) -> u32 {
    let reach = |character: &CharacterRecord| {
        let lacking = DOT_COUNTS.into_iter().find(|dots| !dots_are_coarser(character, *dots));
        let dots =
            lacking.map_or(character.min_vertex_count, |dots| character.min_vertex_count.min(dots * DOT_VERTICES));
        if lacking == Some(1) { 0 } else { dots }
    };
    characters.iter().map(reach).min().unwrap_or(0)
}

/// Corners of all dots of all characters: level after level as in [`DOT_COUNTS`], three corners a dot.
pub fn dot_corners(data: &CrowdData) -> Vec<DotCorner> {
    let of = |number: usize| {
        let seen = look_around(data, number as u32);
        let levels = DOT_COUNTS.into_iter().map(|dots| dots_of(data, number, &seen, dots));
        levels.flat_map(|dots| dots.into_iter().enumerate().flat_map(corners)).collect::<Vec<_>>()
    };
    (0..data.characters.len()).into_par_iter().map(of).collect::<Vec<_>>().concat()
}

/// Every other dot stands on its head, so that a character of several has no pattern.
fn corners((place, dot): (usize, DotCorner)) -> [DotCorner; 3] {
    let first = if place % 2 == 1 { 3 } else { 0 };
    [0, 1, 2].map(|number| DotCorner { number: first + number, ..dot })
}

/// A pixel of a picture of the character.
#[derive(Debug, Clone, Copy)]
struct Sample {
    position: Vec3,
    /// Share of the silhouette, square metres.
    area_m2: f32,
    /// Linear.
    color: Vec3,
    is_unlit: bool,
    /// Of the character.
    vertex: u32,
}

/// Everything that is seen of a character from around, at the start of its first clip.
fn look_around(data: &CrowdData, number: u32) -> Vec<Sample> {
    let character = &data.characters[number as usize];
    let instance =
        InstanceRecord { scale: 1.0, character: number, clip: character.clip_offset, ..InstanceRecord::default() };
    let all = LodChoice { vertex_count: character.vertex_count, triangle_count: character.triangle_count };
    let posed = cpu::pose_instance(data, &instance, all, 0.0);
    let positions: Vec<Vec3> = posed.positions.iter().copied().map(Vec3::from_array).collect();
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let extent_m = (high - low).length();
    if !(extent_m > 0.0 && extent_m.is_finite()) {
        return Vec::new();
    }
    let paints: Vec<(Vec3, bool)> =
        posed.triangles.iter().map(|corners| mean_color(data, character, corners)).collect();
    let pixel_m = extent_m / ROWS as f32;
    let middle = 0.5 * (low + high);
    let mut samples = Vec::new();
    for view in 0..VIEWS {
        let (s, c) = libm::sincosf(std::f32::consts::TAU * view as f32 / VIEWS as f32);
        let (right, towards) = (Vec3::new(c, 0.0, -s), Vec3::new(s, 0.0, c));
        let on_picture = |p: Vec3| {
            let from_middle = (p - middle) / pixel_m;
            let centre = 0.5 * ROWS as f32;
            Vec3::new(right.dot(from_middle) + centre, from_middle.y + centre, towards.dot(from_middle))
        };
        for (triangle, pixel) in nearest_triangles(&posed.triangles, &positions, &on_picture) {
            let corners = posed.triangles[triangle as usize];
            let position = middle
                + (right * (pixel.x - 0.5 * ROWS as f32) + Vec3::Y * (pixel.y - 0.5 * ROWS as f32) + towards * pixel.z)
                    * pixel_m;
            let far = |corner: &u32| positions[*corner as usize].distance_squared(position);
            let vertex = corners.into_iter().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0);
            let (color, is_unlit) = paints[triangle as usize];
            samples.push(Sample { position, area_m2: pixel_m * pixel_m / VIEWS as f32, color, is_unlit, vertex });
        }
    }
    samples
}

/// The triangle nearest to the eye in each pixel, and where: pixels across and up, and towards the eye.
fn nearest_triangles(
    triangles: &[[u32; 3]],
    positions: &[Vec3],
    on_picture: &impl Fn(Vec3) -> Vec3,
) -> Vec<(u32, Vec3)> {
    let mut nearest: Vec<(u32, f32)> = vec![(NONE, f32::NEG_INFINITY); ROWS * ROWS];
    for (number, corners) in triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|corner| on_picture(positions[corner as usize]));
        let doubled = (b - a).truncate().perp_dot((c - a).truncate());
        if doubled == 0.0 || !doubled.is_finite() {
            continue;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let pixels =
            |low: f32, high: f32| (low - 0.5).ceil().max(0.0) as usize..((high + 0.5).floor() as usize).min(ROWS);
        for y in pixels(low.y, high.y) {
            for x in pixels(low.x, high.x) {
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let share =
                    |from: Vec3, to: Vec3| (to.truncate() - from.truncate()).perp_dot(p - from.truncate()) / doubled;
                let (of_c, of_a) = (share(a, b), share(b, c));
                let of_b = 1.0 - of_a - of_c;
                if of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0 {
                    let depth = of_a * a.z + of_b * b.z + of_c * c.z;
                    let pixel = &mut nearest[y * ROWS + x];
                    if depth > pixel.1 {
                        *pixel = (number as u32, depth);
                    }
                }
            }
        }
    }
    let place = |(i, (triangle, depth)): (usize, &(u32, f32))| {
        let p = Vec3::new((i % ROWS) as f32 + 0.5, (i / ROWS) as f32 + 0.5, *depth);
        (*triangle != NONE).then_some((*triangle, p))
    };
    nearest.iter().enumerate().filter_map(place).collect()
}

/// A triangle's mean colour, linear, and whether light does not change it.
fn mean_color(data: &CrowdData, character: &CharacterRecord, corners: &[u32; 3]) -> (Vec3, bool) {
    let texels = texels_of(data, character, corners);
    let SurfaceColor { color, is_unlit, .. } = color_at(data, character, corners, Vec3::splat(1.0 / 3.0), texels);
    (color.truncate(), is_unlit)
}

/// So many dots for what is seen: its parts by their middles (Lloyd 1982), begun far apart.
fn dots_of(data: &CrowdData, character: usize, seen: &[Sample], count: u32) -> Vec<DotCorner> {
    if seen.is_empty() {
        return vec![DotCorner::default(); count as usize];
    }
    let mut middles = far_apart(seen, count);
    let mut owner = vec![0; seen.len()];
    for _ in 0..ROUNDS {
        for (sample, owner) in seen.iter().zip(&mut owner) {
            let far = |m: &usize| middles[*m].distance_squared(sample.position);
            *owner = (0..middles.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0);
        }
        for (m, middle) in middles.iter_mut().enumerate() {
            let (mut sum, mut samples) = (Vec3::ZERO, 0.0);
            for (sample, _) in seen.iter().zip(&owner).filter(|(_, owner)| **owner == m) {
                sum += sample.position;
                samples += 1.0;
            }
            *middle = if samples > 0.0 { sum / samples } else { *middle };
        }
    }
    let part = |m: usize| seen.iter().zip(&owner).filter(move |(_, owner)| **owner == m).map(|(sample, _)| sample);
    (0..middles.len()).map(|m| dot(data, character, part(m), middles[m])).collect()
}

/// Samples far from each other, the first the farthest from the middle of all.
fn far_apart(seen: &[Sample], count: u32) -> Vec<Vec3> {
    let middle = seen.iter().map(|sample| sample.position).sum::<Vec3>() / seen.len() as f32;
    let mut off: Vec<f32> = seen.iter().map(|sample| sample.position.distance_squared(middle)).collect();
    let mut chosen = Vec::new();
    for number in 0..count {
        let next = (0..seen.len()).max_by(|a, b| off[*a].total_cmp(&off[*b])).unwrap_or(0);
        let place = seen[next].position;
        chosen.push(place);
        for (off, sample) in off.iter_mut().zip(seen) {
            let distance = sample.position.distance_squared(place);
            *off = if number == 0 { distance } else { off.min(distance) };
        }
    }
    chosen
}

/// One dot for a part: as tall in comparison to its width as the part, and of the part's area.
fn dot<'a>(
    data: &CrowdData,
    character: usize,
    part: impl Iterator<Item = &'a Sample> + Clone,
    middle: Vec3,
) -> DotCorner {
    let (mut area_m2, mut color, mut unlit_m2) = (0.0f32, Vec3::ZERO, 0.0f32);
    let (mut across, mut up) = (0.0f32, 0.0f32);
    for sample in part.clone() {
        let off = sample.position - middle;
        area_m2 += sample.area_m2;
        color += sample.color * sample.area_m2;
        unlit_m2 += if sample.is_unlit { sample.area_m2 } else { 0.0 };
        across += 0.5 * (off.x * off.x + off.z * off.z) * sample.area_m2;
        up += off.y * off.y * sample.area_m2;
    }
    let far = |sample: &&Sample| sample.position.distance_squared(middle);
    let Some(nearest) = part.min_by(|a, b| far(a).total_cmp(&far(b))).filter(|_| area_m2 > 0.0) else {
        return DotCorner::default();
    };
    let aspect = (up / across.max(1e-12)).sqrt().clamp(0.25, 4.0);
    // A triangle has the area half width times half height times two.
    let half_width_m = (AREA_FACTOR * area_m2 / (2.0 * aspect)).sqrt();
    let [r, g, b] = roots(color / area_m2);
    let is_lit = 2.0 * unlit_m2 < area_m2;
    let followed = &data.vertices[(data.characters[character].vertex_offset + nearest.vertex) as usize];
    DotCorner {
        position: followed.position,
        color: [r, g, b, if is_lit { 255 } else { 0 }],
        half_size_m: [half_width_m, half_width_m * aspect],
        joints: followed.joints,
        weights: followed.weights,
        ..DotCorner::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_pack::{ClipRecord, LodRecord, MaterialRecord, VertexRecord, encode_normal};

    /// A box a metre wide and deep and `height_m` high; its lower half is red, its upper half blue.
    fn pillar(height_m: f32) -> CrowdData {
        let corner = |i: u32, y: f32, color: u32| VertexRecord {
            position: [[-0.5, y, -0.5], [0.5, y, -0.5], [0.5, y, 0.5], [-0.5, y, 0.5]][i as usize % 4],
            normal_oct: encode_normal([0.0, 1.0, 0.0]),
            color,
            weights: [65_535, 0],
            ..VertexRecord::default()
        };
        let (red, blue) = (0xff00_00ff, 0xffff_0000);
        let half = 0.5 * height_m;
        let rings = [(0.0, red), (half, red), (half, blue), (height_m, blue)];
        let vertices: Vec<VertexRecord> =
            rings.iter().flat_map(|&(y, color)| (0..4).map(move |i| corner(i, y, color))).collect();
        let wall = |low: u32, high: u32| {
            (0..4).flat_map(move |i| {
                let next = (i + 1) % 4;
                [[low + i, low + next, high + i], [low + next, high + next, high + i]]
            })
        };
        let triangles: Vec<[u32; 3]> = wall(0, 4).chain(wall(8, 12)).collect();
        let (vertex_count, triangle_count) = (vertices.len() as u32, triangles.len() as u32);
        let character = CharacterRecord {
            vertex_count,
            triangle_count,
            min_vertex_count: vertex_count,
            joint_count: 1,
            clip_count: 1,
            ..CharacterRecord::default()
        };
        CrowdData {
            characters: vec![character],
            collapse_map: (0..vertex_count).collect(),
            vertices,
            triangles,
            lods: vec![LodRecord { vertex_count, triangle_count }; vertex_count as usize + 1],
            clips: vec![ClipRecord { frame_count: 1, ..ClipRecord::default() }],
            animation: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
                .map(|r| r.map(f32::to_bits))
                .to_vec(),
            materials: vec![MaterialRecord { base_color: [1.0; 4], image: NONE, ..MaterialRecord::default() }],
            ..CrowdData::default()
        }
    }

    /// The dots of a level, a corner each.
    fn level(corners: &[DotCorner], number: usize) -> Vec<DotCorner> {
        let before: u32 = DOT_COUNTS[..number].iter().sum();
        let dots = corners.iter().step_by(3).skip(before as usize);
        dots.take(DOT_COUNTS[number] as usize).copied().collect()
    }

    fn area_m2(dots: &[DotCorner]) -> f32 {
        dots.iter().map(|dot| 2.0 * dot.half_size_m[0] * dot.half_size_m[1]).sum()
    }

    #[test]
    fn dots_have_the_area_of_the_silhouette_and_stand_upright() {
        let corners = dot_corners(&pillar(3.0));
        assert_eq!(corners.len(), 3 * 31);
        // Seen from around a square is (1 + sqrt 2) / 2 of its side wide on the average over these eight directions.
        let silhouette_m2 = 3.0 * (1.0 + std::f32::consts::SQRT_2) / 2.0;
        for number in 0..DOT_COUNTS.len() {
            let area_m2 = area_m2(&level(&corners, number));
            assert!((area_m2 / (AREA_FACTOR * silhouette_m2) - 1.0).abs() < 0.06, "{area_m2} of {silhouette_m2}");
        }
        let [one] = level(&corners, 0)[..] else { panic!("the first level is one dot") };
        assert!(one.half_size_m[1] > 1.8 * one.half_size_m[0], "{one:?}");
    }

    #[test]
    fn no_level_of_dots_has_more_than_the_coarsest_mesh() {
        let least = |min_vertex_count, min_triangle_count| CharacterRecord {
            min_vertex_count,
            min_triangle_count,
            ..pillar(1.0).characters[0]
        };
        let has = |character: CharacterRecord| DOT_COUNTS.map(|dots| dots_are_coarser(&character, dots));
        assert_eq!(has(least(25, 20)), [true, true, true, true, false]);
        // A pack may keep vertices that no triangle has: a table of levels must not fall for it.
        assert_eq!(has(least(60, 2)), [true, true, false, false, false]);
        assert_eq!(has(least(60, 0)), [true, false, false, false, false]);
        assert_eq!(has(least(3, 1)), [false; 5]);
    }

    #[test]
    fn one_dot_has_the_mean_colour_and_two_have_one_each() {
        let corners = dot_corners(&pillar(3.0));
        let root_half = 180;
        assert!(level(&corners, 0)[0].color[0].abs_diff(root_half) < 5, "{:?}", level(&corners, 0));
        let mut two: Vec<[u8; 4]> = level(&corners, 1).iter().map(|dot| dot.color).collect();
        two.sort_unstable();
        assert_eq!(two, [[0, 0, 255, 255], [255, 0, 0, 255]]);
        let upper = level(&corners, 1).into_iter().find(|dot| dot.color[2] == 255).expect("there is a blue one");
        assert!(upper.position[1] >= 1.5, "a dot follows a vertex of its part: {upper:?}");
    }

    #[test]
    fn what_has_no_extent_has_no_dots_but_room_for_them() {
        let mut data = pillar(1.0);
        data.vertices.iter_mut().for_each(|vertex| vertex.position = [f32::NAN, 0.0, 0.0]);
        assert_eq!(dot_corners(&data).iter().map(|dot| dot.half_size_m).collect::<Vec<_>>(), vec![[0.0; 2]; 93]);
    }
}
