//! Which tables there are, where they begin, and what their columns are called.

use super::{Database, Record};
use crate::{Error, Result};

/// Tables of a database that are looked at.
const MOST_TABLES: usize = 1000;

/// A table of the database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Table {
    pub(crate) name: String,
    root: u32,
    columns: Vec<String>,
}

impl Table {
    /// All tables, in the order they were made.
    pub(crate) fn all(database: &Database<'_>) -> Result<Vec<Self>> {
        let mut tables = Vec::new();
        // The first page holds type, name, tbl_name, rootpage, sql of everything.
        database.scan(1, &mut |row: &Record<'_>| {
            let is_table = row.value(0).as_text() == Some("table");
            let root = row.value(3).as_i64().and_then(|root| u32::try_from(root).ok());
            if let (true, Some(name), Some(root), Some(sql)) =
                (is_table, row.value(1).as_text(), root, row.value(4).as_text())
                && tables.len() < MOST_TABLES
            {
                tables.push(Self { name: name.to_owned(), root, columns: columns_of(sql) });
            }
            Ok(())
        })?;
        Ok(tables)
    }

    /// The table of that name.
    ///
    /// # Errors
    /// [`Error::Content`] with the names there are.
    pub(crate) fn named<'a>(tables: &'a [Self], name: &str) -> Result<&'a Self> {
        tables.iter().find(|table| table.name.eq_ignore_ascii_case(name)).ok_or_else(|| {
            let names: Vec<&str> = tables.iter().map(|table| table.name.as_str()).take(12).collect();
            Error::content("database", format!("the tables {}", names.join(", ")), format!("a table {name}"))
                .with_remedy("is it the trajectory database that JuPedSim writes?")
        })
    }

    /// Position of a column, if the table has it.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.eq_ignore_ascii_case(name))
    }

    /// Position of a column.
    ///
    /// # Errors
    /// [`Error::Content`] with the columns there are.
    pub(crate) fn column(&self, name: &str) -> Result<usize> {
        self.find(name).ok_or_else(|| {
            let found = format!("the columns {}", self.columns.join(", "));
            Error::content(format!("table {}", self.name), found, format!("a column {name}"))
        })
    }

    /// Calls `row` with each row.
    pub(crate) fn scan(&self, database: &Database<'_>, row: &mut dyn FnMut(&Record<'_>) -> Result<()>) -> Result<()> {
        database.scan(self.root, row)
    }
}

/// The columns' names in a `CREATE TABLE` statement; constraints on the whole table are passed over.
fn columns_of(sql: &str) -> Vec<String> {
    const CONSTRAINTS: [&str; 5] = ["constraint", "primary", "unique", "check", "foreign"];
    let Some(open) = sql.find('(') else { return Vec::new() };
    let (mut depth, mut parts, mut part) = (0_u32, Vec::new(), String::new());
    for c in sql[open + 1..].chars() {
        match c {
            '(' => depth += 1,
            ')' if depth == 0 => break,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(std::mem::take(&mut part));
                continue;
            }
            _ => {}
        }
        part.push(c);
    }
    parts.push(part);
    let name = |part: &String| {
        let word = part.split_whitespace().next()?.trim_matches(['"', '`', '[', ']', '\'']);
        (!CONSTRAINTS.iter().any(|c| word.eq_ignore_ascii_case(c))).then(|| word.to_owned())
    };
    parts.iter().filter_map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_read_from_the_statement() {
        let sql =
            "CREATE TABLE t(  key TEXT NOT NULL, \"v a\" REAL, [b] DECIMAL(3, 2) CHECK (b > 0), PRIMARY KEY (key, b))";
        assert_eq!(columns_of(sql), ["key", "v", "b"]);
        assert!(columns_of("CREATE TABLE t AS SELECT 1").is_empty());
    }
}
