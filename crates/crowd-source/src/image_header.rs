//! What an image is, by its own first bytes, and whether all of it decodes. The bytes are kept as they are.

use std::io::Cursor;

use image::ImageFormat;

use crate::refusal::Asset;
use crate::{ImageEncoding, RawImage, Result};

/// What decoding one image may allocate, bytes: the largest image of 16-bit RGBA. The pack's readers allow as much.
const LARGEST_ALLOC: u64 = 512 << 20;

/// Checks an encoded image: kind, size, and once through all of it. One broken texture would keep a whole pack from being
/// shown, and here it still has a name.
pub(crate) fn read_image(asset: Asset<'_>, place: &str, name: String, bytes: Vec<u8>) -> Result<RawImage> {
    if bytes.starts_with(b"\xabKTX") {
        return Err(asset.unsupported(place, "a KTX2 image", "convert it to PNG, JPEG or WebP"));
    }
    // The file's own word, not its name or declared type: both are wrong often enough.
    let (format, encoding) = match &bytes[..] {
        [0x89, b'P', b'N', b'G', ..] => (ImageFormat::Png, ImageEncoding::Png),
        [0xff, 0xd8, 0xff, ..] => (ImageFormat::Jpeg, ImageEncoding::Jpeg),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => (ImageFormat::WebP, ImageEncoding::WebP),
        _ => {
            return Err(asset.unsupported(
                place,
                "an image that is neither PNG, JPEG nor WebP",
                "convert it to one of these",
            ));
        }
    };
    let reader = || image::ImageReader::with_format(Cursor::new(&bytes), format);
    let (width, height) = reader()
        .into_dimensions()
        .map_err(|e| asset.format(place, format!("the image's header does not decode: {e}")))?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(asset.format(place, format!("an image of {width}x{height} pixels")));
    }
    asset.check_limit(place, "pixels", pixels, asset.limits.image_pixels)?;
    asset.check_limit(place, "pixels a side", u64::from(width.max(height)), asset.limits.image_side)?;
    let mut reader = reader();
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(LARGEST_ALLOC);
    reader.limits(limits);
    reader.decode().map_err(|e| {
        let (e, size) = (e.to_string(), bytes.len());
        asset.format(
            place,
            format!("the image of {size} bytes does not decode: {e}; write it anew with an image program"),
        )
    })?;
    Ok(RawImage { name, named: true, encoding, width, height, bytes })
}
