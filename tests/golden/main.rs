//! Did the bake change? One checksum per section of each fixture's pack, in `sections.txt`.
//!
//! `UPDATE_GOLDEN=1 cargo test --release -p crowd-tests --test golden` writes the file anew; the commit says why it moved.

use crowd_pack::layout::{ENTRY_BYTES, HEADER_BYTES, SECTIONS};
use crowd_tests::folders::{fixtures, repository};
use std::path::{Path, PathBuf};

/// Lines `fixture section bytes checksum`, as the section table of the fixture's own pack has them.
fn sections_of(path: &Path) -> Vec<String> {
    let name = path.file_name().expect("a fixture is a file").to_string_lossy().into_owned();
    let contents = crowdbake::bake_file(path).unwrap_or_else(|error| panic!("{error}"));
    let bytes = contents.to_bytes().unwrap_or_else(|error| panic!("{name}: {error}"));
    // Behind the table of an older version lies something else.
    let count = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes"));
    let table = bytes[HEADER_BYTES..].chunks_exact(ENTRY_BYTES).zip(SECTIONS).take(count as usize);
    let line = |(entry, (section, _)): (&[u8], (&str, u32))| {
        let byte_count = u64::from_le_bytes(entry[24..32].try_into().expect("eight bytes"));
        let checksum = u32::from_le_bytes(entry[36..40].try_into().expect("four bytes"));
        format!("{name} {section} {byte_count} {checksum:08x}")
    };
    table.map(line).collect()
}

fn good_fixtures() -> Vec<PathBuf> {
    let items = std::fs::read_dir(fixtures().join("good")).expect("fixtures are committed");
    let mut paths: Vec<PathBuf> = items.map(|item| item.expect("a readable folder").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ["glb", "gltf", "obj"].iter().any(|e| ending == *e)));
    paths.sort();
    assert!(paths.len() > 8, "found {} fixtures", paths.len());
    paths
}

#[test]
fn every_section_of_every_fixture_is_what_it_was() {
    let golden = repository().join("tests/golden/sections.txt");
    let found: Vec<String> = good_fixtures().iter().flat_map(|path| sections_of(path)).collect();
    if std::env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1") {
        std::fs::write(&golden, found.join("\n") + "\n").expect("the repository can be written");
        return;
    }
    let expected = std::fs::read_to_string(&golden).unwrap_or_default();
    let expected: Vec<&str> = expected.lines().collect();
    let moved: Vec<String> = difference(&expected, &found);
    assert!(
        moved.is_empty(),
        "{} lines moved; if that is meant, run with UPDATE_GOLDEN=1 and say in the commit why:\n{}",
        moved.len(),
        moved.join("\n")
    );
}

/// Lines of either side that the other lacks, `-` for expected, `+` for found.
fn difference(expected: &[&str], found: &[String]) -> Vec<String> {
    let gone = expected.iter().filter(|line| !found.iter().any(|other| other == *line)).map(|line| format!("- {line}"));
    let new = found.iter().filter(|line| !expected.contains(&line.as_str())).map(|line| format!("+ {line}"));
    gone.chain(new).collect()
}

#[test]
fn a_changed_checksum_shows_on_both_sides() {
    let found = ["a.glb lods 8 00000001".to_owned()];
    assert_eq!(difference(&["a.glb lods 8 00000002"], &found).len(), 2);
    assert!(difference(&["a.glb lods 8 00000001"], &found).is_empty());
}
