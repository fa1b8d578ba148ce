// A vertex of an instance at a time: Peng 2011 Eq. 2 with premultiplied matrices and interpolated frames.
// Twin: crowd-stages/src/cpu/pose_instance.rs. Needs `joint_matrix`, the rows of a joint's matrix at that time.

// Rows of the weighted sum of the joints' matrices: of `own` by its share, of `other` by the rest. Both are joints and weights
// as VertexRecord has them. As many turns as there are joints with weight: lanes that are alike pay for one set.
fn skin_matrix(own: vec4u, other: vec4u, own_share: f32, drawn: DrawnInstance) -> mat3x4f {
    var joints = own.xy;
    var weights = own.zw;
    // Neighbours on the same joints have one matrix.
    var is_last = own_share >= 1.0 || all(own == other);
    var share = select(own_share, 1.0, is_last);
    var rows = mat3x4f(vec4f(0.0), vec4f(0.0), vec4f(0.0));
    loop {
        let weight = f32(weights.x & 0xffffu) / 65535.0 * share;
        rows += joint_matrix(drawn, joints.x & 0xffffu) * weight;
        joints = vec2u(joints.x >> 16u | joints.y << 16u, joints.y >> 16u);
        weights = vec2u(weights.x >> 16u | weights.y << 16u, weights.y >> 16u);
        if all(weights == vec2u(0u)) {
            if is_last {
                break;
            }
            is_last = true;
            joints = other.xy;
            weights = other.zw;
            share = 1.0 - own_share;
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
