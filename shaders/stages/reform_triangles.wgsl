// Peng 2011 §5.2: the first q triangles of each instance, their vertices replaced by looking up collapse targets until
// they fall below k. One group an instance. Twin: crowd-stages/src/cpu/reform_triangles.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> capacities: Capacities;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(4) var<storage, read> triangles: array<u32>;
@group(0) @binding(5) var<storage, read> collapse_map: array<u32>;
@group(0) @binding(6) var<storage, read> choices: array<LodChoice>;
@group(0) @binding(7) var<storage, read> bases: array<InstanceBase>;
@group(0) @binding(8) var<storage, read_write> indices: array<u32>;

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
    let first_corner = character.triangle_offset * 3u;
    for (var c = lane; c < choice.triangle_count * 3u; c += INSTANCE_GROUP_SIZE) {
        var v = triangles[first_corner + c];
        // A target lies below its vertex, so this ends; the equality guards against data that was never checked.
        while v >= choice.vertex_count {
            let target_vertex = collapse_map[character.vertex_offset + v];
            if target_vertex >= v {
                v = 0u;
                break;
            }
            v = target_vertex;
        }
        indices[base.triangle_base * 3u + c] = base.vertex_base + v;
    }
}
