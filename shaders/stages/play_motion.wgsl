// Which clip each instance plays by now, which it leaves, and where it is in both: looked up in its schedule, so any time may follow
// any other. Twin: crowd-stages/src/cpu/play_motion.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> motions: array<MotionRecord>;
@group(0) @binding(2) var<storage, read> schedules: array<MotionSchedule>;
@group(0) @binding(3) var<storage, read> stretches: array<MotionStretch>;
@group(0) @binding(4) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(5) var<storage, read_write> instances: array<InstanceRecord>;

// Turns after so many seconds of a fade in which the rate goes evenly from one to the other.
fn turned(since_s: f32, first_hz: f32, last_hz: f32, fade_s: f32) -> f32 {
    return since_s * (first_hz + (last_hz - first_hz) * (0.5 * since_s / max(fade_s, 1e-6)));
}

// The last stretch that starts at or before a time.
fn stretch_at(schedule: MotionSchedule, time_s: f32) -> u32 {
    var low = 0u;
    var high = schedule.count;
    while low + 1u < high {
        let middle = (low + high) / 2u;
        if stretches[schedule.first + middle].start_s <= time_s {
            low = middle;
        } else {
            high = middle;
        }
    }
    return schedule.first + low;
}

// The phase with which a clip has done so many turns by now.
fn phase_of(clip: u32, turns: f32) -> f32 {
    return (turns - floor(turns)) * clips[clip].duration_s - config.time_s;
}

@compute @workgroup_size(BLOCK_SIZE)
fn play_motion(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count || motions[i].schedule == NONE {
        return;
    }
    let schedule = schedules[motions[i].schedule];
    let time_s = config.time_s + motions[i].ahead_s;
    let within_s = time_s - floor(time_s / schedule.loop_s) * schedule.loop_s;
    let one = stretches[stretch_at(schedule, within_s)];
    let since_s = within_s - one.start_s;
    let fading_s = min(since_s, one.fade_s);
    let turns = one.turns + turned(fading_s, one.first_rate_hz, one.rate_hz, one.fade_s)
        + (since_s - fading_s) * one.rate_hz;
    let left_turns = one.left_turns + turned(fading_s, one.left_rate_hz, one.left_last_rate_hz, one.fade_s);
    // Neither end of a fade jumps in speed.
    let done = select(1.0, fading_s / max(one.fade_s, 1e-6), since_s < one.fade_s);
    instances[i].clip = one.clip;
    instances[i].phase_s = phase_of(one.clip, turns);
    instances[i].leaving_clip = one.left_clip;
    instances[i].leaving_phase_s = phase_of(one.left_clip, left_turns);
    instances[i].leaving_share = 1.0 - done * done * (3.0 - 2.0 * done);
}
