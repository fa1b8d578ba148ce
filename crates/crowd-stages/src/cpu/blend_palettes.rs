//! Palettes of drawn instances.

use crate::{Buckets, CrowdData, DrawnInstance};

/// Three rows a joint of each drawn instance, blended between its two frames, and with those of the clip that it leaves;
/// [`Buckets::palette_rows`] of room for each, zeros where a character has fewer joints; no more than there is room for
/// ([`Buckets::palette_slots`]).
///
/// Paper: Dong 2019 §5.1 reads the nearest frame's matrices for each vertex. Departs: two frames of one or two clips, blended once a
/// joint. Twin: `shaders/stages/blend_palettes.wgsl`. Within rounding of a product and a sum for each.
pub fn blend_palettes(data: &CrowdData, buckets: &Buckets, drawn: &[DrawnInstance]) -> Vec<[f32; 4]> {
    let slots = drawn.len().min(buckets.palette_slots as usize);
    let mut palettes = vec![[0.0; 4]; slots * buckets.palette_rows as usize];
    for (one, palette) in drawn.iter().zip(palettes.chunks_exact_mut(buckets.palette_rows as usize)) {
        for (joint, rows) in (0..one.row_count / 3).zip(palette.chunks_exact_mut(3)) {
            rows.copy_from_slice(&data.blended_joint(one, joint).map(|row| row.to_array()));
        }
    }
    palettes
}
