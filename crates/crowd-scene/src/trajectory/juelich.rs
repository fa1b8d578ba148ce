//! The text form of the Juelich pedestrian dynamics archive, which JuPedSim wrote, too, and PedPy reads.
//!
//! ```text
//! # framerate: 16.00 fps
//! # ID frame x/m y/m z/m
//! 1 0 2.83 15.04 0.0
//! ```

use super::rows::Rows;
use super::table::{parse_id, parse_number};
use crate::text::{wrong, wrong_count};
use crate::{Error, Result};

/// Reads the text. `frame_rate_hz`: for files that do not say theirs.
pub(super) fn read(text: &str, frame_rate_hz: Option<f64>) -> Result<Rows> {
    let head = Head::read(text)?;
    let rate = head.frame_rate_hz.or(frame_rate_hz).ok_or_else(|| {
        Error::content("heading", "no frame rate", "a line such as `# framerate: 16 fps`")
            .with_remedy("or name the rate")
    })?;
    let mut rows = Rows::of_rate(rate);
    if head.metres.is_none() {
        rows.remarks.push("the heading names no unit (x/m or x/cm); taken for metres".to_owned());
    }
    let metres = head.metres.unwrap_or(1.0);
    for (index, line) in text.lines().enumerate() {
        let line_number = index + 1;
        let mut words = line.split('#').next().unwrap_or("").split_whitespace();
        let Some(id) = words.next() else { continue };
        let (Some(frame), Some(x), Some(y)) = (words.next(), words.next(), words.next()) else {
            let count = line.split('#').next().unwrap_or("").split_whitespace().count();
            return Err(wrong_count(line_number, count, "at least 4: id frame x y"));
        };
        let frame = parse_number(line_number, "frame", frame)?;
        let place = [parse_number(line_number, "x", x)? * metres, parse_number(line_number, "y", y)? * metres];
        // z is the height of the head in recorded data and 0 in simulated: people stand on the ground either way.
        rows.push(line_number, parse_id(id), frame / rate, place, [0.0; 2])?;
    }
    Ok(rows)
}

/// What the comments say.
#[derive(Debug, Default)]
struct Head {
    frame_rate_hz: Option<f64>,
    metres: Option<f64>,
}

impl Head {
    fn read(text: &str) -> Result<Self> {
        let mut head = Self::default();
        let comments = text
            .lines()
            .enumerate()
            .take(1000)
            .take_while(|(_, l)| l.trim().is_empty() || l.trim_start().starts_with('#'));
        for (index, line) in comments {
            let line = line.to_lowercase();
            if head.frame_rate_hz.is_none() && (line.contains("framerate") || line.contains("frame rate")) {
                let after = line.split_once("rate").map_or("", |(_, after)| after);
                let word = after.trim_start_matches([':', '=', ' ', '\t']).split_whitespace().next().unwrap_or("");
                let rate = word.trim_end_matches("fps").parse::<f64>().ok().filter(|r| super::RATES_HZ.contains(r));
                head.frame_rate_hz = Some(rate.ok_or_else(|| {
                    let allowed = format!("frames a second, {:?}", super::RATES_HZ);
                    wrong(index + 1, word, &allowed)
                })?);
            }
            let has = |words: [&str; 3]| words.iter().any(|word| line.contains(word));
            if has(["x/cm", "x[cm]", "in cm"]) {
                head.metres = Some(0.01);
            } else if has(["x/m", "x[m]", "in meter"]) {
                head.metres = Some(1.0);
            }
        }
        Ok(head)
    }
}

/// True where the first line that is no comment begins with a number.
pub(super) fn looks_like_it(first_line: &str) -> bool {
    first_line.split_whitespace().next().is_some_and(|word| word.parse::<f64>().is_ok())
}
