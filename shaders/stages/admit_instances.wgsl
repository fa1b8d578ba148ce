// Instances that a simulator wrote become the frame's: those that could not be drawn become nobody. Twin:
// crowd-stages/src/cpu/admit_instances.rs.

@group(0) @binding(0) var<uniform> feed: FeedConfig;
@group(0) @binding(1) var<storage, read> given: array<InstanceRecord>;
// One number: how many are given.
@group(0) @binding(2) var<storage, read> given_count: array<u32>;
@group(0) @binding(3) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(4) var<storage, read_write> instances: array<InstanceRecord>;
@group(0) @binding(5) var<storage, read_write> block_refused: array<u32>;
@group(0) @binding(6) var<storage, read_write> state: FeedState;

var<workgroup> refused_here: atomic<u32>;
var<workgroup> sums: array<u32, BLOCK_SIZE>;

// By its bits: compilers may take numbers to be finite.
fn is_finite(number: f32) -> bool {
    return (bitcast<u32>(number) & 0x7f800000u) != 0x7f800000u;
}

fn has_sound_fade(one: InstanceRecord, character: CharacterRecord) -> bool {
    let is_one_of_its_own =
        one.leaving_clip >= character.clip_offset && one.leaving_clip - character.clip_offset < character.clip_count;
    let fades = is_finite(one.leaving_share) && one.leaving_share > 0.0 && one.leaving_share <= 1.0;
    return one.leaving_share == 0.0 || (fades && is_one_of_its_own);
}

fn is_sound(one: InstanceRecord) -> bool {
    if one.character >= feed.character_count {
        return false;
    }
    let character = characters[one.character];
    return one.clip >= character.clip_offset && one.clip - character.clip_offset < character.clip_count
        && is_finite(one.position.x) && is_finite(one.position.y) && is_finite(one.position.z)
        && is_finite(one.yaw_rad) && is_finite(one.scale) && is_finite(one.phase_s)
        && is_finite(one.leaving_phase_s) && is_finite(one.held_s) && has_sound_fade(one, character);
}

@compute @workgroup_size(BLOCK_SIZE)
fn admit(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let i = block * BLOCK_SIZE + lane;
    if lane == 0u {
        atomicStore(&refused_here, 0u);
    }
    workgroupBarrier();
    var one = InstanceRecord(vec3f(0.0), 0.0, 0.0, 0u, characters[0].clip_offset, 0.0, 0u, 0.0, 0.0, 0.0);
    if i < min(given_count[0], feed.most) {
        let asked = given[i];
        if is_sound(asked) {
            one = asked;
        } else {
            atomicAdd(&refused_here, 1u);
        }
    }
    if i < feed.most {
        instances[i] = one;
    }
    workgroupBarrier();
    if lane == 0u && block * BLOCK_SIZE < feed.most {
        block_refused[block] = atomicLoad(&refused_here);
    }
}

@compute @workgroup_size(BLOCK_SIZE)
fn count_refused(@builtin(local_invocation_index) lane: u32) {
    let blocks = (feed.most + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    var sum = 0u;
    for (var b = lane; b < blocks; b += BLOCK_SIZE) {
        sum += block_refused[b];
    }
    sums[lane] = sum;
    workgroupBarrier();
    if lane == 0u {
        var refused = 0u;
        for (var other = 0u; other < BLOCK_SIZE; other++) {
            refused += sums[other];
        }
        let count = min(given_count[0], feed.most);
        state = FeedState(count, refused + (given_count[0] - count));
    }
}
