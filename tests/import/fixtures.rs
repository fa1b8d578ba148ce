//! The project's own characters and malformed inputs: the good load clean, each bad one gets the answer it is named after.

use std::path::{Path, PathBuf};

use crowd_source::{Error, Limits, load_character};

use crate::invariants::broken_promise;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name)
}

fn assets_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("the fixtures folder is readable");
    let paths = entries.map(|e| e.expect("an entry").path());
    let mut assets: Vec<PathBuf> =
        paths.filter(|p| p.extension().is_some_and(|e| e == "glb" || e == "gltf" || e == "obj")).collect();
    assets.sort();
    assets
}

#[test]
fn good_characters_load_without_a_warning() {
    let assets = assets_in(&folder("good"));
    assert!(assets.len() >= 8, "{assets:?}");
    for path in assets {
        let character = load_character(&path, &Limits::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(broken_promise(&character), None, "{}", path.display());
        assert!(character.warnings.is_empty(), "{}: {:?}", path.display(), character.warnings);
    }
}

#[test]
fn bad_inputs_get_the_answer_they_are_named_after() {
    let folder = folder("bad");
    let text = std::fs::read_to_string(folder.join("expected.json")).expect("readable");
    let expected: Vec<serde_json::Value> = serde_json::from_str(&text).expect("JSON");
    let mut wrong = Vec::new();
    for entry in &expected {
        let word = |key: &str| entry[key].as_str().expect("a word");
        let path = folder.join(word("file"));
        let error = match load_character(&path, &Limits::default()) {
            Err(error) => error,
            Ok(_) => {
                wrong.push(format!("{} was accepted", word("file")));
                continue;
            }
        };
        let kind = match &error {
            Error::Io { .. } | Error::NamedFile { .. } => "io",
            Error::Format { .. } => "format",
            Error::Unsupported { .. } => "unsupported",
            Error::Limit { .. } => "limit",
            other => panic!("{}: an unknown kind of refusal: {other}", word("file")),
        };
        let said = error.to_string();
        let words = entry["words"].as_array().expect("words");
        if kind != word("kind") || !words.iter().all(|w| said.contains(w.as_str().expect("a word"))) {
            wrong.push(format!("expected {entry}, found {kind}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let listed: Vec<PathBuf> = expected.iter().map(|e| folder.join(e["file"].as_str().expect("a word"))).collect();
    assert!(assets_in(&folder).iter().all(|path| listed.contains(path)), "expected.json lists every bad input");
}
