//! Where the steps of one clip are those of another: so that fades between walking and running do not cross legs.

use crowd_stages::{CrowdData, InstanceRecord, LodChoice, cpu};
use glam::Vec3;

/// Poses compared in a turn of a clip.
const POSES: usize = 24;

/// Turns that `other` is ahead of `clip` where the two are most alike, 0 to 1; 0 for clips without a turn. Both are indices among
/// all clips, of one character.
///
/// Compared are the coarsest level's vertices around their middle, so that what a clip moves the character by does not count.
/// Some thousands of vertices posed.
pub fn turns_ahead(data: &CrowdData, character: u32, clip: u32, other: u32) -> f32 {
    let has_turn = |clip: u32| data.clips[clip as usize].duration_s > 0.0 && data.clips[clip as usize].frame_count > 1;
    if clip == other || !has_turn(clip) || !has_turn(other) {
        return 0.0;
    }
    let (poses, others) = (poses(data, character, clip), poses(data, character, other));
    let apart = |ahead: usize| -> f64 {
        let pair = |(i, pose): (usize, &Vec<Vec3>)| -> f64 {
            let like = &others[(i + ahead) % POSES];
            pose.iter().zip(like).map(|(a, b)| f64::from(a.distance_squared(*b))).sum()
        };
        poses.iter().enumerate().map(pair).sum()
    };
    let best = (0..POSES).map(|ahead| (apart(ahead), ahead)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(0.0, |(_, ahead)| ahead as f32 / POSES as f32)
}

fn poses(data: &CrowdData, character: u32, clip: u32) -> Vec<Vec<Vec3>> {
    let record = &data.characters[character as usize];
    let coarsest = LodChoice { vertex_count: record.min_vertex_count, triangle_count: 0 };
    let instance = InstanceRecord { scale: 1.0, character, clip, ..Default::default() };
    let duration_s = data.clips[clip as usize].duration_s;
    let pose = |i: usize| {
        let time_s = duration_s * i as f32 / POSES as f32;
        let posed = cpu::pose_instance(data, &instance, coarsest, time_s);
        let mut points: Vec<Vec3> = posed.positions.into_iter().map(Vec3::from_array).collect();
        let middle = points.iter().sum::<Vec3>() / points.len().max(1) as f32;
        points.iter_mut().for_each(|point| *point -= middle);
        points
    };
    (0..POSES).map(pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_pack::{CharacterRecord, ClipRecord, VertexRecord};

    /// Two vertices a metre apart; the second swings along x once a turn. The second clip is a quarter turn ahead, has other frames
    /// and twice the swing.
    fn swings() -> CrowdData {
        let rows = |x: f32| [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let mut data = CrowdData {
            characters: vec![CharacterRecord {
                vertex_count: 2,
                min_vertex_count: 2,
                joint_count: 2,
                clip_count: 2,
                ..Default::default()
            }],
            vertices: vec![
                VertexRecord { weights: [65_535, 0], ..Default::default() },
                VertexRecord { position: [0.0, 1.0, 0.0], joints: [1, 0], weights: [65_535, 0], ..Default::default() },
            ],
            collapse_map: vec![0, 0],
            ..Default::default()
        };
        for (frames, swing, ahead) in [(25, 0.2, 0.0), (41, 0.4, 0.25)] {
            let texel_offset = data.animation.len() as u32;
            data.clips.push(ClipRecord { texel_offset, frame_count: frames, duration_s: 1.0, ..Default::default() });
            for frame in 0..frames {
                let turns = frame as f32 / (frames - 1) as f32 - ahead;
                let x = swing * libm::sinf(turns * std::f32::consts::TAU);
                crowd_pack::store_frame(crowd_pack::JointStorage::F32, &[rows(0.0), rows(x)], &mut data.animation);
            }
        }
        data
    }

    #[test]
    fn a_clip_that_is_ahead_is_found_out() {
        let data = swings();
        assert_eq!(turns_ahead(&data, 0, 0, 1), 0.25);
        assert_eq!(turns_ahead(&data, 0, 1, 0), 0.75);
        assert_eq!(turns_ahead(&data, 0, 0, 0), 0.0);
    }

    #[test]
    fn poses_without_a_turn_match_as_they_are() {
        let mut data = swings();
        data.clips[1].duration_s = 0.0;
        assert_eq!(turns_ahead(&data, 0, 0, 1), 0.0);
    }
}
