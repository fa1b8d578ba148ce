// Everyone of a flock as an instance with a clip that follows the metres walked. Twin: crowd-stages/src/cpu/place_boids.rs.

@group(0) @binding(0) var<uniform> flock: FlockConfig;
@group(0) @binding(1) var<storage, read> boids: array<BoidRecord>;
@group(0) @binding(2) var<storage, read> traits: array<BoidTraits>;
@group(0) @binding(3) var<storage, read> movers: array<MoverRecord>;
@group(0) @binding(4) var<storage, read_write> instances: array<InstanceRecord>;

// A clip at a time: seconds that it is ahead of the clock, and what it has moved the character by.
struct Played {
    clip: u32,
    phase_s: f32,
    moved: vec3f,
}

// Metres of one turn of a clip, 0 where its speed is not known.
fn stride_of(mover: u32, gait: u32, size: f32) -> f32 {
    let own_speed = movers[mover].clips[gait].ground_speed_m_s * size;
    let duration_s = movers[mover].clips[gait].duration_s;
    let is_known = own_speed >= flock.least_clip_speed_m_s && duration_s > 0.0;
    return select(0.0, own_speed * duration_s, is_known);
}

// Turns of a gait's clip by now: walking and running count the same steps.
fn turns_of(mover: u32, gait: u32, boid: BoidRecord, size: f32) -> f32 {
    let walk_m = stride_of(mover, 1u, size);
    let run_m = stride_of(mover, 2u, size);
    if gait != 0u && walk_m > 0.0 && run_m > 0.0 {
        let ahead = select(0.0, movers[mover].run_ahead_turns, gait == 2u);
        return (boid.walked_m - boid.ran_m) / walk_m + boid.ran_m / run_m + ahead;
    }
    let own_m = select(select(0.0, walk_m, gait == 1u), run_m, gait == 2u);
    if own_m > 0.0 {
        return boid.walked_m / own_m;
    }
    let duration_s = movers[mover].clips[gait].duration_s;
    return select(0.0, flock.time_s / max(duration_s, 1e-6), duration_s > 0.0);
}

// Where a clip's root path is after so many turns.
fn beside(mover: u32, gait: u32, turns: f32) -> vec3f {
    let at = (turns - floor(turns)) * f32(ROOT_PATH_POINTS);
    let first = min(u32(at), ROOT_PATH_POINTS - 1u);
    let a = movers[mover].clips[gait].root_path_m[first];
    let b = movers[mover].clips[gait].root_path_m[(first + 1u) % ROOT_PATH_POINTS];
    let now = a + (b - a) * (at - f32(first));
    return vec3f(now.x, 0.0, now.y);
}

fn played(mover: u32, gait: u32, boid: BoidRecord, size: f32, start: f32) -> Played {
    let duration_s = movers[mover].clips[gait].duration_s;
    let turns = start + turns_of(mover, gait, boid, size);
    var phase_s = 0.0;
    if duration_s > 0.0 {
        let ahead = turns * duration_s - flock.time_s;
        phase_s = ahead - duration_s * floor(ahead / duration_s);
    }
    let moved = movers[mover].clips[gait].displacement_m * (turns - floor(turns)) - beside(mover, gait, turns);
    return Played(movers[mover].clips[gait].clip, phase_s, moved * size);
}

@compute @workgroup_size(BLOCK_SIZE)
fn place_boids(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= flock.boid_count {
        return;
    }
    let boid = boids[i];
    let mine = traits[i];
    let size = movers[mine.mover].scale * mine.scale;
    let now = played(mine.mover, min(boid.gait, 2u), boid, size, mine.start);
    let left = played(mine.mover, min(boid.gait_before, 2u), boid, size, mine.start);
    var share = 0.0;
    if left.clip != now.clip && boid.changed_s < flock.fade_s {
        let done = clamp(boid.changed_s / flock.fade_s, 0.0, 1.0);
        share = 1.0 - done * done * (3.0 - 2.0 * done);
    }
    // What clips move the character by is taken out again.
    let moved = turn(boid.yaw_rad, now.moved + (left.moved - now.moved) * share);
    instances[i] = InstanceRecord(
        vec3f(boid.place.x, 0.0, boid.place.y) - moved,
        boid.yaw_rad,
        size,
        movers[mine.mover].character,
        now.clip,
        now.phase_s,
        left.clip,
        left.phase_s,
        share,
        0.0,
    );
}
