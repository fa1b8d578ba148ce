//! Finishes pictures: antialiasing by downsampling, PNG and JPEG.

use glam::Vec3;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

use crate::Target;
use crate::srgb::{decode_table, encode_rgb};

/// Averages blocks of `factor` x `factor` pixels in linear light. Depth is the block's nearest. Rows and columns that do
/// not fill a block are dropped; a factor of 0 or 1 copies.
pub fn downsample(target: &Target, factor: u32) -> Target {
    if factor <= 1 {
        return target.clone();
    }
    let (width, height) = (target.width / factor, target.height / factor);
    let mut small = Target::new(width, height, [0, 0, 0, 255]);
    if width == 0 || height == 0 {
        return small;
    }
    let linear = decode_table();
    let share = 1.0 / (factor as f32 * factor as f32);
    let rows = small.color.par_chunks_mut(width as usize).zip(small.depth.par_chunks_mut(width as usize)).enumerate();
    rows.for_each(|(y, (colors, depths))| {
        for (x, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
            let mut sum = Vec3::ZERO;
            let mut nearest = f32::INFINITY;
            for dy in 0..factor as usize {
                let start = (y * factor as usize + dy) * target.width as usize + x * factor as usize;
                for i in start..start + factor as usize {
                    let [r, g, b, _] = target.color[i];
                    sum += Vec3::new(linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)]);
                    nearest = nearest.min(target.depth[i]);
                }
            }
            *color = encode_rgb(sum * share);
            *depth = nearest;
        }
    });
    small
}

/// Writes the target as PNG bytes (sRGB, opaque). No bytes for a target without pixels, which PNG cannot hold.
pub fn encode_png(target: &Target) -> Vec<u8> {
    let mut bytes = Vec::new();
    let rgb: Vec<u8> = target.color.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    if rgb.is_empty() {
        return bytes;
    }
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(&rgb, target.width, target.height, ExtendedColorType::Rgb8)
        .expect("memory takes every byte, and a target holds width * height pixels");
    bytes
}

/// Writes texels as PNG bytes, alpha included, as small as PNG gets. No bytes where there are none, or not `width * height`.
pub fn encode_texels(width: u32, height: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    encode_rgba(width, height, texels, CompressionType::Best)
}

/// The same, a tenth of the time and somewhat larger.
pub fn encode_texels_soon(width: u32, height: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    encode_rgba(width, height, texels, CompressionType::Default)
}

fn encode_rgba(width: u32, height: u32, texels: &[[u8; 4]], compression: CompressionType) -> Vec<u8> {
    let mut bytes = Vec::new();
    if texels.is_empty() || texels.len() != width as usize * height as usize {
        return bytes;
    }
    PngEncoder::new_with_quality(&mut bytes, compression, FilterType::Adaptive)
        .write_image(texels.as_flattened(), width, height, ExtendedColorType::Rgba8)
        .expect("memory takes every byte, and there are width * height texels");
    bytes
}

/// Sides of a JPEG, pixels.
const LARGEST_JPEG_SIDE: u32 = 65_535;

/// Writes the target as JPEG bytes (sRGB, full colour resolution): a third of the PNG's for shaded pictures. `quality`: 1 to
/// 100, clamped. No bytes for a target that JPEG cannot hold: without pixels, or above 65,535 of them along a side.
pub fn encode_jpeg(target: &Target, quality: u8) -> Vec<u8> {
    let mut bytes = Vec::new();
    let rgb: Vec<u8> = target.color.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    if rgb.is_empty() || target.width.max(target.height) > LARGEST_JPEG_SIDE {
        return bytes;
    }
    JpegEncoder::new_with_quality(&mut bytes, quality.clamp(1, 100))
        .write_image(&rgb, target.width, target.height, ExtendedColorType::Rgb8)
        .expect("memory takes every byte, and a target holds width * height pixels within JPEG's sides");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{compare_images, decode_picture};

    #[test]
    fn averages_are_taken_in_linear_light() {
        let mut target = Target::new(2, 2, [0, 0, 0, 255]);
        target.color[0] = [255, 255, 255, 255];
        target.color[3] = [255, 255, 255, 255];
        target.depth[2] = 0.25;
        let small = downsample(&target, 2);
        assert_eq!((small.width, small.height, small.color[0], small.depth[0]), (1, 1, [188, 188, 188, 255], 0.25));
    }

    #[test]
    fn a_png_holds_the_same_pixels() {
        let mut target = Target::new(17, 9, [0, 0, 0, 255]);
        for (i, pixel) in target.color.iter_mut().enumerate() {
            *pixel = [(i * 7) as u8, (i * 13) as u8, (i * 29) as u8, 255];
        }
        let again = decode_picture(&encode_png(&target)).expect("our own PNG");
        assert_eq!(compare_images(&target, &again).expect("same size").max, 0);
    }

    #[test]
    fn a_jpeg_holds_nearly_the_same_pixels_in_fewer_bytes() {
        let mut target = Target::new(64, 48, [0, 0, 0, 255]);
        for (i, pixel) in target.color.iter_mut().enumerate() {
            let (x, y) = (i as u32 % 64, i as u32 / 64);
            *pixel = [(x * 3) as u8, (y * 5) as u8, 128, 255];
        }
        let bytes = encode_jpeg(&target, 90);
        let again = decode_picture(&bytes).expect("our own JPEG");
        assert!(compare_images(&target, &again).expect("same size").max < 16);
        assert!(encode_jpeg(&Target::new(0, 5, [0; 4]), 90).is_empty());
    }

    #[test]
    fn texels_keep_their_alpha() {
        let texels: Vec<[u8; 4]> = (0..12).map(|i| [i, 2 * i, 255 - i, 20 * i]).collect();
        let again = decode_picture(&encode_texels(4, 3, &texels)).expect("our own PNG");
        assert_eq!((again.width, again.height, again.color), (4, 3, texels.clone()));
        assert!(encode_texels(4, 4, &texels).is_empty());
    }

    #[test]
    fn an_empty_target_has_no_png() {
        assert!(encode_png(&Target::new(0, 5, [0; 4])).is_empty());
        assert_eq!(downsample(&Target::new(3, 3, [7; 4]), 4).width, 0);
    }
}
