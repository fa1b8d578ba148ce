//! Pictures out of a backend and into files: nothing half-written is ever left behind.

use crate::{Error, Result};
use std::io::Write;
use std::path::Path;

/// A finished frame: sRGB-encoded RGBA8, row 0 at the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// `width * height`, row by row.
    pub pixels: Vec<[u8; 4]>,
}

/// A picture in the corner of another has one of so many parts of its width and height.
const INSET_PART: u32 = 3;
/// Pixels of its frame, and their colour.
const INSET_FRAME: u32 = 2;
const INSET_COLOR: [u8; 4] = [245, 245, 245, 255];

impl Picture {
    /// The same, a third as wide and high, with the means of three by three pixels.
    pub fn reduced(&self) -> Self {
        let (width, height) = (self.width / INSET_PART, self.height / INSET_PART);
        let mean = |x: u32, y: u32| {
            let mut sum = [0u32; 4];
            for i in 0..INSET_PART * INSET_PART {
                let (px, py) = (x * INSET_PART + i % INSET_PART, y * INSET_PART + i / INSET_PART);
                let pixel = self.pixels[(py * self.width + px) as usize];
                sum.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += u32::from(value));
            }
            sum.map(|sum| (sum / (INSET_PART * INSET_PART)) as u8)
        };
        let pixels = (0..width * height).map(|i| mean(i % width, i / width)).collect();
        Self { width, height, pixels }
    }

    /// Puts a reduced picture with a frame into the lower right corner, as far as there is room.
    pub fn put_into_corner(&mut self, small: &Self) {
        let margin = 2 * INSET_FRAME;
        let (across, down) = (small.width + 2 * INSET_FRAME, small.height + 2 * INSET_FRAME);
        if small.pixels.is_empty() || across + margin > self.width || down + margin > self.height {
            return;
        }
        let (left, top) = (self.width - across - margin, self.height - down - margin);
        for y in 0..down {
            for x in 0..across {
                let inner = (x.wrapping_sub(INSET_FRAME), y.wrapping_sub(INSET_FRAME));
                let is_inside = inner.0 < small.width && inner.1 < small.height;
                let pixel =
                    if is_inside { small.pixels[(inner.1 * small.width + inner.0) as usize] } else { INSET_COLOR };
                self.pixels[((top + y) * self.width + left + x) as usize] = pixel;
            }
        }
    }

    /// PNG bytes, opaque.
    pub fn to_png(&self) -> Vec<u8> {
        use image::codecs::png::{CompressionType, FilterType, PngEncoder};
        let rgb: Vec<u8> = self.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
        image::ImageEncoder::write_image(encoder, &rgb, self.width, self.height, image::ExtendedColorType::Rgb8)
            .expect("a picture has width * height pixels, and memory takes what is written to it");
        bytes
    }
}

/// Writes a file as a whole or not at all ([`crowd_pack::whole_file::write`]).
///
/// # Errors
/// [`Error::Output`] where it cannot.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    crowd_pack::whole_file::write(path, bytes).map_err(|source| Error::Output { path: path.to_owned(), source })
}

/// Writes to standard output; a reader that has gone away is no failure.
pub fn write_stdout(stdout: &mut dyn Write, bytes: &[u8]) -> Result<()> {
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(|source| Error::Output { path: "standard output".into(), source }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smaller_picture_goes_into_the_corner_or_nowhere() {
        let of = |width: u32, height: u32, value: u8| Picture {
            width,
            height,
            pixels: vec![[value, value, value, 255]; (width * height) as usize],
        };
        let mut large = of(60, 45, 10);
        let small = of(60, 45, 200).reduced();
        assert_eq!((small.width, small.height, small.pixels[0]), (20, 15, [200, 200, 200, 255]));
        large.put_into_corner(&small);
        let count = |value: u8| large.pixels.iter().filter(|pixel| pixel[0] == value).count();
        assert_eq!((count(200), count(245)), (300, 24 * 19 - 300));
        assert_eq!(large.pixels[0][0], 10);
        for side in [1, 2, 5, 8] {
            let mut tiny = of(side, side, 10);
            let reduced = tiny.reduced();
            tiny.put_into_corner(&reduced);
            assert_eq!(tiny.pixels.len(), (side * side) as usize);
        }
    }

    #[test]
    fn a_picture_survives_its_png() {
        let pixels = vec![[1, 2, 3, 255], [4, 5, 6, 255]];
        let picture = Picture { width: 2, height: 1, pixels: pixels.clone() };
        let back = image::load_from_memory(&picture.to_png()).unwrap().to_rgba8();
        assert_eq!(back.pixels().map(|p| p.0).collect::<Vec<_>>(), pixels);
    }

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        write_file(&folder.path().join("a"), b"one").unwrap();
        write_file(&folder.path().join("a"), b"two").unwrap();
        assert_eq!(std::fs::read(folder.path().join("a")).unwrap(), b"two");
        let error = write_file(&folder.path().join("a/b"), b"x").unwrap_err();
        assert_eq!(error.exit_code(), crate::error::EXIT_OUTPUT, "a file is no folder");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        write_file(&folder.path().join("new/folder/a"), b"three").unwrap();
        assert_eq!(std::fs::read_dir(folder.path().join("new/folder")).unwrap().count(), 1);
    }
}
