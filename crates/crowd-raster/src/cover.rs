//! Decides which triangle each pixel of a band shows: edge functions in fixed point, top-left rule, depth test.
//!
//! Nothing is shaded here, except that a material with an alpha cutoff is asked for its alpha: each pixel is shaded once,
//! however many triangles lie behind each other.

use crate::Batch;
use crate::bin::{BAND_ROWS, Bins, SUBPIXELS, ScreenTriangle, Size, doubled_area};
use crate::shade::{Surface, shade, surface_at};

/// The three edge functions of a triangle: positive inside, linear in the position.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edges {
    /// Change a pixel to the right, (1/256 pixel)².
    pub(crate) step_x: [i64; 3],
    /// Change a pixel down.
    pub(crate) step_y: [i64; 3],
    /// Value at the centre of pixel (0, 0).
    origin: [i64; 3],
    /// 0 for edges that own their points (top and left), -1 for those that do not.
    bias: [i64; 3],
    /// The three values' sum, anywhere.
    pub(crate) area: i64,
}

impl Edges {
    /// Edge `i` lies across corner `i`: its value over the area is that corner's share.
    pub(crate) fn new(triangle: &ScreenTriangle) -> Self {
        let mut edges = Self {
            step_x: [0; 3],
            step_y: [0; 3],
            origin: [0; 3],
            bias: [0; 3],
            area: doubled_area(&triangle.x, &triangle.y),
        };
        let centre = i64::from(SUBPIXELS / 2);
        for i in 0..3 {
            let (a, b) = ((i + 1) % 3, (i + 2) % 3);
            let dx = i64::from(triangle.x[b]) - i64::from(triangle.x[a]);
            let dy = i64::from(triangle.y[b]) - i64::from(triangle.y[a]);
            edges.origin[i] = dx * (centre - i64::from(triangle.y[a])) - dy * (centre - i64::from(triangle.x[a]));
            edges.step_x[i] = -dy * i64::from(SUBPIXELS);
            edges.step_y[i] = dx * i64::from(SUBPIXELS);
            let top = dy == 0 && dx > 0;
            let left = dy < 0;
            edges.bias[i] = if top || left { 0 } else { -1 };
        }
        edges
    }

    /// Values at a pixel's centre.
    pub(crate) fn at(&self, x: u32, y: u32) -> [i64; 3] {
        std::array::from_fn(|i| self.origin[i] + self.step_x[i] * i64::from(x) + self.step_y[i] * i64::from(y))
    }

    fn covers(&self, values: &[i64; 3]) -> bool {
        ((values[0] + self.bias[0]) | (values[1] + self.bias[1]) | (values[2] + self.bias[2])) >= 0
    }
}

/// Draws one band: `colors` and `depths` are its rows, `band` its number. `bins` in drawing order.
pub(crate) fn draw_band(
    batches: &[Batch<'_>],
    bins: &[Bins],
    band: u32,
    size: Size,
    colors: &mut [[u8; 4]],
    depths: &mut [f32],
) {
    let listed: Vec<(&Bins, &ScreenTriangle)> = bins
        .iter()
        .flat_map(|bins| bins.bands[band as usize].iter().map(move |&i| (bins, &bins.triangles[i as usize])))
        .collect();
    if listed.is_empty() {
        return;
    }
    // Small draws touch a small part of a band: keep what is visible only for the columns they touch.
    let (mut left, mut right) = (size.width, 0);
    for (_, triangle) in &listed {
        let columns = triangle.columns(size.width);
        left = left.min(columns.start);
        right = right.max(columns.end);
    }
    let first_row = band * BAND_ROWS;
    let end_row = size.height.min(first_row + BAND_ROWS);
    let kept_width = (right - left) as usize;
    // 0 for none, else one more than the index into `listed`.
    let mut visible = vec![0_u32; kept_width * (end_row - first_row) as usize];

    for (number, (bins, triangle)) in listed.iter().enumerate() {
        let edges = Edges::new(triangle);
        let columns = triangle.columns(size.width);
        let rows = triangle.rows(size.height);
        let inv_area = 1.0 / edges.area as f32;
        let (z0, dz1, dz2) = (triangle.z[0], triangle.z[1] - triangle.z[0], triangle.z[2] - triangle.z[0]);
        let cut = cutoff_of(batches, triangle);
        for y in rows.start.max(first_row)..rows.end.min(end_row) {
            let mut values = edges.at(columns.start, y);
            let row = (y - first_row) as usize;
            for x in columns.clone() {
                if edges.covers(&values) {
                    let z = z0 + dz1 * (values[1] as f32 * inv_area) + dz2 * (values[2] as f32 * inv_area);
                    let depth = &mut depths[row * size.width as usize + x as usize];
                    let passes =
                        z < *depth && cut.is_none_or(|cutoff| alpha_at(batches, bins, triangle, x, y) >= cutoff);
                    if passes {
                        *depth = z;
                        visible[row * kept_width + (x - left) as usize] = number as u32 + 1;
                    }
                }
                for i in 0..3 {
                    values[i] += edges.step_x[i];
                }
            }
        }
    }

    for (row, visible) in visible.chunks_exact(kept_width).enumerate() {
        for (column, &id) in visible.iter().enumerate() {
            let Some(number) = id.checked_sub(1) else { continue };
            let (bins, triangle) = listed[number as usize];
            let (x, y) = (left + column as u32, first_row + row as u32);
            let surface = surface_at(triangle, bins, x, y);
            colors[row * size.width as usize + x as usize] = shade(batches, triangle, &surface);
        }
    }
}

/// The alpha below which this triangle's pixels are dropped, if any can be.
fn cutoff_of(batches: &[Batch<'_>], triangle: &ScreenTriangle) -> Option<f32> {
    let batch = &batches[triangle.batch as usize];
    let material = batch.material_of(batch.triangles[triangle.triangle as usize]);
    (material.alpha_cutoff > 0.0 && batch.fill != crate::Fill::VertexColor).then_some(material.alpha_cutoff)
}

fn alpha_at(batches: &[Batch<'_>], bins: &Bins, triangle: &ScreenTriangle, x: u32, y: u32) -> f32 {
    let surface: Surface = surface_at(triangle, bins, x, y);
    crate::shade::base_color(&batches[triangle.batch as usize], triangle, &surface)[3]
}
