//! From [`PackContents`] to bytes and to a file.

use crate::check_contents::check_contents;
use crate::check_manifest::encode_manifest;
use crate::finishes::encode_finishes;
use crate::layout::{SECTIONS, align_up, join_sections, section_count, version_of};
use crate::{Error, ImageRecord, ImpostorRecord, PackContents, Result, WriteReport, whole_file};
use std::path::Path;

impl PackContents {
    /// Adds an encoded image, or finds the same one, and gives its index into `images`.
    ///
    /// `encoding`: 0 PNG, 1 JPEG, 2 WebP. Pads `image_bytes` so that the image starts at a multiple of 64.
    pub fn add_image(&mut self, encoded: &[u8], width: u32, height: u32, encoding: u32) -> u32 {
        add_to(&mut self.images, &mut self.image_bytes, encoded, [width, height, encoding])
    }

    /// The same for the images of finishes.
    pub fn add_finish_image(&mut self, encoded: &[u8], width: u32, height: u32, encoding: u32) -> u32 {
        add_to(&mut self.finish_images, &mut self.finish_bytes, encoded, [width, height, encoding])
    }

    /// Adds the impostors of the next character: `shape` says what the pictures hold, its places are filled in. `color`, `normal`: whole
    /// PNG files.
    pub fn add_impostors(&mut self, shape: ImpostorRecord, color: &[u8], normal: &[u8]) {
        let mut append = |encoded: &[u8]| {
            self.impostor_bytes.resize(align_up(self.impostor_bytes.len()), 0);
            let byte_offset = self.impostor_bytes.len() as u64;
            self.impostor_bytes.extend_from_slice(encoded);
            (byte_offset, encoded.len() as u32)
        };
        let (color_byte_offset, color_byte_count) = append(color);
        let (normal_byte_offset, normal_byte_count) = append(normal);
        self.impostors.push(ImpostorRecord {
            color_byte_offset,
            color_byte_count,
            normal_byte_offset,
            normal_byte_count,
            ..shape
        });
    }

    /// Everything that a reader of the pack relies on.
    ///
    /// # Errors
    /// The same as of [`crate::Pack::from_bytes`].
    pub fn check(&self) -> Result<()> {
        check_contents(self)
    }

    /// The file's bytes. The same contents give the same bytes.
    ///
    /// # Errors
    /// The same checks as [`crate::Pack::from_bytes`]: what could not be read back is not written.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        check_contents(self)?;
        join_sections(&self.sections(&encode_manifest(&self.manifest)?, &encode_finishes(&self.finishes)?))
    }

    /// Writes under a temporary name in the same folder and renames: the old file or the new one, never half.
    ///
    /// The bytes are on the disk before the rename. The file gets the permissions of any new file. Links are followed,
    /// devices and pipes written to directly, missing folders made ([`whole_file`]).
    ///
    /// # Errors
    /// What [`Self::to_bytes`] refuses, and [`Error::Io`] with the path; the old file is untouched then.
    pub fn write(&self, path: &Path) -> Result<WriteReport> {
        let bytes = self.to_bytes()?;
        whole_file::write(path, &bytes).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        let manifest_bytes = encode_manifest(&self.manifest)?;
        let finishes_bytes = encode_finishes(&self.finishes)?;
        let sections = self.sections(&manifest_bytes, &finishes_bytes);
        let written = &sections[..section_count(version_of(&sections))];
        let named = SECTIONS.iter().zip(written).map(|((name, _), bytes)| ((*name).to_owned(), bytes.len() as u64));
        Ok(WriteReport { pack_bytes: bytes.len() as u64, sections: named.collect() })
    }

    /// The sections' bytes in file order.
    fn sections<'a>(&'a self, manifest: &'a [u8], finishes: &'a [u8]) -> [&'a [u8]; SECTIONS.len()] {
        use bytemuck::cast_slice;
        [
            manifest,
            cast_slice(&self.characters),
            cast_slice(&self.vertices),
            cast_slice(&self.triangles),
            cast_slice(&self.collapse_map),
            cast_slice(&self.lods),
            cast_slice(&self.clips),
            cast_slice(&self.animation),
            cast_slice(&self.inverse_binds),
            cast_slice(&self.materials),
            cast_slice(&self.images),
            &self.image_bytes,
            cast_slice(&self.track_values),
            cast_slice(&self.level_sets),
            cast_slice(&self.levels),
            cast_slice(&self.indices_16),
            cast_slice(&self.indices_32),
            cast_slice(&self.refit_vertices),
            cast_slice(&self.impostors),
            &self.impostor_bytes,
            finishes,
            cast_slice(&self.finish_images),
            &self.finish_bytes,
        ]
    }
}

fn add_to(
    images: &mut Vec<ImageRecord>,
    bytes: &mut Vec<u8>,
    encoded: &[u8],
    [width, height, encoding]: [u32; 3],
) -> u32 {
    let same = |image: &ImageRecord| {
        let start = image.byte_offset as usize;
        image.encoding == encoding && bytes.get(start..start + image.byte_count as usize) == Some(encoded)
    };
    if let Some(index) = images.iter().position(same) {
        return index as u32;
    }
    bytes.resize(align_up(bytes.len()), 0);
    let byte_offset = bytes.len() as u64;
    bytes.extend_from_slice(encoded);
    let byte_count = encoded.len() as u64;
    images.push(ImageRecord { byte_offset, byte_count, width, height, encoding, reserved: 0 });
    images.len() as u32 - 1
}
