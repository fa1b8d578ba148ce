//! Where pictures and reports go: never over an input, never in the place of a device, never half.

use crate::words::TINY;
use crate::{Scene, crowdplay};

fn run_with(scene: &Scene, words: &[&str]) -> crate::Ran {
    let pack = scene.pack();
    crowdplay(&[&[pack.as_str(), "--headless"], words, &TINY].concat())
}

#[test]
fn output_that_cannot_be_written_is_code_3_and_leaves_nothing() {
    let scene = Scene::new();
    std::fs::write(scene.file("file"), "").unwrap();
    let lost = scene.path("file/out");
    for option in ["--out", "--report"] {
        let ran = run_with(&scene, &[option, &lost]);
        assert_eq!(ran.code, 3, "{option}: {}", ran.stderr);
        assert!(ran.stderr.contains(&lost), "{}", ran.stderr);
    }
    assert_eq!(scene.files(), ["file", "posts.crowdpack"]);
}

#[test]
fn pictures_are_png_alone() {
    let scene = Scene::new();
    for name in ["a.jpg", "a.JPEG", "f-%03d.webp", "%d.bmp", "deep/a.svg"] {
        let ran = run_with(&scene, &["--frames", "2", "--out", &scene.path(name)]);
        assert!(ran.code == 2 && ran.stderr.contains("--out") && ran.stderr.contains(".png"), "{name}: {}", ran.stderr);
        let pack = scene.pack();
        let ran = crowdplay(&[&pack, "--frames", "1", "--screenshot", &scene.path(name)]);
        let names = [name, "--screenshot", ".png"];
        assert!(ran.code == 2 && names.iter().all(|word| ran.stderr.contains(word)), "{name}: {}", ran.stderr);
    }
    for name in ["a.mp4", "a.GIF", "-"] {
        let ran = crowdplay(&[&scene.pack(), "--frames", "1", "--screenshot", name]);
        assert!(ran.code == 2 && ran.stderr.contains("--headless --out"), "{name}: {}", ran.stderr);
    }
    assert_eq!(scene.files(), ["posts.crowdpack"]);
    // No ending says nothing else.
    scene.render(&[&["--out", &scene.path("plain")][..], &TINY].concat());
    assert!(std::fs::read(scene.file("plain")).unwrap().starts_with(b"\x89PNG"));
}

/// What cannot be written is found out before anything is drawn, and nothing is made on the way.
#[test]
fn outputs_are_tried_before_the_work() {
    let scene = Scene::new();
    for folder in ["a.png", "a.mp4", "a.json", "a.txt"] {
        std::fs::create_dir(scene.file(folder)).unwrap();
    }
    std::fs::write(scene.file("file"), "").unwrap();
    let long = scene.path(&format!("new/{}/a.png", "n".repeat(300)));
    let [png, film, json, text, below] = ["a.png", "a.mp4", "a.json", "a.txt", "file/b/c"].map(|name| scene.path(name));
    let pack = scene.pack();
    let table: &[&[&str]] = &[
        &["--out", &png],
        &["--out", &film],
        &["--report", &json],
        &["--record-camera", &text],
        &["--report", &below],
        &["--out", &long],
        #[cfg(target_os = "linux")]
        &["--report", "/proc/a.json"],
        #[cfg(target_os = "linux")]
        &["--out", "/proc/new/frame-%d.png"],
    ];
    for words in table {
        let ran = run_with(&scene, &[&["--frames", "1000000"], *words].concat());
        assert!(ran.code == 3 && !ran.stderr.contains("instances"), "{words:?}: {}", ran.stderr);
    }
    let ran = crowdplay(&["bench", &pack, "--ab", "b1,bucketed", "--csv", &json]);
    assert!(ran.code == 3 && ran.stderr.contains("a folder"), "{}", ran.stderr);
    assert_eq!(scene.files(), ["a.json", "a.mp4", "a.png", "a.txt", "file", "posts.crowdpack"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("gone", scene.file("link")).unwrap();
        let ran = run_with(&scene, &["--frames", "1000000", "--out", &scene.path("link/a.mp4")]);
        assert!(ran.code == 3 && ran.stderr.contains("leads nowhere"), "{}", ran.stderr);
    }
}

#[test]
fn missing_folders_are_made() {
    let scene = Scene::new();
    scene.render(
        &[&["--out", &scene.path("new/folder/x.png"), "--report", &scene.path("other/x.json")], &TINY[..]].concat(),
    );
    assert!(scene.file("new/folder/x.png").is_file() && scene.file("other/x.json").is_file());
}

#[test]
fn sequences_are_numbered_from_zero() {
    let scene = Scene::new();
    let out = scene.path("film-%03d.png");
    scene.render(&[&["--frames", "3", "--out", &out][..], &TINY].concat());
    assert_eq!(scene.files(), ["film-000.png", "film-001.png", "film-002.png", "posts.crowdpack"]);
}

#[test]
fn no_output_replaces_an_input_or_another_output() {
    let scene = Scene::new();
    std::fs::create_dir(scene.file("folder")).unwrap();
    std::fs::write(scene.file("crowd.txt"), "# crowd layout v1\n0 0 0 0 1 0 0 0\n").unwrap();
    std::fs::write(scene.file("film-2.png"), "# crowd camera path v1\n0 0 2 9 0 1 0 45\n").unwrap();
    let pack = scene.pack();
    let [pack_again, crowd, film, film_2, a, a_again] =
        ["folder/../posts.crowdpack", "crowd.txt", "film-%d.png", "film-2.png", "a", "not/there/../../a"]
            .map(|name| scene.path(name));
    let before = std::fs::read(&pack).unwrap();
    let table: &[(&[&str], [&str; 2])] = &[
        (&["--out", &pack], ["--out", "the pack"]),
        (&["--report", &pack], ["--report", "the pack"]),
        (&["--out", &pack_again], [&pack_again, &pack]),
        (&["--layout", &crowd, "--out", &crowd], ["--out", "--layout"]),
        (&["--layout", &crowd, "--report", &crowd], ["--report", "--layout"]),
        (&["--camera-path", &film_2, "--report", &film_2], ["--report", "--camera-path"]),
        (&["--camera-path", &film_2, "--frames", "3", "--out", &film], [&film_2, "--camera-path"]),
        (&["--report", &film_2, "--frames", "3", "--out", &film], [&film_2, "--report"]),
        (&["--report", &a, "--out", &a_again], [&a, &a_again]),
    ];
    for (words, both) in table {
        let ran = run_with(&scene, words);
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.stderr);
        assert!(both.iter().all(|one| ran.stderr.contains(one)), "{words:?}: {}", ran.stderr);
    }
    assert!(std::fs::read(&pack).unwrap() == before);
    assert_eq!(scene.files(), ["crowd.txt", "film-2.png", "folder", "posts.crowdpack"]);
    // Frames 0 and 1 are not frame 2.
    scene.render(&[&["--report", &film_2, "--frames", "2", "--out", &film][..], &TINY].concat());
}

#[test]
#[cfg(unix)]
fn links_are_followed() {
    let scene = Scene::new();
    std::fs::create_dir(scene.file("far")).unwrap();
    for (link, option) in [("link.png", "--out"), ("link.json", "--report")] {
        let real = format!("far/{link}");
        std::fs::write(scene.file(&real), "old").unwrap();
        std::os::unix::fs::symlink(&real, scene.file(link)).unwrap();
        scene.render(&[&[option, &scene.path(link)], &TINY[..]].concat());
        assert!(scene.file(link).is_symlink(), "{link} is a file now");
        assert_ne!(std::fs::read(scene.file(&real)).unwrap(), b"old");
    }
    // A link to the pack is the pack.
    std::os::unix::fs::symlink("posts.crowdpack", scene.file("again")).unwrap();
    assert_eq!(run_with(&scene, &["--out", &scene.path("again")]).code, 2);
}

#[test]
#[cfg(unix)]
fn pipes_are_written_to_and_stay() {
    use std::os::unix::fs::FileTypeExt;
    let scene = Scene::new();
    for (pipe, option, start) in [("pipe.png", "--out", b"\x89PNG"), ("pipe.json", "--report", b"{\n  ")] {
        let made = std::process::Command::new("mkfifo").arg(scene.file(pipe)).status().expect("every Unix has mkfifo");
        assert!(made.success());
        let path = scene.file(pipe);
        // Opened for both: neither side waits for the other, and what is written stays to be read.
        let mut reader = std::fs::OpenOptions::new().read(true).write(true).open(&path).unwrap();
        scene.render(&[&[option, &scene.path(pipe)], &TINY[..]].concat());
        assert!(std::fs::symlink_metadata(&path).unwrap().file_type().is_fifo(), "{pipe} is a file now");
        let mut first = [0; 4];
        std::io::Read::read_exact(&mut reader, &mut first).unwrap();
        assert_eq!(&first, start);
    }
}
