//! Everyone of a flock as an instance.

use super::turn;
use crate::{BoidRecord, BoidTraits, FlockConfig, InstanceRecord, MoverRecord};
use glam::Vec3;

/// Instances at `flock.time_s`, in order of the boids' numbers. A clip whose ground speed is known follows the metres walked, so
/// that feet do not slide; another plays at its own rate. What the clip itself moves the character by is taken out again.
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
    let clip = &mover.clips[boid.gait.min(2) as usize];
    let scale = mover.scale * mine.scale;
    let (mut moved, mut phase_s) = (Vec3::ZERO, 0.0);
    if clip.duration_s > 0.0 {
        let own_speed = clip.ground_speed_m_s * scale;
        let follows = boid.gait != 0 && own_speed >= flock.least_clip_speed_m_s;
        let since = if follows { boid.walked_m / own_speed } else { flock.time_s };
        let clip_time = mine.start * clip.duration_s + since;
        let ahead = clip_time - flock.time_s;
        phase_s = ahead - clip.duration_s * (ahead / clip.duration_s).floor();
        let turns = clip_time / clip.duration_s;
        moved = Vec3::from(clip.displacement_m) * ((turns - turns.floor()) * scale);
    }
    let [x, z] = boid.place;
    let position = (Vec3::new(x, 0.0, z) - turn(boid.yaw_rad, moved)).to_array();
    InstanceRecord { position, yaw_rad: boid.yaw_rad, scale, character: mover.character, clip: clip.clip, phase_s }
}
