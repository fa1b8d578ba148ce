// What is shown besides those who are drawn. By the reference camera: the culled ones as dots, and the edges of the frustum that culled
// them (the second viewport of Dong & Peng 2019's film). By views: a tag over everyone whose colour says what was chosen for them.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> draw: DrawConfig;
@group(0) @binding(2) var<uniform> marks: MarkConfig;
@group(0) @binding(3) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(4) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(5) var<storage, read> culled: array<CullRecord>;
@group(0) @binding(6) var<storage, read> choices: array<LodChoice>;
// The number of instances it is valid for, then a word for each; where nobody is left out for being hidden, anything.
@group(0) @binding(7) var<storage, read> seen: array<u32>;

// Depth is 1 near and 0 far.
override REVERSED: bool = false;

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
    var first = config.clip_from_world * marks.corners[pair.x];
    var last = config.clip_from_world * marks.corners[pair.y];
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

struct Tag {
    @builtin(position) clip_position: vec4f,
    // Of the ellipse: its rim is at 1.
    @location(0) place: vec2f,
    @location(1) @interpolate(flat) color: vec4f,
}

// Blue over green and yellow to red.
fn heat(share: f32) -> vec3f {
    let t = clamp(share, 0.0, 1.0) * 3.0;
    let low = mix(vec3f(0.02, 0.07, 0.8), vec3f(0.0, 0.55, 0.15), clamp(t, 0.0, 1.0));
    let middle = mix(low, vec3f(0.95, 0.7, 0.0), clamp(t - 1.0, 0.0, 1.0));
    return mix(middle, vec3f(0.85, 0.02, 0.01), clamp(t - 2.0, 0.0, 1.0));
}

// Where a count lies between two others, by its logarithm.
fn share_between(count: u32, least: u32, most: u32) -> f32 {
    let low = log2(f32(max(least, 1u)));
    let high = log2(f32(max(most, 1u)));
    return (log2(f32(max(count, 1u))) - low) / max(high - low, 1e-3);
}

// What a view says of an instance: a colour, and how opaque; nothing where that is 0.
fn said_of(i: u32, character: CharacterRecord) -> vec4f {
    if marks.view == VIEW_OCCLUSION {
        let sight = seen[1u + i];
        let is_hidden = (sight & SIGHT_HIDDEN) != 0u;
        if (sight & SIGHT_DRAWN) != 0u {
            return vec4f(select(vec3f(0.0, 0.5, 0.1), vec3f(0.95, 0.45, 0.0), is_hidden), 0.6);
        }
        return vec4f(0.85, 0.02, 0.01, select(0.0, 0.9, is_hidden));
    }
    if culled[i].visible == 0u {
        return vec4f(0.0);
    }
    var level = LodChoice(character.vertex_count, character.triangle_count);
    if marks.has_choices == 1u {
        level = choices[i];
    }
    if marks.view == VIEW_LEVELS {
        return vec4f(heat(share_between(level.vertex_count, character.min_vertex_count, character.vertex_count)), 0.6);
    }
    if marks.view == VIEW_DENSITY {
        // Triangles a pixel: a hundredth is blue, one and more are red.
        let density = f32(level.triangle_count) / max(culled[i].area_px2, 1.0);
        return vec4f(heat(log2(max(density, 1e-6)) / 6.64 + 1.0), 0.6);
    }
    if level.vertex_count < character.min_vertex_count {
        return vec4f(0.5, 0.02, 0.6, 0.8);
    }
    if level.vertex_count == character.min_vertex_count {
        return vec4f(0.02, 0.07, 0.8, 0.6);
    }
    let is_full = level.vertex_count == character.vertex_count;
    return vec4f(select(vec3f(0.0, 0.55, 0.15), vec3f(0.85, 0.02, 0.01), is_full), 0.6);
}

// An ellipse over somebody's box, in front of it.
@vertex
fn tag(@builtin(vertex_index) corner: u32, @builtin(instance_index) i: u32) -> Tag {
    if i >= config.instance_count || instances[i].scale == 0.0 {
        return Tag(vec4f(2.0, 2.0, 2.0, 1.0), vec2f(0.0), vec4f(0.0));
    }
    let instance = instances[i];
    let character = characters[instance.character];
    let said = said_of(i, character);
    let half_box = 0.5 * (character.box_max - character.box_min) * instance.scale;
    let middle = instance.position + vec3f(0.0, 0.5 * character.height_m * instance.scale, 0.0);
    let towards_eye = config.eye - middle;
    let distance_m = max(length(towards_eye), 1e-3);
    let ahead_m = min(0.5 * (half_box.x + half_box.z), 0.5 * distance_m);
    let at = config.clip_from_world * vec4f(middle + towards_eye * (ahead_m / distance_m), 1.0);
    if said.a == 0.0 || at.w <= NEAREST_M {
        return Tag(vec4f(2.0, 2.0, 2.0, 1.0), vec2f(0.0), vec4f(0.0));
    }
    let place = vec2f(select(-1.0, 1.0, (corner & 1u) != 0u), select(-1.0, 1.0, corner == 2u || corner >= 4u));
    let half_m = vec2f(0.35 * (half_box.x + half_box.z), 0.5 * character.height_m * instance.scale);
    // At least a few pixels, so that far ones can be told.
    let half_px = max(half_m * config.focal_px / distance_m, vec2f(max(draw.height_px / 360.0, 1.0)));
    // Who is left out shows through whatever hides them, as a smaller one.
    let is_left_out = marks.view == VIEW_OCCLUSION && (seen[1u + i] & SIGHT_DRAWN) == 0u;
    let size = select(1.0, 0.4, is_left_out);
    let aside = place * half_px * size * 2.0 / vec2f(draw.width_px, draw.height_px) * at.w;
    return Tag(vec4f(at.xy + aside, select(at.z, select(0.0, at.w, REVERSED), is_left_out), at.w), place, said);
}

@fragment
fn shade_tag(tag: Tag) -> @location(0) vec4f {
    if dot(tag.place, tag.place) > 1.0 {
        discard;
    }
    return tag.color;
}
