// Every vertex of every drawn instance skinned once, in the character's own space, moved between levels where they morph. However many
// passes draw them. One thread a vertex. Twin: crowd-stages/src/cpu/skin_vertices.rs.

@group(0) @binding(0) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(1) var<storage, read> places: array<BucketPlace>;
@group(0) @binding(2) var<storage, read> drawn: array<DrawnInstance>;
@group(0) @binding(3) var<storage, read> vertices: array<VertexRecord>;
@group(0) @binding(4) var<storage, read> origins: array<OriginRecord>;
@group(0) @binding(5) var<storage, read> palettes: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> skinned: array<SkinnedVertex>;
// Where poses are shared: the entry of each leader; else anything.
@group(0) @binding(7) var<storage, read> leaders: array<u32>;

fn joint_matrix(one: DrawnInstance, pose: Pose, joint: u32) -> mat3x4f {
    let row = one.palette_row + joint * 3u;
    return mat3x4f(palettes[row], palettes[row + 1u], palettes[row + 2u]);
}

// Palettes have both clips in them.
fn left_share(one: DrawnInstance) -> f32 {
    return 0.0;
}

// The bucket whose part holds that vertex: the last that begins at or before it. Those without room begin after all.
fn bucket_at(place: u32) -> u32 {
    var low = 0u;
    var high = bucket_counts.bucket_count;
    while low + 1u < high {
        let middle = (low + high) / 2u;
        if places[middle].vertex_base <= place {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// `shares`: the n-th of a bucket is its n-th leader, not its n-th instance.
fn skin(place: u32, shares: bool) {
    if place >= places[bucket_counts.bucket_count].vertex_base {
        return;
    }
    let bucket = places[bucket_at(place)];
    let within = place - bucket.vertex_base;
    var entry = bucket.first + within / bucket.vertex_count;
    if shares {
        entry = leaders[entry];
    }
    let one = drawn[entry];
    let v = within % bucket.vertex_count;
    let vertex = vertices[bucket.vertex_offset + v];
    let origin = origins[bucket.vertex_offset + v];
    let share = select(1.0, one.fraction, v >= one.coarser_vertex_count);
    let rows = skin_matrix(vec4u(vertex.joints, vertex.weights), vec4u(origin.joints, origin.weights), share, one);
    let position = between(origin.position, vertex.position, share);
    let normal = between(decode_normal(origin.normal_oct), decode_normal(vertex.normal_oct), share);
    let local = vec4f(position, 1.0) * rows;
    let turned = vec4f(normal, 0.0) * rows;
    skinned[place] = SkinnedVertex(local.x, local.y, local.z, turned.x, turned.y, turned.z);
}

@compute @workgroup_size(BLOCK_SIZE)
fn skin_vertices(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    skin(group_number(workgroup) * BLOCK_SIZE + lane, false);
}

@compute @workgroup_size(BLOCK_SIZE)
fn skin_leaders(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    skin(group_number(workgroup) * BLOCK_SIZE + lane, true);
}
