//! The farthest depth of ever larger blocks of pixels.

use crate::PyramidConfig;

/// The pyramid over a picture's depth, all levels in one list as `config` has them.
///
/// `depth`: samples of a pixel together, pixels by rows, 0 near to 1 far, or 1 near to 0 far where `config` says so. A number is the largest depth in its block of
/// `2^(level + 1)` pixels a side; blocks at the right and lower rim have fewer.
///
/// Paper: Greene, Kass & Miller 1993 (hierarchical Z). Departs: the picture is not stretched to a power of two, blocks are cut
/// off where it ends.
/// Twin: `shaders/stages/build_pyramid.wgsl`. Equal.
pub fn build_pyramid(config: &PyramidConfig, depth: &[f32]) -> Vec<f32> {
    let mut farthest = vec![0.0f32; config.number_count() as usize];
    let levels = &config.levels[..config.level_count as usize];
    for (k, level) in levels.iter().enumerate() {
        let (width, height) =
            if k == 0 { (config.width_px, config.height_px) } else { (levels[k - 1].width, levels[k - 1].height) };
        for i in 0..level.width * level.height {
            let (x, y) = (2 * (i % level.width), 2 * (i / level.width));
            let block = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, below)| {
                let from = (y + below).min(height - 1) * width + (x + right).min(width - 1);
                if k > 0 {
                    return farthest[(levels[k - 1].offset + from) as usize];
                }
                let samples = config.sample_count as usize;
                let ascending = |depth: &f32| if config.reversed != 0 { 1.0 - depth } else { *depth };
                depth[from as usize * samples..][..samples].iter().map(ascending).fold(0.0, f32::max)
            });
            farthest[(level.offset + i) as usize] = block.into_iter().fold(0.0, f32::max);
        }
    }
    farthest
}
