//! How alike two pictures are.

/// What differs between two pictures of one size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Mean over pixels of the largest channel difference, 0 to 255.
    pub mean: f64,
    /// Largest channel difference.
    pub max: u8,
    /// Share of pixels with a channel more than `threshold` apart.
    pub share: f64,
}

/// Compares the colours of two pictures, pixel by pixel; alpha does not count.
///
/// # Panics
/// When they have different numbers of pixels: that is a difference no number describes.
pub fn compare(a: &[[u8; 4]], b: &[[u8; 4]], threshold: u8) -> Difference {
    assert_eq!(a.len(), b.len(), "the pictures have different sizes");
    let apart = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
    let differences: Vec<u8> = a.iter().zip(b).map(apart).collect();
    let count = differences.len().max(1) as f64;
    Difference {
        mean: differences.iter().map(|d| f64::from(*d)).sum::<f64>() / count,
        max: differences.iter().copied().max().unwrap_or(0),
        share: differences.iter().filter(|d| **d > threshold).count() as f64 / count,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_do_not_differ_and_one_changed_channel_is_seen() {
        let a = vec![[10, 20, 30, 255]; 8];
        let mut b = a.clone();
        assert_eq!(compare(&a, &b, 0), Difference { mean: 0.0, max: 0, share: 0.0 });
        b[3][1] = 36;
        assert_eq!(compare(&a, &b, 15), Difference { mean: 2.0, max: 16, share: 0.125 });
    }
}
