//! How far two pictures lie apart, and the bound within which the CPU and the GPU must agree.

use image::RgbImage;

/// The stated bound. Edges may fall on the other side of a pixel's centre, and textures are filtered with other
/// roundings; both touch few pixels. A whole instance, or a shift by one pixel, touches far more. Seen in these tests: no
/// pixel far apart, a mean of 0.09; of 10,000 characters as found, whose far triangles are smaller than a pixel: 0.0016
/// and 0.24.
pub const BOUND: Difference = Difference { far_share: 0.001, mean: 0.2 };

/// How far two pictures lie apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Share of the pixels with a channel more than 16 of 255 apart.
    pub far_share: f64,
    /// Mean distance of all channels, of 255.
    pub mean: f64,
}

impl Difference {
    /// Between two pictures of one size.
    pub fn between(a: &RgbImage, b: &RgbImage) -> Self {
        assert_eq!(a.dimensions(), b.dimensions(), "pictures of two sizes cannot be compared");
        let (mut far, mut sum) = (0u64, 0u64);
        for (a, b) in a.pixels().zip(b.pixels()) {
            let apart = [0, 1, 2].map(|c| u64::from(a[c].abs_diff(b[c])));
            far += u64::from(apart.iter().any(|&d| d > 16));
            sum += apart.iter().sum::<u64>();
        }
        let pixels = f64::from(a.width()) * f64::from(a.height());
        Self { far_share: far as f64 / pixels, mean: sum as f64 / (3.0 * pixels) }
    }

    /// Within the bound in both numbers.
    pub fn is_within(&self, bound: &Self) -> bool {
        self.far_share <= bound.far_share && self.mean <= bound.mean
    }
}
