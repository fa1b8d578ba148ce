// What stands still around the crowd: triangles of one colour a corner, lit like the crowd, seen from their front alone.

@group(0) @binding(0) var<uniform> config: FrameConfig;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) normal: vec3f,
    @location(1) color: vec3f,
    @location(2) world_position: vec3f,
}

@vertex
fn place(@location(0) position: vec3f, @location(1) color: vec4f, @location(2) normal: vec3f) -> Corner {
    return Corner(config.clip_from_world * vec4f(position, 1.0), normal, color.rgb, position);
}

@fragment
fn shade(corner: Corner) -> @location(0) vec4f {
    let normal = normalize(corner.normal);
    let color = corner.color * light_at(normal, sun_share(corner.world_position, normal));
    return vec4f(through_fog(color, distance(corner.world_position, config.eye), config.fog_per_m), 1.0);
}
