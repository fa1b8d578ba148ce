//! The README's figures of crowds are those of the pages in `docs/benchmarks`.
//!
//! `UPDATE_BARS=1 cargo test --release --locked -p crowd-tests --test house` writes them again.

use crate::bars::cells;
use std::path::{Path, PathBuf};

const BEGIN: &str = "<!-- figures of the pages -->\n";
const END: &str = "<!-- end of figures -->";

/// The people of the table.
const PEOPLE: &str = "8192";

/// Techniques as the page names them, and as the README does.
const TECHNIQUES: [(&str, &str); 6] = [
    ("pseudo-instancing", "pseudo-instancing, a draw per instance (Peng 2011's baseline)"),
    ("instanced", "instanced, culled"),
    ("discrete", "three discrete levels by depth (Park & Han 2009)"),
    ("reform", "reformed every frame (Peng 2011, Dong & Peng 2019)"),
    ("bucketed", "**bucketed**"),
    ("static-floor", "the same triangles, skinned beforehand"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Rows of a page's table of techniques, cells by their column's name.
struct Rows(Vec<Vec<(String, String)>>);

impl Rows {
    fn of(page: &str) -> Self {
        let mut lines = page.lines().filter_map(cells).skip_while(|cells| cells.first() != Some(&"instances"));
        let header = lines.next().expect("a table of techniques");
        let rows = lines.skip(1).take_while(|cells| cells.len() == header.len());
        let named = |cells: Vec<&str>| header.iter().zip(cells).map(|(a, b)| ((*a).to_owned(), b.to_owned())).collect();
        Self(rows.map(named).collect())
    }

    fn number(&self, people: &str, technique: &str, column: &str) -> f64 {
        let is = |row: &[(String, String)], name: &str, value: &str| row.iter().any(|(n, v)| n == name && v == value);
        let row = self.0.iter().find(|row| is(row, "instances", people) && is(row, "technique", technique));
        let row = row.unwrap_or_else(|| panic!("no row of {people} people and {technique}"));
        let (_, text) = row.iter().find(|(name, _)| name == column).unwrap_or_else(|| panic!("no column {column}"));
        text.parse().unwrap_or_else(|_| panic!("no number: {text}"))
    }
}

fn grouped(number: f64) -> String {
    let digits = format!("{number:.0}");
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|group| std::str::from_utf8(group).expect("digits")).collect();
    groups.join(",")
}

/// What the README says, of the pages' texts.
fn figures(crowd: &str, million: &str, street: &str) -> String {
    let (crowd, million, street) = (Rows::of(crowd), Rows::of(million), Rows::of(street));
    let mut text =
        String::from("| technique | triangles | ms | level of detail, % of the GPU's time |\n|---|---|---|---|\n");
    for (name, words) in TECHNIQUES {
        let of = |column| crowd.number(PEOPLE, name, column);
        let mut ms = grouped(of("frame ms"));
        if name == "bucketed" {
            ms = format!("**{ms}**");
        }
        let share = of("LOD %");
        let share = if share > 0.0 { format!("{share:.1} ") } else { String::new() };
        text += &format!("| {words} | {} | {ms} | {share}|\n", grouped(of("triangles")));
    }
    let frame = |rows: &Rows, people, name| rows.number(people, name, "frame ms");
    let times = frame(&million, "1000000", "bucketed") / frame(&million, "30000", "bucketed");
    let left = |column| {
        100.0 * street.number("2000", "bucketed+occlusion", column) / street.number("2000", "bucketed", column)
    };
    text += &format!(
        "\nA million people with 3.6 million vertices take {times:.2} times the frame of 30,000 with as many\n\
         ([docs/benchmarks/million.md](docs/benchmarks/million.md)). In a street with walls occlusion culling leaves {:.0} % of the triangles and {:.0} % of the frame\n\
         ([docs/benchmarks/occlusion.md](docs/benchmarks/occlusion.md)).\n",
        left("triangles"),
        left("frame ms"),
    );
    text
}

#[test]
fn readme_says_what_the_pages_say() {
    let page = |name: &str| {
        std::fs::read_to_string(root().join("docs/benchmarks").join(name)).expect("a page of docs/benchmarks")
    };
    let want = figures(&page("crowd-morphs.md"), &page("million.md"), &page("occlusion.md"));
    let file = root().join("README.md");
    let readme = std::fs::read_to_string(&file).expect("README.md");
    let (before, rest) = readme.split_once(BEGIN).expect("the README marks where the figures begin");
    let (found, after) = rest.split_once(END).expect("the README marks where the figures end");
    if found == want {
        return;
    }
    assert!(
        std::env::var_os("UPDATE_BARS").is_some(),
        "README.md has other figures than docs/benchmarks: write them again with UPDATE_BARS=1. Found:\n{found}\nwanted:\n{want}"
    );
    std::fs::write(&file, [before, BEGIN, &want, END, after].concat()).expect("README.md can be written");
}

#[test]
fn figures_are_of_the_rows_they_name() {
    let mut page = String::from("| instances | technique | frame ms | LOD % | triangles |\n|---|---|---|---|---|\n");
    for (people, name, ms, share, triangles) in [
        ("8192", "pseudo-instancing", "4098.7", "0.00", "39779272"),
        ("8192", "instanced", "7", "0.04", "8"),
        ("8192", "discrete", "7", "0.7", "8"),
        ("8192", "reform", "7", "18.94", "8"),
        ("128", "bucketed", "7", "0.7", "8"),
        ("8192", "bucketed", "89.5", "4.8", "1000"),
        ("8192", "static-floor", "7", "0", "8"),
        ("30000", "bucketed", "100", "1", "8"),
        ("1000000", "bucketed", "191", "1", "8"),
        ("2000", "bucketed", "600", "1", "80"),
        ("2000", "bucketed+occlusion", "78", "1", "8"),
    ] {
        page += &format!("| {people} | {name} | {ms} | {share} | {triangles} |\n");
    }
    let text = figures(&page, &page, &page);
    assert!(text.contains("baseline) | 39,779,272 | 4,099 | |\n"), "{text}");
    assert!(text.contains("| **bucketed** | 1,000 | **90** | 4.8 |\n"), "{text}");
    assert!(text.contains("take 1.91 times"), "{text}");
    assert!(text.contains("leaves 10 % of the triangles and 13 % of the frame"), "{text}");
}
