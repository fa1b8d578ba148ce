//! Textures from image files, and their mip levels.

use std::io::Cursor;

use glam::Vec3;
use image::{ImageReader, Limits};

use crate::srgb::{decode_table, encode};
use crate::{Error, Mip, Result, Target, Texture};

/// Largest image read, pixels a side: what GPUs of the last ten years take as a texture.
const LARGEST_SIDE: u32 = 16_384;
/// What decoding may allocate, bytes: 8192 x 8192 RGBA of 8 bits, twice.
const LARGEST_ALLOC: u64 = 512 << 20;

/// Decodes PNG, JPEG or WebP bytes into a texture with mip levels. `max_side` bounds what is kept (larger ones are halved).
///
/// # Errors
/// [`Error::Image`] when the bytes do not decode, or are larger than 16,384 pixels a side or 512 MiB decoded.
pub fn decode_texture(bytes: &[u8], max_side: u32) -> Result<Texture> {
    let (width, height, texels) = decode_rgba(bytes, [LARGEST_SIDE; 2])?;
    let mut texture = Texture::from_rgba8(width, height, texels);
    let kept = texture.mips.iter().position(|mip| mip.width.max(mip.height) <= max_side.max(1)).unwrap_or(0);
    texture.mips.drain(..kept);
    Ok(texture)
}

/// Decodes PNG, JPEG or WebP bytes into a picture with depth 1: to compare pictures.
///
/// # Errors
/// As [`decode_texture`].
pub fn decode_picture(bytes: &[u8]) -> Result<Target> {
    decode_picture_within(bytes, [LARGEST_SIDE; 2])
}

/// The same of pictures that have at most so many pixels across and down: nothing larger is decoded.
///
/// # Errors
/// As [`decode_texture`], also for a larger one.
pub fn decode_picture_within(bytes: &[u8], largest: [u32; 2]) -> Result<Target> {
    let (width, height, color) = decode_rgba(bytes, largest)?;
    let depth = vec![1.0; color.len()];
    Ok(Target { width, height, color, depth })
}

fn decode_rgba(bytes: &[u8], largest: [u32; 2]) -> Result<(u32, u32, Vec<[u8; 4]>)> {
    let refused = |error: &dyn std::fmt::Display| Error::Image(error.to_string());
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| refused(&e))?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(largest[0]);
    limits.max_image_height = Some(largest[1]);
    limits.max_alloc = Some(LARGEST_ALLOC);
    reader.limits(limits);
    let image = reader.decode().map_err(|e| refused(&e))?;
    let decoded = u64::from(image.width()) * u64::from(image.height()) * 4;
    if decoded > LARGEST_ALLOC {
        return Err(Error::Image(format!("found {decoded} bytes of pixels, allowed {LARGEST_ALLOC}")));
    }
    let rgba = image.into_rgba8();
    let (width, height) = rgba.dimensions();
    Ok((width, height, rgba.as_raw().as_chunks::<4>().0.to_vec()))
}

impl Texture {
    /// A texture from its largest level, `width * height` sRGB-encoded RGBA8 texels; makes the smaller ones down to 1 x 1.
    ///
    /// Each level is the mean of the one before in linear light, weighted by alpha, so that the colour of invisible texels
    /// does not bleed in. Odd sizes: each texel covers its exact share. Empty when a side is 0 or texels are missing.
    pub fn from_rgba8(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Self {
        if width == 0 || height == 0 || texels.len() != width as usize * height as usize {
            return Self::default();
        }
        let mut mips = vec![Mip { width, height, texels }];
        loop {
            let last = &mips[mips.len() - 1];
            if last.width == 1 && last.height == 1 {
                return Self { mips };
            }
            let next = halve(last);
            mips.push(next);
        }
    }
}

fn halve(mip: &Mip) -> Mip {
    let (width, height) = ((mip.width / 2).max(1), (mip.height / 2).max(1));
    let (columns, rows) = (shares(mip.width, width), shares(mip.height, height));
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    let linear = decode_table();
    for row in &rows {
        for column in &columns {
            let (mut visible, mut any, mut alpha) = (Vec3::ZERO, Vec3::ZERO, 0.0);
            for (y, share_y) in row.taken() {
                for (x, share_x) in column.taken() {
                    let [r, g, b, a] = mip.texels[y as usize * mip.width as usize + x as usize];
                    let rgb = Vec3::new(linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)]);
                    let share = share_x * share_y;
                    let a = f32::from(a) / 255.0 * share;
                    visible += rgb * a;
                    any += rgb * share;
                    alpha += a;
                }
            }
            let rgb = if alpha > 0.0 { visible / alpha } else { any };
            texels.push([encode(rgb.x), encode(rgb.y), encode(rgb.z), (alpha * 255.0 + 0.5) as u8]);
        }
    }
    Mip { width, height, texels }
}

/// Which texels of the larger level one texel of the smaller one covers: up to three, from `first`.
struct Shares {
    first: u32,
    weights: [f32; 3],
}

impl Shares {
    fn taken(&self) -> impl Iterator<Item = (u32, f32)> {
        (self.first..).zip(self.weights).filter(|(_, weight)| *weight > 0.0)
    }
}

fn shares(from: u32, to: u32) -> Vec<Shares> {
    // In units of 1/to of a larger texel everything is whole: smaller texel i covers [i * from, (i + 1) * from).
    (0..u64::from(to))
        .map(|i| {
            let (from, to) = (u64::from(from), u64::from(to));
            let (start, end) = (i * from, (i + 1) * from);
            let first = start / to;
            let weights = std::array::from_fn(|k| {
                let texel = (first + k as u64) * to;
                let covered = end.min(texel + to).saturating_sub(start.max(texel));
                covered as f32 / from as f32
            });
            Shares { first: first as u32, weights }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode_png;

    #[test]
    fn levels_halve_down_to_one_and_keep_the_mean() {
        let texels: Vec<[u8; 4]> =
            (0..7 * 5).map(|i| if i % 2 == 0 { [255, 0, 0, 255] } else { [0, 0, 0, 255] }).collect();
        let texture = Texture::from_rgba8(7, 5, texels);
        let sizes: Vec<_> = texture.mips.iter().map(|mip| (mip.width, mip.height)).collect();
        assert_eq!(sizes, [(7, 5), (3, 2), (1, 1)]);
        let mean = decode_table()[usize::from(texture.mips[2].texels[0][0])];
        assert!((mean - 18.0 / 35.0).abs() < 0.01, "{mean}");
    }

    #[test]
    fn invisible_texels_do_not_bleed() {
        let texture = Texture::from_rgba8(2, 1, vec![[200, 100, 50, 255], [0, 255, 0, 0]]);
        assert_eq!(texture.mips[1].texels, [[200, 100, 50, 128]]);
    }

    #[test]
    fn a_large_side_is_halved_until_it_fits() {
        let png = encode_png(&Target::new(100, 10, [9, 99, 199, 255]));
        let texture = decode_texture(&png, 32).expect("our own PNG");
        assert_eq!((texture.mips[0].width, texture.mips[0].height), (25, 2));
        assert_eq!(texture.mips[0].texels[0], [9, 99, 199, 255]);
        assert_eq!(decode_texture(&png, 0).expect("our own PNG").mips.len(), 1);
    }

    #[test]
    fn broken_images_are_refused() {
        let png = encode_png(&Target::new(8, 8, [1, 2, 3, 255]));
        for end in 0..png.len() - 12 {
            assert!(decode_texture(&png[..end], 64).is_err(), "prefix of {end} bytes");
        }
        assert!(decode_texture(b"not an image", 64).is_err());
    }

    #[test]
    fn a_huge_size_in_a_small_file_is_refused() {
        let mut png = encode_png(&Target::new(8, 8, [1, 2, 3, 255]));
        png[16..24].copy_from_slice(&[0, 0, 0xFF, 0xFF, 0, 0, 0xFF, 0xFF]);
        let crc = crc32(&png[12..29]);
        png[29..33].copy_from_slice(&crc.to_be_bytes());
        assert!(decode_texture(&png, 64).is_err());
    }

    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0_u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & 0_u32.wrapping_sub(crc & 1)))
        })
    }
}
