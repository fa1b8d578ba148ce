//! What other tools reached, judged once: Blender, and settings of others that no run tries. Single cells, from a file of figures.

use super::metrics::{METRICS, Metric};
use super::scores::{CharacterScores, find};
use serde::Serialize;

const CELLS: &str = include_str!("published.csv");

/// A figure of a peer and ours beside it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PublishedCell {
    /// The character.
    pub character: String,
    /// Share of the triangles.
    pub ratio: f64,
    /// Key of the metric.
    pub metric: &'static str,
    /// The least value that any peer reached there.
    pub least: f64,
    /// Who reached it.
    pub peer: &'static str,
    /// What `refit` has in this run.
    pub ours: f64,
    /// The same over the least value.
    pub found: f64,
}

/// A line of the file.
struct Line {
    character: &'static str,
    triangles: u32,
    ratio: f64,
    metric: &'static Metric,
    least: f64,
    peer: &'static str,
}

/// The file's cells for the characters, ratios and metrics of a run in which `refit` took part and reached its target. A character is
/// the one of the file when its name and its triangles are the same.
pub(super) fn published_cells(characters: &[CharacterScores]) -> Vec<PublishedCell> {
    let cell = |line: Line| {
        let named = |c: &&CharacterScores| c.name == line.character && c.triangles == line.triangles;
        let score = find(characters.iter().find(named)?, "refit", line.ratio).filter(|score| score.reached)?;
        let ours = (line.metric.of)(score.verdict.as_ref()?)?;
        Some(PublishedCell {
            character: line.character.to_owned(),
            ratio: line.ratio,
            metric: line.metric.key,
            least: line.least,
            peer: line.peer,
            ours,
            found: ours / line.least,
        })
    };
    CELLS.lines().filter(|line| !line.starts_with('#')).filter_map(parse).filter_map(cell).collect()
}

fn parse(line: &'static str) -> Option<Line> {
    let mut words = line.split(',');
    let mut word = || words.next();
    let (character, triangles, percent) = (word()?, word()?.parse().ok()?, word()?.parse::<f64>().ok()?);
    let key = word()?;
    let metric = METRICS.iter().find(|metric| metric.key == key)?;
    Some(Line { character, triangles, ratio: percent / 100.0, metric, least: word()?.parse().ok()?, peer: word()? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::scores::tests::scores;

    #[test]
    fn every_line_of_the_file_is_read_once() {
        let lines: Vec<&str> = CELLS.lines().filter(|line| !line.starts_with('#')).collect();
        assert_eq!(lines.len(), 6 * 5 * 4);
        let mut keys = Vec::new();
        for line in lines {
            let read = parse(line).unwrap_or_else(|| panic!("{line}"));
            assert!(read.least > 0.0 && read.ratio > 0.0, "{line}");
            keys.push((read.character, (read.ratio * 100.0) as u32, read.metric.key));
        }
        keys.sort_unstable();
        assert!(keys.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn only_the_same_character_is_held_against_a_figure() {
        let mut fox = scores("Fox", &[("refit", 1.026, 100)]);
        assert!(published_cells(std::slice::from_ref(&fox)).is_empty(), "another fox");
        fox.triangles = 576;
        let cells = published_cells(std::slice::from_ref(&fox));
        let rms = cells.iter().find(|cell| cell.metric == "animated_rms_percent").expect("a cell");
        assert_eq!((rms.ratio, rms.least, rms.peer), (0.25, 0.513, "blender"));
        assert!((rms.found - 2.0).abs() < 1e-9, "{rms:?}");
        fox.scores[0].reached = false;
        assert!(published_cells(&[fox]).is_empty(), "missed its target");
    }
}
