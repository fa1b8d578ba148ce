//! `docs/benchmarks/bars.md` says in one place which bars the pages beside it hold: it is made of their own tables, so that no summary can say
//! what no page says.
//!
//! `UPDATE_BARS=1 cargo test --release --locked -p crowd-tests --test house bars` writes it again.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// One row of a page's table of bars.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    /// What is divided by what, and what it may come to: rows with equal bars share a line.
    bar: String,
    /// Where it was measured: people, or the share of the triangles.
    at: String,
    found: f64,
    held: bool,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/benchmarks")
}

/// The cells of a line `| a | b |`, or nothing of any other line.
pub(crate) fn cells(line: &str) -> Option<Vec<&str>> {
    let inner = line.trim().strip_prefix('|')?.strip_suffix('|')?;
    Some(inner.split('|').map(str::trim).collect())
}

/// All rows of tables whose last column is `holds` (`crowdplay bench`) or `met` (`crowdbake compare`).
///
/// # Panics
/// On a row of such a table that cannot be read: nothing is left out in silence.
fn rows_of(page: &str) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut header: Option<Vec<&str>> = None;
    for line in page.lines() {
        let Some(cells) = cells(line) else {
            header = None;
            continue;
        };
        match &header {
            None => header = Some(cells),
            Some(_) if cells.iter().all(|cell| !cell.is_empty() && cell.chars().all(|c| c == '-')) => {}
            Some(names) => {
                assert_eq!(cells.len(), names.len(), "a row of another width: {line}");
                rows.extend(row_of(names, &cells));
            }
        }
    }
    rows
}

/// A row by its header, or nothing where the table is none of bars.
fn row_of(names: &[&str], cells: &[&str]) -> Option<Row> {
    let number = |text: &str| text.parse::<f64>().unwrap_or_else(|_| panic!("no number: {text} in {cells:?}"));
    let held = |text: &str| match text {
        "yes" => true,
        "NO" => false,
        _ => panic!("neither yes nor NO: {text} in {cells:?}"),
    };
    match (names, cells) {
        (["condition", "instances", "N", "found", "holds"], [condition, instances, _, found, holds]) => Some(Row {
            bar: (*condition).to_owned(),
            at: (*instances).to_owned(),
            found: number(found),
            held: held(holds),
        }),
        (["ours", "of", "than", "at", "found", "allowed", "met"], [ours, of, than, at, found, allowed, met]) => {
            let (than, on) = than.split_once(" on ").map_or((*than, None), |(than, on)| (than, Some(on)));
            let at = on.map_or_else(|| (*at).to_owned(), |on| format!("{on} {at}"));
            let bar = match (on, than) {
                (Some(_), "its own rest RMS %") => format!("{ours}: {of} / at rest <= {allowed}, the worst character"),
                (Some(on), _) if on.ends_with("judged elsewhere") => {
                    format!("{ours} / a peer's single cell judged elsewhere <= {allowed}, the worst")
                }
                (Some(_), _) => format!("{ours} / the best peer's single cell <= {allowed}, the worst or all lost"),
                // The page names the best peer of each share; here they share a line.
                (None, _) if *of == "colour" || *of == "normal deg" || *of == "image" => {
                    format!("{ours}: {of} / the best peer <= {allowed}")
                }
                (None, than) => format!("{ours}: {of} / {than} <= {allowed}"),
            };
            Some(Row { bar, at, found: number(found), held: held(met) })
        }
        _ => {
            let last = names.last().copied().unwrap_or_default();
            assert!(last != "holds" && last != "met", "a table of bars with other columns: {names:?}");
            None
        }
    }
}

/// The page of pages; `pages` are names without `.md` and their texts.
fn summary(pages: &BTreeMap<String, String>) -> String {
    let mut lines: [Vec<String>; 2] = [Vec::new(), Vec::new()];
    let (mut held, mut all) = (0, 0);
    for (name, text) in pages {
        let mut bars: Vec<(String, Vec<Row>)> = Vec::new();
        for row in rows_of(text) {
            match bars.iter_mut().find(|(bar, _)| *bar == row.bar) {
                Some((_, rows)) => rows.push(row),
                None => bars.push((row.bar.clone(), vec![row])),
            }
        }
        for (bar, rows) in bars {
            all += rows.len();
            held += rows.iter().filter(|row| row.held).count();
            let found: Vec<String> = rows
                .iter()
                .map(|row| {
                    if row.held {
                        format!("{}: {:.3}", row.at, row.found)
                    } else {
                        format!("{}: **{:.3}**", row.at, row.found)
                    }
                })
                .collect();
            let missed = rows.iter().any(|row| !row.held);
            lines[usize::from(!missed)].push(format!("| [{name}]({name}.md) | {bar} | {} |", found.join(", ")));
        }
    }
    let mut page = String::from(
        "# Bars\n\nWhat the pages beside this one ask for, made of their own tables of bars by `UPDATE_BARS=1 cargo test --release --locked -p crowd-tests --test house bars`; do not edit by hand.\n",
    );
    let _ = writeln!(
        page,
        "{held} of {all} hold; what is missed stands in bold type. Where it was measured (share of the triangles, with the character that decides; people) stands before each figure.\n[BENCHMARKS.md](../BENCHMARKS.md) says why the others are missed, and which bars no page can check."
    );
    for (title, lines) in ["Missed somewhere", "Held everywhere"].into_iter().zip(lines) {
        let _ = writeln!(page, "\n## {title}\n\n| page | bar | found |\n|---|---|---|");
        for line in lines {
            page.push_str(&line);
            page.push('\n');
        }
    }
    page
}

#[test]
fn bars_page_says_what_the_pages_say() {
    let mut pages = BTreeMap::new();
    for entry in std::fs::read_dir(folder()).expect("docs/benchmarks is there") {
        let path = entry.expect("its entries can be read").path();
        let name = path.file_stem().and_then(|name| name.to_str()).expect("names are UTF-8").to_owned();
        if name != "bars" {
            pages.insert(name, std::fs::read_to_string(&path).expect("a page is text"));
        }
    }
    let want = summary(&pages);
    let file = folder().join("bars.md");
    if std::env::var_os("UPDATE_BARS").is_some() {
        std::fs::write(&file, &want).expect("docs/benchmarks can be written");
    }
    let found = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        found == want,
        "docs/benchmarks/bars.md is not what the pages beside it say: write it again with UPDATE_BARS=1 and look at what changed"
    );
}

#[test]
fn missed_and_held_bars_are_told_apart() {
    let page = "| condition | instances | N | found | holds |\n|---|---|---|---|---|\n| a/b <= 0.5 | 128 | 9 | 0.4 | yes |\n| a/b <= 0.5 | 1024 | 9 | 0.6 | NO |\n\n\
                | ours | of | than | at | found | allowed | met |\n|---|---|---|---|---|---|---|\n| refit | colour | x | 50 % | 0.1 | 0.85 | yes |\n| refit | colour | y | 25 % | 0.2 | 0.85 | yes |\n";
    let text = summary(&BTreeMap::from([("p".to_owned(), page.to_owned())]));
    let (missed, held) = text.split_once("## Held everywhere").expect("two parts");
    assert!(missed.contains("| a/b <= 0.5 | 128: 0.400, 1024: **0.600** |"), "{text}");
    assert!(held.contains("| refit: colour / the best peer <= 0.85 | 50 %: 0.100, 25 %: 0.200 |"), "{text}");
    assert!(text.contains("3 of 4 hold"), "{text}");
}

#[test]
#[should_panic(expected = "neither yes nor NO")]
fn a_row_that_cannot_be_read_is_not_left_out() {
    rows_of(
        "| condition | instances | N | found | holds |\n|---|---|---|---|---|\n| a <= 1 | 1 | 1 | 0.5 | perhaps |\n",
    );
}
