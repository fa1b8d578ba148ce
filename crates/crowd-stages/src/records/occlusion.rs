//! Who is hidden, and by what.

use crate::dispatch;
use bytemuck::{Pod, Zeroable};

/// A level of the depth pyramid, 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct PyramidLevel {
    /// Its first number in the pyramid's buffer.
    pub offset: u32,
    /// Numbers a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Zero.
    pub reserved: u32,
}

/// The depth pyramid's shape, a uniform of 288 bytes. Level `k` has one number for each block of `2^(k + 1)` pixels a side,
/// as far as the picture goes, so that a pixel's block is found by shifting whatever the size.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct PyramidConfig {
    /// Width of the picture, pixels.
    pub width_px: u32,
    /// Height of the picture, pixels.
    pub height_px: u32,
    /// Samples a pixel.
    pub sample_count: u32,
    /// Levels; the last is one number.
    pub level_count: u32,
    /// 1 where the depth texture has 1 near and 0 far; the pyramid has 0 near and 1 far in both.
    pub reversed: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
    /// Zero.
    pub reserved_c: u32,
    /// The finest first.
    pub levels: [PyramidLevel; dispatch::PYRAMID_LEVELS as usize],
}

impl PyramidConfig {
    /// The pyramid over a picture of at least one pixel and at most 2^16 a side.
    pub fn new(width_px: u32, height_px: u32, sample_count: u32) -> Self {
        let mut config = Self { width_px, height_px, sample_count, ..Self::default() };
        let (mut width, mut height, mut offset) = (width_px, height_px, 0);
        for level in &mut config.levels {
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
            *level = PyramidLevel { offset, width, height, reserved: 0 };
            offset += width * height;
            config.level_count += 1;
            if width == 1 && height == 1 {
                break;
            }
        }
        config
    }

    /// Numbers of all levels.
    pub fn number_count(&self) -> u32 {
        self.levels.iter().map(|level| level.width * level.height).sum()
    }
}

/// Which level `build_pyramid` makes, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct PyramidStep {
    /// The level.
    pub level: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
    /// Zero.
    pub reserved_c: u32,
}

/// Who waits for the second phase of occlusion culling, 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct SightTally {
    /// Vertices of their coarsest levels, saturating.
    pub hidden_min_count: u32,
    /// Instances.
    pub hidden_count: u32,
}

/// What is known of an instance's sight: words of the `seen` buffer, after the number of instances they are valid for.
pub mod sight {
    /// Not hidden by the newest pyramid.
    pub const SEEN: u32 = 1;
    /// Hidden by the newest pyramid.
    pub const HIDDEN: u32 = 2;
    /// Drawn in the newest frame, whether then hidden or not.
    pub const DRAWN: u32 = 4;
}
