// Everyone of a flock as an instance with a clip that follows the metres walked. Twin: crowd-stages/src/cpu/place_boids.rs.

@group(0) @binding(0) var<uniform> flock: FlockConfig;
@group(0) @binding(1) var<storage, read> boids: array<BoidRecord>;
@group(0) @binding(2) var<storage, read> traits: array<BoidTraits>;
@group(0) @binding(3) var<storage, read> movers: array<MoverRecord>;
@group(0) @binding(4) var<storage, read_write> instances: array<InstanceRecord>;

@compute @workgroup_size(BLOCK_SIZE)
fn place_boids(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= flock.boid_count {
        return;
    }
    let boid = boids[i];
    let mine = traits[i];
    let character = movers[mine.mover].character;
    let scale = movers[mine.mover].scale * mine.scale;
    let clip = movers[mine.mover].clips[min(boid.gait, 2u)];
    var moved = vec3f(0.0);
    var phase_s = 0.0;
    if clip.duration_s > 0.0 {
        let own_speed = clip.ground_speed_m_s * scale;
        let follows = boid.gait != 0u && own_speed >= flock.least_clip_speed_m_s;
        let since = select(flock.time_s, boid.walked_m / max(own_speed, 1e-6), follows);
        let clip_time = mine.start * clip.duration_s + since;
        let ahead = clip_time - flock.time_s;
        phase_s = ahead - clip.duration_s * floor(ahead / clip.duration_s);
        // What the clip itself moves is taken out again.
        let turns = clip_time / clip.duration_s;
        moved = turn(boid.yaw_rad, clip.displacement_m * ((turns - floor(turns)) * scale));
    }
    let position = vec3f(boid.place.x, 0.0, boid.place.y) - moved;
    instances[i] = InstanceRecord(position, boid.yaw_rad, scale, character, clip.clip, phase_s);
}
