//! Images of a document, once each, still encoded.

use std::collections::BTreeMap;

use gltf::json::Root;

use super::buffers::Buffers;
use super::document::describe;
use crate::folder::Folder;
use crate::image_header::read_image;
use crate::names::{name_or, shorten};
use crate::refusal::Asset;
use crate::{RawImage, Result};

/// The images that materials use, in the order of their first use.
pub(super) struct ImageTable<'a, 'b> {
    asset: Asset<'a>,
    root: &'a Root,
    buffers: &'a Buffers<'b>,
    folder: &'a Folder<'a>,
    known: BTreeMap<usize, u32>,
    pub(super) images: Vec<RawImage>,
}

impl<'a, 'b> ImageTable<'a, 'b> {
    pub(super) fn new(asset: Asset<'a>, root: &'a Root, buffers: &'a Buffers<'b>, folder: &'a Folder<'a>) -> Self {
        Self { asset, root, buffers, folder, known: BTreeMap::new(), images: Vec::new() }
    }

    /// The character's index of document image `source`.
    pub(super) fn index(&mut self, place: &str, source: usize) -> Result<u32> {
        if let Some(index) = self.known.get(&source) {
            return Ok(*index);
        }
        let Some(image) = self.root.images.get(source) else {
            let problem = format!("image {source}, the file has {}", self.root.images.len());
            return Err(self.asset.format(place, problem));
        };
        let here = describe("image", source, image.name.as_ref());
        let (bytes, file_name) = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                let file = uri.rsplit('/').next().filter(|_| !uri.starts_with("data:"));
                let decoded = file.map(|file| percent_encoding::percent_decode_str(file).decode_utf8_lossy());
                (self.folder.read_uri(&here, uri)?, decoded.map(|file| shorten(&file)))
            }
            (None, Some(view)) => (self.buffers.view(&here, view.value())?.bytes.to_vec(), None),
            (None, None) => return Err(self.asset.format(here, "neither `uri` nor `bufferView`")),
        };
        // Several images may point at the same bytes; what they come to is bounded too.
        let sum = self.images.iter().map(|i| i.bytes.len() as u64).sum::<u64>() + bytes.len() as u64;
        self.asset.check_limit(&here, "bytes of images", sum, self.asset.limits.file_bytes)?;
        let name = name_or(image.name.as_deref(), || file_name.unwrap_or_default());
        let named = !name.is_empty();
        let name = if named { name } else { format!("image {source}") };
        let index = self.images.len() as u32;
        self.images.push(RawImage { named, ..read_image(self.asset, &here, name, bytes)? });
        self.known.insert(source, index);
        Ok(index)
    }
}
