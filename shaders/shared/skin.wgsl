// A vertex of an instance at a time: Peng 2011 Eq. 2 with premultiplied matrices and interpolated frames.
// Twin: crowd-stages/src/cpu/pose_instance.rs. Needs pose.wgsl, `joint_matrix`, the rows of a joint's matrix in a pose, and `left_share`,
// the share of the clip that an instance leaves which is not in those rows.

// Rows of the weighted sum of the joints' matrices: of `own` by its share, of `other` by the rest. Both are joints and weights
// as VertexRecord has them. Where `other` begins with the first joint of `own` its weights lie beside those of the same joints, and one walk
// over the joints serves both (see crowd-stages/src/origins.rs); else they are walked one after the other. Whoever fades has all of it again
// in the clip they leave.
//
// One loop with one body: adapters that work on groups of vertices pay for as many turns as the longest walk of a group takes, and for what
// is around a turn whether somebody takes it or not (decision 0063).
fn skin_matrix(own: vec4u, other: vec4u, own_share: f32, drawn: DrawnInstance) -> mat3x4f {
    let moves = own_share < 1.0;
    let is_beside = (own.x & 0xffffu) == (other.x & 0xffffu);
    let is_one_walk = is_beside || !moves;
    let first_joints = select(own.xy, other.xy, is_beside);
    let first_others = select(vec2u(0u), other.zw, is_beside && moves);
    let left = left_share(drawn);
    var joints = first_joints;
    var weights = own.zw;
    var others = first_others;
    var pose = played_pose(drawn);
    var clip_share = 1.0 - left;
    var is_last = is_one_walk;
    var is_last_clip = !(left > 0.0);
    var rows = mat3x4f(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    loop {
        let own_part = f32(weights.x & 0xffffu) * own_share;
        let other_part = f32(others.x & 0xffffu) * (1.0 - own_share);
        let weight = (own_part + other_part) / 65535.0 * clip_share;
        rows += joint_matrix(drawn, pose, joints.x & 0xffffu) * weight;
        joints = vec2u(joints.x >> 16u | joints.y << 16u, joints.y >> 16u);
        weights = vec2u(weights.x >> 16u | weights.y << 16u, weights.y >> 16u);
        others = vec2u(others.x >> 16u | others.y << 16u, others.y >> 16u);
        if all((weights | others) == vec2u(0u)) {
            if is_last && is_last_clip {
                break;
            }
            // The second walk, or the first one in the other clip.
            let is_next_clip = is_last;
            joints = select(other.xy, first_joints, is_next_clip);
            weights = select(vec2u(0u), own.zw, is_next_clip);
            others = select(other.zw, first_others, is_next_clip);
            let next = left_pose(drawn);
            pose.first_texel = select(pose.first_texel, next.first_texel, is_next_clip);
            pose.second_texel = select(pose.second_texel, next.second_texel, is_next_clip);
            pose.blend = select(pose.blend, next.blend, is_next_clip);
            clip_share = select(clip_share, left, is_next_clip);
            is_last_clip = is_last_clip || is_next_clip;
            is_last = is_one_walk || !is_next_clip;
        }
    }
    return rows;
}

// The second at a share of 1, exactly: `mix` need not give that.
fn between(a: vec3f, b: vec3f, share: f32) -> vec3f {
    return a * (1.0 - share) + b * share;
}

fn decode_normal(packed: u32) -> vec3f {
    let e = unpack2x16snorm(packed);
    var n = vec3f(e, 1.0 - abs(e.x) - abs(e.y));
    let fold = max(-n.z, 0.0);
    n.x += select(fold, -fold, n.x >= 0.0);
    n.y += select(fold, -fold, n.y >= 0.0);
    return normalize(n);
}
