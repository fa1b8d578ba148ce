//! Rows as files have them: who was where at what time. Nothing sorted, nothing derived yet.

use std::collections::HashMap;

use crate::text::wrong;
use crate::{Error, Result};

/// Rows of one file: ten thousand people for a hundred seconds at 10 Hz; 700 MB of memory while they are sorted.
pub(super) const MOST_ROWS: usize = 10_000_000;
/// People in one file.
pub(super) const MOST_PEOPLE: usize = 1_000_000;
/// Coordinates in a file's own metres: any map grid of the world.
const FARTHEST_M: f64 = 1.0e9;
/// Times in a file's own seconds: any clock's.
const LATEST_S: f64 = 1.0e12;

/// Who someone is, by number or by name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Id {
    Number(i64),
    Name(String),
}

impl Id {
    /// A number that the same person has in every file.
    pub(super) fn key(&self) -> u32 {
        match self {
            Self::Number(number) => (*number as u64 ^ (*number as u64 >> 32)) as u32,
            // FNV-1a.
            Self::Name(name) => {
                name.bytes().fold(0x811C_9DC5, |hash, b| (hash ^ u32::from(b)).wrapping_mul(0x0100_0193))
            }
        }
    }
}

impl std::fmt::Display for Id {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Name(name) => write!(f, "`{}`", name.chars().take(60).collect::<String>().escape_debug()),
        }
    }
}

/// One row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Index into the ids.
    pub(super) person: u32,
    /// Line of the file or row of the table, from 1.
    pub(super) line: u32,
    pub(super) time_s: f64,
    pub(super) x: f64,
    pub(super) y: f64,
    /// Direction in the file's plane; zero where it says nothing.
    pub(super) facing: [f32; 2],
}

/// All rows of a file.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub(super) rows: Vec<Row>,
    pub(super) ids: Vec<Id>,
    index_of: HashMap<Id, u32>,
    /// What the reader passed over or assumed, as sentences.
    pub(super) remarks: Vec<String>,
    /// People stay where they are between rows however far those are apart (steps as events, not frames).
    pub(super) stay_between_rows: bool,
    /// Seconds between frames, where the file has frames.
    pub(super) frame_s: Option<f64>,
}

impl Rows {
    /// None yet, of a file with so many frames a second.
    pub(super) fn of_rate(rate_hz: f64) -> Self {
        Self { frame_s: Some(1.0 / rate_hz), ..Self::default() }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`Error::Format`] with the line for a number that is not finite or too large, [`Error::Limit`] for too many rows or
    /// people.
    pub(super) fn push(&mut self, line: usize, id: Id, time_s: f64, [x, y]: [f64; 2], facing: [f32; 2]) -> Result<()> {
        if self.rows.len() == MOST_ROWS {
            return Err(Error::Limit { line, allowed: MOST_ROWS });
        }
        within(line, "time in seconds", time_s, LATEST_S)?;
        within(line, "x in metres", x, FARTHEST_M)?;
        within(line, "y in metres", y, FARTHEST_M)?;
        let next = self.ids.len() as u32;
        let person = match self.index_of.get(&id) {
            Some(&person) => person,
            None if self.ids.len() == MOST_PEOPLE => {
                let found = format!("another person, {id}");
                return Err(wrong(line, &found, &format!("at most {MOST_PEOPLE} people")));
            }
            None => {
                self.index_of.insert(id.clone(), next);
                self.ids.push(id);
                next
            }
        };
        let facing = if facing.iter().all(|f| f.is_finite()) { facing } else { [0.0; 2] };
        self.rows.push(Row { person, line: line as u32, time_s, x, y, facing });
        Ok(())
    }
}

fn within(line: usize, name: &str, value: f64, most: f64) -> Result<()> {
    if value.abs() <= most {
        return Ok(());
    }
    Err(wrong(line, &value.to_string(), &format!("{name}, a number from -{most:e} to {most:e}")))
}
