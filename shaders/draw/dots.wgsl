// Characters a few pixels high: a triangle for each part of them, turned to the eye. Compiled with crowd.wgsl, whose bindings and
// inputs it has. What a dot is: crowd-stages/src/dots.rs.

struct Dot {
    @builtin(position) clip_position: vec4f,
    @location(0) @interpolate(flat) color: vec3f,
}

const PI: f32 = 3.14159265;

// The mean of light_at over the side of a sphere that is seen from a direction: a body from far away. The sun's part is the
// phase function of a white ball (Lambert), the mean normal two thirds of the direction.
fn light_of_ball(towards_eye: vec3f) -> vec3f {
    let cosine = clamp(dot(towards_eye, SUN_DIRECTION), -1.0, 1.0);
    let angle = acos(cosine);
    let lit = 2.0 / (3.0 * PI) * (sqrt(1.0 - cosine * cosine) + (PI - angle) * cosine);
    let ambient = mix(GROUND_AMBIENT, SKY_AMBIENT, towards_eye.y / 3.0 + 0.5);
    return (ambient + SUN_COLOR * lit) * EXPOSURE;
}

// A dot's middle; its corner is a DotCorner in the words of a mesh's vertex.
fn dot_middle(vertex: MeshVertex, drawn: DrawnInstance) -> vec3f {
    let rows = skin_matrix(vertex.skin, vertex.skin, 1.0, drawn);
    let local = vec4f(bitcast<vec3f>(vertex.place.xyz), 1.0) * rows;
    return drawn.position + turn_by(drawn.turn, local * drawn.scale);
}

// The corner of a dot that is turned to the eye, or to the sun.
fn dot_corner(vertex: MeshVertex, drawn: DrawnInstance, middle: vec3f, towards_eye: vec3f) -> vec3f {
    let half_size_m = bitcast<vec2f>(vertex.looks.xy);
    // Seen from above nothing has a right side; any will do.
    let across = length(towards_eye.xz);
    let right = select(vec3f(1.0, 0.0, 0.0), vec3f(towards_eye.z, 0.0, -towards_eye.x) / across, across > 1e-4);
    let up = cross(towards_eye, right);
    // From above the height is foreshortened to the depth, which is the width.
    let height_m = mix(half_size_m.x, half_size_m.y, across);
    let number = vertex.looks.z % 3u;
    let turned = select(1.0, -1.0, vertex.looks.z >= 3u);
    let x = select(select(0.0, 1.0, number == 1u), -1.0, number == 0u);
    // The middle of the corners is the dot's.
    let y = select(4.0 / 3.0, -2.0 / 3.0, number < 2u) * turned;
    return middle + (right * (half_size_m.x * x) + up * (height_m * y)) * drawn.scale;
}

@vertex
fn dots(vertex: MeshVertex, owner: Owner) -> Dot {
    let drawn = drawn_of(owner);
    let middle = dot_middle(vertex, drawn);
    let towards_eye = normalize(config.eye - middle);
    let place = dot_corner(vertex, drawn, middle, towards_eye);
    let color = unpack4x8unorm(vertex.place.w);
    let light = select(vec3f(1.0), light_of_ball(towards_eye), color.a > 0.5);
    let seen = through_fog(color.rgb * color.rgb * light, distance(middle, config.eye), config.fog_per_m);
    return Dot(config.clip_from_world * vec4f(place, 1.0), seen);
}

// Depth alone, for the shadow maps: the sun is the eye.
@vertex
fn dots_caster(vertex: MeshVertex, owner: Owner) -> @builtin(position) vec4f {
    let drawn = drawn_of(owner);
    let place = dot_corner(vertex, drawn, dot_middle(vertex, drawn), SUN_DIRECTION);
    return config.clip_from_world * vec4f(place, 1.0);
}

@fragment
fn shade_dot(dot: Dot) -> @location(0) vec4f {
    return vec4f(dot.color, 1.0);
}
