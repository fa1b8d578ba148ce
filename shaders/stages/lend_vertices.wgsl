// Where the crowd's own pass has the skinned vertices of each instance, told to the passes of the shadow maps: a coarser level's vertices
// are the first of a finer one's. One thread an entry of a sorted list. Twin: crowd-stages/src/cpu/lend_vertices.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<storage, read> sorted_keys: array<u32>;
@group(0) @binding(3) var<storage, read> sorted_values: array<u32>;
@group(0) @binding(4) var<storage, read_write> drawn: array<DrawnInstance>;
// Of each instance; NONE where it has none.
@group(0) @binding(5) var<storage, read_write> lent: array<u32>;

// Over the crowd's list, in which everyone is, drawn or not.
@compute @workgroup_size(BLOCK_SIZE)
fn lend_vertices(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let entry = group_number(workgroup) * BLOCK_SIZE + lane;
    if entry >= config.instance_count {
        return;
    }
    var base = NONE;
    // Dots and impostors have other words there, or none.
    if sorted_keys[entry] < bucket_counts.mesh_count {
        base = drawn[entry].vertex_base;
    }
    lent[sorted_values[entry]] = base;
}

// Over the casters' list.
@compute @workgroup_size(BLOCK_SIZE)
fn borrow_vertices(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let entry = group_number(workgroup) * BLOCK_SIZE + lane;
    if entry >= config.instance_count || sorted_keys[entry] >= bucket_counts.mesh_count {
        return;
    }
    drawn[entry].vertex_base = lent[sorted_values[entry]];
}
