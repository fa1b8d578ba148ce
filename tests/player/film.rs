//! Films: ffmpeg is another program, so a stand-in on the path says what it was told and given.

#![cfg(unix)]

use crate::{Scene, crowdplay, player, stand_in};
use std::os::unix::fs::PermissionsExt;
use std::process::Command;
use std::time::{Duration, Instant};

const FRAMES: [&str; 9] = ["--headless", "--count", "9", "--size", "65x35", "--backend", "cpu", "--frames", "3"];

/// The real program with that ffmpeg, ready to film into `name`.
fn filming(scene: &Scene, name: &str, more: &[&str]) -> Command {
    let mut command = player();
    let path = std::env::var("PATH").unwrap_or_default();
    command.env("PATH", format!("{}:{path}", scene.path("bin"))).current_dir(scene.folder());
    command.args([&scene.pack()]).args(FRAMES).args(["--out", name]).args(more);
    command
}

fn left_over(scene: &Scene) -> Vec<String> {
    scene.files().into_iter().filter(|name| name.starts_with(".crowdplay-")).collect()
}

#[test]
fn ffmpeg_gets_every_frame_and_its_film_takes_its_place_at_the_end() {
    let scene = Scene::new();
    stand_in(&scene, "printf '%s\\n' \"$@\" > words\ncat > pictures\nprintf film > \"$last\"");
    for (name, more) in [("a.mp4", &["--dt", "0.1"][..]), ("b.GIF", &[])] {
        let ran = filming(&scene, name, more).output().expect("the program starts");
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        assert_eq!(std::fs::read(scene.file(name)).expect("the film is there"), b"film");
        let words = std::fs::read_to_string(scene.file("words")).expect("ffmpeg ran");
        let words: Vec<&str> = words.lines().collect();
        let after = |word: &str| words[words.iter().position(|w| *w == word).expect("the word is there") + 1];
        assert_eq!(after("-framerate"), if more.is_empty() { "30.0000" } else { "10.0000" });
        assert_eq!(words.contains(&"yuv420p"), name == "a.mp4", "{words:?}");
        let last = std::path::Path::new(words[words.len() - 1]);
        assert_eq!(
            last.extension().map(std::ffi::OsStr::to_ascii_lowercase),
            std::path::Path::new(name).extension().map(std::ffi::OsStr::to_ascii_lowercase)
        );
        assert!(last.file_name().is_some_and(|file| file != name), "under another name until it is whole");
        assert_eq!(left_over(&scene), Vec::<String>::new());
    }
    // The same bytes that go to files, and the same rights that files get.
    let out = scene.path("f%d.png");
    let ran = crowdplay(&[&[scene.pack().as_str()][..], &FRAMES, &["--out", &out]].concat());
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let frames: Vec<u8> =
        (0..3).flat_map(|i| std::fs::read(scene.file(&format!("f{i}.png"))).expect("a frame")).collect();
    assert!(frames == std::fs::read(scene.file("pictures")).expect("ffmpeg ran"));
    let mode = |name: &str| std::fs::metadata(scene.file(name)).expect("it is there").permissions().mode();
    assert_eq!(mode("a.mp4"), mode("f0.png"));
}

#[test]
fn a_film_goes_where_a_link_leads_and_into_a_pipe() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let scene = Scene::new();
    stand_in(&scene, "printf %s \"$last\" > words\ncat > /dev/null\nprintf film > \"$last\"");
    let film = |name: &str| {
        let ran = filming(&scene, name, &[]).output().expect("the program starts");
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    };
    std::fs::create_dir(scene.file("deep")).expect("the folder is ours");
    std::fs::write(scene.file("deep/real"), "old").expect("the folder is there");
    symlink("deep/real", scene.file("link.mp4")).expect("the folder is ours");
    film("link.mp4");
    assert!(scene.file("link.mp4").is_symlink(), "the link was replaced");
    assert_eq!(std::fs::read(scene.file("deep/real")).expect("it is there"), b"film");
    let unfinished = std::fs::read_to_string(scene.file("words")).expect("ffmpeg ran");
    assert!(unfinished.contains("/deep/.crowdplay-") && unfinished.ends_with(".mp4"), "{unfinished}");
    assert_eq!(std::fs::read_dir(scene.file("deep")).expect("it is there").count(), 1);

    let made = Command::new("mkfifo").arg(scene.file("pipe.mp4")).status().expect("coreutils are there");
    assert!(made.success());
    // Opened for reading and writing, a pipe waits for nobody; what is written fits into it.
    let mut pipe = std::fs::File::options().read(true).write(true).open(scene.file("pipe.mp4")).expect("it is ours");
    film("pipe.mp4");
    let kind = std::fs::symlink_metadata(scene.file("pipe.mp4")).expect("it is there").file_type();
    assert!(kind.is_fifo(), "the pipe was replaced");
    let mut read = [0; 4];
    std::io::Read::read_exact(&mut pipe, &mut read).expect("a film was written");
    assert_eq!(&read, b"film");
    assert_eq!(left_over(&scene), Vec::<String>::new());
    let unfinished = std::fs::read_to_string(scene.file("words")).expect("ffmpeg ran");
    assert!(!std::path::Path::new(&unfinished).exists(), "{unfinished} is left");

    symlink("gone/a.mp4", scene.file("nowhere.mp4")).expect("the folder is ours");
    let ran = filming(&scene, "nowhere.mp4", &[]).output().expect("the program starts");
    assert_eq!(ran.status.code(), Some(3), "{}", String::from_utf8_lossy(&ran.stderr));
}

/// A name that standard output goes by is no folder's.
#[test]
fn a_folder_called_like_standard_output_is_in_nobodys_way() {
    let scene = Scene::new();
    std::fs::create_dir(scene.file("-")).expect("the folder is ours");
    let mut command = player();
    command.current_dir(scene.folder()).arg(scene.pack()).args(&FRAMES[..7]).args(["--frames", "1", "--report", "-"]);
    let ran = command.output().expect("the program starts");
    assert!(ran.status.success() && ran.stdout.starts_with(b"{"), "{}", String::from_utf8_lossy(&ran.stderr));
}

#[test]
fn an_ffmpeg_that_dies_is_quoted_and_the_old_film_stays() {
    let scene = Scene::new();
    for lines in [
        "head -c 50 > /dev/null; echo half > \"$last\"; echo 'no such codec' >&2; exit 3",
        "cat > /dev/null; echo half > \"$last\"; echo 'no such codec' >&2; exit 1",
    ] {
        stand_in(&scene, lines);
        std::fs::write(scene.file("a.mp4"), "old").expect("the folder is there");
        let ran = filming(&scene, "a.mp4", &["--quiet"]).output().expect("the program starts");
        let talk = String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(3), "{talk}");
        assert!(talk.contains("no such codec") && talk.contains("a.mp4"), "{talk}");
        assert_eq!(std::fs::read(scene.file("a.mp4")).expect("the old film is there"), b"old");
        assert_eq!(left_over(&scene), Vec::<String>::new());
    }
}

#[test]
fn a_killed_run_leaves_no_half_film_under_its_name() {
    let scene = Scene::new();
    // It does not end before it is let go, so that the run cannot have ended either.
    std::fs::create_dir_all(scene.file("bin")).expect("a temporary folder can be written to");
    std::fs::write(scene.file("bin/hold"), "").expect("the folder is there");
    let held = "cat > \"$last\"; while [ -e bin/hold ]; do sleep 0.05; done; rm bin/began";
    stand_in(&scene, &format!("echo began > bin/began; {held}"));
    let mut run = filming(&scene, "a.mp4", &["--dt", "0.01"]).args(["--quiet"]).spawn().expect("the program starts");
    let began = || std::fs::read(scene.file("bin/began")).is_ok_and(|words| !words.is_empty());
    wait_for(began);
    run.kill().expect("the child is ours");
    let was_killed = run.wait().expect("the child is ours").code().is_none();
    assert!(was_killed && !scene.file("a.mp4").exists());
    // What it began ends before its folder goes.
    std::fs::remove_file(scene.file("bin/hold")).expect("the file is ours");
    wait_for(|| !began());
}

fn wait_for(happened: impl Fn() -> bool) {
    let since = Instant::now();
    while !happened() {
        assert!(since.elapsed() < Duration::from_secs(60), "it takes too long");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_film_is_made_by_the_ffmpeg_that_is_here_or_refused_without() {
    let scene = Scene::new();
    let film = scene.path("film.mp4");
    let ran = crowdplay(&[&[scene.pack().as_str()][..], &FRAMES, &["--out", &film]].concat());
    if ran.code == 0 {
        assert!(std::fs::metadata(&film).is_ok_and(|file| file.len() > 100));
    } else {
        assert_eq!(ran.code, 5, "{}", ran.stderr);
        assert!(ran.stderr.contains("ffmpeg") && ran.stderr.contains("frame-%04d.png"), "{}", ran.stderr);
        assert!(!std::path::Path::new(&film).exists());
    }
    assert_eq!(left_over(&scene), Vec::<String>::new(), "nothing half-written stays");
}

#[test]
fn a_percent_sign_is_written_twice_and_a_film_has_no_number() {
    let scene = Scene::new();
    stand_in(&scene, "cat > /dev/null; printf film > \"$last\"");
    let ran = filming(&scene, "50%%.mp4", &[]).output().expect("the program starts");
    assert!(ran.status.success() && scene.file("50%.mp4").exists(), "{}", String::from_utf8_lossy(&ran.stderr));
    for (name, taught) in [("50%.mp4", "%%"), ("a-%d.mp4", "without a number"), ("a%03d.gif", "without a number")] {
        let ran = filming(&scene, name, &[]).output().expect("the program starts");
        let talk = String::from_utf8_lossy(&ran.stderr);
        assert!(ran.status.code() == Some(2) && talk.contains(taught), "{talk}");
    }
}
