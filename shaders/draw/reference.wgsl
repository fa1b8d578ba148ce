// What the reference camera shows besides those who are drawn: the culled ones as dots, and the edges of the frustum that culled
// them (the second viewport of Dong & Peng 2019's film).

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> draw: DrawConfig;
@group(0) @binding(2) var<uniform> frustum: FrustumCorners;
@group(0) @binding(3) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(4) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(5) var<storage, read> culled: array<CullRecord>;

struct Mark {
    @builtin(position) clip_position: vec4f,
    @location(0) @interpolate(flat) color: vec3f,
}

const CULLED_COLOR = vec3f(0.93, 0.62, 0.02);
const EDGE_COLOR = vec3f(0.55, 0.02, 0.03);
// Nearest depth of an edge's end, metres.
const NEAREST_M: f32 = 0.05;

// Edges of the frustum by its corners: four at the near side, four at the far one, four between.
const ENDS = array<vec2u, 12>(
    vec2u(0u, 1u), vec2u(1u, 3u), vec2u(3u, 2u), vec2u(2u, 0u),
    vec2u(4u, 5u), vec2u(5u, 7u), vec2u(7u, 6u), vec2u(6u, 4u),
    vec2u(0u, 4u), vec2u(1u, 5u), vec2u(2u, 6u), vec2u(3u, 7u),
);

fn not_drawn() -> Mark {
    return Mark(vec4f(2.0, 2.0, 2.0, 1.0), vec3f(0.0));
}

// A triangle of some pixels at the middle of everyone whom the frustum does not meet.
@vertex
fn culled_dot(@builtin(vertex_index) corner: u32, @builtin(instance_index) i: u32) -> Mark {
    let instance = instances[i];
    if culled[i].visible != 0u || instance.scale == 0.0 || i >= config.instance_count {
        return not_drawn();
    }
    let middle = instance.position + vec3f(0.0, 0.5 * characters[instance.character].height_m * instance.scale, 0.0);
    let at = config.clip_from_world * vec4f(middle, 1.0);
    let angle = f32(corner) * 2.0943951;
    let half_px = max(draw.height_px / 160.0, 1.5);
    let aside = vec2f(sin(angle) / draw.width_px, cos(angle) / draw.height_px) * (2.0 * half_px * at.w);
    return Mark(at + vec4f(aside, 0.0, 0.0), CULLED_COLOR);
}

// Two triangles an edge, of a width in pixels.
@vertex
fn edge(@builtin(vertex_index) vertex: u32) -> Mark {
    var ends = ENDS;
    let pair = ends[vertex / 6u];
    var first = config.clip_from_world * frustum.corners[pair.x];
    var last = config.clip_from_world * frustum.corners[pair.y];
    if first.w < NEAREST_M && last.w < NEAREST_M {
        return not_drawn();
    }
    // What lies behind the camera is cut off.
    if first.w < NEAREST_M {
        first = mix(first, last, (NEAREST_M - first.w) / (last.w - first.w));
    } else if last.w < NEAREST_M {
        last = mix(last, first, (NEAREST_M - last.w) / (first.w - last.w));
    }
    let size = vec2f(draw.width_px, draw.height_px);
    let along = (last.xy / last.w - first.xy / first.w) * size;
    let aside = vec2f(-along.y, along.x) / max(length(along), 1e-6) * max(draw.height_px / 240.0, 1.0);
    let corner = vertex % 6u;
    let is_last = corner == 1u || corner == 2u || corner == 4u;
    let is_left = corner == 2u || corner == 4u || corner == 5u;
    let at = select(first, last, is_last);
    return Mark(at + vec4f(select(-aside, aside, is_left) / size * at.w, 0.0, 0.0), EDGE_COLOR);
}

@fragment
fn mark(mark: Mark) -> @location(0) vec4f {
    return vec4f(mark.color, 1.0);
}
