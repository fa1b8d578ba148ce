//! A comparison as text and as Markdown.

use super::bars::Bar;
use super::metrics::{METRICS, Metric};
use super::published::PublishedCell;
use super::scores::{CharacterScores, Comparison, Means, Score};
use crate::units::counted;
use crowd_judge::JudgeOptions;
use std::fmt::Write;

/// A table: headings and rows of cells.
struct Table {
    headings: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

/// Tables for a terminal.
pub(crate) fn to_text(comparison: &Comparison) -> String {
    let mut out = String::new();
    for character in &comparison.characters {
        let _ = writeln!(out, "{}", heading_of(character));
        out += &aligned(&character_table(character));
        out.push('\n');
    }
    let count = counted(comparison.characters.len(), "character");
    let _ = writeln!(out, "geometric means over {count}, where the target was reached");
    out += &aligned(&means_table(&comparison.means));
    if !comparison.bars.is_empty() {
        out += "\nbars: ours divided by theirs\n";
        out += &aligned(&bars_table(&comparison.bars));
    }
    if comparison.points < JudgeOptions::FULL.points {
        let _ =
            writeln!(out, "single cells are not judged: with {} points a side chance decides there", comparison.points);
    }
    out
}

const INTRODUCTION: &str = "\
Made by `crowdbake compare ASSET... -o FILE.md`; do not edit by hand.

How judged: each level is posed by its own skeleton at 24 moments spread over all clips by duration, half way between the \
frames that a bake samples, and in the pose at rest. Points spread by area over both surfaces and fixed there; distance of \
each to the other surface, both ways, in percent of the diagonal of the original's box at rest. Normals and base colours \
(sRGB 0 to 1) are compared at the nearest point on a face that looks the same way; UV: slide of the texture there, in \
texels. Image: RMS difference of pictures over the union of both silhouettes, 6 views of 5 poses, 256 x 256 pixels of 3 x 3 \
samples. XOR: what one silhouette alone covers, of their union; missed: what the level's leaves out of the original's; limbs missed: the same \
as a mean over the joints that show, so that a shin counts as much as a belly. s: seconds in the simplifier, on a machine that does \
other work too; for gltfpack of the whole process.

Who is compared: `wedge` our default order, `refit` its levels with their vertices moved, `bind` the same order from the \
pose at rest alone, `peng2011` the paper to the letter; of ours always the level with the most triangles that is not above \
the target. `meshopt-attr` and `meshopt-update`: meshoptimizer's simplifyWithAttributes and simplifyWithUpdate (normals 0.1, \
texture coordinates 1, skin weights 0.5, permissive, no error limit), each primitive by the same share; `meshopt-global` and \
`meshopt-best`: the same two over the whole character at once, in the pose at rest. `gltfpack-se1`: gltfpack with \
`-si R -se 1`; `gltfpack-best`: with `-si 0.0005 -sv -sp -se E`; R and E searched until the count fits.
";

const PUBLISHED: &str = "\
The least value that any of twelve peers reached (gltfpack 1.3.0 in seven settings, meshoptimizer 1.3 in four, Blender 3.4.1 Decimate, each with a count near \
the target), and `refit` in this run over it. They were judged once, in as many poses, with 10,000 points a side and as many pictures, by other code: \
peers that are in both mostly differ by less than 10 % in distances and colours (distances of Knight and Mage at 5 % by 45 and 20 %), and \
pictures, drawn by another rasteriser, by up to 40 %. \
The figures are rounded as they were given, those of small errors coarsely.";

/// The document of `docs/benchmarks/levels.md` and `levels-more.md`.
pub(crate) fn to_markdown(comparison: &Comparison) -> String {
    let mut out = format!("# Benchmarks: levels of detail\n\n{INTRODUCTION}\n");
    let names: Vec<String> = comparison
        .characters
        .iter()
        .map(|character| format!("{} ({} triangles)", character.name.replace('|', "\\|"), character.triangles))
        .collect();
    let _ = writeln!(out, "Points a side: {}. Characters: {}.\n", comparison.points, names.join(", "));
    out += "## All characters together\n\nGeometric means, only over the characters where the target was reached.\n\n";
    out += &markdown(&means_table(&comparison.means));
    out += "\n## Bars\n\nWhat we ask of our levels: ours divided by theirs, over the characters where both reached the \
            target; for single cells (allowed 1.03) all of RMS, picture, colour and normals of any character that are lost, or else the worst.\n\n";
    out += &markdown(&bars_table(&comparison.bars));
    if !comparison.published.is_empty() {
        let _ = write!(out, "\n## Single cells judged elsewhere\n\n{PUBLISHED}\n\n");
        out += &markdown(&published_table(&comparison.published));
    }
    for character in &comparison.characters {
        let _ = write!(out, "\n## {}\n\n{}\n\n", character.name, heading_of(character));
        out += &markdown(&character_table(character));
    }
    out
}

fn heading_of(character: &CharacterScores) -> String {
    format!(
        "{}: {} triangles, {} poses in motion; distances in percent of {:.3} m",
        character.name, character.triangles, character.moments, character.diagonal_m
    )
}

fn character_table(character: &CharacterScores) -> Table {
    let row = |score: &Score| {
        let count = match score.triangles {
            Some(triangles) if score.reached => triangles.to_string(),
            Some(triangles) => format!("{triangles} missed"),
            None => "nothing left".to_owned(),
        };
        let value = |metric: &Metric| score.verdict.as_ref().and_then(metric.of);
        row_of(score.ratio, score.contender, count, METRICS.iter().map(value), score.seconds)
    };
    let sorted = sorted_by_ratio(&character.scores, |score| score.ratio);
    table("triangles", sorted.into_iter().map(row).collect())
}

fn means_table(means: &[Means]) -> Table {
    let row = |mean: &Means| {
        let reached = format!("{} of {}", mean.reached, mean.characters);
        row_of(mean.ratio, mean.contender, reached, mean.values.iter().copied(), mean.seconds)
    };
    table("reached", sorted_by_ratio(means, |mean| mean.ratio).into_iter().map(row).collect())
}

fn bars_table(bars: &[Bar]) -> Table {
    let row = |bar: &Bar| {
        let met = if bar.met { "yes" } else { "NO" };
        let heading =
            METRICS.iter().find(|metric| metric.key == bar.metric).map_or(bar.metric, |metric| metric.heading);
        let cells = [bar.ours, heading, &bar.than, &percent(bar.ratio), &format!("{:.3}", bar.found)];
        let mut cells: Vec<String> = cells.iter().map(|cell| (*cell).to_owned()).collect();
        cells.extend([format!("{:.2}", bar.allowed), met.to_owned()]);
        cells
    };
    let headings = vec!["ours", "of", "than", "at", "found", "allowed", "met"];
    Table { headings, rows: bars.iter().map(row).collect() }
}

/// A line a character and ratio, least values with their peers and ours over them.
fn published_table(cells: &[PublishedCell]) -> Table {
    let mut headings = vec!["character", "at"];
    // A run without pictures has none of theirs.
    let shown: Vec<&Metric> = METRICS.iter().filter(|m| cells.iter().any(|cell| cell.metric == m.key)).collect();
    headings.extend(shown.iter().map(|metric| metric.heading));
    let row = |cells: &[PublishedCell]| {
        let mut row = vec![cells[0].character.clone(), percent(cells[0].ratio)];
        row.extend(shown.iter().map(|metric| match cells.iter().find(|cell| cell.metric == metric.key) {
            Some(cell) => format!("{:.3} ({} {})", cell.found, cell.peer, cell.least),
            None => "–".to_owned(),
        }));
        row
    };
    let rows = cells.chunk_by(|a, b| (&a.character, a.ratio) == (&b.character, b.ratio)).map(row).collect();
    Table { headings, rows }
}

fn table(count_heading: &'static str, rows: Vec<Vec<String>>) -> Table {
    let mut headings = vec!["ratio", "contender", count_heading];
    headings.extend(METRICS.iter().map(|metric| metric.heading));
    headings.push("s");
    Table { headings, rows }
}

fn row_of(
    ratio: f64,
    contender: &str,
    count: String,
    values: impl Iterator<Item = Option<f64>>,
    seconds: f64,
) -> Vec<String> {
    let mut cells = vec![percent(ratio), contender.to_owned(), count];
    cells.extend(METRICS.iter().zip(values).map(|(metric, value)| match value {
        Some(value) => format!("{value:.decimals$}", decimals = metric.decimals),
        None => "-".to_owned(),
    }));
    cells.push(format!("{seconds:.3}"));
    cells
}

fn percent(ratio: f64) -> String {
    let percent = (ratio * 1e6).round() / 1e4;
    format!("{percent} %")
}

/// Largest ratio first, else as they stand.
fn sorted_by_ratio<T>(all: &[T], ratio: fn(&T) -> f64) -> Vec<&T> {
    let mut sorted: Vec<&T> = all.iter().collect();
    sorted.sort_by(|a, b| ratio(b).total_cmp(&ratio(a)));
    sorted
}

/// Columns as wide as their widest cell; words to the left, numbers to the right.
fn aligned(table: &Table) -> String {
    let heading = |column: usize| table.headings[column].chars().count();
    let widest = |column: usize| {
        let cells = table.rows.iter().map(|row| row[column].chars().count());
        cells.fold(heading(column), usize::max)
    };
    let widths: Vec<usize> = (0..table.headings.len()).map(widest).collect();
    let mut out = String::new();
    let headings: Vec<String> = table.headings.iter().map(|heading| (*heading).to_owned()).collect();
    for row in std::iter::once(&headings).chain(&table.rows) {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
            if column == 1 || column == 2 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        });
        let line = cells.collect::<Vec<_>>().join("  ");
        let _ = writeln!(out, "{}", line.trim_end());
    }
    out
}

fn markdown(table: &Table) -> String {
    let mut out = format!("| {} |\n|{}\n", table.headings.join(" | "), "---|".repeat(table.headings.len()));
    for row in &table.rows {
        let cells: Vec<String> = row.iter().map(|cell| cell.replace('|', "\\|")).collect();
        let _ = writeln!(out, "| {} |", cells.join(" | "));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::scores::tests::scores;

    #[test]
    fn missed_targets_and_odd_names_show_and_break_nothing() {
        let rows = [("wedge", 0.5, 100), ("meshopt-global", 1.0, 120)];
        let comparison = crate::compare::sum_up(vec![scores("a|b", &rows)], &crate::compare::tests::request(), 1.0);
        let text = to_text(&comparison);
        assert!(text.contains("120 missed") && text.contains("25 %") && text.contains("1 of 1"), "{text}");
        let page = to_markdown(&comparison);
        let table_lines = page.lines().filter(|line| line.starts_with('|'));
        let bars_in = |line: &str| line.replace("\\|", "").matches('|').count();
        for line in table_lines {
            assert!([8, 18].contains(&bars_in(line)), "{line}");
        }
    }
}
