//! Which texels of a texture triangles show.
//!
//! Each texel has four samples, so that charts have shares of those at their borders, and knows besides whether any triangle touches it at
//! all: rows of a triangle are clipped to rows of texels, so that no texel is missed however thin the triangle (what Akenine-Möller & Aila
//! 2005, *Conservative and tiled rasterization using a modified triangle set-up*, ask for, without edge functions).

use crate::Wrap;

/// Samples of a texel, a bit each: left and right, upper row first.
pub(crate) const SAMPLES: u8 = 0b1111;
/// Bit of a texel that a triangle touches.
const TOUCHED: u8 = 1 << 4;
/// Tiles of the texture that a triangle may reach over: beyond, the whole texture counts as shown.
const MOST_TILES: f64 = 64.0;
/// Texels looked at, over those of the texture, before the whole of it counts as shown.
const MOST_LAYERS: u64 = 16;
/// Texels that every triangle may have without counting: triangles of a few texels are in any case bounded by their number.
const FREE_TEXELS: u64 = 16;

/// Which texels of a texture are shown, wrapped as samplers do.
#[derive(Debug, Clone)]
pub struct Coverage {
    width: u32,
    height: u32,
    /// A byte a texel, row by row.
    marks: Vec<u8>,
    /// Across and down: some triangle reads the texture as a tile among others.
    repeats: [bool; 2],
    reads_alpha: bool,
    is_empty: bool,
    work_left: u64,
}

impl Coverage {
    /// Nothing shown of a texture of that size.
    pub fn new(width: u32, height: u32) -> Self {
        let texels = width as usize * height as usize;
        Self {
            width,
            height,
            marks: vec![0; texels],
            repeats: [false; 2],
            reads_alpha: false,
            is_empty: true,
            work_left: MOST_LAYERS * texels as u64,
        }
    }

    /// Somebody cuts out what has little alpha: colours then count by alpha, too.
    pub fn read_alpha(&mut self) {
        self.reads_alpha = true;
    }

    /// Adds a triangle. Corners may have any coordinates: those that are no numbers show nothing, those over very many tiles everything.
    pub fn add(&mut self, uvs: [[f32; 2]; 3], wraps: [Wrap; 2]) {
        if self.marks.is_empty() || self.work_left == 0 || !uvs.as_flattened().iter().all(|c| c.is_finite()) {
            return;
        }
        self.is_empty = false;
        let mut corners = [[0.0; 2]; 3];
        for axis in 0..2 {
            self.repeats[axis] |= wraps[axis] == Wrap::Repeat;
            let along = uvs.map(|uv| f64::from(uv[axis]));
            let low = along.into_iter().fold(f64::INFINITY, f64::min);
            let high = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
            if high - low > MOST_TILES {
                return self.show_all();
            }
            let size = f64::from([self.width, self.height][axis]);
            let inner = |c: f64| match wraps[axis] {
                Wrap::Repeat => c - low.floor(),
                Wrap::Mirror => c - 2.0 * (low / 2.0).floor(),
                Wrap::Clamp => c.clamp(-MOST_TILES, MOST_TILES + 1.0),
            };
            (0..3).for_each(|corner| corners[corner][axis] = inner(along[corner]) * size);
        }
        let corners = corners;
        self.mark_texels(&corners, wraps, TOUCHED);
        // One that falls between the samples: its texels are all it has.
        if !self.mark_samples(&corners, wraps) {
            self.mark_texels(&corners, wraps, 1);
        }
    }

    /// All texels that the triangle touches; `corners` in texels.
    fn mark_texels(&mut self, corners: &[[f64; 2]; 3], wraps: [Wrap; 2], mark: u8) {
        let [width, height] = [self.width, self.height].map(i64::from);
        let (top, bottom) = touched(corners.iter().map(|corner| corner[1]));
        let mut cost = 0;
        for row in top..=bottom {
            let (left, right) = touched(clipped_to(corners, row as f64, row as f64 + 1.0));
            runs(row, row, height, wraps[1], |row, _| {
                runs(left, right, width, wraps[0], |first, last| {
                    cost += (last - first + 1) as u64;
                    let row = &mut self.marks[row * width as usize..][..width as usize];
                    row[first..=last].iter_mut().for_each(|texel| *texel |= mark);
                });
            });
            cost += 1;
            if cost > self.work_left {
                return self.show_all();
            }
        }
        self.work_left = self.work_left.saturating_sub(cost.saturating_sub(FREE_TEXELS)).max(1);
    }

    /// All samples within the triangle; whether there are any.
    fn mark_samples(&mut self, corners: &[[f64; 2]; 3], wraps: [Wrap; 2]) -> bool {
        if self.work_left == 0 {
            return true;
        }
        let [width, height] = [self.width, self.height].map(|side| 2 * i64::from(side));
        let ys = corners.map(|corner| corner[1]);
        let (top, bottom) = samples_between(ys.iter().copied());
        let mut hits = false;
        for row in top..bottom {
            let y = (row as f64 + 0.5) / 2.0;
            let (first, end) = samples_between(clipped_to(corners, y, y));
            if first >= end {
                continue;
            }
            hits = true;
            runs(row, row, height, wraps[1], |row, _| {
                let marks = &mut self.marks[row / 2 * (width / 2) as usize..][..(width / 2) as usize];
                let bit = |column: usize| 1 << (column % 2 + row % 2 * 2);
                runs(first, end - 1, width, wraps[0], |first, last| {
                    (first..=last).for_each(|column| marks[column / 2] |= bit(column));
                });
            });
        }
        hits
    }

    fn show_all(&mut self) {
        self.marks.fill(SAMPLES | TOUCHED);
        self.work_left = 0;
    }

    /// No triangle was added that shows anything.
    pub fn is_empty(&self) -> bool {
        self.is_empty
    }

    /// Whether it is of a texture of that size.
    pub(crate) fn fits(&self, width: u32, height: u32) -> bool {
        [self.width, self.height] == [width, height]
    }

    pub(crate) fn reads_alpha(&self) -> bool {
        self.reads_alpha
    }

    pub(crate) fn repeats(&self) -> [bool; 2] {
        self.repeats
    }

    /// A byte a texel: 0 where nothing is shown, else the samples within triangles and a bit that is none of theirs.
    pub(crate) fn marks(&self) -> &[u8] {
        &self.marks
    }
}

/// First and last texel that what lies between these coordinates touches; a point touches one.
fn touched(along: impl Iterator<Item = f64>) -> (i64, i64) {
    let (low, high) = ends(along);
    let first = low.floor() as i64;
    (first, (high.ceil() as i64 - 1).max(first))
}

/// Samples between these coordinates, half a texel apart, and one beyond.
fn samples_between(along: impl Iterator<Item = f64>) -> (i64, i64) {
    let (low, high) = ends(along);
    let first = |c: f64| (2.0 * c - 0.5).ceil() as i64;
    (first(low), first(high))
}

fn ends(along: impl Iterator<Item = f64>) -> (f64, f64) {
    along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)))
}

/// Where the edges of a triangle lie across, between two heights. A triangle's extent there is that of its edges.
fn clipped_to(corners: &[[f64; 2]; 3], top: f64, bottom: f64) -> impl Iterator<Item = f64> {
    let edge = move |[a, b]: [[f64; 2]; 2]| {
        let [a, b] = if a[1] <= b[1] { [a, b] } else { [b, a] };
        let is_there = a[1] <= bottom && b[1] >= top;
        let at = |y: f64| match y {
            y if y <= a[1] => a[0],
            y if y >= b[1] => b[0],
            y => a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])),
        };
        // A level edge has both its ends there.
        let crossed = if a[1] == b[1] { [a[0], b[0]] } else { [at(top), at(bottom)] };
        is_there.then_some(crossed)
    };
    let [a, b, c] = *corners;
    [[a, b], [b, c], [c, a]].into_iter().filter_map(edge).flatten()
}

/// Calls `run` with the first and the last of each row of neighbours that `low..=high` are, once wrapped into `0..size`.
fn runs(low: i64, high: i64, size: i64, wrap: Wrap, mut run: impl FnMut(usize, usize)) {
    if wrap == Wrap::Clamp {
        return run(low.clamp(0, size - 1) as usize, high.clamp(0, size - 1) as usize);
    }
    // Twice around is everything, mirrored or not.
    let high = high.min(low + 2 * size - 1);
    let mut at = low;
    while at <= high {
        let tile = at.div_euclid(size);
        let last = high.min((tile + 1) * size - 1);
        let (first, end) = ((at - tile * size) as usize, (last - tile * size) as usize);
        match wrap == Wrap::Mirror && tile % 2 != 0 {
            true => run(size as usize - 1 - end, size as usize - 1 - first),
            false => run(first, end),
        }
        at = last + 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPEAT: [Wrap; 2] = [Wrap::Repeat; 2];

    /// One row a line: a digit of samples, `.` where nothing is shown, `t` for what is only touched.
    fn drawn(coverage: &Coverage) -> Vec<String> {
        let texel = |mark: &u8| match (mark & SAMPLES).count_ones() {
            0 if *mark == 0 => '.',
            0 => 't',
            samples => char::from_digit(samples, 10).expect("at most four"),
        };
        coverage.marks.chunks(coverage.width as usize).map(|row| row.iter().map(texel).collect()).collect()
    }

    fn of(side: u32, triangles: &[[[f32; 2]; 3]], wraps: [Wrap; 2]) -> Vec<String> {
        let mut coverage = Coverage::new(side, side);
        triangles.iter().for_each(|corners| coverage.add(*corners, wraps));
        drawn(&coverage)
    }

    fn square(low: [f32; 2], high: [f32; 2]) -> [[[f32; 2]; 3]; 2] {
        let [a, b] = [[high[0], low[1]], [low[0], high[1]]];
        [[low, a, high], [low, high, b]]
    }

    #[test]
    fn charts_cover_their_texels_and_shares_of_those_at_the_border() {
        assert_eq!(of(4, &square([0.25, 0.25], [0.75, 0.5]), REPEAT), ["....", ".44.", "....", "...."]);
        assert_eq!(of(4, &square([0.25, 0.25], [0.625, 0.55]), REPEAT), ["....", ".42.", ".tt.", "...."]);
        let whole = of(8, &square([0.0, 0.0], [1.0, 1.0]), REPEAT);
        assert_eq!(whole, vec!["44444444"; 8]);
    }

    #[test]
    fn points_and_lines_and_slivers_have_the_texels_that_they_touch() {
        let point = [[0.3, 0.6]; 3];
        assert_eq!(of(4, &[point], REPEAT), ["....", "....", ".1..", "...."]);
        let line = [[0.1, 0.1], [0.1, 0.1], [0.9, 0.9]];
        assert_eq!(of(4, &[line], REPEAT), ["1...", ".1..", "..1.", "...1"]);
        let sliver = [[0.0, 0.5625], [1.0, 0.5626], [0.5, 0.5627]];
        assert_eq!(of(4, &[sliver], REPEAT), ["....", "....", "1111", "...."]);
    }

    #[test]
    fn coordinates_outside_are_wrapped_as_samplers_do() {
        let corner = square([0.75, 0.0], [1.25, 0.25]);
        assert_eq!(of(4, &corner, REPEAT), ["4..4", "....", "....", "...."]);
        assert_eq!(of(4, &corner, [Wrap::Mirror; 2]), ["...4", "....", "....", "...."]);
        assert_eq!(of(4, &corner, [Wrap::Clamp; 2]), ["...4", "....", "....", "...."]);
        let far = square([-6.5, 3.0], [-6.25, 3.25]);
        assert_eq!(of(4, &far, REPEAT), ["..4.", "....", "....", "...."]);
        assert_eq!(of(4, &far, [Wrap::Mirror; 2]), ["....", "....", "....", ".4.."]);
        assert_eq!(of(4, &far, [Wrap::Clamp; 2]), ["....", "....", "....", "1..."]);
        let wide = square([0.25, 0.0], [4.0, 0.25]);
        assert_eq!(of(4, &wide, REPEAT), ["4444", "....", "....", "...."]);
        assert_eq!(of(4, &wide, [Wrap::Clamp; 2]), [".444", "....", "....", "...."]);
    }

    #[test]
    fn hostile_coordinates_end_soon_and_show_all_or_nothing() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(of(4, &[[[0.0, 0.0], [1.0, bad], [0.0, 1.0]]], REPEAT), vec!["...."; 4]);
        }
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            assert_eq!(of(4, &[[[0.0, 0.0], [1e30, 0.0], [0.0, 1.0]]], [wrap; 2]), vec!["4444"; 4]);
            let far = of(4, &[[[1e30, -1e30]; 3]], [wrap; 2]).concat();
            assert_eq!(far.chars().filter(|texel| *texel == '1').count(), 1, "{far}");
        }
        // So many large triangles that nobody could have them all.
        let mut coverage = Coverage::new(256, 256);
        for _ in 0..1_000_000 {
            coverage.add([[0.0, 0.0], [60.0, 0.0], [0.0, 0.9]], REPEAT);
        }
        assert_eq!(coverage.marks, vec![SAMPLES | TOUCHED; 256 * 256]);
        coverage.add([[0.1; 2]; 3], REPEAT);
        let mut none = Coverage::new(0, 7);
        none.add([[0.1; 2]; 3], REPEAT);
        assert!(none.is_empty() && !coverage.is_empty());
    }

    #[test]
    fn many_small_triangles_are_no_reason_to_give_up() {
        let mut coverage = Coverage::new(8, 8);
        for _ in 0..100_000 {
            coverage.add([[0.3, 0.3], [0.31, 0.3], [0.3, 0.31]], REPEAT);
        }
        assert_eq!(drawn(&coverage).concat().replace('.', ""), "1");
    }
}
