// Peng 2011 §5.2: the first q triangles of each instance, their vertices replaced by looking up collapse targets until
// they fall below k. Each triangle is turned so that its least index comes first, as in the index tables. One group an
// instance. Twin: crowd-stages/src/cpu/reform_triangles.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> capacities: Capacities;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(4) var<storage, read> triangles: array<u32>;
@group(0) @binding(5) var<storage, read> collapse_map: array<u32>;
@group(0) @binding(6) var<storage, read> choices: array<LodChoice>;
@group(0) @binding(7) var<storage, read> bases: array<InstanceBase>;
@group(0) @binding(8) var<storage, read_write> indices: array<u32>;

// The vertex of a level of k vertices that v has moved into.
fn surviving(first_vertex: u32, v: u32, k: u32) -> u32 {
    var at = v;
    // A target lies below its vertex, so this ends; the equality guards against data that was never checked.
    while at >= k {
        let target_vertex = collapse_map[first_vertex + at];
        if target_vertex >= at {
            return 0u;
        }
        at = target_vertex;
    }
    return at;
}

fn from_least(t: vec3u) -> vec3u {
    if t.x <= t.y && t.x <= t.z {
        return t;
    }
    return select(t.zxy, t.yzx, t.y <= t.z);
}

@compute @workgroup_size(INSTANCE_GROUP_SIZE)
fn reform_triangles(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup);
    if i >= config.instance_count {
        return;
    }
    let choice = choices[i];
    let base = bases[i];
    if choice.vertex_count == 0u || !is_kept(base, choice, capacities) {
        return;
    }
    let character = characters[instances[i].character];
    let k = choice.vertex_count;
    // The instance's triangles in the part of the buffer that is bound.
    let window_end = select(saturating_add(capacities.window_first, capacities.window_count), 0xffffffffu, capacities.window_count == 0u);
    let begin = max(capacities.window_first, base.triangle_base) - base.triangle_base;
    let end = min(choice.triangle_count, max(window_end, base.triangle_base) - base.triangle_base);
    for (var q = begin + lane; q < end; q += INSTANCE_GROUP_SIZE) {
        let corner = (character.triangle_offset + q) * 3u;
        let a = surviving(character.vertex_offset, triangles[corner], k);
        let b = surviving(character.vertex_offset, triangles[corner + 1u], k);
        let c = surviving(character.vertex_offset, triangles[corner + 2u], k);
        let t = from_least(vec3u(a, b, c));
        let place = (base.triangle_base + q - capacities.window_first) * 3u;
        indices[place] = base.vertex_base + t.x;
        indices[place + 1u] = base.vertex_base + t.y;
        indices[place + 2u] = base.vertex_base + t.z;
    }
}
