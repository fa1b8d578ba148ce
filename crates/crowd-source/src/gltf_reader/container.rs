//! GLB container: JSON and binary chunk out of one file (glTF 2.0, chapter 4).

use crate::Result;
use crate::refusal::Asset;

const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BIN_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// The two parts of a glTF file.
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The GLB's own buffer.
    pub(super) bin: Option<&'a [u8]>,
}

/// Splits a `.glb`, or takes a `.gltf` as it is. Told apart by the first four bytes, not by the name.
pub(super) fn split_container<'a>(asset: Asset<'_>, bytes: &'a [u8]) -> Result<Container<'a>> {
    if bytes.is_empty() {
        return Err(asset.format("file", "empty, expected glTF"));
    }
    if !bytes.starts_with(MAGIC) {
        return Ok(Container { json: bytes, bin: None });
    }
    if bytes.len() < 12 {
        return Err(asset.format("GLB header", format!("{} bytes, expected 12", bytes.len())));
    }
    match word(bytes, 4) {
        2 => {}
        1 => return Err(asset.unsupported("GLB header", "GLB version 1", "convert the file to glTF 2.0")),
        other => return Err(asset.format("GLB header", format!("GLB version {other}, expected 2"))),
    }
    let length = word(bytes, 8) as usize;
    if length > bytes.len() {
        return Err(asset.format("GLB header", format!("says {length} bytes, the file has {}", bytes.len())));
    }
    let bytes = &bytes[..length];
    let mut json = None;
    let mut bin = None;
    let mut at = 12;
    while at < bytes.len() {
        if bytes.len() - at < 8 {
            return Err(asset.format("GLB", format!("{} stray bytes after the last chunk", bytes.len() - at)));
        }
        let size = word(bytes, at) as usize;
        let kind = word(bytes, at + 4);
        at += 8;
        if size > bytes.len() - at {
            return Err(asset.format("GLB chunk", format!("says {size} bytes, {} are left", bytes.len() - at)));
        }
        let body = &bytes[at..at + size];
        at += size;
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(body),
            BIN_CHUNK if bin.is_none() => bin = Some(body),
            // Unknown chunks are to be ignored.
            _ => {}
        }
        if json.is_none() {
            return Err(asset.format("GLB", "the first chunk is not JSON"));
        }
    }
    match json {
        Some(json) => Ok(Container { json, bin }),
        None => Err(asset.format("GLB", "no JSON chunk")),
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
