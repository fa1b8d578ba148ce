// The frame's one vertex list (Peng 2011 §5.2, Dong 2019 §5.3): each selected vertex is an entry. We store only whose it
// is; the vertex shader reads the rest where it lies. One group an instance. Twin: crowd-stages/src/cpu/place_vertices.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> capacities: Capacities;
@group(0) @binding(2) var<storage, read> choices: array<LodChoice>;
@group(0) @binding(3) var<storage, read> bases: array<InstanceBase>;
@group(0) @binding(4) var<storage, read_write> slot_instances: array<u32>;

@compute @workgroup_size(INSTANCE_GROUP_SIZE)
fn place_vertices(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup);
    if i >= config.instance_count {
        return;
    }
    let choice = choices[i];
    let base = bases[i];
    if !is_kept(base, choice, capacities) {
        return;
    }
    for (var v = lane; v < choice.vertex_count; v += INSTANCE_GROUP_SIZE) {
        slot_instances[base.vertex_base + v] = i;
    }
}
