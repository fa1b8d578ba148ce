//! The folder rule: what an asset may read is its own folder and what lies below it.
//!
//! Names in an asset are written by strangers. `http:` and friends are refused by name, absolute paths, `..` that climbs
//! out and links that lead out are refused, and only plain files are opened (a pipe would hang the reader).

use std::cell::Cell;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;

use crate::names::shorten;
use crate::refusal::Asset;
use crate::{Error, Result};

/// Reads the files that an asset names.
pub(crate) struct Folder<'a> {
    asset: Asset<'a>,
    root: PathBuf,
    bytes_read: Cell<u64>,
}

/// Reads a file that the caller named, at most `limits.file_bytes` long.
pub(crate) fn read_named_file(asset: Asset<'_>) -> Result<Vec<u8>> {
    let io = |source| Error::Io { path: asset.path.to_owned(), source };
    read_plain_file(asset, "file", asset.path, asset.limits.file_bytes, io)
}

fn read_plain_file(
    asset: Asset<'_>,
    place: &str,
    path: &Path,
    allowed: u64,
    io: impl Fn(std::io::Error) -> Error,
) -> Result<Vec<u8>> {
    let found = std::fs::metadata(path).map_err(&io)?;
    if !found.is_file() {
        return Err(io(std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a plain file")));
    }
    asset.check_limit(place, "bytes", found.len(), allowed)?;
    let mut bytes = Vec::with_capacity(found.len() as usize);
    // The file may grow between the question and the reading: the reader itself is bounded too.
    std::fs::File::open(path).map_err(&io)?.take(allowed + 1).read_to_end(&mut bytes).map_err(&io)?;
    asset.check_limit(place, "bytes", bytes.len() as u64, allowed)?;
    Ok(bytes)
}

impl<'a> Folder<'a> {
    /// The folder of the asset's path.
    pub(crate) fn of(asset: Asset<'a>) -> Result<Self> {
        let parent = match asset.path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let root = parent.canonicalize().map_err(|source| Error::Io { path: parent.to_owned(), source })?;
        Ok(Self { asset, root, bytes_read: Cell::new(0) })
    }

    /// The bytes behind a glTF URI: a `data:` URI, or a percent-encoded path relative to the asset's folder.
    pub(crate) fn read_uri(&self, place: &str, uri: &str) -> Result<Vec<u8>> {
        if let Some(data) = strip_data_scheme(uri) {
            return self.decode_data_uri(place, data);
        }
        self.refuse_scheme(place, uri)?;
        let decoded = percent_encoding::percent_decode_str(uri)
            .decode_utf8()
            .map_err(|_| self.asset.format(place, format!("the URI `{}` is not UTF-8 after decoding", shorten(uri))))?;
        match self.read_relative(place, &decoded) {
            // Some exporters write a bare `%`: the name as it stands is the second guess.
            Err(Error::NamedFile { .. }) if decoded != uri && self.resolve(place, uri).is_ok_and(|p| p.is_file()) => {
                self.read_relative(place, uri)
            }
            other => other,
        }
    }

    /// The bytes of a file named by a path (OBJ and MTL do not percent-encode).
    pub(crate) fn read_path(&self, place: &str, name: &str) -> Result<Vec<u8>> {
        self.refuse_scheme(place, name)?;
        self.read_relative(place, name)
    }

    fn read_relative(&self, place: &str, name: &str) -> Result<Vec<u8>> {
        let path = self.resolve(place, name)?;
        let allowed = self.asset.limits.file_bytes.saturating_sub(self.bytes_read.get());
        let bytes = read_plain_file(self.asset, place, &path, allowed, |source| self.unread(place, name, source))?;
        self.bytes_read.set(self.bytes_read.get() + bytes.len() as u64);
        Ok(bytes)
    }

    /// The canonical path behind a glTF URI; `None` for data, and for what is not there or may not be read.
    pub(crate) fn locate_uri(&self, uri: &str) -> Option<PathBuf> {
        if strip_data_scheme(uri).is_some() {
            return None;
        }
        let decoded = percent_encoding::percent_decode_str(uri).decode_utf8().ok()?;
        self.locate_path(&decoded).or_else(|| self.locate_path(uri))
    }

    /// The canonical path of a file that the asset names; `None` where it is not there or may not be read.
    pub(crate) fn locate_path(&self, name: &str) -> Option<PathBuf> {
        self.refuse_scheme("", name).and_then(|()| self.resolve("", name)).ok()
    }

    fn unread(&self, place: &str, name: &str, source: std::io::Error) -> Error {
        Error::NamedFile { path: self.asset.path.to_owned(), place: place.to_owned(), name: shorten(name), source }
    }

    /// The canonical path of `name`, inside the folder.
    fn resolve(&self, place: &str, name: &str) -> Result<PathBuf> {
        let leaves = || {
            self.asset.format(
                place,
                format!("`{}` leaves the asset's folder; only files in it and below it are read", shorten(name)),
            )
        };
        if name.is_empty() || name.contains('\0') {
            return Err(self.asset.format(place, format!("`{}` is not a file name", shorten(name))));
        }
        // Backslashes are how Windows exporters write folders, on every system.
        let steps: Vec<&str> = name.split(['/', '\\']).collect();
        let drive = name.as_bytes().get(1) == Some(&b':');
        if steps[0].is_empty() || drive {
            return Err(leaves());
        }
        let mut depth = 0i64;
        let mut path = self.root.clone();
        for step in steps {
            match step {
                "" | "." => {}
                ".." => {
                    depth -= 1;
                    path.push("..");
                }
                name => {
                    depth += 1;
                    path.push(name);
                }
            }
            if depth < 0 {
                return Err(leaves());
            }
        }
        let canonical = path.canonicalize().map_err(|source| self.unread(place, name, source))?;
        // Symbolic links are resolved by now.
        if canonical.starts_with(&self.root) { Ok(canonical) } else { Err(leaves()) }
    }

    /// Refuses `https:`, `file:` and the like by name. One letter and a colon is a Windows drive, refused as a path.
    fn refuse_scheme(&self, place: &str, uri: &str) -> Result<()> {
        let Some((scheme, _)) = uri.split_once(':') else { return Ok(()) };
        let is_scheme = scheme.len() > 1
            && scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+.-".contains(c));
        if !is_scheme {
            return Ok(());
        }
        Err(self.asset.unsupported(
            place,
            format!("a `{scheme}:` URI (`{}`)", shorten(uri)),
            "put the file into the asset's folder and name it by a relative path",
        ))
    }

    fn decode_data_uri(&self, place: &str, data: &str) -> Result<Vec<u8>> {
        let Some((header, body)) = data.split_once(',') else {
            return Err(self.asset.format(place, "a data URI without a comma"));
        };
        if !header.to_ascii_lowercase().ends_with(";base64") {
            return Ok(percent_encoding::percent_decode_str(body).collect());
        }
        // Line breaks and percent signs do turn up in hand-written files; the common case has neither.
        let cleaned: Vec<u8>;
        let body = if body.bytes().any(|b| b == b'%' || b.is_ascii_whitespace()) {
            cleaned = percent_encoding::percent_decode_str(body).filter(|b| !b.is_ascii_whitespace()).collect();
            &cleaned[..]
        } else {
            body.as_bytes()
        };
        let lenient = base64::engine::GeneralPurpose::new(
            &base64::alphabet::STANDARD,
            base64::engine::GeneralPurposeConfig::new()
                .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent)
                .with_decode_allow_trailing_bits(true),
        );
        lenient.decode(body).map_err(|e| self.asset.format(place, format!("a data URI that is not base64: {e}")))
    }
}

fn strip_data_scheme(uri: &str) -> Option<&str> {
    let scheme = uri.get(..5)?;
    scheme.eq_ignore_ascii_case("data:").then(|| &uri[5..])
}
