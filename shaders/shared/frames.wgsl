// Frames of clips. Needs pose.wgsl and `animation`, the texture of stored joints: texels of 16 bytes.

// Texels of the animation texture: row-major in layers, addressed by one number.
const ANIMATION_WIDTH: u32 = 4096u;
const ANIMATION_HEIGHT: u32 = 64u;

// Storages that characters have, a bit each: what nobody has is not compiled.
override JOINT_STORAGES: u32 = 7u;

// Software adapters have the texture as a storage texture: `with_stored_frames` in crowd-stages/src/gpu/kernel.rs changes the last line.
fn animation_texel(texel: u32) -> vec4u {
    let row = texel / ANIMATION_WIDTH;
    let x = texel % ANIMATION_WIDTH;
    let y = row % ANIMATION_HEIGHT;
    let layer = row / ANIMATION_HEIGHT;
    return textureLoad(animation, vec2u(x, y), layer, 0);
}

fn f32_joint(first_texel: u32, joint: u32) -> mat3x4f {
    let at = first_texel + joint * 3u;
    return mat3x4f(
        bitcast<vec4f>(animation_texel(at)),
        bitcast<vec4f>(animation_texel(at + 1u)),
        bitcast<vec4f>(animation_texel(at + 2u)),
    );
}

// Two rows a texel: a joint has all of one and half of the one before or behind.
fn f16_joint(first_texel: u32, joint: u32) -> mat3x4f {
    let at = first_texel + joint * 3u / 2u;
    let a = animation_texel(at);
    let b = animation_texel(at + 1u);
    let is_odd = (joint & 1u) == 1u;
    let first = select(a.xy, a.zw, is_odd);
    let second = select(a.zw, b.xy, is_odd);
    let third = select(b.xy, b.zw, is_odd);
    return mat3x4f(half_row(first), half_row(second), half_row(third));
}

// The exponent of a half float, read as that of a float, is 112 too small.
fn half_row(words: vec2u) -> vec4f {
    let halves = vec4u(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu, words.y >> 16u);
    let sign = (halves & vec4u(0x8000u)) << vec4u(16u);
    return bitcast<vec4f>(((halves & vec4u(0x7fffu)) << vec4u(13u)) | sign) * 5.192296858534828e33;
}

// Numbers of 16 bits with a power of two for the quaternion and one for the translation; the quaternion's length is the root of the
// scale.
fn quantized_joint(first_texel: u32, joint: u32) -> mat3x4f {
    let texel = bitcast<vec4i>(animation_texel(first_texel + joint));
    let low = vec4f((texel << vec4u(16u)) >> vec4u(16u));
    let high = vec4f(texel >> vec4u(16u));
    let last = bitcast<u32>(texel.w);
    let q = vec4f(low.x, high.x, low.y, high.y) * bitcast<f32>((last >> 16u & 0xffu) << 23u);
    let t = vec3f(low.z, high.z, low.w) * bitcast<f32>((last >> 24u) << 23u);
    let s = q * q;
    return mat3x4f(
        vec4f((s.w + s.x) - (s.y + s.z), 2.0 * (q.x * q.y - q.z * q.w), 2.0 * (q.x * q.z + q.y * q.w), t.x),
        vec4f(2.0 * (q.x * q.y + q.z * q.w), (s.w + s.y) - (s.x + s.z), 2.0 * (q.y * q.z - q.x * q.w), t.y),
        vec4f(2.0 * (q.x * q.z - q.y * q.w), 2.0 * (q.y * q.z + q.x * q.w), (s.w + s.z) - (s.x + s.y), t.z),
    );
}

// The rows of a joint's matrix in the frame whose texels begin there. Twin: stored_joint in crowd-pack/src/store_joint.rs.
fn stored_joint(first_texel: u32, joint: u32, storage: u32) -> mat3x4f {
    // All characters alike, as most packs have it: no branch is left.
    if JOINT_STORAGES == 1u << JOINTS_QUANTIZED {
        return quantized_joint(first_texel, joint);
    }
    if JOINT_STORAGES == 1u << JOINTS_F16 {
        return f16_joint(first_texel, joint);
    }
    if JOINT_STORAGES == 1u << JOINTS_F32 {
        return f32_joint(first_texel, joint);
    }
    if storage == JOINTS_QUANTIZED {
        return quantized_joint(first_texel, joint);
    }
    if storage == JOINTS_F16 {
        return f16_joint(first_texel, joint);
    }
    return f32_joint(first_texel, joint);
}

// The same between two frames: Dong 2019 shows the nearest one.
fn joint_between(first_texel: u32, second_texel: u32, blend: f32, joint: u32, storage: u32) -> mat3x4f {
    let a = stored_joint(first_texel, joint, storage);
    let b = stored_joint(second_texel, joint, storage);
    return a + (b - a) * blend;
}

// The rows of a joint's matrix at that time.
fn posed_joint(pose: Pose, joint: u32, storage: u32) -> mat3x4f {
    return joint_between(pose.first_texel, pose.second_texel, pose.blend, joint, storage);
}

// The same of an instance, between the clip it plays and the one it leaves. One turn, two where it fades: adapters that work on groups of
// lanes pay for what an `if` or a second loop holds even where nobody of a group goes in, but not for a turn that nobody takes.
fn blended_joint(drawn: DrawnInstance, joint: u32) -> mat3x4f {
    var pose = played_pose(drawn);
    // All of the clip it plays, then the other one's share.
    var share = 1.0;
    var is_last = !(drawn.leaving_share > 0.0);
    var rows = mat3x4f(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    loop {
        rows += (posed_joint(pose, joint, drawn.storage) - rows) * share;
        if is_last {
            break;
        }
        is_last = true;
        pose = left_pose(drawn);
        share = drawn.leaving_share;
    }
    return rows;
}
