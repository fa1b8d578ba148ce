//! Where things lie in the file: header, section table, alignment. `docs/FORMAT.md` has the same tables in prose.
//!
//! Knows bytes only; what the sections mean is checked in `check_contents`.

use crate::{Error, FORMAT_VERSION, IMPOSTORS_VERSION, MAGIC, PLAIN_VERSION, Result, limits};

#[cfg(target_endian = "big")]
compile_error!(
    "crowd-pack casts little-endian sections to records as they lie; a big-endian host needs a swapping reader"
);

/// Sections, the table and the file's end lie at multiples of this: a cache line, and what GPU copies ask for.
pub const ALIGNMENT: usize = 64;
/// Bytes of the header.
pub const HEADER_BYTES: usize = 64;
/// Bytes of one entry of the section table.
pub const ENTRY_BYTES: usize = 40;
/// Header bytes that the header's own checksum covers.
const HEADER_CHECKED_BYTES: usize = 60;
/// Bytes of a section's name, zero-padded.
const NAME_BYTES: usize = 16;

/// Names and element sizes of the sections of version 5, in file order. All are always there, empty or not.
pub const SECTIONS: [(&str, u32); 23] = [
    ("manifest", 1),
    ("characters", 112),
    ("vertices", 48),
    ("triangles", 12),
    ("collapse_map", 4),
    ("lods", 8),
    ("clips", 48),
    ("animation", 16),
    ("inverse_binds", 16),
    ("materials", 32),
    ("images", 32),
    ("image_bytes", 1),
    ("track_values", 4),
    ("level_sets", 16),
    ("levels", 24),
    ("indices_16", 2),
    ("indices_32", 4),
    ("refit_vertices", 48),
    ("impostors", 48),
    ("impostor_bytes", 1),
    ("finishes", 1),
    ("finish_images", 32),
    ("finish_bytes", 1),
];
/// Sections of version 3: the first ones.
const PLAIN_SECTIONS: usize = 18;
/// Sections of version 4.
const IMPOSTORS_SECTIONS: usize = 20;

/// The sections of a version that is read.
fn sections_of(version: u32) -> Option<&'static [(&'static str, u32)]> {
    match version {
        PLAIN_VERSION => Some(&SECTIONS[..PLAIN_SECTIONS]),
        IMPOSTORS_VERSION => Some(&SECTIONS[..IMPOSTORS_SECTIONS]),
        FORMAT_VERSION => Some(&SECTIONS),
        _ => None,
    }
}

/// The version that sections in the order of [`SECTIONS`] are written as: the oldest that has what is in them.
pub(crate) fn version_of(sections: &[&[u8]; SECTIONS.len()]) -> u32 {
    let is_empty_from = |first: usize| sections[first..].iter().all(|section| section.is_empty());
    match (is_empty_from(PLAIN_SECTIONS), is_empty_from(IMPOSTORS_SECTIONS)) {
        (true, _) => PLAIN_VERSION,
        (_, true) => IMPOSTORS_VERSION,
        _ => FORMAT_VERSION,
    }
}

/// How many sections that version has.
pub(crate) fn section_count(version: u32) -> usize {
    sections_of(version).map_or(0, <[_]>::len)
}

/// The next multiple of [`ALIGNMENT`].
pub fn align_up(bytes: usize) -> usize {
    bytes.next_multiple_of(ALIGNMENT)
}

/// Lays the sections, given in the order of [`SECTIONS`], out behind a header and a table.
pub(crate) fn join_sections(sections: &[&[u8]; SECTIONS.len()]) -> Result<Vec<u8>> {
    let version = version_of(sections);
    let count = section_count(version);
    let sections = &sections[..count];
    let first_byte_offset = align_up(HEADER_BYTES + count * ENTRY_BYTES);
    let file_bytes = sections.iter().fold(first_byte_offset, |end, section| align_up(end + section.len()));
    refuse_above("bytes of the pack", file_bytes as u64, limits::PACK_BYTES)?;

    let mut table = Vec::with_capacity(count * ENTRY_BYTES);
    let mut byte_offset = first_byte_offset;
    for ((name, element_bytes), section) in SECTIONS.iter().zip(sections) {
        let mut padded_name = [0_u8; NAME_BYTES];
        padded_name[..name.len()].copy_from_slice(name.as_bytes());
        table.extend_from_slice(&padded_name);
        table.extend_from_slice(&(byte_offset as u64).to_le_bytes());
        table.extend_from_slice(&(section.len() as u64).to_le_bytes());
        table.extend_from_slice(&element_bytes.to_le_bytes());
        table.extend_from_slice(&crc32fast::hash(section).to_le_bytes());
        byte_offset = align_up(byte_offset + section.len());
    }

    let mut file = Vec::with_capacity(file_bytes);
    file.extend_from_slice(&MAGIC);
    file.extend_from_slice(&version.to_le_bytes());
    file.extend_from_slice(&(count as u32).to_le_bytes());
    file.extend_from_slice(&(file_bytes as u64).to_le_bytes());
    file.extend_from_slice(&(HEADER_BYTES as u64).to_le_bytes());
    file.extend_from_slice(&crc32fast::hash(&table).to_le_bytes());
    file.resize(HEADER_CHECKED_BYTES, 0);
    file.extend_from_slice(&crc32fast::hash(&file).to_le_bytes());
    file.extend_from_slice(&table);
    for section in sections {
        file.resize(align_up(file.len()), 0);
        file.extend_from_slice(section);
    }
    file.resize(file_bytes, 0);
    Ok(file)
}

/// What the header says, checked against its checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Header {
    /// Bytes of the whole file.
    pub(crate) file_bytes: u64,
    /// Checksum of the section table.
    table_crc32: u32,
    /// Names and element sizes of the version's sections.
    sections: &'static [(&'static str, u32)],
}

/// Reads the first [`HEADER_BYTES`] of a file. Magic, then version, then checksum: an unknown version is told as such.
pub(crate) fn read_header(bytes: &[u8]) -> Result<Header> {
    if bytes.len() < HEADER_BYTES {
        return Err(format_error("header", format!("{} bytes", bytes.len()), format!("at least {HEADER_BYTES}")));
    }
    if bytes[..8] != MAGIC {
        return Err(format_error("header: magic", bytes[..8].escape_ascii(), MAGIC.escape_ascii()));
    }
    let version = u32_at(bytes, 8);
    let Some(sections) = sections_of(version) else {
        return Err(Error::Version { found: version, supported: FORMAT_VERSION });
    };
    check_crc32("header", &bytes[..HEADER_CHECKED_BYTES], u32_at(bytes, HEADER_CHECKED_BYTES))?;
    if u32_at(bytes, 12) as usize != sections.len() {
        return Err(format_error("header: section count", u32_at(bytes, 12), sections.len()));
    }
    if u64_at(bytes, 24) != HEADER_BYTES as u64 {
        return Err(format_error("header: table byte offset", u64_at(bytes, 24), HEADER_BYTES));
    }
    if bytes[36..HEADER_CHECKED_BYTES].iter().any(|&b| b != 0) {
        return Err(format_error("header: bytes 36 to 59", "other bytes", "zeros"));
    }
    let file_bytes = u64_at(bytes, 16);
    refuse_above("bytes of the pack", file_bytes, limits::PACK_BYTES)?;
    Ok(Header { file_bytes, table_crc32: u32_at(bytes, 32), sections })
}

/// The sections of a file in the order of [`SECTIONS`], once every byte of it is accounted for; those that its version lacks are empty.
pub(crate) fn split_sections(bytes: &[u8]) -> Result<[&[u8]; SECTIONS.len()]> {
    let header = read_header(bytes)?;
    if header.file_bytes != bytes.len() as u64 {
        return Err(format_error("file length", bytes.len(), format!("{}, as the header says", header.file_bytes)));
    }
    let table_end = HEADER_BYTES + header.sections.len() * ENTRY_BYTES;
    let Some(table) = bytes.get(HEADER_BYTES..table_end) else {
        return Err(format_error("file length", bytes.len(), format!("at least {table_end}")));
    };
    check_crc32("section table", table, header.table_crc32)?;

    let mut sections: [&[u8]; SECTIONS.len()] = [&[]; SECTIONS.len()];
    let mut end = table_end;
    for (index, (name, element_bytes)) in header.sections.iter().copied().enumerate() {
        let entry = &table[index * ENTRY_BYTES..(index + 1) * ENTRY_BYTES];
        let start = align_up(end);
        check_zeros(&format!("padding before section {name}"), bytes.get(end..start))?;
        let byte_count = check_entry(entry, name, element_bytes, start)?;
        let Some(section) = usize::try_from(byte_count).ok().and_then(|count| bytes[start..].get(..count)) else {
            let left = bytes.len() - start;
            return Err(format_error(format!("section {name}: bytes"), byte_count, format!("at most {left}")));
        };
        check_crc32(name, section, u32_at(entry, 36))?;
        sections[index] = section;
        end = start + section.len();
    }
    check_zeros("padding at the end", bytes.get(end..align_up(end)))?;
    if bytes.len() != align_up(end) {
        return Err(format_error("file length", bytes.len(), align_up(end)));
    }
    Ok(sections)
}

/// Checks a table entry against what must stand there; gives the section's byte count.
fn check_entry(entry: &[u8], name: &str, element_bytes: u32, start: usize) -> Result<u64> {
    let mut padded_name = [0_u8; NAME_BYTES];
    padded_name[..name.len()].copy_from_slice(name.as_bytes());
    if entry[..NAME_BYTES] != padded_name {
        return Err(format_error("section table: name", entry[..NAME_BYTES].escape_ascii(), name));
    }
    let (byte_offset, byte_count) = (u64_at(entry, 16), u64_at(entry, 24));
    if byte_offset != start as u64 {
        return Err(format_error(format!("section {name}: byte offset"), byte_offset, start));
    }
    if u32_at(entry, 32) != element_bytes {
        return Err(format_error(format!("section {name}: element bytes"), u32_at(entry, 32), element_bytes));
    }
    if byte_count % u64::from(element_bytes) != 0 {
        let allowed = format!("a multiple of {element_bytes}");
        return Err(format_error(format!("section {name}: bytes"), byte_count, allowed));
    }
    Ok(byte_count)
}

fn check_zeros(place: &str, padding: Option<&[u8]>) -> Result<()> {
    match padding {
        None => Err(format_error(place, "the end of the file", "zeros")),
        Some(padding) => match padding.iter().find(|&&b| b != 0) {
            Some(byte) => Err(format_error(place, format!("byte {byte:#04x}"), "zeros")),
            None => Ok(()),
        },
    }
}

fn check_crc32(section: &str, bytes: &[u8], expected: u32) -> Result<()> {
    let found = crc32fast::hash(bytes);
    if found == expected { Ok(()) } else { Err(Error::Checksum { section: section.to_owned(), found, expected }) }
}

/// [`Error::Limit`] when `found` is above `allowed`.
pub(crate) fn refuse_above(what: &str, found: u64, allowed: u64) -> Result<()> {
    if found <= allowed { Ok(()) } else { Err(Error::Limit { what: what.to_owned(), found, allowed }) }
}

/// [`Error::Format`] from whatever can be printed.
pub(crate) fn format_error(place: impl ToString, found: impl ToString, allowed: impl ToString) -> Error {
    Error::Format { place: place.to_string(), found: found.to_string(), allowed: allowed.to_string() }
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes were sliced"))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes were sliced"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::size_of;

    #[test]
    fn element_sizes_are_the_records_sizes() {
        let sizes = [
            1,
            size_of::<crate::CharacterRecord>(),
            size_of::<crate::VertexRecord>(),
            size_of::<[u32; 3]>(),
            size_of::<u32>(),
            size_of::<crate::LodRecord>(),
            size_of::<crate::ClipRecord>(),
            size_of::<[f32; 4]>(),
            size_of::<[f32; 4]>(),
            size_of::<crate::MaterialRecord>(),
            size_of::<crate::ImageRecord>(),
            1,
            size_of::<f32>(),
            size_of::<crate::LevelSetRecord>(),
            size_of::<crate::LevelRecord>(),
            size_of::<u16>(),
            size_of::<u32>(),
            size_of::<crate::VertexRecord>(),
            size_of::<crate::ImpostorRecord>(),
            1,
            1,
            size_of::<crate::ImageRecord>(),
            1,
        ];
        assert_eq!(SECTIONS.map(|(_, bytes)| bytes as usize), sizes);
        assert!(SECTIONS.iter().all(|(name, _)| name.len() <= NAME_BYTES));
    }

    #[test]
    fn sections_come_back_and_lie_aligned() {
        let mut sections: [&[u8]; SECTIONS.len()] = [&[]; SECTIONS.len()];
        sections[0] = b"words";
        sections[11] = b"picture";
        sections[12] = &[1, 2, 3, 4];
        let file = join_sections(&sections).unwrap();
        assert_eq!(file.len() % ALIGNMENT, 0);
        assert_eq!(split_sections(&file).unwrap(), sections);
    }

    #[test]
    fn a_pack_is_written_as_the_oldest_version_that_has_its_sections() {
        let mut sections: [&[u8]; SECTIONS.len()] = [&[]; SECTIONS.len()];
        let plain = join_sections(&sections).unwrap();
        assert_eq!((u32_at(&plain, 8), u32_at(&plain, 12)), (PLAIN_VERSION, 18));
        sections[19] = b"picture";
        let pictured = join_sections(&sections).unwrap();
        assert_eq!((u32_at(&pictured, 8), u32_at(&pictured, 12)), (IMPOSTORS_VERSION, 20));
        assert_eq!(split_sections(&pictured).unwrap(), sections);
        for pictures in [b"picture".as_slice(), b""] {
            (sections[19], sections[20]) = (pictures, b"words");
            let newest = join_sections(&sections).unwrap();
            assert_eq!((u32_at(&newest, 8), u32_at(&newest, 12)), (FORMAT_VERSION, 23));
            assert_eq!(split_sections(&newest).unwrap(), sections);
        }
    }

    #[test]
    fn an_unknown_version_is_told_as_such() {
        let mut file = join_sections(&[&[]; SECTIONS.len()]).unwrap();
        file[8] = 9;
        assert!(matches!(split_sections(&file), Err(Error::Version { found: 9, supported: FORMAT_VERSION })));
    }

    #[test]
    fn another_file_is_told_by_its_magic() {
        let error = read_header(&[b'P'; 64]).unwrap_err().to_string();
        assert_eq!(error, "pack: header: magic: found PPPPPPPP, allowed CROWDPK\\x00");
    }
}
