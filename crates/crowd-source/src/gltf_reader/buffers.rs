//! Buffers and buffer views as byte slices, loaded and decompressed when first asked for.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

use gltf::json::Root;

use super::decompress::{Compressed, decompress_view, find_compression};
use crate::Result;
use crate::folder::Folder;
use crate::refusal::Asset;

/// All bytes of a document.
pub(super) struct Buffers<'a> {
    asset: Asset<'a>,
    root: &'a Root,
    folder: &'a Folder<'a>,
    bin: Option<&'a [u8]>,
    loaded: Vec<OnceCell<Cow<'a, [u8]>>>,
    decoded: Vec<OnceCell<Vec<u8>>>,
    /// Bytes out of data URIs and compressed views so far: several small texts may not add up to more than one file.
    made_bytes: Cell<u64>,
}

/// A view's bytes and the distance between its elements.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(asset: Asset<'a>, root: &'a Root, folder: &'a Folder<'a>, bin: Option<&'a [u8]>) -> Self {
        Self {
            asset,
            root,
            folder,
            bin,
            loaded: (0..root.buffers.len()).map(|_| OnceCell::new()).collect(),
            decoded: (0..root.buffer_views.len()).map(|_| OnceCell::new()).collect(),
            made_bytes: Cell::new(0),
        }
    }

    /// The bytes of view `index`; `place` is who asks.
    pub(super) fn view(&self, place: &str, index: usize) -> Result<View<'_>> {
        let Some(view) = self.root.buffer_views.get(index) else {
            return Err(self
                .asset
                .format(place, format!("buffer view {index}, the file has {}", self.root.buffer_views.len())));
        };
        let here = format!("buffer view {index}");
        if let Some(compressed) = find_compression(self.asset, &here, view)? {
            let stride = Some(compressed.stride);
            if let Some(bytes) = self.decoded[index].get() {
                return Ok(View { bytes, stride });
            }
            let made = self.decode(&here, &compressed)?;
            return Ok(View { bytes: self.decoded[index].get_or_init(|| made), stride });
        }
        let offset = view.byte_offset.map_or(0, |o| o.0);
        let bytes = self.slice(&here, view.buffer.value(), offset, view.byte_length.0)?;
        Ok(View { bytes, stride: view.byte_stride.map(|s| s.0).filter(|s| *s != 0) })
    }

    fn decode(&self, here: &str, compressed: &Compressed) -> Result<Vec<u8>> {
        let source = self.slice(here, compressed.buffer, compressed.byte_offset, compressed.byte_length)?;
        self.count_made_bytes(here, compressed.count as u64 * compressed.stride as u64)?;
        decompress_view(self.asset, here, compressed, source)
    }

    fn count_made_bytes(&self, here: &str, bytes: u64) -> Result<()> {
        let sum = self.made_bytes.get().saturating_add(bytes);
        self.asset.check_limit(here, "bytes of decoded buffers", sum, self.asset.limits.file_bytes)?;
        self.made_bytes.set(sum);
        Ok(())
    }

    fn slice(&self, here: &str, buffer: usize, offset: u64, length: u64) -> Result<&[u8]> {
        let bytes = self.buffer(here, buffer)?;
        let end = offset.checked_add(length).filter(|end| *end <= bytes.len() as u64);
        match end {
            Some(end) => Ok(&bytes[offset as usize..end as usize]),
            None => Err(self
                .asset
                .format(here, format!("bytes {offset} to {offset} + {length}, buffer {buffer} has {}", bytes.len()))),
        }
    }

    fn buffer(&self, here: &str, index: usize) -> Result<&[u8]> {
        let Some(buffer) = self.root.buffers.get(index) else {
            return Err(self.asset.format(here, format!("buffer {index}, the file has {}", self.root.buffers.len())));
        };
        if let Some(bytes) = self.loaded[index].get() {
            return Ok(bytes);
        }
        let place = format!("buffer {index}");
        let bytes: Cow<'a, [u8]> = match (&buffer.uri, self.bin) {
            (Some(uri), _) => {
                let bytes = self.folder.read_uri(&place, uri)?;
                self.count_made_bytes(&place, bytes.len() as u64)?;
                Cow::Owned(bytes)
            }
            (None, Some(bin)) if index == 0 => Cow::Borrowed(bin),
            (None, _) => return Err(self.asset.format(place, "no `uri`, and no binary chunk to stand for it")),
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            return Err(self
                .asset
                .format(place, format!("says {} bytes, {} are there", buffer.byte_length.0, bytes.len())));
        }
        Ok(self.loaded[index].get_or_init(|| bytes))
    }
}
