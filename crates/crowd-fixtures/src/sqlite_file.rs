//! Writes a small SQLite 3 database: tables without indices, leaf pages under at most one interior page.

const PAGE_BYTES: usize = 1024;
const HEADER_BYTES: usize = 100;
/// What stays of a longer row on its page, for pages of 1024 bytes (section 1.6 of the format).
const MOST_LOCAL: usize = PAGE_BYTES - 35;
const LEAST_LOCAL: usize = (PAGE_BYTES - 12) * 32 / 255 - 23;

/// A value of a row.
#[derive(Clone, Debug)]
pub enum Value {
    /// Whole number.
    Integer(i64),
    /// Number.
    Real(f64),
    /// Text.
    Text(String),
}

/// A table with its rows.
#[derive(Clone, Debug)]
pub struct Table {
    /// Name.
    pub name: &'static str,
    /// Between the brackets of `CREATE TABLE name(...)`.
    pub columns: &'static str,
    /// Values in the order of the columns.
    pub rows: Vec<Vec<Value>>,
}

/// The bytes of the database.
///
/// # Panics
/// When a table needs two levels of interior pages, or the schema more than its page.
pub fn write_database(tables: &[Table]) -> Vec<u8> {
    // Page 1 is the schema's; it is filled last, when the roots are known.
    let mut pages: Vec<Vec<u8>> = vec![Vec::new()];
    let mut schema = Vec::new();
    for table in tables {
        let root = write_table(&mut pages, &table.rows);
        let sql = format!("CREATE TABLE {}({})", table.name, table.columns);
        let text = |s: &str| Value::Text(s.to_owned());
        schema.push(vec![text("table"), text(table.name), text(table.name), Value::Integer(root as i64), text(&sql)]);
    }
    let cells: Vec<Vec<u8>> = schema.iter().zip(1..).map(|(row, id)| leaf_cell(&mut pages, id, row)).collect();
    pages[0] = page(13, &cells, None, HEADER_BYTES);
    let header = header(pages.len() as u32);
    pages[0][..HEADER_BYTES].copy_from_slice(&header);
    pages.concat()
}

fn header(page_count: u32) -> [u8; HEADER_BYTES] {
    let mut header = [0; HEADER_BYTES];
    header[..16].copy_from_slice(b"SQLite format 3\0");
    header[16..18].copy_from_slice(&(PAGE_BYTES as u16).to_be_bytes());
    // Journal of the older kind, for reading and writing; no reserved bytes; shares of the payload that never change.
    header[18..24].copy_from_slice(&[1, 1, 0, 64, 32, 32]);
    let mut word = |at: usize, value: u32| header[at..at + 4].copy_from_slice(&value.to_be_bytes());
    // Change counter, pages, schema's cookie and format, UTF-8, for which change the page count holds, version.
    for (at, value) in [(24, 1), (28, page_count), (40, 1), (44, 4), (56, 1), (92, 1), (96, 3_040_001)] {
        word(at, value);
    }
    header
}

/// Appends the table's pages; the number of its root.
fn write_table(pages: &mut Vec<Vec<u8>>, rows: &[Vec<Value>]) -> usize {
    let mut leaves: Vec<(usize, u64)> = Vec::new();
    let mut waiting: Vec<Vec<u8>> = Vec::new();
    let mut room = PAGE_BYTES - 8;
    let mut flush = |pages: &mut Vec<Vec<u8>>, waiting: &mut Vec<Vec<u8>>, last_row: u64| {
        pages.push(page(13, waiting, None, 0));
        leaves.push((pages.len(), last_row));
        waiting.clear();
    };
    for (row, id) in rows.iter().zip(1_u64..) {
        let cell = leaf_cell(pages, id, row);
        if cell.len() + 2 > room {
            flush(pages, &mut waiting, id - 1);
            room = PAGE_BYTES - 8;
        }
        room -= cell.len() + 2;
        waiting.push(cell);
    }
    flush(pages, &mut waiting, rows.len() as u64);
    let ((last, _), others) = leaves.split_last().expect("one leaf at least");
    if others.is_empty() {
        return *last;
    }
    let cell = |&(number, row): &(usize, u64)| [&(number as u32).to_be_bytes()[..], &varint(row)].concat();
    let cells: Vec<Vec<u8>> = others.iter().map(cell).collect();
    pages.push(page(5, &cells, Some(*last as u32), 0));
    pages.len()
}

fn page(kind: u8, cells: &[Vec<u8>], right: Option<u32>, start: usize) -> Vec<u8> {
    let mut bytes = vec![0; PAGE_BYTES];
    let mut end = PAGE_BYTES;
    let mut pointers = start + if right.is_some() { 12 } else { 8 };
    for cell in cells {
        end -= cell.len();
        assert!(end >= pointers + 2, "the cells of a page fit it");
        bytes[end..end + cell.len()].copy_from_slice(cell);
        bytes[pointers..pointers + 2].copy_from_slice(&(end as u16).to_be_bytes());
        pointers += 2;
    }
    bytes[start] = kind;
    bytes[start + 3..start + 5].copy_from_slice(&(cells.len() as u16).to_be_bytes());
    bytes[start + 5..start + 7].copy_from_slice(&(end as u16).to_be_bytes());
    if let Some(right) = right {
        bytes[start + 8..start + 12].copy_from_slice(&right.to_be_bytes());
    }
    bytes
}

/// A row's cell; what does not fit it goes to pages of its own.
fn leaf_cell(pages: &mut Vec<Vec<u8>>, id: u64, row: &[Value]) -> Vec<u8> {
    let payload = record(row);
    let mut cell = [varint(payload.len() as u64), varint(id)].concat();
    if payload.len() <= MOST_LOCAL {
        cell.extend(payload);
        return cell;
    }
    let even = LEAST_LOCAL + (payload.len() - LEAST_LOCAL) % (PAGE_BYTES - 4);
    let local = if even <= MOST_LOCAL { even } else { LEAST_LOCAL };
    cell.extend(&payload[..local]);
    cell.extend((pages.len() as u32 + 1).to_be_bytes());
    let chunks: Vec<&[u8]> = payload[local..].chunks(PAGE_BYTES - 4).collect();
    for (index, chunk) in chunks.iter().enumerate() {
        let next = if index + 1 < chunks.len() { pages.len() as u32 + 2 } else { 0 };
        let mut bytes = [&next.to_be_bytes()[..], chunk].concat();
        bytes.resize(PAGE_BYTES, 0);
        pages.push(bytes);
    }
    cell
}

fn record(row: &[Value]) -> Vec<u8> {
    let (mut types, mut values) = (Vec::new(), Vec::new());
    for value in row {
        match value {
            Value::Integer(0) => types.extend(varint(8)),
            Value::Integer(1) => types.extend(varint(9)),
            Value::Integer(number) if i8::try_from(*number).is_ok() => {
                types.extend(varint(1));
                values.push(*number as u8);
            }
            Value::Integer(number) if i16::try_from(*number).is_ok() => {
                types.extend(varint(2));
                values.extend((*number as i16).to_be_bytes());
            }
            Value::Integer(number) => {
                types.extend(varint(6));
                values.extend(number.to_be_bytes());
            }
            Value::Real(number) => {
                types.extend(varint(7));
                values.extend(number.to_be_bytes());
            }
            Value::Text(text) => {
                types.extend(varint(13 + 2 * text.len() as u64));
                values.extend(text.as_bytes());
            }
        }
    }
    // The head's length counts itself; rows here have few columns.
    let head = varint(types.len() as u64 + 1);
    assert_eq!(head.len(), 1, "the head is short");
    [head, types, values].concat()
}

fn varint(value: u64) -> Vec<u8> {
    assert!(value < 1 << 56, "nothing here is so large");
    let groups = (1..8).find(|g| value < 1 << (7 * g)).unwrap_or(8);
    (0..groups).rev().map(|g| ((value >> (7 * g)) & 0x7f) as u8 | if g > 0 { 0x80 } else { 0 }).collect()
}
