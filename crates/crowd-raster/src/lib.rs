//! A small textured CPU rasteriser: pictures for reports, oracle for GPU images, preview where there is no GPU.
//!
//! Draws triangles already posed in world space: depth-tested, perspective-correct, bilinear textures with mip levels,
//! per-pixel lighting with the same numbers as `shaders/shared/light.wgsl`. One sample a pixel at the pixel's centre, as
//! the GPU without MSAA; [`downsample`] turns a larger picture into an antialiased one. Rows are split into bands over
//! the rayon pool; the picture does not depend on the number of threads.

pub mod ground;
pub mod light;
pub mod srgb;
mod types;

pub use ground::{draw_ground, draw_sky};
pub use types::*;

/// Draws a batch into the target.
pub fn draw(target: &mut Target, view: &View, batch: &Batch<'_>) {
    let _ = (target, view, batch);
    unimplemented!("crowd-raster: being written")
}

/// Averages blocks of `factor` x `factor` pixels in linear light.
pub fn downsample(target: &Target, factor: u32) -> Target {
    let _ = (target, factor);
    unimplemented!("crowd-raster: being written")
}

/// Decodes PNG, JPEG or WebP bytes into a texture with mip levels. `max_side` bounds what is kept (larger ones are halved).
///
/// # Errors
/// [`Error::Image`] when the bytes do not decode or are larger than `limits` in the decoder allow.
pub fn decode_texture(bytes: &[u8], max_side: u32) -> Result<Texture> {
    let _ = (bytes, max_side);
    unimplemented!("crowd-raster: being written")
}

/// Writes the target as PNG bytes (sRGB, opaque).
pub fn encode_png(target: &Target) -> Vec<u8> {
    let _ = target;
    unimplemented!("crowd-raster: being written")
}
