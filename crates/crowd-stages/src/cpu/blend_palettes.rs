//! Palettes of drawn instances.

use crate::{Buckets, CrowdData, DrawnInstance};
use glam::Vec4;

/// Three rows a joint of each drawn instance, blended between its two frames; [`Buckets::palette_rows`] of room for each, zeros
/// where a character has fewer joints.
///
/// Paper: Dong 2019 §5.1 reads the nearest frame's matrices for each vertex. Departs: two frames, blended once a joint.
/// Twin: `shaders/stages/blend_palettes.wgsl`. Within rounding of one product and one sum.
pub fn blend_palettes(data: &CrowdData, buckets: &Buckets, drawn: &[DrawnInstance]) -> Vec<[f32; 4]> {
    let mut palettes = vec![[0.0; 4]; drawn.len() * buckets.palette_rows as usize];
    for (one, palette) in drawn.iter().zip(palettes.chunks_exact_mut(buckets.palette_rows as usize)) {
        for (row, blended) in palette.iter_mut().take(one.row_count as usize).enumerate() {
            let texel = |first: u32| Vec4::from_array(data.animation[first as usize + row]);
            let (a, b) = (texel(one.first_texel), texel(one.second_texel));
            *blended = (a + (b - a) * one.blend).to_array();
        }
    }
    palettes
}
