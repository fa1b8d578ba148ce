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
fn blended_joint(drawn: DrawnInstance, joint: u32) -> mat3x4f {
    let a = stored_joint(drawn.first_texel, joint, drawn.storage);
    let b = stored_joint(drawn.second_texel, joint, drawn.storage);
    return a + (b - a) * drawn.blend;
}
