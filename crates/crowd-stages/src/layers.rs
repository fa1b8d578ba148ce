//! Decodes a pack's images into texture layers of one size, with mip levels averaged in linear light over what characters show.

use crate::shown_texels::shown_texels;
use crate::{Error, Result, TextureLayer};
use crowd_pack::PackContents;
use crowd_raster::{Coverage, Texture};
use image::imageops::{FilterType, resize};
use image::{ImageReader, Limits, RgbaImage};
use rayon::prelude::*;
use std::io::Cursor;

/// Pixels a side an image may have: what the decoder is let to allocate.
const MAX_IMAGE_SIDE: u32 = 16_384;
/// Bytes the decoder may allocate for one image.
const MAX_DECODE_BYTES: u64 = 1 << 30;

/// One layer an image, and the side they share.
pub(crate) fn decode_layers(contents: &PackContents, max_layer_side: u32) -> Result<(Vec<TextureLayer>, u32)> {
    let PackContents { images, image_bytes: bytes, .. } = contents;
    let largest = images.iter().map(|image| image.width.max(image.height)).max().unwrap_or(1).min(MAX_IMAGE_SIDE);
    let allowed = 1 << max_layer_side.clamp(1, MAX_IMAGE_SIDE).ilog2();
    let side = largest.max(1).next_power_of_two().min(allowed);
    let layers = images
        .par_iter()
        .enumerate()
        .map(|(index, image)| {
            let start = image.byte_offset as usize;
            let encoded = start.checked_add(image.byte_count as usize).and_then(|end| bytes.get(start..end));
            let encoded =
                encoded.ok_or_else(|| Error::Image { index, problem: "lies outside the image bytes".to_owned() })?;
            let decoded = decode(encoded).map_err(|problem| Error::Image { index, problem: problem.to_string() })?;
            Ok(TextureLayer::from_shown(decoded, side, &shown_texels(contents, index as u32, side)))
        })
        .collect::<Result<Vec<_>>>()?;
    Ok((layers, side))
}

fn decode(bytes: &[u8]) -> image::ImageResult<RgbaImage> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_IMAGE_SIDE);
    limits.max_image_height = Some(MAX_IMAGE_SIDE);
    limits.max_alloc = Some(MAX_DECODE_BYTES);
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    reader.limits(limits);
    Ok(reader.decode()?.into_rgba8())
}

/// A picture that has to be so large: nothing larger is decoded.
pub(crate) fn decode_sized(bytes: &[u8], width: u32, height: u32) -> std::result::Result<Vec<[u8; 4]>, String> {
    let mut limits = Limits::default();
    limits.max_image_width = Some(width);
    limits.max_image_height = Some(height);
    limits.max_alloc = Some(MAX_DECODE_BYTES);
    let mut reader =
        ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|problem| problem.to_string())?;
    reader.limits(limits);
    let picture = reader.decode().map_err(|problem| problem.to_string())?.into_rgba8();
    let found = picture.dimensions();
    if found != (width, height) {
        return Err(format!("found {} x {} texels, its tiles need {width} x {height}", found.0, found.1));
    }
    Ok(picture.pixels().map(|pixel| pixel.0).collect())
}

impl TextureLayer {
    /// Resamples to `side` x `side` (a power of two) and makes the mip levels: means of all texels.
    pub fn from_image(image: RgbaImage, side: u32) -> Self {
        let mut mips = vec![resampled(image, side)];
        let light = LightTable::new();
        let mut level_side = side as usize;
        while level_side > 1 {
            let finer = mips.last().expect("the loop starts with level 0");
            mips.push(light.halve(finer, level_side));
            level_side /= 2;
        }
        Self { mips }
    }

    /// The same with means of the texels that are shown, and of no others; of all of them where none is.
    fn from_shown(image: RgbaImage, side: u32, coverage: &Coverage) -> Self {
        if coverage.is_empty() {
            return Self::from_image(image, side);
        }
        let texture = Texture::from_shown(side, side, resampled(image, side), coverage);
        Self { mips: texture.mips.into_iter().map(|mip| mip.texels).collect() }
    }
}

fn resampled(image: RgbaImage, side: u32) -> Vec<[u8; 4]> {
    let fitting = match image.dimensions() == (side, side) {
        true => image,
        false => resize(&image, side, side, FilterType::Triangle),
    };
    fitting.as_raw().as_chunks::<4>().0.to_vec()
}

/// sRGB to linear by table, and back by searching the middles between neighbours: exact rounding without a power.
pub(crate) struct LightTable {
    linear: [f32; 256],
    middles: [f32; 255],
}

impl LightTable {
    pub(crate) fn new() -> Self {
        let decode = |value: f32| match value <= 0.04045 {
            true => value / 12.92,
            false => libm::powf((value + 0.055) / 1.055, 2.4),
        };
        Self {
            linear: std::array::from_fn(|i| decode(i as f32 / 255.0)),
            middles: std::array::from_fn(|i| decode((i as f32 + 0.5) / 255.0)),
        }
    }

    fn encode(&self, linear: f32) -> u8 {
        self.middles.partition_point(|middle| *middle <= linear) as u8
    }

    /// Of four numbers, taken as light.
    pub(crate) fn mean(&self, block: [u8; 4]) -> u8 {
        self.encode(block.iter().map(|value| self.linear[usize::from(*value)]).sum::<f32>() * 0.25)
    }

    fn halve(&self, finer: &[[u8; 4]], side: usize) -> Vec<[u8; 4]> {
        let half = side / 2;
        let mut coarser = Vec::with_capacity(half * half);
        for y in 0..half {
            for x in 0..half {
                let corner = y * 2 * side + x * 2;
                let block = [finer[corner], finer[corner + 1], finer[corner + side], finer[corner + side + 1]];
                let color = |c: usize| self.mean(block.map(|texel| texel[c]));
                let alpha = (block.iter().map(|t| u32::from(t[3])).sum::<u32>() + 2) / 4;
                coarser.push([color(0), color(1), color(2), alpha as u8]);
            }
        }
        coarser
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_pack::ImageRecord;

    #[test]
    fn every_grey_survives_decoding_and_encoding() {
        let light = LightTable::new();
        for value in 0..=255u8 {
            assert_eq!(light.encode(light.linear[value as usize]), value);
        }
    }

    #[test]
    fn mips_average_light_not_bytes() {
        let image = RgbaImage::from_fn(2, 2, |x, _| image::Rgba(if x == 0 { [0, 0, 0, 255] } else { [255; 4] }));
        let layer = TextureLayer::from_image(image, 2);
        assert_eq!(layer.mips.len(), 2);
        assert_eq!(layer.mips[1], vec![[188, 188, 188, 255]]);
    }

    #[test]
    fn bytes_that_are_no_image_are_refused_with_their_index() {
        let record = ImageRecord { byte_offset: 0, byte_count: 5, width: 1, height: 1, ..Default::default() };
        let of = |image| PackContents { images: vec![image], image_bytes: b"hello".to_vec(), ..Default::default() };
        let error = decode_layers(&of(record), 64).expect_err("not an image");
        assert!(error.to_string().starts_with("image 0 of the pack:"), "{error}");
        let beyond = ImageRecord { byte_offset: 3, byte_count: u64::MAX, ..record };
        assert!(decode_layers(&of(beyond), 64).is_err());
    }
}
