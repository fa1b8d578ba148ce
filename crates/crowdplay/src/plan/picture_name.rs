//! Where pictures go, and the number of a frame in a file's name.

use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Where pictures go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PictureName {
    /// The last frame, to standard output.
    Stdout,
    /// The last frame, to a file.
    Last(PathBuf),
    /// All frames, to a film.
    Film(PathBuf),
    /// Each frame: text before the number, digits to pad to, text after it.
    Each {
        /// Before.
        before: String,
        /// At least so many digits.
        digits: usize,
        /// After.
        after: String,
    },
}

impl PictureName {
    /// Reads `%d` or `%04d` in the file's name; `%%` is a percent sign.
    pub(super) fn parse(out: &Path) -> Result<Self> {
        let text = &*out.to_string_lossy();
        if text == "-" {
            return Ok(Self::Stdout);
        }
        let refused =
            |allowed: &str| Error::Parameter { option: "--out", found: text.to_owned(), allowed: allowed.to_owned() };
        // Of a name that is no text nothing can be read but its ending, and nothing may be put in.
        let is_text = out.to_str().is_some();
        if !is_text && text.contains('%') {
            return Err(refused("a name in UTF-8 where it has a %"));
        }
        let wrong = || refused("one %d or %04d for the frame's number, and %% for a percent sign");
        let (mut name, mut number) = (String::new(), None);
        let mut parts = text.split('%');
        name.push_str(parts.next().unwrap_or_default());
        while let Some(part) = parts.next() {
            if part.is_empty() {
                name.push('%');
                name.push_str(parts.next().ok_or_else(wrong)?);
                continue;
            }
            let (digits, after) = part.split_once('d').ok_or_else(wrong)?;
            if number.is_some() || digits.len() > 2 || !digits.chars().all(|c| c.is_ascii_digit()) {
                return Err(wrong());
            }
            number = Some((std::mem::take(&mut name), digits.parse().unwrap_or(1)));
            name.push_str(after);
        }
        // The number is part of the name, be it all of it.
        let is_film = crate::film::is_film(Path::new(&format!("0{name}")));
        if let Some(other) = other_picture(&name) {
            return Err(refused(&format!(
                ".png, or a film's {}; no .{other} is written",
                crate::film::ENDINGS.join(", ")
            )));
        }
        match number {
            Some(_) if is_film => Err(refused("a film's name without a number, or the number in that of a PNG")),
            Some((before, digits)) => Ok(Self::Each { before, digits, after: name }),
            None => {
                let path = if is_text { name.into() } else { out.to_owned() };
                Ok(if is_film { Self::Film(path) } else { Self::Last(path) })
            }
        }
    }

    /// File of a frame, if that frame is to be written to a file.
    pub fn file_of(&self, frame: u32, frames: u32) -> Option<PathBuf> {
        match self {
            Self::Stdout => None,
            Self::Last(path) | Self::Film(path) => (frame + 1 == frames).then(|| path.clone()),
            Self::Each { before, digits, after } => {
                Some(PathBuf::from(format!("{before}{frame:0width$}{after}", width = digits)))
            }
        }
    }

    /// Whether the frame's pixels are needed at all.
    pub fn wants(&self, frame: u32, frames: u32) -> bool {
        frame + 1 == frames || matches!(self, Self::Each { .. } | Self::Film(_))
    }
}

/// The ending of another kind of file than the picture that is written.
fn other_picture(name: &str) -> Option<&str> {
    const OTHERS: [&str; 9] = ["jpg", "jpeg", "webp", "bmp", "tif", "tiff", "tga", "svg", "exr"];
    let (_, ending) = name.rsplit_once('.')?;
    OTHERS.iter().any(|other| other.eq_ignore_ascii_case(ending)).then_some(ending)
}

/// Refuses a picture of the window that is no PNG file by its name.
pub(super) fn expect_png(file: &Path) -> Result<()> {
    let name = file.to_string_lossy();
    let refused = |allowed: String| Err(Error::Parameter { option: "--screenshot", found: name.to_string(), allowed });
    match other_picture(&name) {
        Some(ending) => refused(format!(".png; no .{ending} is written")),
        None if crate::film::is_film(file) => {
            refused(".png; films are made without a window (--headless --out)".into())
        }
        None if name == "-" => refused("a file; without a window (--headless --out -) standard output, too".into()),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_file_names() {
        let each = PictureName::parse(Path::new("a/frame-%04d.png")).unwrap();
        assert_eq!(each.file_of(7, 10), Some(PathBuf::from("a/frame-0007.png")));
        assert!(each.wants(7, 10));
        let last = PictureName::parse(Path::new("x.png")).unwrap();
        assert_eq!(last.file_of(7, 10), None);
        assert_eq!(last.file_of(9, 10), Some(PathBuf::from("x.png")));
        assert!(!last.wants(7, 10) && last.wants(9, 10));
        let literal = PictureName::parse(Path::new("50%%/a%%%d%%.png")).unwrap();
        assert_eq!(literal.file_of(7, 10), Some(PathBuf::from("50%/a%7%.png")));
        assert_eq!(PictureName::parse(Path::new("9%%.png")).unwrap(), PictureName::Last("9%.png".into()));
        for bad in ["%s.png", "%d-%d.png", "100%.png", "%0004d.png", "a%", "a%%%", "%d.mp4"] {
            assert!(PictureName::parse(Path::new(bad)).is_err(), "{bad}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn names_that_are_no_text_keep_their_bytes_and_their_rules() {
        let name =
            |bytes: &'static [u8]| Path::new(<std::ffi::OsStr as std::os::unix::ffi::OsStrExt>::from_bytes(bytes));
        assert_eq!(PictureName::parse(name(b"\xff.png")).unwrap(), PictureName::Last(name(b"\xff.png").into()));
        assert_eq!(PictureName::parse(name(b"\xff.mp4")).unwrap(), PictureName::Film(name(b"\xff.mp4").into()));
        for bad in [&b"\xff.jpg"[..], b"\xff%d.png", b"\xff%%.png"] {
            assert!(PictureName::parse(name(bad)).is_err(), "{bad:?}");
        }
        assert!(expect_png(name(b"\xff.jpg")).is_err() && expect_png(name(b"\xff.png")).is_ok());
    }
}
