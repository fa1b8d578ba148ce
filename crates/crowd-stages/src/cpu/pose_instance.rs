//! What the vertex shader computes, vertex by vertex: the oracle for images, and the preview without a GPU.

use super::gather_drawn::drawn_instance;
use super::reform_triangles::surviving;
use super::{reform_level, turn, world_from_local};
use crate::{CrowdData, DrawnInstance, InstanceRecord, LodChoice, MorphRecord};
use crowd_pack::{ClipRecord, VertexRecord, decode_normal};
use glam::{Vec2, Vec3, Vec4};

/// An instance posed on the CPU at its level: what the vertex shader computes, vertex by vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PosedInstance {
    /// World positions of the level's vertices.
    pub positions: Vec<[f32; 3]>,
    /// World normals, unit.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// Linear RGBA8.
    pub colors: Vec<[u8; 4]>,
    /// Reformed triangles, indices below the level's vertex count.
    pub triangles: Vec<[u32; 3]>,
}

/// The two frames an instance stands between at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramePair {
    /// Earlier frame.
    pub first: u32,
    /// Later frame, at most the clip's last.
    pub second: u32,
    /// Share of the later one, 0 to 1.
    pub blend: f32,
}

/// Poses one instance at the level chosen, at `time_s`.
///
/// Matrices are interpolated entry by entry between the two frames around the instance's time; positions and normals are
/// transformed by the weighted sum of up to four joint matrices (linear blend skinning). Of someone who fades, the matrices of both
/// clips are mixed in the same way, by the share of the clip that is left.
///
/// Paper: Peng 2011 Eq. 2 (§5.3), Dong 2019 Eq. 2. Departs: inverse bind matrices are multiplied in beforehand, and frames are
/// interpolated; the papers show the nearest one. Twin: `shaders/shared/skin.wgsl`.
pub fn pose_instance(data: &CrowdData, instance: &InstanceRecord, choice: LodChoice, time_s: f32) -> PosedInstance {
    let at_home = MorphRecord { coarser_vertex_count: choice.vertex_count, fraction: 1.0 };
    pose_between(data, instance, choice, at_home, time_s)
}

/// The same between two levels: a vertex that the coarser one lacks comes from where that has it, by `morph.fraction`, with its
/// normal, texture coordinates and colour.
///
/// Its matrix comes from there, too, so at 0 the surface is that of the coarser level in every pose. Seam partners collapse together
/// (Peng 2011 §4.2), so they move together. Paper: none of ours; geomorphs as in Hoppe 1996. Twin: `bucketed_morphing` in
/// `shaders/draw/crowd.wgsl`.
pub fn pose_between(
    data: &CrowdData,
    instance: &InstanceRecord,
    choice: LodChoice,
    morph: MorphRecord,
    time_s: f32,
) -> PosedInstance {
    let character = &data.characters[instance.character as usize];
    let clips = clip_palettes(data, instance, time_s);
    let matrix = |vertex: &VertexRecord| sum_of_clips(&clips, vertex.joints, vertex.weights);
    let first = character.vertex_offset as usize;
    let vertices = &data.vertices[first..first + choice.vertex_count as usize];
    let mut posed = PosedInstance {
        positions: Vec::with_capacity(vertices.len()),
        normals: Vec::with_capacity(vertices.len()),
        uvs: vertices.iter().map(|vertex| vertex.uv).collect(),
        colors: vertices.iter().map(|vertex| vertex.color.to_le_bytes()).collect(),
        triangles: reform_level(data, character, choice),
    };
    let collapse_map = &data.collapse_map[first..first + vertices.len()];
    for (v, vertex) in vertices.iter().enumerate() {
        let mut rows = matrix(vertex);
        let mut position = Vec3::from_array(vertex.position);
        let mut normal = Vec3::from_array(decode_normal(vertex.normal_oct));
        if v as u32 >= morph.coarser_vertex_count && morph.fraction < 1.0 {
            let origin = &vertices[surviving(collapse_map, v as u32, morph.coarser_vertex_count) as usize];
            let from = matrix(origin);
            rows = [0, 1, 2].map(|r| from[r].lerp(rows[r], morph.fraction));
            position = Vec3::from_array(origin.position).lerp(position, morph.fraction);
            normal = Vec3::from_array(decode_normal(origin.normal_oct)).lerp(normal, morph.fraction);
            posed.uvs[v] = Vec2::from_array(origin.uv).lerp(Vec2::from_array(vertex.uv), morph.fraction).to_array();
            posed.colors[v] = mix_colors(origin.color.to_le_bytes(), posed.colors[v], morph.fraction);
        }
        let (position, normal) = (position.extend(1.0), normal.extend(0.0));
        let local = Vec3::new(rows[0].dot(position), rows[1].dot(position), rows[2].dot(position));
        let turned = Vec3::new(rows[0].dot(normal), rows[1].dot(normal), rows[2].dot(normal));
        posed.positions.push(world_from_local(instance, local).to_array());
        posed.normals.push(turn(instance.yaw_rad, turned).normalize_or(Vec3::Y).to_array());
    }
    posed
}

fn mix_colors(from: [u8; 4], to: [u8; 4], fraction: f32) -> [u8; 4] {
    let mix = |(from, to): (u8, u8)| (f32::from(from) * (1.0 - fraction) + f32::from(to) * fraction + 0.5) as u8;
    std::array::from_fn(|channel| mix((from[channel], to[channel])))
}

/// Where in its clip an instance is: `t = (time + phase) mod duration`, `frame = t / duration * (frames - 1)`.
pub fn frame_pair(clip: &ClipRecord, phase_s: f32, time_s: f32) -> FramePair {
    let last = clip.frame_count.max(1) - 1;
    if clip.duration_s <= 0.0 || last == 0 {
        return FramePair { first: 0, second: 0, blend: 0.0 };
    }
    let turns = (time_s + phase_s) / clip.duration_s;
    let frame = (turns - turns.floor()) * last as f32;
    let first = (frame.floor().max(0.0) as u32).min(last);
    FramePair { first, second: (first + 1).min(last), blend: frame - first as f32 }
}

/// Three rows a joint, blended between the instance's two frames, and with those of the clip that it leaves.
pub(super) fn blend_palette(data: &CrowdData, instance: &InstanceRecord, time_s: f32) -> Vec<Vec4> {
    let drawn = drawn_instance(data, instance, MorphRecord::default(), time_s);
    palette(data, &drawn)
}

fn palette(data: &CrowdData, drawn: &DrawnInstance) -> Vec<Vec4> {
    (0..drawn.row_count / 3).flat_map(|joint| data.blended_joint(drawn, joint)).collect()
}

/// The palettes of the clip that an instance plays and, where it fades, of the one that it leaves, each with its share.
fn clip_palettes(data: &CrowdData, instance: &InstanceRecord, time_s: f32) -> Vec<(f32, Vec<Vec4>)> {
    let drawn = drawn_instance(data, instance, MorphRecord::default(), time_s);
    let played = DrawnInstance { leaving_share: 0.0, ..drawn };
    let left = DrawnInstance {
        first_texel: drawn.leaving_first_texel,
        second_texel: drawn.leaving_second_texel,
        blend: drawn.leaving_blend,
        ..played
    };
    let shares = [(1.0 - drawn.leaving_share, played), (drawn.leaving_share, left)];
    let clips = shares.into_iter().take(if drawn.leaving_share > 0.0 { 2 } else { 1 });
    clips.map(|(share, one)| (share, palette(data, &one))).collect()
}

/// Rows of the weighted sum of a vertex's joints in each clip, mixed: the order in which the vertex shader adds. Palettes mix each joint first.
fn sum_of_clips(clips: &[(f32, Vec<Vec4>)], joints: [u32; 2], weights: [u32; 2]) -> [Vec4; 3] {
    clips.iter().fold([Vec4::ZERO; 3], |sum, (share, palette)| {
        let rows = skin_matrix(palette, joints, weights);
        [0, 1, 2].map(|r| sum[r] + rows[r] * *share)
    })
}

/// Rows of the weighted sum of a vertex's joints.
pub(super) fn skin_matrix(palette: &[Vec4], joints: [u32; 2], weights: [u32; 2]) -> [Vec4; 3] {
    let mut rows = [Vec4::ZERO; 3];
    for influence in 0..4 {
        let shift = (influence % 2) * 16;
        let joint = ((joints[influence / 2] >> shift) & 0xffff) as usize;
        let weight = ((weights[influence / 2] >> shift) & 0xffff) as f32 / 65_535.0;
        if weight > 0.0 {
            for (r, row) in rows.iter_mut().enumerate() {
                *row += palette[joint * 3 + r] * weight;
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_pack::{CharacterRecord, encode_normal};

    fn clip(frame_count: u32, duration_s: f32) -> ClipRecord {
        ClipRecord { frame_count, duration_s, ..Default::default() }
    }

    #[test]
    fn time_and_phase_choose_two_frames_and_a_share() {
        let five = clip(5, 2.0);
        assert_eq!(frame_pair(&five, 0.0, 0.0), FramePair { first: 0, second: 1, blend: 0.0 });
        assert_eq!(frame_pair(&five, 0.5, 0.25), FramePair { first: 1, second: 2, blend: 0.5 });
        // Two seconds a turn: 4.75 s is 0.75 s into the third.
        assert_eq!(frame_pair(&five, 0.5, 4.25), FramePair { first: 1, second: 2, blend: 0.5 });
        // Before the start it counts backwards.
        assert_eq!(frame_pair(&five, 0.0, -0.25), FramePair { first: 3, second: 4, blend: 0.5 });
    }

    #[test]
    fn a_single_pose_has_no_time() {
        let still = FramePair { first: 0, second: 0, blend: 0.0 };
        assert_eq!(frame_pair(&clip(1, 2.0), 0.3, 9.0), still);
        assert_eq!(frame_pair(&clip(5, 0.0), 0.3, 9.0), still);
        assert_eq!(frame_pair(&clip(0, 1.0), 0.3, 9.0), still);
    }

    /// One vertex a metre up, half on a joint that stays and half on one that moves 2 m along x within the clip.
    fn arm() -> CrowdData {
        let shifted = |x: f32| [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let frames = [[shifted(0.0), shifted(0.0)], [shifted(0.0), shifted(2.0)]];
        CrowdData {
            characters: vec![CharacterRecord { vertex_count: 1, joint_count: 2, clip_count: 1, ..Default::default() }],
            vertices: vec![VertexRecord {
                position: [0.0, 1.0, 0.0],
                normal_oct: encode_normal([0.0, 0.0, 1.0]),
                joints: [1 << 16, 0],
                weights: [32_768 | (32_767 << 16), 0],
                ..Default::default()
            }],
            collapse_map: vec![0],
            clips: vec![clip(2, 1.0)],
            animation: frames.as_flattened().as_flattened().iter().map(|row| row.map(f32::to_bits)).collect(),
            ..Default::default()
        }
    }

    #[test]
    fn a_vertex_follows_its_joints_by_weight_and_the_frames_by_time() {
        let choice = LodChoice { vertex_count: 1, triangle_count: 0 };
        let turned = InstanceRecord {
            position: [10.0, 0.0, 0.0],
            yaw_rad: std::f32::consts::FRAC_PI_2,
            scale: 2.0,
            ..Default::default()
        };
        let posed = pose_instance(&arm(), &turned, choice, 0.5);
        // Half the way of half the weight is 0.5 m along x; a quarter turn from +Z to +X takes +X to -Z; twice the size.
        let [x, y, z] = posed.positions[0];
        assert!((x - 10.0).abs() < 1e-4 && (y - 2.0).abs() < 1e-4 && (z + 1.0).abs() < 1e-3, "{x} {y} {z}");
        let [x, y, z] = posed.normals[0];
        assert!((x - 1.0).abs() < 1e-4 && y.abs() < 1e-4 && z.abs() < 1e-4, "{x} {y} {z}");
    }
}
