// Peng 2011 Eq. 1: a vertex count for every visible instance. Twin: crowd-stages/src/cpu/select_lod.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(2) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(3) var<storage, read> culled: array<CullRecord>;
@group(0) @binding(4) var<storage, read> sums: WeightSums;
@group(0) @binding(5) var<storage, read_write> wanted: array<u32>;

@compute @workgroup_size(BLOCK_SIZE)
fn select_lod(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let cull = culled[i];
    if cull.visible == 0u {
        wanted[i] = 0u;
        return;
    }
    let character = characters[instances[i].character];
    // Never more than the budget: the quotient of equal sums may round up.
    let share = min(cull.weight / sums.weight, 1.0);
    // The clamp comes before the conversion: a float beyond the range of u32 has no defined value.
    let k = clamp(floor(f32(config.budget) * share), 0.0, f32(character.vertex_count));
    wanted[i] = clamp(u32(k), character.min_vertex_count, character.vertex_count);
}
