//! Everyone of a flock as an instance.

use super::turn;
use crate::{BoidRecord, BoidTraits, FlockConfig, GaitClipRecord, InstanceRecord, MoverRecord};
use glam::Vec3;

/// Instances at `flock.time_s`, in order of the boids' numbers. A clip whose ground speed is known follows the metres walked, so
/// that feet do not slide; another plays at its own rate. For `flock.fade_s` after a change the gait before shares in the pose. What
/// clips themselves move the character by is taken out again, and they go along their clips' root paths. The rules are those of
/// `Cast::instance` in `crowd-scene`.
///
/// Twin: `shaders/stages/place_boids.wgsl`. Phases within a share of 1e-5 of the clip's time; places within 2^-10 of what the clip
/// moves, for WGSL's sine.
pub fn place_boids(
    flock: &FlockConfig,
    boids: &[BoidRecord],
    traits: &[BoidTraits],
    movers: &[MoverRecord],
) -> Vec<InstanceRecord> {
    boids.iter().zip(traits).map(|(boid, mine)| place(flock, boid, mine, &movers[mine.mover as usize])).collect()
}

fn place(flock: &FlockConfig, boid: &BoidRecord, mine: &BoidTraits, mover: &MoverRecord) -> InstanceRecord {
    let scale = mover.scale * mine.scale;
    let played = |gait: u32| {
        let clip = &mover.clips[gait.min(2) as usize];
        let turns = mine.start + turns(flock, mover, gait, boid, scale);
        let ahead = turns * clip.duration_s - flock.time_s;
        let phase_s =
            if clip.duration_s > 0.0 { ahead - clip.duration_s * (ahead / clip.duration_s).floor() } else { 0.0 };
        let moved = Vec3::from(clip.displacement_m) * (turns - turns.floor()) - beside(clip, turns);
        (clip.clip, phase_s, moved * scale)
    };
    let (clip, phase_s, moved) = played(boid.gait);
    let (leaving_clip, leaving_phase_s, left_moved) = played(boid.gait_before);
    let mut leaving_share = 0.0;
    if leaving_clip != clip && boid.changed_s < flock.fade_s {
        let done = (boid.changed_s / flock.fade_s).clamp(0.0, 1.0);
        leaving_share = 1.0 - done * done * (3.0 - 2.0 * done);
    }
    let moved = moved + (left_moved - moved) * leaving_share;
    let [x, z] = boid.place;
    InstanceRecord {
        position: (Vec3::new(x, 0.0, z) - turn(boid.yaw_rad, moved)).to_array(),
        yaw_rad: boid.yaw_rad,
        scale,
        character: mover.character,
        clip,
        phase_s,
        leaving_clip,
        leaving_phase_s,
        leaving_share,
        held_s: 0.0,
    }
}

/// Where a clip's root path is after so many turns.
fn beside(clip: &GaitClipRecord, turns: f32) -> Vec3 {
    let count = clip.root_path_m.len();
    let at = (turns - turns.floor()) * count as f32;
    let first = (at as usize).min(count - 1);
    let ([ax, az], [bx, bz]) = (clip.root_path_m[first], clip.root_path_m[(first + 1) % count]);
    let share = at - first as f32;
    Vec3::new(ax + (bx - ax) * share, 0.0, az + (bz - az) * share)
}

/// Turns of a gait's clip by now: where both strides are known, walking and running count the same steps.
fn turns(flock: &FlockConfig, mover: &MoverRecord, gait: u32, boid: &BoidRecord, scale: f32) -> f32 {
    let stride = |clip: &GaitClipRecord| {
        let own_speed = clip.ground_speed_m_s * scale;
        let is_known = own_speed >= flock.least_clip_speed_m_s && clip.duration_s > 0.0;
        is_known.then_some(own_speed * clip.duration_s)
    };
    let duration_s = mover.clips[gait.min(2) as usize].duration_s;
    let ahead = if gait == 2 { mover.run_ahead_turns } else { 0.0 };
    match (gait, stride(&mover.clips[1]), stride(&mover.clips[2])) {
        (1 | 2, Some(walk_m), Some(run_m)) => (boid.walked_m - boid.ran_m) / walk_m + boid.ran_m / run_m + ahead,
        (1, Some(stride_m), None) | (2, None, Some(stride_m)) => boid.walked_m / stride_m,
        _ if duration_s > 0.0 => flock.time_s / duration_s,
        _ => 0.0,
    }
}
