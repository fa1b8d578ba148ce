// Poses that are held for a while (ERATO §4). Twin: crowd-stages/src/cpu/hold_poses.rs. Needs place.wgsl.

const HOLD_TICK_S: f32 = 0.02;
const HOLD_SHORTEST_S: f32 = 0.02;
const HOLD_LONGEST_S: f32 = 0.25;

// Ticks between two poses of an instance that far away: 0 where its pose is always new. `speed_m_s`: of the fastest point of its clip
// at scale 1.
fn hold_ticks(instance: InstanceRecord, clip: ClipRecord, speed_m_s: f32, sphere: vec4f) -> u32 {
    // What is left within its clip alone is held; a single pose needs not be.
    if instance.leaving_share > 0.0 || clip.duration_s <= 0.0 || clip.frame_count < 2u {
        return 0u;
    }
    let nearest_m = max(distance(sphere.xyz, config.eye) - sphere.w, 0.0);
    var wanted_s = config.hold_px * nearest_m / max(config.focal_px * instance.scale * speed_m_s, 1e-6);
    if config.hold_far_m > 0.0 {
        let far = min(nearest_m / config.hold_far_m, 1.0);
        wanted_s = HOLD_SHORTEST_S + (HOLD_LONGEST_S - HOLD_SHORTEST_S) * far * far;
    }
    let ticks = wanted_s / HOLD_TICK_S;
    return select(0u, 1u, ticks >= 1.0) + select(0u, 1u, ticks >= 2.0) + select(0u, 2u, ticks >= 4.0)
        + select(0u, 4u, ticks >= 8.0) + select(0u, 4u, ticks >= 12.0);
}

// Number of the pose that is held, in ticks from the clip's beginning.
fn held_tick(instance: InstanceRecord, clip: ClipRecord, ticks: u32) -> u32 {
    return u32(clip_seconds(instance, clip) / (f32(ticks) * HOLD_TICK_S)) * ticks;
}

// Poses of a clip that may be held: its ticks, at least one.
fn clip_ticks(clip: ClipRecord) -> u32 {
    return u32(max(clip.duration_s, 0.0) / HOLD_TICK_S) + 1u;
}

// Seconds from the clip's beginning.
fn clip_seconds(instance: InstanceRecord, clip: ClipRecord) -> f32 {
    let turns = (config.time_s + instance.phase_s) / clip.duration_s;
    return (turns - floor(turns)) * clip.duration_s;
}
