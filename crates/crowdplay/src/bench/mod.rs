//! `crowdplay bench`: several techniques side by side in one process, their frames interleaved, and conditions on the outcome.
//!
//! Machines are noisy, so what counts is the ratio of medians that were measured frame by frame in turn: same crowd, same
//! camera, same poses, and each round begins with another contender. `words` reads the command line, `measure` draws, `rows` holds what
//! came out and `condition` judges it.

mod condition;
mod measure;
mod pops;
mod rows;
mod variant;
mod words;

pub use condition::Condition;
pub use rows::{BenchReport, Judged, Row};
pub use words::{Asked, BenchWords, NAME, command, parse};

use crate::picture::{write_file, write_stdout};
use crate::{Error, Result, Talk};
use std::io::Write;
use std::path::Path;

/// Measures, writes what was asked for, and judges the conditions.
///
/// # Errors
/// As a headless run; [`Error::Machine`] without a GPU, also without one in software; [`Error::Missed`] when a condition does
/// not hold (everything is written by then).
pub fn run(asked: &Asked, stdout: &mut dyn Write, talk: &mut Talk<'_>) -> Result<()> {
    let report = measure::measure(asked, talk)?;
    let words = &asked.words;
    if let Some(path) = &words.csv {
        write_to(path, report.to_csv().as_bytes(), stdout)?;
    }
    if let Some(path) = &words.json {
        let mut text = serde_json::to_vec_pretty(&report)
            .map_err(|e| Error::Output { path: path.clone(), source: std::io::Error::other(e) })?;
        text.push(b'\n');
        write_to(path, &text, stdout)?;
    }
    if let Some(path) = &words.markdown {
        write_to(path, report.to_markdown(&asked.typed).as_bytes(), stdout)?;
    }
    if words.csv.is_none() && words.json.is_none() && words.markdown.is_none() {
        write_stdout(stdout, report.to_table().as_bytes())?;
    }
    for judged in &report.conditions {
        let verdict = if judged.holds { "holds" } else { "DOES NOT HOLD" };
        let Judged { condition, count, budget, found, .. } = judged;
        talk.say(&format!("{condition} at {count} instances, N {budget}: found {found:.4}, {verdict}"));
    }
    match report.conditions.iter().filter(|judged| !judged.holds).count() {
        0 => Ok(()),
        missed => Err(Error::Missed { missed, of: report.conditions.len() }),
    }
}

fn write_to(path: &Path, bytes: &[u8], stdout: &mut dyn Write) -> Result<()> {
    if path == Path::new("-") { write_stdout(stdout, bytes) } else { write_file(path, bytes) }
}
