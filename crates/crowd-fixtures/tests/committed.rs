//! The committed fixtures are what the generator makes, and the import gives each the answer its name promises.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crowd_fixtures::{beast, generate, people};
use crowd_source::{Error, Limits, load_character};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures")
}

#[test]
fn committed_files_are_the_generators() {
    let made = generate();
    for f in &made {
        let path = folder().join(&f.path);
        let committed = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(committed == f.bytes, "{} differs: run `cargo run --release -p crowd-fixtures -- fixtures`", f.path);
    }
    let names: BTreeSet<&str> = made.iter().map(|f| f.path.as_str()).collect();
    for part in ["good", "bad", "scenes"] {
        for entry in std::fs::read_dir(folder().join(part)).expect("the folder is committed") {
            let name = format!("{part}/{}", entry.expect("readable").file_name().to_string_lossy());
            assert!(names.contains(name.as_str()), "{name} is not made by the generator");
        }
    }
}

#[test]
fn good_files_load() {
    for f in generate().iter().filter(|f| f.path.starts_with("good/")) {
        if f.path.ends_with(".glb") || f.path.ends_with(".obj") {
            let character = load_character(&folder().join(&f.path), &Limits::default());
            let character = character.unwrap_or_else(|e| panic!("{e}"));
            assert!(character.warnings.is_empty(), "{}: {:?}", f.path, character.warnings);
        }
    }
}

fn kind(error: &Error) -> &'static str {
    match error {
        Error::Io { .. } | Error::NamedFile { .. } => "io",
        Error::Format { .. } => "format",
        Error::Unsupported { .. } => "unsupported",
        Error::Limit { .. } => "limit",
        _ => "other",
    }
}

/// What is wrong with the import's answer to one file; nothing if it is the listed one.
fn wrong_answer(path: &Path, kind_wanted: &str, words: &[&str]) -> Option<String> {
    match load_character(path, &Limits::default()) {
        Ok(_) => Some(format!("{}: was accepted", path.display())),
        Err(error) => {
            let said = error.to_string();
            let missing: Vec<&&str> = words.iter().filter(|w| !said.contains(**w)).collect();
            let right = kind(&error) == kind_wanted && missing.is_empty();
            (!right).then(|| format!("{}: {} {said:?} lacks {missing:?}", path.display(), kind(&error)))
        }
    }
}

#[test]
fn bad_files_get_their_answer() {
    let text = std::fs::read_to_string(folder().join("bad/expected.json")).expect("the list is committed");
    let list: serde_json::Value = serde_json::from_str(&text).expect("the list is JSON");
    let rows = list.as_array().expect("the list is an array");
    assert!(rows.len() > 40);
    let mut wrong = Vec::new();
    for row in rows {
        let word = |key: &str| row[key].as_str().expect("a text");
        let words: Vec<&str> = row["words"].as_array().expect("words").iter().filter_map(|w| w.as_str()).collect();
        wrong.extend(wrong_answer(&folder().join("bad").join(word("file")), word("kind"), &words));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_answer_check_can_fail() {
    let bad = folder().join("bad/joint_index_beyond_skeleton.glb");
    assert!(wrong_answer(&folder().join("good/mara.glb"), "format", &[]).is_some(), "a good file is accepted");
    assert!(wrong_answer(&bad, "io", &[]).is_some(), "another kind");
    assert!(wrong_answer(&bad, "format", &["no such words"]).is_some(), "other words");
    assert_eq!(wrong_answer(&bad, "format", &["91"]), None);
}

#[test]
fn the_cast_has_its_counts() {
    let count = |name: &str| {
        let person = people::cast().into_iter().find(|p| p.name == name).expect("in the cast");
        let (document, _) = person.make();
        (document.meshes[0].1[0].indices.len() / 3, document.joints.len())
    };
    let (mara, joints) = count("mara");
    assert!(mara.abs_diff(2620) <= 52, "the paper's 2,620 triangles within 2 %: {mara}");
    assert!((20..=60).contains(&joints));
    assert!(count("noor").0 >= 20_000);
    for (kind, name) in beast::KINDS {
        let document = beast::make(kind, name).0;
        assert!((900..=1200).contains(&(document.meshes[0].1[0].indices.len() / 3)), "{name}");
        assert_eq!(document.joints.len(), 44, "{name}");
    }
}

/// Every directed edge once, and its other direction once: the surfaces are closed.
#[test]
fn characters_are_closed_surfaces() {
    let documents =
        people::cast().into_iter().map(|p| p.make().0).chain(beast::KINDS.map(|(k, n)| beast::make(k, n).0));
    for document in documents.collect::<Vec<_>>() {
        let p = &document.meshes[0].1[0];
        let at = |i: u32| p.positions[i as usize].map(f32::to_bits);
        let mut edges = BTreeSet::new();
        for t in p.indices.chunks_exact(3) {
            for k in 0..3 {
                assert!(edges.insert((at(t[k]), at(t[(k + 1) % 3]))), "{}: an edge twice", document.nodes[0].name);
            }
        }
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "{}: an open edge", document.nodes[0].name);
    }
}

#[test]
fn loops_are_closed_and_weights_add_up() {
    for person in people::cast() {
        let (document, _) = person.make();
        for clip in &document.clips {
            for (_, curve) in &clip.curves {
                match curve {
                    crowd_fixtures::glb::Curve::Rotation(q) => assert_eq!(q[0], q[q.len() - 1]),
                    crowd_fixtures::glb::Curve::Translation(t) => assert_eq!(t[0], t[t.len() - 1]),
                }
            }
        }
        for w in &document.meshes[0].1[0].weights {
            assert!((w.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        }
    }
}
