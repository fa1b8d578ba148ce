//! Which levels and which moment a character's pictures show.

use crate::explain::{frame_palette, measured_near};
use crate::pose::Mat3x4;
use crate::unpack::Unpacked;
use crowd_pack::LodRecord;

/// Shares of the triangles that are shown.
pub(crate) const RATIOS: [f64; 5] = [0.5, 0.25, 0.1, 0.05, 0.02];
/// The share whose worst frame is shown: a level that a crowd shows much, and coarse enough to err.
const WORST_AT: f64 = 0.1;

/// A column of the pictures.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ShownLevel {
    /// Shares that this level stands for, largest first; none for full detail.
    pub ratios: Vec<f64>,
    /// Full detail.
    pub full: bool,
    /// The coarsest level.
    pub coarsest: bool,
    /// The discrete levels that this is, by their place in the pack.
    pub discrete: Vec<usize>,
    /// Has vertices of its own: those of its one discrete level.
    pub refitted: bool,
    pub level: LodRecord,
}

/// Discrete levels shown; a page is to be looked at.
const MOST_DISCRETE: usize = 8;

/// Full detail, the shares that are reached, the coarsest level, and the discrete levels; each level once, finest first, a refitted one
/// after the one it was made from.
pub(crate) fn shown_levels(character: &Unpacked<'_>) -> Vec<ShownLevel> {
    let record = character.record;
    let full = LodRecord { vertex_count: record.vertex_count, triangle_count: record.triangle_count };
    let coarsest = LodRecord { vertex_count: record.min_vertex_count, triangle_count: record.min_triangle_count };
    let plain = |level| ShownLevel {
        ratios: Vec::new(),
        full: false,
        coarsest: false,
        discrete: Vec::new(),
        refitted: false,
        level,
    };
    let mut shown = vec![ShownLevel { full: true, coarsest: full == coarsest, ..plain(full) }];
    for ratio in RATIOS {
        let (level, reached) = character.level_of_ratio(ratio);
        if !reached {
            continue;
        }
        match shown.iter_mut().find(|known| known.level == level) {
            Some(known) => known.ratios.push(ratio),
            None => {
                shown.push(ShownLevel { ratios: vec![ratio], coarsest: level == coarsest, ..plain(level) });
            }
        }
    }
    if !shown.iter().any(|known| known.coarsest) {
        shown.push(ShownLevel { coarsest: true, ..plain(coarsest) });
    }
    for (number, stored) in character.discrete_levels().iter().enumerate().take(MOST_DISCRETE) {
        let level = LodRecord { vertex_count: stored.vertex_count, triangle_count: stored.triangle_count };
        match shown.iter_mut().find(|known| known.level == level && !known.refitted && !stored.is_refit()) {
            Some(known) => known.discrete.push(number),
            None => shown.push(ShownLevel { discrete: vec![number], refitted: stored.is_refit(), ..plain(level) }),
        }
    }
    shown.sort_by_key(|known| (std::cmp::Reverse(known.level.triangle_count), known.refitted));
    shown
}

/// Shares that no level reaches.
pub(crate) fn missed_ratios(character: &Unpacked<'_>) -> Vec<f64> {
    RATIOS.into_iter().filter(|&ratio| !character.level_of_ratio(ratio).1).collect()
}

/// A frame of a clip.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WorstFrame {
    /// Name of the clip.
    pub clip: String,
    /// Seconds into it.
    pub time_s: f32,
    /// The level whose worst frame it is: its share of the triangles.
    pub share: f64,
    /// Its matrices.
    pub palette: Vec<Mat3x4>,
}

/// The frame in which the level of 10 %, or the measured one nearest to it, lies furthest from full detail. None where
/// nothing moves or nothing was measured.
pub(crate) fn worst_frame(character: &Unpacked<'_>) -> Option<WorstFrame> {
    let (level, _) = character.level_of_ratio(WORST_AT);
    let measured = measured_near(character, level)?;
    let clip = measured.max_clip as usize;
    let record = character.clips.get(clip).filter(|record| record.frame_count > 1)?;
    let frame = measured.max_frame.min(record.frame_count - 1);
    let palette = frame_palette(character, clip, frame)?;
    Some(WorstFrame {
        clip: character.manifest.clips[clip].name.clone(),
        time_s: frame_time_s(record.duration_s, frame, record.frame_count),
        share: f64::from(measured.triangle_count) / f64::from(character.record.triangle_count.max(1)),
        palette,
    })
}

/// When a frame is shown, seconds into its clip.
pub(crate) fn frame_time_s(duration_s: f32, frame: u32, frame_count: u32) -> f32 {
    if frame_count > 1 { duration_s * frame as f32 / (frame_count - 1) as f32 } else { 0.0 }
}
