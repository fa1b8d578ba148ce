// An instance's place in the world.

// Turns by the instance's yaw: 0 faces +Z, positive turns towards +X.
fn turn(yaw_rad: f32, v: vec3f) -> vec3f {
    let s = sin(yaw_rad);
    let c = cos(yaw_rad);
    return vec3f(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
}

fn world_from_local(instance: InstanceRecord, p: vec3f) -> vec3f {
    return instance.position + turn(instance.yaw_rad, p * instance.scale);
}
