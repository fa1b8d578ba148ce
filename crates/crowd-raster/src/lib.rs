//! A small textured CPU rasteriser: pictures for reports, oracle for GPU images, preview where there is no GPU.
//!
//! Draws triangles already posed in world space: depth-tested, perspective-correct, bilinear textures with mip levels,
//! per-pixel lighting with the same numbers as `shaders/shared/light.wgsl`. One sample a pixel at the pixel's centre, as
//! the GPU without MSAA; [`downsample`] turns a larger picture into an antialiased one. Rows are split into bands over
//! the rayon pool; the picture does not depend on the number of threads.
//!
//! The steps of [`draw_many`]: `bin` (transform, `clip`, cull, snap), `cover` (which triangle a pixel shows), `shade`
//! (with `sample` and [`light`]). Formulas that the shaders repeat stand in [`light`] and [`ground`].

mod bin;
mod clip;
mod compare;
mod cover;
mod coverage;
mod dabs;
mod draw;
mod fog;
pub mod ground;
pub mod light;
mod mips;
mod picture;
mod sample;
mod shade;
pub mod srgb;
mod texture;
mod types;

pub use compare::{ImageDifference, compare_images};
pub use coverage::Coverage;
pub use dabs::{Dab, draw_dabs};
pub use draw::{draw, draw_many};
pub use fog::draw_fog;
pub use ground::{draw_ground, draw_sky};
pub use picture::{downsample, encode_jpeg, encode_png, encode_texels, encode_texels_soon};
pub use sample::{level_of_detail, sample};
pub use texture::{decode_picture, decode_picture_within, decode_shown, decode_texture};
pub use types::*;

#[cfg(test)]
mod tests;
