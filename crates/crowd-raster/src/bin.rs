//! Bins triangles: transform, clip, cull, snap to fixed point, and list each under the bands of rows that it touches.

use std::ops::Range;

use glam::{Mat4, Vec3, Vec4};

use crate::clip::{Outcome, classify, clip_triangle};
use crate::{Batch, View};

/// Rows in a band: few enough for some bands a thread, enough that most triangles lie in one.
pub(crate) const BAND_ROWS: u32 = 16;
/// Steps of a screen coordinate in a pixel, as GPUs have (8 bits).
pub(crate) const SUBPIXELS: i32 = 256;
/// `ScreenTriangle::piece` of a triangle that was not clipped.
pub(crate) const WHOLE: u32 = u32::MAX;

/// A triangle, or a piece of a clipped one, on the screen. Its area is positive (clockwise as seen, y down).
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScreenTriangle {
    /// Index into the batches.
    pub(crate) batch: u32,
    /// Index into the batch's triangles.
    pub(crate) triangle: u32,
    /// Index into [`Bins::pieces`], or [`WHOLE`].
    pub(crate) piece: u32,
    /// The triangle's corner behind each of ours (for whole ones).
    pub(crate) corners: [u8; 3],
    /// Seen from outside.
    pub(crate) front: bool,
    /// 1/256 pixel.
    pub(crate) x: [i32; 3],
    /// 1/256 pixel, down.
    pub(crate) y: [i32; 3],
    /// Depth.
    pub(crate) z: [f32; 3],
    /// 1 / clip w.
    pub(crate) inv_w: [f32; 3],
}

impl ScreenTriangle {
    /// Columns whose centres lie within the bounds, clamped to the picture; may be empty.
    pub(crate) fn columns(&self, width: u32) -> Range<u32> {
        centres_within(&self.x, width)
    }

    /// Rows whose centres lie within the bounds, clamped to the picture; may be empty.
    pub(crate) fn rows(&self, height: u32) -> Range<u32> {
        centres_within(&self.y, height)
    }
}

fn centres_within(corners: &[i32; 3], size: u32) -> Range<u32> {
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    let half = SUBPIXELS / 2;
    let first = (low - half + SUBPIXELS - 1).div_euclid(SUBPIXELS).max(0);
    let last = (high - half).div_euclid(SUBPIXELS).min(size as i32 - 1);
    first as u32..(last + 1).max(first) as u32
}

/// Triangles of some batches, listed by band.
#[derive(Debug, Default)]
pub(crate) struct Bins {
    pub(crate) triangles: Vec<ScreenTriangle>,
    /// Shares of the original corners at the corners of a piece.
    pub(crate) pieces: Vec<[Vec3; 3]>,
    /// For each band, indices into `triangles`, rising.
    pub(crate) bands: Vec<Vec<u32>>,
}

/// Some triangles of one batch.
#[derive(Debug, Clone)]
pub(crate) struct Span {
    pub(crate) batch: u32,
    pub(crate) triangles: Range<usize>,
}

/// Picture size in pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Bins the spans' triangles in their order. Triangles that name missing vertices are passed over.
pub(crate) fn bin_triangles(batches: &[Batch<'_>], spans: &[Span], view: &View, size: Size) -> Bins {
    let mut bins = Bins::default();
    bins.bands.resize_with(size.height.div_ceil(BAND_ROWS) as usize, Vec::new);
    for span in spans {
        let batch = &batches[span.batch as usize];
        for index in span.triangles.clone() {
            let corners = batch.triangles[index];
            let Some(clip) = clip_positions(&view.clip_from_world, batch, corners) else { continue };
            let outcome = classify(&clip);
            if outcome == Outcome::Outside {
                continue;
            }
            let culls = !batch.material_of(corners).double_sided;
            let whole = ScreenTriangle {
                batch: span.batch,
                triangle: index as u32,
                piece: WHOLE,
                corners: [0, 1, 2],
                front: true,
                x: [0; 3],
                y: [0; 3],
                z: [0.0; 3],
                inv_w: [0.0; 3],
            };
            match outcome {
                Outcome::Outside => {}
                Outcome::Whole => bins.add(whole, clip, None, culls, size),
                Outcome::Crossing => {
                    let polygon = clip_triangle(&clip);
                    for i in 2..polygon.corners().len() {
                        let piece = [polygon.corners()[0], polygon.corners()[i - 1], polygon.corners()[i]];
                        let shares = piece.map(|corner| corner.barycentric);
                        bins.add(whole, piece.map(|corner| corner.position), Some(shares), culls, size);
                    }
                }
            }
        }
    }
    bins
}

fn clip_positions(clip_from_world: &Mat4, batch: &Batch<'_>, corners: [u32; 3]) -> Option<[Vec4; 3]> {
    let mut clip = [Vec4::ZERO; 3];
    for (clip, corner) in clip.iter_mut().zip(corners) {
        *clip = *clip_from_world * Vec3::from(*batch.positions.get(corner as usize)?).extend(1.0);
    }
    Some(clip)
}

impl Bins {
    /// Projects, culls, and lists a triangle whose corners all have a positive w.
    fn add(&mut self, mut screen: ScreenTriangle, clip: [Vec4; 3], shares: Option<[Vec3; 3]>, culls: bool, size: Size) {
        for (i, p) in clip.iter().enumerate() {
            let inv_w = 1.0 / p.w;
            let x = (p.x * inv_w * 0.5 + 0.5) * size.width as f32;
            let y = (0.5 - p.y * inv_w * 0.5) * size.height as f32;
            screen.x[i] = (x * SUBPIXELS as f32 + 0.5).floor() as i32;
            screen.y[i] = (y * SUBPIXELS as f32 + 0.5).floor() as i32;
            screen.z[i] = p.z * inv_w;
            screen.inv_w[i] = inv_w;
        }
        let area = doubled_area(&screen.x, &screen.y);
        // Y points down on the screen: counter-clockwise in clip space is negative here.
        screen.front = area < 0;
        if area == 0 || (culls && !screen.front) {
            return;
        }
        let mut shares = shares;
        if screen.front {
            screen.x.swap(1, 2);
            screen.y.swap(1, 2);
            screen.z.swap(1, 2);
            screen.inv_w.swap(1, 2);
            screen.corners.swap(1, 2);
            if let Some(shares) = &mut shares {
                shares.swap(1, 2);
            }
        }
        let rows = screen.rows(size.height);
        if rows.is_empty() || screen.columns(size.width).is_empty() {
            return;
        }
        if let Some(shares) = shares {
            screen.piece = self.pieces.len() as u32;
            self.pieces.push(shares);
        }
        let index = self.triangles.len() as u32;
        self.triangles.push(screen);
        for band in rows.start / BAND_ROWS..=(rows.end - 1) / BAND_ROWS {
            self.bands[band as usize].push(index);
        }
    }
}

/// Twice the area, in (1/256 pixel)².
pub(crate) fn doubled_area(x: &[i32; 3], y: &[i32; 3]) -> i64 {
    let d = |a: i32, b: i32| i64::from(a) - i64::from(b);
    d(x[1], x[0]) * d(y[2], y[0]) - d(x[2], x[0]) * d(y[1], y[0])
}
