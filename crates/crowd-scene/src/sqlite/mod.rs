//! Reads whole tables of an SQLite 3 database held in memory; neither queries nor writing, no indices.
//!
//! The file format is documented and frozen (sqlite.org/fileformat2.html). A simulator's trajectories need four tables
//! read from start to end, so this is all of it: pages, b-trees of tables, records. Every offset is checked; a page is
//! visited once at most, so hostile links end. Why no library: docs/decisions/0020-own-sqlite-reader.md.

mod btree;
mod record;
mod schema;

pub(crate) use btree::{Database, MAGIC};
pub(crate) use record::{Record, Value};
pub(crate) use schema::Table;

#[cfg(test)]
mod tests;
