// Frames of clips. Needs `animation`, the texture of palette rows.

// Texels of the animation texture: row-major in layers, addressed by one number.
const ANIMATION_WIDTH: u32 = 4096u;
const ANIMATION_HEIGHT: u32 = 64u;

fn palette_row(texel: u32) -> vec4f {
    let y = texel / ANIMATION_WIDTH;
    return textureLoad(animation, vec2u(texel % ANIMATION_WIDTH, y % ANIMATION_HEIGHT), y / ANIMATION_HEIGHT, 0);
}

// A row of a joint's matrix between two frames: Dong 2019 shows the nearest one.
fn blended_row(drawn: DrawnInstance, row: u32) -> vec4f {
    let a = palette_row(drawn.first_texel + row);
    let b = palette_row(drawn.second_texel + row);
    return a + (b - a) * drawn.blend;
}
