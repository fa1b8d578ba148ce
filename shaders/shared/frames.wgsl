// Frames of clips. Needs `animation`, the texture of palette rows.

// Texels of the animation texture: row-major in layers, addressed by one number.
const ANIMATION_WIDTH: u32 = 4096u;
const ANIMATION_HEIGHT: u32 = 64u;

fn animation_texel(texel: u32) -> vec4f {
    let y = texel / ANIMATION_WIDTH;
    return textureLoad(animation, vec2u(texel % ANIMATION_WIDTH, y % ANIMATION_HEIGHT), y / ANIMATION_HEIGHT, 0);
}

// The rows of a joint's matrix in the frame whose texels begin there. Twin: CrowdData::stored_joint.
fn stored_joint(first_texel: u32, joint: u32, storage: u32) -> mat3x4f {
    let at = first_texel + joint * 3u;
    return mat3x4f(animation_texel(at), animation_texel(at + 1u), animation_texel(at + 2u));
}

// The same between two frames: Dong 2019 shows the nearest one.
fn joint_between(first_texel: u32, second_texel: u32, blend: f32, joint: u32, storage: u32) -> mat3x4f {
    let a = stored_joint(first_texel, joint, storage);
    let b = stored_joint(second_texel, joint, storage);
    return a + (b - a) * blend;
}

// The same of an instance, between the clip it plays and the one it leaves.
fn blended_joint(drawn: DrawnInstance, joint: u32) -> mat3x4f {
    var rows = joint_between(drawn.first_texel, drawn.second_texel, drawn.blend, joint, drawn.storage);
    // One turn or none. Adapters that pay for both sides of an `if` pass a loop by where nobody of a group takes a turn.
    var share = drawn.leaving_share;
    while share > 0.0 {
        let first = drawn.leaving_first_texel;
        let left = joint_between(first, drawn.leaving_second_texel, drawn.leaving_blend, joint, drawn.storage);
        rows += (left - rows) * share;
        share = 0.0;
    }
    return rows;
}
