//! Textures from image files.

use std::io::Cursor;

use image::{ImageReader, Limits};

use crate::{Coverage, Error, Result, Target, Texture};

/// Largest image read, pixels a side: what GPUs of the last ten years take as a texture.
const LARGEST_SIDE: u32 = 16_384;
/// What decoding may allocate, bytes: 8192 x 8192 RGBA of 8 bits, twice.
const LARGEST_ALLOC: u64 = 512 << 20;

/// Decodes PNG, JPEG or WebP bytes into a texture with mip levels. `max_side` bounds what is kept (larger ones are halved).
///
/// # Errors
/// [`Error::Image`] when the bytes do not decode, or are larger than 16,384 pixels a side or 512 MiB decoded.
pub fn decode_texture(bytes: &[u8], max_side: u32) -> Result<Texture> {
    decode_shown(bytes, max_side, |_| {})
}

/// The same with mip levels of the texels that are shown, see [`Texture::from_shown`]; `show` adds the triangles to what begins empty.
///
/// # Errors
/// As [`decode_texture`].
pub fn decode_shown(bytes: &[u8], max_side: u32, show: impl FnOnce(&mut Coverage)) -> Result<Texture> {
    let (width, height, texels) = decode_rgba(bytes, [LARGEST_SIDE; 2])?;
    let mut coverage = Coverage::new(width, height);
    show(&mut coverage);
    let mut texture = Texture::from_shown(width, height, texels, &coverage);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode_png;

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
