//! Mip levels: means in linear light, of what is shown alone where that is known.
//!
//! An atlas has charts, and between them texels that nobody sees. A plain mip level mixes both, and who is a few pixels high reads little
//! else: people far away then are as dark as their atlas is empty. Here a texel's weight is the share of it that a chart covers; what no
//! chart covers is filled from its neighbours and from coarser levels (the push-pull of Gortler et al. 1996, *The Lumigraph*), so that
//! reads between texels at a chart's border find the chart's own colours. The largest level stays as it is.

use glam::Vec3;
use rayon::prelude::*;

use crate::coverage::{Coverage, SAMPLES};
use crate::srgb::{decode_table, encode};
use crate::{Mip, Texture};

/// Weight of a texel that triangles only touch, between its samples: next to any other it counts for nothing, alone it is all there is.
const TOUCHED_WEIGHT: f32 = 1.0 / (1_u64 << 40) as f32;
/// Below this no sample of a texel is shown, however large the texel: 4^14 of the largest level lie in one of the smallest.
const LEAST_SHOWN: f32 = 0.125 / (1_u64 << 30) as f32;

impl Texture {
    /// A texture from its largest level, `width * height` sRGB-encoded RGBA8 texels; makes the smaller ones down to 1 x 1.
    ///
    /// Each level is the mean of the one before in linear light, weighted by alpha, so that the colour of invisible texels
    /// does not bleed in. Odd sizes: each texel covers its exact share. Empty when a side is 0 or texels are missing.
    pub fn from_rgba8(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Self {
        if width == 0 || height == 0 || texels.len() != width as usize * height as usize {
            return Self::default();
        }
        let mut mips = vec![Mip { width, height, texels }];
        while let Some(last) = mips.last().filter(|mip| mip.width > 1 || mip.height > 1) {
            let (next, _) = halve(last, |_| 1.0, true);
            mips.push(next);
        }
        Self { mips }
    }

    /// The same with means of the texels that are shown, and of no others: weighted by coverage, and by alpha where that is read. Texels of
    /// smaller levels that show nothing have colours from around. As [`Texture::from_rgba8`] where `coverage` is of another size or empty.
    pub fn from_shown(width: u32, height: u32, texels: Vec<[u8; 4]>, coverage: &Coverage) -> Self {
        let fits = coverage.fits(width, height) && texels.len() == coverage.marks().len();
        if !fits || coverage.is_empty() || texels.is_empty() {
            return Self::from_rgba8(width, height, texels);
        }
        let reads_alpha = coverage.reads_alpha();
        let marks = coverage.marks();
        let largest = Mip { width, height, texels };
        let mut levels = vec![];
        if width > 1 || height > 1 {
            levels.push(halve(&largest, |at| weight_of(marks[at]), reads_alpha));
        }
        while let Some((last, weights)) = levels.last().filter(|(mip, _)| mip.width > 1 || mip.height > 1) {
            let next = halve(last, |at| weights[at], reads_alpha);
            levels.push(next);
        }
        for at in (0..levels.len()).rev() {
            let (finer, coarser) = levels.split_at_mut(at + 1);
            let (mip, weights) = &mut finer[at];
            fill(mip, weights, coarser.first().map(|(mip, _)| mip), (coverage.repeats(), reads_alpha));
        }
        Self { mips: std::iter::once(largest).chain(levels.into_iter().map(|(mip, _)| mip)).collect() }
    }
}

fn weight_of(mark: u8) -> f32 {
    match (mark & SAMPLES).count_ones() {
        0 if mark == 0 => 0.0,
        0 => TOUCHED_WEIGHT,
        samples => samples as f32 * 0.25,
    }
}

/// Colours and alpha on their way to a mean.
#[derive(Default, Clone, Copy)]
struct Sum {
    /// By weight and alpha.
    visible: Vec3,
    /// By weight alone.
    any: Vec3,
    alpha: f32,
    weight: f32,
}

impl Sum {
    fn add(&mut self, [r, g, b, a]: [u8; 4], weight: f32, linear: &[f32; 256]) {
        let rgb = Vec3::new(linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)]);
        let alpha = f32::from(a) / 255.0 * weight;
        self.visible += rgb * alpha;
        self.any += rgb * weight;
        self.alpha += alpha;
        self.weight += weight;
    }

    /// `whole`: the weights' sum where that is known better than by adding.
    fn mean(&self, whole: f32, reads_alpha: bool) -> [u8; 4] {
        let rgb = match self.alpha > 0.0 && reads_alpha {
            true => self.visible / self.alpha,
            false => self.any / whole,
        };
        [encode(rgb.x), encode(rgb.y), encode(rgb.z), (self.alpha / whole * 255.0 + 0.5) as u8]
    }
}

/// The next smaller level, and the weights of its texels: means of those in `weight_at`. What has none is nothing yet.
fn halve(mip: &Mip, weight_at: impl Fn(usize) -> f32 + Sync, reads_alpha: bool) -> (Mip, Vec<f32>) {
    let (width, height) = ((mip.width / 2).max(1), (mip.height / 2).max(1));
    let (columns, rows) = (shares(mip.width, width), shares(mip.height, height));
    let linear = decode_table();
    let of_row = |row: &Shares| {
        let of_texel = |column: &Shares| {
            let (mut sum, mut is_whole) = (Sum::default(), true);
            for (y, share_y) in row.taken() {
                for (x, share_x) in column.taken() {
                    let at = y as usize * mip.width as usize + x as usize;
                    let weight = weight_at(at);
                    is_whole &= weight == 1.0;
                    sum.add(mip.texels[at], share_x * share_y * weight, linear);
                }
            }
            let whole = if is_whole { 1.0 } else { sum.weight };
            if whole > 0.0 { (sum.mean(whole, reads_alpha), whole) } else { ([0; 4], 0.0) }
        };
        columns.iter().map(of_texel).collect::<Vec<_>>()
    };
    let rows: Vec<_> = rows.par_iter().map(of_row).collect();
    let (texels, weights) = rows.into_iter().flatten().unzip();
    (Mip { width, height, texels }, weights)
}

/// Gives texels that show nothing, or that triangles only touch, the mean of the shown ones around; where there are none, the colour of
/// the coarser level.
fn fill(mip: &mut Mip, weights: &[f32], coarser: Option<&Mip>, (repeats, reads_alpha): ([bool; 2], bool)) {
    let (width, height) = (mip.width as usize, mip.height as usize);
    let linear = decode_table();
    let texels = &mip.texels;
    let filled = |at: usize| {
        let (x, y) = (at % width, at / width);
        let mut sum = Sum::default();
        let columns = around(x, width, repeats[0]);
        for row in around(y, height, repeats[1]).into_iter().flatten() {
            for column in columns.into_iter().flatten() {
                let near = row * width + column;
                if weights[near] > 0.0 {
                    sum.add(texels[near], weights[near], linear);
                }
            }
        }
        if sum.weight > 0.0 {
            return sum.mean(sum.weight, reads_alpha);
        }
        let Some(coarser) = coarser else { return texels[at] };
        let parent = |at: usize, last: u32| (at / 2).min(last as usize - 1);
        coarser.texels[parent(y, coarser.height) * coarser.width as usize + parent(x, coarser.width)]
    };
    let of_row = |row: usize| -> Vec<[u8; 4]> {
        let texel = |at: usize| if weights[at] < LEAST_SHOWN { filled(at) } else { texels[at] };
        (row * width..(row + 1) * width).map(texel).collect()
    };
    let rows: Vec<_> = (0..height).into_par_iter().map(of_row).collect();
    mip.texels = rows.concat();
}

/// A texel's place and its neighbours'.
fn around(at: usize, size: usize, repeats: bool) -> [Option<usize>; 3] {
    let before = if at > 0 { Some(at - 1) } else { repeats.then_some(size - 1) };
    let after = if at + 1 < size { Some(at + 1) } else { repeats.then_some(0) };
    [before, Some(at), after]
}

/// Which texels of the larger level one texel of the smaller one covers: up to three, from `first`.
struct Shares {
    first: u32,
    weights: [f32; 3],
}

impl Shares {
    fn taken(&self) -> impl Iterator<Item = (u32, f32)> {
        (self.first..).zip(self.weights).filter(|(_, weight)| *weight > 0.0)
    }
}

fn shares(from: u32, to: u32) -> Vec<Shares> {
    // In units of 1/to of a larger texel everything is whole: smaller texel i covers [i * from, (i + 1) * from).
    (0..u64::from(to))
        .map(|i| {
            let (from, to) = (u64::from(from), u64::from(to));
            let (start, end) = (i * from, (i + 1) * from);
            let first = start / to;
            let weights = std::array::from_fn(|k| {
                let texel = (first + k as u64) * to;
                let covered = end.min(texel + to).saturating_sub(start.max(texel));
                covered as f32 / from as f32
            });
            Shares { first: first as u32, weights }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Wrap;

    const RED: [u8; 4] = [255, 0, 0, 255];
    const BLACK: [u8; 4] = [0, 0, 0, 255];

    /// Charts on black, in texels, and what they cover.
    fn atlas(side: u32, charts: &[([u32; 4], [u8; 4])]) -> (Vec<[u8; 4]>, Coverage) {
        let mut texels = vec![BLACK; (side * side) as usize];
        let mut coverage = Coverage::new(side, side);
        for ([left, top, right, bottom], color) in charts {
            for y in *top..*bottom {
                texels[(y * side + left) as usize..(y * side + right) as usize].fill(*color);
            }
            let [l, t, r, b] = [left, top, right, bottom].map(|at| *at as f32 / side as f32);
            coverage.add([[l, t], [r, t], [r, b]], [Wrap::Repeat; 2]);
            coverage.add([[l, t], [r, b], [l, b]], [Wrap::Repeat; 2]);
        }
        (texels, coverage)
    }

    /// The first texel of smaller levels that is not red, among those that reads within the chart can reach.
    fn first_off(texture: &Texture, [left, top, right, bottom]: [u32; 4]) -> Option<(usize, [u8; 4])> {
        for (level, mip) in texture.mips.iter().enumerate().skip(1) {
            let near = |from: u32, to: u32, size: u32| {
                let at = |texel: u32| texel as usize >> level;
                at(from).saturating_sub(1)..(at(to - 1) + 2).min(size as usize)
            };
            for y in near(top, bottom, mip.height) {
                for x in near(left, right, mip.width) {
                    let texel = mip.texels[y * mip.width as usize + x];
                    if texel != RED {
                        return Some((level, texel));
                    }
                }
            }
        }
        None
    }

    #[test]
    fn a_red_chart_on_black_is_red_in_every_level() {
        for chart in [[8, 8, 24, 24], [5, 9, 18, 12], [13, 3, 14, 29], [31, 31, 32, 32], [0, 0, 1, 64]] {
            let (texels, coverage) = atlas(64, &[(chart, RED)]);
            let texture = Texture::from_shown(64, 64, texels.clone(), &coverage);
            assert_eq!(texture.mips[0].texels, texels, "the largest level is the author's");
            assert_eq!(first_off(&texture, chart), None, "{chart:?}");
            // The comparison that must fail: plain means.
            let plain = Texture::from_rgba8(64, 64, texels);
            assert!(first_off(&plain, chart).is_some(), "{chart:?}");
        }
    }

    #[test]
    fn charts_that_share_a_texel_share_it_by_area() {
        let (texels, coverage) = atlas(16, &[([0, 0, 3, 4], RED), ([3, 0, 4, 4], [0, 255, 0, 255])]);
        let texture = Texture::from_shown(16, 16, texels, &coverage);
        assert_eq!(texture.mips[2].texels[0], [encode(0.75), encode(0.25), 0, 255]);
        // The whole texture is what the two are, the empty part of it nothing.
        assert!(texture.mips[4].texels[0][0].abs_diff(encode(0.75)) <= 1, "{:?}", texture.mips[4].texels);
    }

    #[test]
    fn texels_beyond_the_neighbours_have_colours_of_coarser_levels() {
        let (texels, coverage) = atlas(64, &[([0, 0, 8, 8], RED), ([32, 32, 64, 64], [0, 0, 255, 255])]);
        let texture = Texture::from_shown(64, 64, texels, &coverage);
        let at = |level: usize, x: usize, y: usize| texture.mips[level].texels[y * (64 >> level) + x];
        assert_eq!((at(1, 6, 6), at(1, 30, 30)), (RED, [0, 0, 255, 255]));
        assert!(texture.mips[1..].iter().flat_map(|mip| &mip.texels).all(|texel| *texel != BLACK));
    }

    #[test]
    fn alpha_counts_where_somebody_cuts_by_it() {
        let texels = vec![[200, 100, 50, 255], [0, 255, 0, 0], BLACK, BLACK];
        let chart = [[[0.0, 0.0], [1.0, 0.0], [1.0, 0.5]], [[0.0, 0.0], [1.0, 0.5], [0.0, 0.5]]];
        let mut coverage = Coverage::new(2, 2);
        chart.iter().for_each(|corners| coverage.add(*corners, [Wrap::Clamp; 2]));
        let of = |coverage: &Coverage| Texture::from_shown(2, 2, texels.clone(), coverage).mips[1].texels[0];
        let half = |a: u8| encode(0.5 * decode_table()[usize::from(a)]);
        let linear = |a: u8| decode_table()[usize::from(a)];
        assert_eq!(of(&coverage), [half(200), encode(0.5 * linear(100) + 0.5), half(50), 128]);
        coverage.read_alpha();
        assert_eq!(of(&coverage), [200, 100, 50, 128]);
    }

    #[test]
    fn what_is_filled_heeds_alpha_where_somebody_cuts_by_it() {
        // Red without alpha, a gap, green with it.
        let (red, green) = ([255, 0, 0, 0], [0, 255, 0, 255]);
        let texels = [[red, red, BLACK, BLACK, green, green]; 2].concat();
        let mut coverage = Coverage::new(6, 2);
        for [from, to] in [[0.0, 1.0 / 3.0], [2.0 / 3.0, 1.0]] {
            for corners in [[[from, 0.0], [to, 0.0], [to, 1.0]], [[from, 0.0], [to, 1.0], [from, 1.0]]] {
                coverage.add(corners, [Wrap::Clamp; 2]);
            }
        }
        let gap = |coverage: &Coverage| Texture::from_shown(6, 2, texels.clone(), coverage).mips[1].texels[1];
        assert_eq!(gap(&coverage), [encode(0.5), encode(0.5), 0, 128]);
        coverage.read_alpha();
        assert_eq!(gap(&coverage), [0, 255, 0, 128]);
    }

    #[test]
    fn a_palette_has_the_colours_that_points_read() {
        // Points in the middle of cells of four texels: their reads reach no neighbour.
        let colors = [[10, 20, 30, 255], [240, 10, 10, 255], [0, 200, 0, 255], [90, 90, 200, 255]];
        let texels: Vec<_> = (0..8 * 8).map(|at| colors[(at % 8) / 4 + at / 32 * 2]).collect();
        let mut coverage = Coverage::new(8, 8);
        for (u, v) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75)] {
            coverage.add([[u, v]; 3], [Wrap::Repeat; 2]);
        }
        let texture = Texture::from_shown(8, 8, texels, &coverage);
        for (at, color) in [(0, colors[0]), (1, colors[1]), (2, colors[2])] {
            assert_eq!(texture.mips[2].texels[at], color);
        }
        assert_ne!(texture.mips[2].texels[3], colors[3], "nobody reads the last one");
    }

    #[test]
    fn where_all_is_shown_levels_are_the_plain_ones() {
        let texels: Vec<[u8; 4]> =
            (0..7 * 5_u32).map(|i| [i as u8 * 7, 255 - i as u8, (i * i % 251) as u8, 255 - i as u8 / 3]).collect();
        let mut coverage = Coverage::new(7, 5);
        coverage.add([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]], [Wrap::Repeat; 2]);
        coverage.read_alpha();
        let plain = Texture::from_rgba8(7, 5, texels.clone());
        assert_eq!(Texture::from_shown(7, 5, texels.clone(), &coverage), plain);
        assert_eq!(Texture::from_shown(7, 5, texels.clone(), &Coverage::new(7, 5)), plain, "nothing shown");
        assert_eq!(Texture::from_shown(7, 5, texels, &Coverage::new(5, 7)), plain, "another size");
        assert_eq!(Texture::from_shown(0, 0, vec![], &Coverage::new(0, 0)), Texture::default());
    }

    #[test]
    fn levels_halve_down_to_one_and_keep_the_mean() {
        let texels: Vec<[u8; 4]> =
            (0..7 * 5).map(|i| if i % 2 == 0 { [255, 0, 0, 255] } else { [0, 0, 0, 255] }).collect();
        let texture = Texture::from_rgba8(7, 5, texels);
        let sizes: Vec<_> = texture.mips.iter().map(|mip| (mip.width, mip.height)).collect();
        assert_eq!(sizes, [(7, 5), (3, 2), (1, 1)]);
        let mean = decode_table()[usize::from(texture.mips[2].texels[0][0])];
        assert!((mean - 18.0 / 35.0).abs() < 0.01, "{mean}");
    }

    #[test]
    fn invisible_texels_do_not_bleed() {
        let texture = Texture::from_rgba8(2, 1, vec![[200, 100, 50, 255], [0, 255, 0, 0]]);
        assert_eq!(texture.mips[1].texels, [[200, 100, 50, 128]]);
    }
}
