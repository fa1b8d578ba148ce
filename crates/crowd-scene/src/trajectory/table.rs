//! Text tables with a heading line: Vadere's output files, and comma-separated values of any origin.
//!
//! Columns are found by their names, whatever their order; those not known are passed over and named in a remark. Words
//! stand between commas, semicolons or tabs, whichever the heading has, else between blanks.

use super::rows::{Id, Rows};
use crate::text::wrong;
use crate::{Error, Result};

/// Columns of a table that are looked at.
const MOST_COLUMNS: usize = 256;
/// Vadere's usual `simTimeStepLength`; its files count steps and do not say how long one is.
const VADERE_STEP_S: f64 = 0.4;

/// What a column means, and the names it goes by: lower case, letters and digits only, units cut off.
const NAMES: [(Column, &[&str]); 10] = [
    (
        Column::Id,
        &["id", "agent", "agentid", "person", "personid", "pedestrian", "pedestrianid", "pedid", "trackid", "no"],
    ),
    (Column::Time, &["time", "t", "times", "simtime", "simsec", "seconds", "timestamp"]),
    (Column::Frame, &["frame", "frameid", "framenumber", "fr", "timestep"]),
    (Column::X, &["x", "posx", "xm", "px", "positionx", "coordcentx", "startx"]),
    (Column::Y, &["y", "posy", "ym", "py", "positiony", "coordcenty", "starty"]),
    (Column::FacingX, &["orix", "facingx", "dirx", "orientationx"]),
    (Column::FacingY, &["oriy", "facingy", "diry", "orientationy"]),
    (Column::EndTime, &["endtime"]),
    (Column::EndX, &["endx"]),
    (Column::EndY, &["endy"]),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
enum Column {
    Id,
    Time,
    Frame,
    X,
    Y,
    FacingX,
    FacingY,
    EndTime,
    EndX,
    EndY,
}

/// Where the columns are.
struct Heading {
    separator: Option<char>,
    places: [Option<usize>; NAMES.len()],
    /// Metres in a unit of x and y.
    metres: f64,
    /// Names not known.
    unknown: Vec<String>,
    /// Counts steps as Vadere does.
    counts_steps: bool,
}

/// Reads the text. `frame_rate_hz`: for files with frames instead of times.
pub(super) fn read(text: &str, frame_rate_hz: Option<f64>) -> Result<Rows> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| is_content(line));
    let (number, first) = lines.next().unwrap_or((0, ""));
    let heading = Heading::read(number + 1, first)?;
    let mut rows = Rows::default();
    let frame_s = heading.frame_s(number + 1, frame_rate_hz, &mut rows)?;
    rows.stay_between_rows = heading.has_steps();
    if !heading.unknown.is_empty() {
        rows.remarks.push(format!("columns passed over: {}", heading.unknown.join(", ")));
    }
    for (index, line) in lines {
        heading.read_row(index + 1, line, frame_s, &mut rows)?;
    }
    Ok(rows)
}

/// Not empty and no comment.
pub(super) fn is_content(line: &str) -> bool {
    let line = line.trim();
    !line.is_empty() && !line.starts_with('#')
}

impl Heading {
    fn read(line_number: usize, line: &str) -> Result<Self> {
        let line = line.trim_start_matches('\u{feff}');
        let separator = [';', ',', '\t'].into_iter().find(|&c| line.contains(c));
        let mut heading =
            Self { separator, places: [None; NAMES.len()], metres: 1.0, unknown: Vec::new(), counts_steps: false };
        for (place, word) in split(line, separator).take(MOST_COLUMNS).enumerate() {
            let name = plain(word);
            let known = NAMES.iter().find(|(_, names)| names.contains(&name.as_str())).map(|&(column, _)| column);
            match known {
                Some(column) if heading.places[column as usize].is_none() => {
                    heading.places[column as usize] = Some(place);
                    heading.counts_steps |= name == "timestep";
                    if column == Column::X && word.to_lowercase().contains("cm") {
                        heading.metres = 0.01;
                    }
                }
                _ if heading.unknown.len() < 12 => heading.unknown.push(word.chars().take(40).collect()),
                _ => {}
            }
        }
        for (column, what) in [(Column::Id, "id"), (Column::X, "x"), (Column::Y, "y")] {
            heading.must_have(line_number, line, &[column], what)?;
        }
        heading.must_have(line_number, line, &[Column::Time, Column::Frame], "time (seconds) or frame")?;
        Ok(heading)
    }

    fn must_have(&self, line_number: usize, line: &str, columns: &[Column], what: &str) -> Result<()> {
        if columns.iter().any(|&column| self.places[column as usize].is_some()) {
            return Ok(());
        }
        let expected = format!("a heading that names a column {what}, as in `id,time,x,y`");
        Err(wrong(line_number, line, &expected))
    }

    /// Rows are steps from a start to an end.
    fn has_steps(&self) -> bool {
        [Column::EndTime, Column::EndX, Column::EndY].iter().all(|&column| self.places[column as usize].is_some())
    }

    /// Seconds of a frame; not used where the file has times.
    fn frame_s(&self, line_number: usize, frame_rate_hz: Option<f64>, rows: &mut Rows) -> Result<f64> {
        if self.places[Column::Time as usize].is_some() {
            return Ok(0.0);
        }
        let frame_s = match frame_rate_hz {
            Some(rate) => 1.0 / rate,
            None if self.counts_steps => {
                let words = format!(
                    "time steps are taken for {VADERE_STEP_S} s, Vadere's usual; name the rate where it is another"
                );
                rows.remarks.push(words);
                VADERE_STEP_S
            }
            None => {
                let place = format!("line {line_number}");
                return Err(Error::content(
                    place,
                    "a column of frames and no frame rate",
                    "a column of times in seconds",
                )
                .with_remedy("or name the rate"));
            }
        };
        rows.frame_s = Some(frame_s);
        Ok(frame_s)
    }

    fn read_row(&self, line_number: usize, line: &str, frame_s: f64, rows: &mut Rows) -> Result<()> {
        let mut words = [None; NAMES.len()];
        for (place, word) in split(line, self.separator).take(MOST_COLUMNS).enumerate() {
            for (wanted, found) in self.places.iter().zip(&mut words) {
                if *wanted == Some(place) {
                    *found = Some(word);
                }
            }
        }
        let number = |column: Column, name: &str| -> Result<f64> {
            let word =
                words[column as usize].ok_or_else(|| wrong(line_number, line, &format!("a value in column {name}")))?;
            parse_number(line_number, name, word)
        };
        let id = words[Column::Id as usize].filter(|w| !w.is_empty());
        let id = parse_id(id.ok_or_else(|| wrong(line_number, line, "a value in column id"))?);
        let time_s = match self.places[Column::Time as usize] {
            Some(_) => number(Column::Time, "time")?,
            None => number(Column::Frame, "frame")? * frame_s,
        };
        let place = [number(Column::X, "x")? * self.metres, number(Column::Y, "y")? * self.metres];
        let facing = match (self.places[Column::FacingX as usize], self.places[Column::FacingY as usize]) {
            (Some(_), Some(_)) => {
                [number(Column::FacingX, "facing x")? as f32, number(Column::FacingY, "facing y")? as f32]
            }
            _ => [0.0; 2],
        };
        if !self.has_steps() {
            return rows.push(line_number, id, time_s, place, facing);
        }
        let end_s = number(Column::EndTime, "endTime")?;
        if end_s < time_s {
            let expected = format!("an end of the step after its start at {time_s}");
            return Err(wrong(line_number, &end_s.to_string(), &expected));
        }
        let end = [number(Column::EndX, "endX")? * self.metres, number(Column::EndY, "endY")? * self.metres];
        rows.push(line_number, id.clone(), time_s, place, facing)?;
        rows.push(line_number, id, end_s, end, facing)
    }
}

fn split(line: &str, separator: Option<char>) -> Box<dyn Iterator<Item = &str> + '_> {
    match separator {
        Some(c) => Box::new(line.split(c).map(|word| word.trim().trim_matches('"'))),
        None => Box::new(line.split_whitespace()),
    }
}

/// A column's name without unit, processor number (Vadere's `-PID1`), case and punctuation.
fn plain(word: &str) -> String {
    let lower = word.to_lowercase();
    let name = lower.split(['/', '[', '(']).next().unwrap_or("");
    let name = name.rsplit(':').next().unwrap_or(name);
    let name = name.split("-pid").next().unwrap_or(name);
    name.chars().filter(|c| c.is_ascii_alphanumeric()).collect()
}

/// A finite number.
pub(super) fn parse_number(line_number: usize, name: &str, word: &str) -> Result<f64> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(wrong(line_number, word, &format!("{name}, a finite number"))),
    }
}

/// A whole number, also when it is written as `4.0`, or else a name.
pub(super) fn parse_id(word: &str) -> Id {
    if let Ok(number) = word.parse::<i64>() {
        return Id::Number(number);
    }
    match word.parse::<f64>() {
        Ok(number) if number == number.trunc() && number.abs() < 9.0e15 => Id::Number(number as i64),
        _ => Id::Name(word.to_owned()),
    }
}
