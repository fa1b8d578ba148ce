//! Pages and the b-trees of tables.

use super::record::{Record, varint};
use crate::{Error, Result};

/// First sixteen bytes of every database.
pub(crate) const MAGIC: &[u8; 16] = b"SQLite format 3\0";
/// A table of 2^32 pages with two children a page is not deeper; SQLite's own limit is 20, too.
const DEEPEST: usize = 20;
/// Bytes of one row: a walkable area of a hundred thousand points has fewer.
const LARGEST_ROW: usize = 16 << 20;
const PLACE: &str = "database";

/// A database: its bytes, and what its header says of them.
pub(crate) struct Database<'a> {
    bytes: &'a [u8],
    page_bytes: usize,
    /// Bytes of a page that hold content; the rest is reserved for extensions.
    usable: usize,
}

impl<'a> Database<'a> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`Error::Content`] when it is no database, is encoded as UTF-16, or is shorter than one page.
    pub(crate) fn new(bytes: &'a [u8]) -> Result<Self> {
        if !bytes.starts_with(MAGIC) || bytes.len() < 100 {
            return Err(Error::content(
                PLACE,
                format!("{} bytes without SQLite's heading", bytes.len()),
                "an SQLite 3 database",
            ));
        }
        let page_bytes = match u16::from_be_bytes([bytes[16], bytes[17]]) {
            1 => 65_536,
            other => usize::from(other),
        };
        if !page_bytes.is_power_of_two() || page_bytes < 512 {
            return Err(Error::content(
                PLACE,
                format!("pages of {page_bytes} bytes"),
                "a power of two from 512 to 65536",
            ));
        }
        let reserved = usize::from(bytes[20]);
        let usable = page_bytes - reserved.min(page_bytes);
        if usable < 480 {
            return Err(Error::content(
                PLACE,
                format!("{reserved} reserved bytes a page"),
                "at least 480 bytes in use",
            ));
        }
        let encoding = u32::from_be_bytes([bytes[56], bytes[57], bytes[58], bytes[59]]);
        if encoding > 1 {
            return Err(Error::content(PLACE, format!("text encoding {encoding}"), "1, UTF-8"));
        }
        Ok(Self { bytes, page_bytes, usable })
    }

    /// Calls `row` with each row of the table whose b-tree begins on page `root` (from 1), in order of row ids.
    pub(crate) fn scan(&self, root: u32, row: &mut dyn FnMut(&Record<'_>) -> Result<()>) -> Result<()> {
        let page_count = self.bytes.len() / self.page_bytes;
        let mut seen = vec![false; page_count + 1];
        // Pages still to visit, the next on top, each with its depth.
        let mut waiting = vec![(root, 0)];
        let mut joined = Vec::new();
        // All rows together are no longer than the file, or cells share their bytes and there is no end of them.
        let mut row_bytes = 0;
        while let Some((number, depth)) = waiting.pop() {
            let page = self.page(number)?;
            if std::mem::replace(&mut seen[number as usize], true) || depth > DEEPEST {
                return Err(damaged(number, "a page that is part of itself", "a tree"));
            }
            let start = if number == 1 { 100 } else { 0 };
            let kind = page[start];
            let cell_count = usize::from(be16(page, start + 3, number)?);
            let pointers = start + if kind == INTERIOR { 12 } else { 8 };
            match kind {
                LEAF => {
                    for cell in 0..cell_count {
                        let at = usize::from(be16(page, pointers + 2 * cell, number)?);
                        let payload = self.payload(page, at, number, &mut joined)?;
                        row_bytes += payload.len();
                        if row_bytes > self.bytes.len() {
                            return Err(damaged(number, "rows that share their bytes", "rows apart"));
                        }
                        row(&Record::new(payload, number)?)?;
                    }
                }
                INTERIOR => {
                    waiting.push((be32(page, start + 8, number)?, depth + 1));
                    for cell in (0..cell_count).rev() {
                        let at = usize::from(be16(page, pointers + 2 * cell, number)?);
                        waiting.push((be32(page, at, number)?, depth + 1));
                    }
                }
                other => return Err(damaged(number, format!("a page of kind {other}"), "5 or 13, a table")),
            }
        }
        Ok(())
    }

    fn page(&self, number: u32) -> Result<&'a [u8]> {
        let outside = || damaged(number, format!("a link to page {number}"), "a page of the file");
        let start =
            (number as usize).checked_sub(1).and_then(|n| n.checked_mul(self.page_bytes)).ok_or_else(outside)?;
        self.bytes.get(start..start.saturating_add(self.page_bytes)).ok_or_else(outside)
    }

    /// The bytes of the record in the cell at `at`: those on the page, or `joined` with those on overflow pages.
    fn payload<'b>(&self, page: &'b [u8], at: usize, number: u32, joined: &'b mut Vec<u8>) -> Result<&'b [u8]>
    where
        'a: 'b,
    {
        let cell = page.get(at..).unwrap_or(&[]);
        let (length, first) = varint(cell).ok_or_else(|| cut(number))?;
        let (_, second) = varint(&cell[first..]).ok_or_else(|| cut(number))?;
        let content = &cell[first + second..];
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        if length > LARGEST_ROW || length > self.bytes.len() {
            let allowed = LARGEST_ROW.min(self.bytes.len());
            return Err(damaged(number, format!("a row of {length} bytes"), format!("at most {allowed}")));
        }
        // The share that stays on the page, as the format's section 1.6 has it.
        let most = self.usable - 35;
        if length <= most {
            return content.get(..length).ok_or_else(|| cut(number));
        }
        let least = (self.usable - 12) * 32 / 255 - 23;
        let even = least + (length - least) % (self.usable - 4);
        let local = if even <= most { even } else { least };
        joined.clear();
        joined.extend_from_slice(content.get(..local).ok_or_else(|| cut(number))?);
        let mut next = be32(content, local, number)?;
        while joined.len() < length {
            let page = self.page(next)?;
            let taken = (length - joined.len()).min(self.usable - 4);
            joined.extend_from_slice(&page[4..4 + taken]);
            next = be32(page, 0, next)?;
        }
        Ok(joined)
    }
}

const INTERIOR: u8 = 5;
const LEAF: u8 = 13;

/// A refusal that names the page.
pub(super) fn damaged(page: u32, found: impl std::fmt::Display, expected: impl std::fmt::Display) -> Error {
    Error::content(format!("{PLACE}, page {page}"), found, expected)
        .with_remedy("the file is damaged or was cut short; let the simulator write it again")
}

pub(super) fn cut(page: u32) -> Error {
    damaged(page, "a cell that leaves its page", "a whole cell")
}

fn be16(bytes: &[u8], at: usize, page: u32) -> Result<u16> {
    match bytes.get(at..at.saturating_add(2)) {
        Some(&[a, b]) => Ok(u16::from_be_bytes([a, b])),
        _ => Err(cut(page)),
    }
}

fn be32(bytes: &[u8], at: usize, page: u32) -> Result<u32> {
    match bytes.get(at..at.saturating_add(4)) {
        Some(&[a, b, c, d]) => Ok(u32::from_be_bytes([a, b, c, d])),
        _ => Err(cut(page)),
    }
}
