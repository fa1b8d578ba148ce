// Far characters as points of their surface, a pixel each (Dong 2019 §6.2 compares with such). Compiled with crowd.wgsl, whose
// bindings and inputs it has. Vertex twin: crowd-stages/src/cpu/pose_points.rs.

struct PointSurface {
    @builtin(position) clip_position: vec4f,
    @location(0) world_position: vec3f,
    @location(1) @interpolate(flat) normal: vec3f,
    @location(2) @interpolate(flat) color: vec4f,
}

// A point is a PointRecord in the words of a mesh's vertex.
@vertex
fn points(vertex: MeshVertex, owner: Owner) -> PointSurface {
    let drawn = drawn_of(owner);
    let rows = skin_matrix(vertex.skin, vertex.skin, 1.0, drawn);
    let local = vec4f(bitcast<vec3f>(vertex.place.xyz), 1.0) * rows;
    let turned = turn_by(drawn.turn, vec4f(decode_normal(vertex.place.w), 0.0) * rows);
    var point: PointSurface;
    point.world_position = drawn.position + turn_by(drawn.turn, local * drawn.scale);
    point.clip_position = config.clip_from_world * vec4f(point.world_position, 1.0);
    let towards = dot(turned, config.eye - point.world_position);
    let length = length(turned);
    let normal = select(vec3f(0.0, 1.0, 0.0), turned / length, length > 0.0);
    point.normal = select(normal, -normal, towards < 0.0);
    point.color = unpack4x8unorm(vertex.looks.x);
    if towards < 0.0 && vertex.looks.y == 0u {
        // The back: nothing is drawn.
        point.clip_position = vec4f(2.0, 2.0, 2.0, 1.0);
    }
    return point;
}

@fragment
fn shade_point(point: PointSurface) -> @location(0) vec4f {
    let base = point.color.rgb * point.color.rgb;
    let light = light_at(point.normal, sun_share(point.world_position, point.normal));
    let color = base * select(vec3f(1.0), light, point.color.a > 0.5);
    return vec4f(through_fog(color, distance(point.world_position, config.eye), config.fog_per_m), 1.0);
}
