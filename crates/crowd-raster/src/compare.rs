//! Compares two pictures.

use crate::{Error, Result, Target};

/// How far two pictures of one size are apart, in codes of 0 to 255 over red, green and blue.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageDifference {
    /// Mean of the absolute difference, over all channels.
    pub mean_abs: f64,
    /// Root of the mean square, over all channels.
    pub rms: f64,
    /// Largest difference of any channel.
    pub max: u8,
    /// Pixels by the largest difference of their channels.
    pub histogram: Box<[u64; 256]>,
}

impl ImageDifference {
    /// Share of pixels (0 to 1) of which a channel differs by more than `threshold`.
    pub fn share_over(&self, threshold: u8) -> f64 {
        let pixels: u64 = self.histogram.iter().sum();
        let over: u64 = self.histogram[usize::from(threshold) + 1..].iter().sum();
        if pixels == 0 { 0.0 } else { over as f64 / pixels as f64 }
    }
}

/// Compares colours; alpha and depth are not looked at.
///
/// # Errors
/// [`Error::Parameter`] when the sizes differ.
pub fn compare_images(a: &Target, b: &Target) -> Result<ImageDifference> {
    if (a.width, a.height) != (b.width, b.height) || a.color.len() != b.color.len() {
        return Err(Error::Parameter(format!(
            "pictures of {} x {} and {} x {} pixels cannot be compared",
            a.width, a.height, b.width, b.height
        )));
    }
    let mut histogram = Box::new([0_u64; 256]);
    let (mut sum, mut squares) = (0_u64, 0_u64);
    for (a, b) in a.color.iter().zip(&b.color) {
        let channels = [a[0].abs_diff(b[0]), a[1].abs_diff(b[1]), a[2].abs_diff(b[2])];
        histogram[usize::from(channels[0].max(channels[1]).max(channels[2]))] += 1;
        for channel in channels.map(u64::from) {
            sum += channel;
            squares += channel * channel;
        }
    }
    let channels = (a.color.len() as f64 * 3.0).max(1.0);
    let max = histogram.iter().rposition(|&pixels| pixels > 0).unwrap_or(0) as u8;
    Ok(ImageDifference { mean_abs: sum as f64 / channels, rms: (squares as f64 / channels).sqrt(), max, histogram })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_equals_itself() {
        let picture = Target::new(20, 10, [30, 60, 90, 255]);
        let same = compare_images(&picture, &picture).expect("same size");
        assert_eq!((same.mean_abs, same.rms, same.max, same.share_over(0)), (0.0, 0.0, 0, 0.0));
    }

    #[test]
    fn one_changed_channel_of_one_pixel_is_seen() {
        let a = Target::new(20, 10, [30, 60, 90, 255]);
        let mut b = a.clone();
        b.color[77][1] += 6;
        let difference = compare_images(&a, &b).expect("same size");
        assert_eq!(difference.max, 6);
        assert!((difference.mean_abs - 0.01).abs() < 1e-12);
        assert!((difference.rms - (36.0_f64 / 600.0).sqrt()).abs() < 1e-12);
        assert_eq!((difference.share_over(5), difference.share_over(6)), (1.0 / 200.0, 0.0));
        assert_eq!(difference.share_over(255), 0.0);
    }

    #[test]
    fn other_sizes_are_refused() {
        assert!(compare_images(&Target::new(2, 3, [0; 4]), &Target::new(3, 2, [0; 4])).is_err());
    }
}
