// An instance's place in the world and in its clip.

// Sine and cosine of a yaw: 0 faces +Z, positive turns towards +X.
fn turn_of(yaw_rad: f32) -> vec2f {
    return vec2f(sin(yaw_rad), cos(yaw_rad));
}

fn turn_by(t: vec2f, v: vec3f) -> vec3f {
    return vec3f(t.y * v.x + t.x * v.z, v.y, t.y * v.z - t.x * v.x);
}

fn turn(yaw_rad: f32, v: vec3f) -> vec3f {
    return turn_by(turn_of(yaw_rad), v);
}

fn world_from_local(instance: InstanceRecord, p: vec3f) -> vec3f {
    return instance.position + turn(instance.yaw_rad, p * instance.scale);
}

// The clip that an instance leaves, or the one it plays where it leaves none.
fn leaving_clip(instance: InstanceRecord) -> u32 {
    return select(instance.clip, instance.leaving_clip, instance.leaving_share > 0.0);
}

// The sphere that holds every pose of its clip, and of its way from the one it leaves. Twin: world_sphere in
// crowd-stages/src/cpu/cull_instances.rs.
fn world_sphere(instance: InstanceRecord, clip: ClipRecord, leaving: ClipRecord) -> vec4f {
    let sphere = clip.sphere + (leaving.sphere - clip.sphere) * instance.leaving_share;
    return vec4f(world_from_local(instance, sphere.xyz), sphere.w * instance.scale);
}

struct FramePair {
    first: u32,
    second: u32,
    blend: f32,
}

fn frame_pair(clip: ClipRecord, phase_s: f32, time_s: f32) -> FramePair {
    let last = max(clip.frame_count, 1u) - 1u;
    if clip.duration_s <= 0.0 || last == 0u {
        return FramePair(0u, 0u, 0.0);
    }
    let turns = (time_s + phase_s) / clip.duration_s;
    let frame = (turns - floor(turns)) * f32(last);
    let first = min(u32(max(floor(frame), 0.0)), last);
    return FramePair(first, min(first + 1u, last), frame - f32(first));
}

// Texels of a frame. Twin: JointStorage::frame_texels in crowd-pack/src/store_joint.rs.
fn frame_texels(character: CharacterRecord) -> u32 {
    let rows = character.joint_count * 3u;
    if character.joint_storage == JOINTS_QUANTIZED {
        return character.joint_count;
    }
    return select(rows, (rows + 1u) / 2u, character.joint_storage == JOINTS_F16);
}

// The first row of the palette in that slot; none where a device binds fewer. Twin: Buckets::palette_row in crowd-stages/src/buckets.rs.
fn palette_row(slot: u32, counts: BucketCounts) -> u32 {
    return select(NONE, slot * counts.palette_rows, slot < counts.palette_slots);
}

// What its vertices need to know of an instance. Twin: drawn_instance in crowd-stages/src/cpu/gather_drawn.rs.
fn drawn_instance(
    instance: InstanceRecord,
    character: CharacterRecord,
    clip: ClipRecord,
    leaving: ClipRecord,
    morph: MorphRecord,
    time_s: f32,
    // Where its skinned vertices and its palette begin, if they are somewhere.
    vertex_base: u32,
    palette_row: u32,
) -> DrawnInstance {
    let pair = frame_pair(clip, instance.phase_s, time_s - instance.held_s);
    let left = frame_pair(leaving, instance.leaving_phase_s, time_s - instance.held_s);
    let texels = frame_texels(character);
    return DrawnInstance(
        instance.position,
        instance.scale,
        turn_of(instance.yaw_rad),
        morph.fraction,
        pair.blend,
        morph.coarser_vertex_count,
        character.material_offset,
        clip.texel_offset + pair.first * texels,
        clip.texel_offset + pair.second * texels,
        vertex_base,
        palette_row,
        character.joint_count * 3u,
        character.joint_storage,
        leaving.texel_offset + left.first * texels,
        leaving.texel_offset + left.second * texels,
        left.blend,
        instance.leaving_share,
    );
}
