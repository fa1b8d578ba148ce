//! Poses that are held for a while.

use super::world_sphere;
use crate::{CrowdData, FrameConfig, InstanceRecord};
use crowd_pack::ClipRecord;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Seconds of a tick: poses change 50 times a second at most.
pub const HOLD_TICK_S: f32 = 0.02;
/// Seconds between two poses at the camera.
pub const HOLD_SHORTEST_S: f32 = 0.02;
/// The same from `hold_far_m` on: 4 a second.
pub const HOLD_LONGEST_S: f32 = 0.25;

/// Sets how long ago each instance's pose is of: far ones keep theirs for up to a quarter of a second.
///
/// Poses change at 1/50 s, or 2, 4, 8 or 12 of these ticks, counted from the clip's beginning: so phases spread the changes evenly over the
/// frames, and instances of one clip hold the same poses whatever their phase. How many: with `config.hold_far_m`, 50 a second at the
/// camera to 4 a second from there on, the time between them growing with the squared distance; else as many as keep the fastest
/// point of the clip within `config.hold_px` pixels of where it should be. Who fades is never held, nor is a clip that has one pose.
///
/// `clip_speeds`: of [`clip_speeds`], one a clip. Distances are to the nearest point of the sphere that culls.
///
/// Paper: ERATO §4: 50 Hz to 4 Hz, linear in the squared distance. Departs: five rates instead of any, poses of the clip instead of
/// those of each one's own time, so that they can be shared; nothing is kept from frame to frame. Its distance where 4 Hz begin
/// is not given. Twin: `shaders/stages/hold_poses.wgsl`. Within [`HELD_BOUND_S`] but at the border of two poses or rates.
pub fn hold_poses(data: &CrowdData, clip_speeds: &[f32], config: &FrameConfig, instances: &mut [InstanceRecord]) {
    for instance in instances {
        let clip = &data.clips[instance.clip as usize];
        let ticks = hold_ticks(data, clip_speeds[instance.clip as usize], config, instance);
        instance.held_s = match ticks {
            0 => 0.0,
            _ => clip_seconds(clip, instance, config) - held_tick(clip, instance, config, ticks) as f32 * HOLD_TICK_S,
        };
    }
}

/// How far GPU and CPU may differ in seconds held: those of a quotient of times of some hundred seconds.
pub const HELD_BOUND_S: f32 = 1e-4;

/// Ticks between two poses of an instance; 0 where its pose is always new.
pub fn hold_ticks(data: &CrowdData, speed_m_s: f32, config: &FrameConfig, instance: &InstanceRecord) -> u32 {
    let clip = &data.clips[instance.clip as usize];
    if instance.leaving_share > 0.0 || clip.duration_s <= 0.0 || clip.frame_count < 2 {
        return 0;
    }
    let (center, radius) = world_sphere(data, instance);
    let nearest_m = (center.distance(Vec3::from_array(config.eye)) - radius).max(0.0);
    let mut wanted_s = config.hold_px * nearest_m / (config.focal_px * instance.scale * speed_m_s).max(1e-6);
    if config.hold_far_m > 0.0 {
        let far = (nearest_m / config.hold_far_m).min(1.0);
        wanted_s = HOLD_SHORTEST_S + (HOLD_LONGEST_S - HOLD_SHORTEST_S) * far * far;
    }
    let ticks = wanted_s / HOLD_TICK_S;
    [12, 8, 4, 2, 1].into_iter().find(|&most| ticks >= most as f32).unwrap_or(0)
}

/// Number of the pose that is held, in ticks from the clip's beginning.
pub fn held_tick(clip: &ClipRecord, instance: &InstanceRecord, config: &FrameConfig, ticks: u32) -> u32 {
    (clip_seconds(clip, instance, config) / (ticks as f32 * HOLD_TICK_S)) as u32 * ticks
}

fn clip_seconds(clip: &ClipRecord, instance: &InstanceRecord, config: &FrameConfig) -> f32 {
    let turns = (config.time_s + instance.phase_s) / clip.duration_s;
    (turns - turns.floor()) * clip.duration_s
}

/// Vertices of the collapse order that tell how fast a clip is: they are those that its shape needs most.
const SPEED_VERTICES: usize = 512;

/// The speed of the fastest vertex of each clip, metres a second at scale 1; 0 of a single pose.
///
/// Of the first 512 vertices of the character's collapse order. Between frames matrices go evenly, so vertices do, too: this is no
/// sample but the speed of these. About 10 ms a million of vertices and frames on two cores.
pub fn clip_speeds(data: &CrowdData) -> Vec<f32> {
    let mut speeds = vec![0.0; data.clips.len()];
    for (number, character) in (0..).zip(&data.characters) {
        let first = character.vertex_offset as usize;
        let vertices = &data.vertices[first..first + (character.vertex_count as usize).min(SPEED_VERTICES)];
        let clips = character.clip_offset..character.clip_offset + character.clip_count;
        let speed = |clip: u32| {
            let record = &data.clips[clip as usize];
            let steps = record.frame_count.max(1) - 1;
            if steps == 0 || record.duration_s <= 0.0 {
                return 0.0;
            }
            let frame_s = record.duration_s / steps as f32;
            let pose = |frame: u32| -> Vec<Vec3> {
                let instance = InstanceRecord { scale: 1.0, character: number, clip, ..Default::default() };
                // The end of the last turn, not the beginning of the next.
                let palette = super::pose_instance::blend_palette(data, &instance, frame as f32 * frame_s * 0.999_99);
                let place = |vertex: &crowd_pack::VertexRecord| {
                    let rows = super::pose_instance::skin_matrix(&palette, vertex.joints, vertex.weights);
                    let position: Vec4 = Vec3::from_array(vertex.position).extend(1.0);
                    Vec3::new(rows[0].dot(position), rows[1].dot(position), rows[2].dot(position))
                };
                vertices.iter().map(place).collect()
            };
            let mut greatest = 0.0f32;
            let mut last = pose(0);
            for frame in 1..=steps {
                let now = pose(frame);
                let moved = now.iter().zip(&last).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
                greatest = greatest.max(moved / frame_s);
                last = now;
            }
            greatest
        };
        let of_character: Vec<f32> = clips.clone().into_par_iter().map(speed).collect();
        speeds[clips.start as usize..clips.end as usize].copy_from_slice(&of_character);
    }
    speeds
}
