//! Fades between clips: nothing jumps, and nothing leaves its bounds.

use crowd_scene::{Cast, Gait, GaitClip, Mover, Walker};
use crowd_stages::{CrowdData, InstanceRecord, LodChoice, cpu};
use crowd_tests::synthetic;
use glam::Vec3;

/// Between two looks at somebody, seconds.
const STEP_S: f32 = 1.0 / 240.0;

fn coarsest(data: &CrowdData, character: u32) -> LodChoice {
    let record = &data.characters[character as usize];
    LodChoice { vertex_count: record.min_vertex_count, triangle_count: 0 }
}

fn positions(data: &CrowdData, instance: &InstanceRecord, time_s: f32) -> Vec<Vec3> {
    let posed = cpu::pose_instance(data, instance, coarsest(data, instance.character), time_s);
    posed.positions.into_iter().map(Vec3::from_array).collect()
}

#[test]
fn every_pose_of_a_fade_lies_within_the_sphere_that_culls() {
    let data = synthetic::crowd();
    let mut fading = 0;
    let mut outside_own = 0;
    for mut instance in synthetic::instances(&data, 400) {
        instance.scale *= 1.3;
        fading += usize::from(instance.leaving_share > 0.0);
        for time_s in [0.0, 0.37, 1.3, 9.9] {
            let (center, radius) = cpu::world_sphere(&data, &instance);
            let alone = cpu::world_sphere(&data, &InstanceRecord { leaving_share: 0.0, ..instance });
            for position in positions(&data, &instance, time_s) {
                assert!(position.distance(center) <= radius * 1.0001 + 1e-5, "{instance:?} at {time_s}: {position}");
                outside_own += usize::from(position.distance(alone.0) > alone.1 * 1.001);
            }
        }
    }
    assert!(fading > 100, "{fading} of 400 fade");
    // The clip that plays would not do: the test would see it.
    assert!(outside_own > 0, "the clips' spheres differ");
}

/// The greatest speed of a vertex while somebody starts to run at 5 s, metres a second.
fn greatest_speed(data: &CrowdData, fade_s: f32) -> f32 {
    let clips = [0, 1, 2].map(|clip| GaitClip {
        clip: clip % data.characters[1].clip_count,
        duration_s: data.clips[(data.characters[1].clip_offset + clip % data.characters[1].clip_count) as usize]
            .duration_s,
        ..Default::default()
    });
    let cast = Cast { movers: vec![Mover { clips, scale: 1.0, run_ahead_turns: 0.0 }], seed: 3, fade_s };
    let mut greatest = 0.0f32;
    let mut last: Option<Vec<Vec3>> = None;
    for i in 0..240 {
        let time_s = 4.5 + i as f32 * STEP_S;
        let changed_s = time_s - 5.0;
        let walker = Walker {
            id: 4,
            position: Vec3::ZERO,
            yaw_rad: 0.4,
            speed_m_s: 0.0,
            gait: if changed_s >= 0.0 { Gait::Walk } else { Gait::Idle },
            walked_m: 0.0,
            ran_m: 0.0,
            gait_before: Gait::Idle,
            changed_s: if changed_s >= 0.0 { changed_s } else { f32::INFINITY },
        };
        let one = cast.instance(&walker, time_s);
        let offset = data.characters[1].clip_offset;
        let instance = InstanceRecord {
            yaw_rad: one.yaw_rad,
            scale: one.scale,
            character: 1,
            clip: offset + one.clip,
            phase_s: one.phase_s,
            leaving_clip: offset + one.leaving.clip,
            leaving_phase_s: one.leaving.phase_s,
            leaving_share: one.leaving.share,
            ..Default::default()
        };
        let now = positions(data, &instance, time_s);
        if let Some(last) = &last {
            let moved = now.iter().zip(last).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            greatest = greatest.max(moved / STEP_S);
        }
        last = Some(now);
    }
    greatest
}

/// A fade adds at most the way between the poses over its time, half as much again in its middle, to the clips' own speeds; a change
/// at once goes the whole way within a step.
#[test]
fn nobody_jumps_from_clip_to_clip_but_without_fades() {
    let data = synthetic::crowd();
    let (faded, at_once) = (greatest_speed(&data, 0.3), greatest_speed(&data, 0.0));
    assert!(at_once > 4.0 * faded, "{faded} m/s with a fade, {at_once} m/s without");
    assert!(faded < 12.0, "{faded} m/s");
}
