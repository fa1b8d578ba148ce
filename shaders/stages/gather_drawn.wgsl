// What the vertices of each drawn instance need to know of it, in the order in which they are drawn: worked out once instead of
// for each vertex. Twin: crowd-stages/src/cpu/gather_drawn.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(4) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(5) var<storage, read> morphs: array<MorphRecord>;
// Of the list, or of the instances: keys, and who stands there or where they stand.
@group(0) @binding(6) var<storage, read> listed_keys: array<u32>;
@group(0) @binding(7) var<storage, read> listed: array<u32>;
@group(0) @binding(8) var<storage, read> places: array<BucketPlace>;
@group(0) @binding(9) var<storage, read_write> drawn: array<DrawnInstance>;

@compute @workgroup_size(BLOCK_SIZE)
fn gather_drawn(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let entry = group_number(workgroup) * BLOCK_SIZE + lane;
    // Those in no bucket come last.
    if entry < config.instance_count && listed_keys[entry] < bucket_counts.bucket_count {
        write_drawn(listed_keys[entry], entry, listed[entry]);
    }
}

// The same in the order of the instances: they lie side by side, and so do those of a bucket that come one after the other. Of a crowd that is larger than
// the caches it takes half the time; it needs to know where everyone stands in the list.
@compute @workgroup_size(BLOCK_SIZE)
fn scatter_drawn(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i < config.instance_count && listed_keys[i] < bucket_counts.bucket_count {
        write_drawn(listed_keys[i], listed[i], i);
    }
}

fn write_drawn(key: u32, entry: u32, i: u32) {
    let instance = instances[i];
    let character = characters[instance.character];
    let place = places[key];
    var base = NONE;
    if place.vertex_base != NONE {
        base = place.vertex_base + (entry - place.first) * place.vertex_count;
    }
    let row = palette_row(entry, bucket_counts);
    let clip = clips[instance.clip];
    let leaving = clips[leaving_clip(instance)];
    var one = drawn_instance(instance, character, clip, leaving, morphs[i], config.time_s, base, row);
    // Dots read their few joints from the frames.
    one.row_count = select(0u, one.row_count, key < bucket_counts.mesh_count);
    if key >= bucket_counts.first_impostor {
        // An impostor is of one clip, and its pixels are thinned by its number.
        one.vertex_base = select(instance.clip, leaving_clip(instance), instance.leaving_share > 0.5);
        one.palette_row = i;
    }
    drawn[entry] = one;
}
