//! From a file's bytes to a checked [`Pack`].

use crate::check_contents::check_contents;
use crate::check_manifest::decode_manifest;
use crate::finishes::decode_finishes;
use crate::layout::{HEADER_BYTES, format_error, read_header, refuse_above, split_sections};
use crate::{Error, Pack, PackContents, Result, limits};
use std::fs::File;
use std::io::Read;
use std::path::Path;

impl Pack {
    /// Reads and checks a file.
    ///
    /// The header is read first: nothing is allocated for a file that is no pack, too long, or not as long as it says.
    ///
    /// # Errors
    /// [`Error::Io`] with the path, and what [`Pack::from_bytes`] refuses.
    pub fn open(path: &Path) -> Result<Self> {
        let io_error = |source| Error::Io { path: path.to_owned(), source };
        // Looked at before it is opened: a pipe that nobody writes to would hold us for ever.
        if !std::fs::metadata(path).map_err(io_error)?.is_file() {
            return Err(io_error(std::io::Error::new(std::io::ErrorKind::InvalidInput, "is no plain file")));
        }
        let mut file = File::open(path).map_err(io_error)?;
        let found_bytes = file.metadata().map_err(io_error)?.len();
        refuse_above("bytes of the pack", found_bytes, limits::PACK_BYTES)?;
        let mut bytes = Vec::new();
        file.by_ref().take(HEADER_BYTES as u64).read_to_end(&mut bytes).map_err(io_error)?;
        let header = read_header(&bytes)?;
        if header.file_bytes != found_bytes {
            let allowed = format!("{}, as the header says", header.file_bytes);
            return Err(format_error("file length", found_bytes, allowed));
        }
        bytes.resize((found_bytes as usize).max(HEADER_BYTES), 0);
        file.read_exact(&mut bytes[HEADER_BYTES..]).map_err(io_error)?;
        Self::from_bytes(&bytes)
    }

    /// Checks the bytes of a file.
    ///
    /// # Errors
    /// [`Error::Version`], [`Error::Checksum`], [`Error::Limit`], and [`Error::Format`] for whatever else is wrong: every
    /// byte is either under a checksum or has to be zero, and every index, count and range is looked at.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        refuse_above("bytes of the pack", bytes.len() as u64, limits::PACK_BYTES)?;
        let [
            manifest,
            characters,
            vertices,
            triangles,
            collapse_map,
            lods,
            clips,
            animation,
            inverse_binds,
            materials,
            images,
            image_bytes,
            track_values,
            level_sets,
            levels,
            indices_16,
            indices_32,
            refit_vertices,
            impostors,
            impostor_bytes,
            finishes,
            finish_images,
            finish_bytes,
        ] = split_sections(bytes)?;
        let contents = PackContents {
            manifest: decode_manifest(manifest)?,
            characters: to_records(characters),
            vertices: to_records(vertices),
            triangles: to_records(triangles),
            collapse_map: to_records(collapse_map),
            lods: to_records(lods),
            clips: to_records(clips),
            animation: to_records(animation),
            inverse_binds: to_records(inverse_binds),
            materials: to_records(materials),
            images: to_records(images),
            image_bytes: image_bytes.to_vec(),
            track_values: to_records(track_values),
            level_sets: to_records(level_sets),
            levels: to_records(levels),
            indices_16: to_records(indices_16),
            indices_32: to_records(indices_32),
            refit_vertices: to_records(refit_vertices),
            impostors: to_records(impostors),
            impostor_bytes: impostor_bytes.to_vec(),
            finishes: decode_finishes(finishes)?,
            finish_images: to_records(finish_images),
            finish_bytes: finish_bytes.to_vec(),
        };
        check_contents(&contents)?;
        Ok(Self { contents })
    }
}

/// Copies a section, whose length is a multiple of the record's, to where the record's alignment is right.
fn to_records<T: bytemuck::Pod>(section: &[u8]) -> Vec<T> {
    let mut records = vec![T::zeroed(); section.len() / size_of::<T>()];
    bytemuck::cast_slice_mut::<T, u8>(&mut records).copy_from_slice(section);
    records
}
