//! Rows: a list of types, then the values.

use super::btree::cut;
use crate::Result;

/// Columns of one row that are looked at.
const MOST_COLUMNS: usize = 64;

/// One value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value<'a> {
    Null,
    Integer(i64),
    Real(f64),
    Text(&'a [u8]),
    Blob(&'a [u8]),
}

impl<'a> Value<'a> {
    /// Whole numbers in a column of reals are stored as such.
    pub(crate) fn as_f64(self) -> Option<f64> {
        match self {
            Self::Real(value) => Some(value),
            Self::Integer(value) => Some(value as f64),
            _ => None,
        }
    }

    pub(crate) fn as_i64(self) -> Option<i64> {
        match self {
            Self::Integer(value) => Some(value),
            _ => None,
        }
    }

    pub(crate) fn as_text(self) -> Option<&'a str> {
        match self {
            Self::Text(bytes) => std::str::from_utf8(bytes).ok(),
            _ => None,
        }
    }
}

impl std::fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Null => write!(f, "NULL"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value}"),
            Self::Text(bytes) => {
                let text: String = String::from_utf8_lossy(bytes).chars().take(60).collect();
                write!(f, "`{}`", text.escape_debug())
            }
            Self::Blob(bytes) => write!(f, "{} bytes", bytes.len()),
        }
    }
}

/// The values of a row.
pub(crate) struct Record<'a> {
    values: Vec<Value<'a>>,
}

impl<'a> Record<'a> {
    /// Reads the record of a cell on `page`.
    pub(super) fn new(payload: &'a [u8], page: u32) -> Result<Self> {
        let (head, mut at) = varint(payload).ok_or_else(|| cut(page))?;
        let head = usize::try_from(head).ok().filter(|&h| h <= payload.len()).ok_or_else(|| cut(page))?;
        let mut values = Vec::new();
        let mut content = &payload[head..];
        while at < head && values.len() < MOST_COLUMNS {
            let (kind, read) = varint(&payload[at..head]).ok_or_else(|| cut(page))?;
            at += read;
            let length =
                usize::try_from(bytes_of(kind)).ok().filter(|&l| l <= content.len()).ok_or_else(|| cut(page))?;
            let (bytes, rest) = content.split_at(length);
            content = rest;
            values.push(value(kind, bytes));
        }
        Ok(Self { values })
    }

    /// Value of a column; of one that was added after the row was written, NULL.
    pub(crate) fn value(&self, column: usize) -> Value<'a> {
        self.values.get(column).copied().unwrap_or(Value::Null)
    }
}

fn bytes_of(kind: u64) -> u64 {
    match kind {
        0 | 8 | 9 => 0,
        1..=4 => kind,
        5 => 6,
        6 | 7 => 8,
        // 10 and 11 are reserved: of no length that a row has.
        10 | 11 => u64::MAX,
        _ => (kind - 12) / 2,
    }
}

fn value(kind: u64, bytes: &[u8]) -> Value<'_> {
    let integer = || {
        let sign = if bytes.first().is_some_and(|b| b & 0x80 != 0) { -1 } else { 0 };
        bytes.iter().fold(sign, |value: i64, &byte| (value << 8) | i64::from(byte))
    };
    match kind {
        0 => Value::Null,
        8 => Value::Integer(0),
        9 => Value::Integer(1),
        7 => Value::Real(f64::from_bits(integer() as u64)),
        1..=6 => Value::Integer(integer()),
        _ if kind % 2 == 1 => Value::Text(bytes),
        _ => Value::Blob(bytes),
    }
}

/// Big-endian, seven bits a byte, all eight of the ninth: the value and its bytes.
pub(super) fn varint(bytes: &[u8]) -> Option<(u64, usize)> {
    let mut value = 0u64;
    for (index, &byte) in bytes.iter().take(9).enumerate() {
        if index == 8 {
            return Some(((value << 8) | u64::from(byte), 9));
        }
        value = (value << 7) | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return Some((value, index + 1));
        }
    }
    None
}
