//! Samples a texture as a GPU does: sRGB decoded, bilinear, linear between two mip levels.

use glam::{Vec2, Vec4};

use crate::srgb::decode_table;
use crate::{Mip, Texture, Wrap};

/// Mip level, 0 the largest: `ddx` and `ddy` are the changes of uv from pixel to pixel.
pub fn level_of_detail(texture: &Texture, ddx: Vec2, ddy: Vec2) -> f32 {
    let Some(largest) = texture.mips.first() else { return 0.0 };
    let size = Vec2::new(largest.width as f32, largest.height as f32);
    let texels = (ddx * size).length_squared().max((ddy * size).length_squared());
    if texels > 1.0 { 0.5 * libm::log2f(texels) } else { 0.0 }
}

/// Linear RGBA at `uv`, which may be any number. White where the texture has no texels.
pub fn sample(texture: &Texture, wrap_u: Wrap, wrap_v: Wrap, uv: Vec2, lod: f32) -> [f32; 4] {
    let Some(last) = texture.mips.len().checked_sub(1) else { return [1.0; 4] };
    let lod = if lod > 0.0 { lod.min(last as f32) } else { 0.0 };
    let level = lod as usize;
    let between = lod - level as f32;
    let near = bilinear(&texture.mips[level], wrap_u, wrap_v, uv);
    if between == 0.0 {
        return near.to_array();
    }
    let far = bilinear(&texture.mips[level + 1], wrap_u, wrap_v, uv);
    (near * (1.0 - between) + far * between).to_array()
}

fn bilinear(mip: &Mip, wrap_u: Wrap, wrap_v: Wrap, uv: Vec2) -> Vec4 {
    if mip.width == 0 || mip.height == 0 {
        return Vec4::ONE;
    }
    let (columns, fx) = neighbours(uv.x, mip.width, wrap_u);
    let (rows, fy) = neighbours(uv.y, mip.height, wrap_v);
    let texel = |row: u32, column: u32| texel(mip, row as usize * mip.width as usize + column as usize);
    let top = texel(rows[0], columns[0]) * (1.0 - fx) + texel(rows[0], columns[1]) * fx;
    let bottom = texel(rows[1], columns[0]) * (1.0 - fx) + texel(rows[1], columns[1]) * fx;
    top * (1.0 - fy) + bottom * fy
}

fn texel(mip: &Mip, index: usize) -> Vec4 {
    let linear = decode_table();
    match mip.texels.get(index) {
        Some(&[r, g, b, a]) => Vec4::new(
            linear[usize::from(r)],
            linear[usize::from(g)],
            linear[usize::from(b)],
            f32::from(a) * (1.0 / 255.0),
        ),
        None => Vec4::ONE,
    }
}

/// The two texels around a coordinate and the second one's share.
fn neighbours(coordinate: f32, size: u32, wrap: Wrap) -> ([u32; 2], f32) {
    let period = match wrap {
        Wrap::Repeat => coordinate - coordinate.floor(),
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
        Wrap::Mirror => coordinate - 2.0 * (coordinate * 0.5).floor(),
    };
    let period = if period.is_finite() { period } else { 0.0 };
    let position = period * size as f32 - 0.5;
    let first = position.floor();
    let wrapped = |index: i64| -> u32 {
        let size = i64::from(size);
        let index = match wrap {
            Wrap::Repeat => index.rem_euclid(size),
            Wrap::Clamp => index.clamp(0, size - 1),
            Wrap::Mirror => {
                let index = index.rem_euclid(2 * size);
                index.min(2 * size - 1 - index)
            }
        };
        index as u32
    };
    ([wrapped(first as i64), wrapped(first as i64 + 1)], position - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four texels in a row: black, white, black, white at (1 x 4) wide.
    fn stripes() -> Texture {
        let (black, white) = ([0, 0, 0, 255], [255, 255, 255, 255]);
        Texture {
            mips: vec![
                Mip { width: 4, height: 1, texels: vec![black, white, black, white] },
                Mip { width: 2, height: 1, texels: vec![[188, 188, 188, 255]; 2] },
                Mip { width: 1, height: 1, texels: vec![[188, 188, 188, 0]] },
            ],
        }
    }

    fn red(u: f32, wrap: Wrap, lod: f32) -> f32 {
        sample(&stripes(), wrap, Wrap::Clamp, Vec2::new(u, 0.5), lod)[0]
    }

    #[test]
    fn texel_centres_give_texels_and_halfway_is_the_mean_in_linear_light() {
        assert_eq!(red(0.125, Wrap::Repeat, 0.0), 0.0);
        assert_eq!(red(0.375, Wrap::Repeat, 0.0), 1.0);
        assert!((red(0.25, Wrap::Repeat, 0.0) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn wraps_differ_at_the_border() {
        assert!((red(0.0, Wrap::Repeat, 0.0) - 0.5).abs() < 1e-6);
        assert_eq!(red(0.0, Wrap::Clamp, 0.0), 0.0);
        assert_eq!(red(0.0, Wrap::Mirror, 0.0), 0.0);
        assert_eq!(red(1.125, Wrap::Repeat, 0.0), 0.0);
        assert_eq!(red(1.125, Wrap::Mirror, 0.0), 1.0);
        assert_eq!(red(-7.0, Wrap::Clamp, 0.0), 0.0);
        assert_eq!(red(-0.875, Wrap::Repeat, 0.0), 0.0);
    }

    #[test]
    fn levels_blend_and_are_held_at_the_last() {
        let half = red(0.375, Wrap::Repeat, 0.5);
        let one = red(0.375, Wrap::Repeat, 1.0);
        assert!((half - (1.0 + one) / 2.0).abs() < 1e-6);
        assert_eq!(sample(&stripes(), Wrap::Repeat, Wrap::Repeat, Vec2::ZERO, 99.0)[3], 0.0);
    }

    #[test]
    fn the_level_is_the_logarithm_of_texels_a_pixel() {
        let lod = |pixels: f32| level_of_detail(&stripes(), Vec2::new(pixels / 4.0, 0.0), Vec2::ZERO);
        assert_eq!((lod(0.5), lod(1.0), lod(2.0), lod(4.0)), (0.0, 0.0, 1.0, 2.0));
    }

    #[test]
    fn no_coordinate_panics() {
        for u in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, f32::MIN_POSITIVE] {
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                assert!(red(u, wrap, f32::NAN).is_finite());
            }
        }
        assert_eq!(sample(&Texture::default(), Wrap::Repeat, Wrap::Repeat, Vec2::ZERO, 0.0), [1.0; 4]);
        let torn = Texture { mips: vec![Mip { width: 4, height: 4, texels: vec![] }] };
        assert_eq!(sample(&torn, Wrap::Repeat, Wrap::Repeat, Vec2::ZERO, 0.0), [1.0; 4]);
    }
}
