// A vertex of an instance at a time: Peng 2011 Eq. 2 with premultiplied matrices and interpolated frames.
// Twin: crowd-stages/src/cpu/pose_instance.rs. Needs `animation`, the texture of palette rows.

// Texels of the animation texture: row-major in layers, addressed by one number.
const ANIMATION_WIDTH: u32 = 4096u;
const ANIMATION_HEIGHT: u32 = 64u;

fn palette_row(texel: u32) -> vec4f {
    let y = texel / ANIMATION_WIDTH;
    return textureLoad(animation, vec2u(texel % ANIMATION_WIDTH, y % ANIMATION_HEIGHT), y / ANIMATION_HEIGHT, 0);
}

// A row of its joints' matrices, blended between its two frames.
fn joint_row(drawn: DrawnInstance, row: u32) -> vec4f {
    let a = palette_row(drawn.first_texel + row);
    let b = palette_row(drawn.second_texel + row);
    return a + (b - a) * drawn.blend;
}

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
        let row = (joints.x & 0xffffu) * 3u;
        rows[0] += joint_row(drawn, row) * weight;
        rows[1] += joint_row(drawn, row + 1u) * weight;
        rows[2] += joint_row(drawn, row + 2u) * weight;
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

fn decode_normal(packed: u32) -> vec3f {
    let e = unpack2x16snorm(packed);
    var n = vec3f(e, 1.0 - abs(e.x) - abs(e.y));
    let fold = max(-n.z, 0.0);
    n.x += select(fold, -fold, n.x >= 0.0);
    n.y += select(fold, -fold, n.y >= 0.0);
    return normalize(n);
}
