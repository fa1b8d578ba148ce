//! A device that is lost: a library in the place of Vulkan's loses it on demand.

#![cfg(unix)]

use crate::{Scene, player, stand_in};
use std::path::PathBuf;
use std::process::Command;

/// The loader that the system would take.
fn vulkan() -> PathBuf {
    let names = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib", "/lib"];
    let named = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let folders = std::env::split_paths(&named).chain(names.map(PathBuf::from));
    let found = folders.map(|folder| folder.join("libvulkan.so.1")).find(|file| file.is_file());
    found.expect("GPU tests need Vulkan's loader, libvulkan.so.1; opt out aloud with CROWD_NO_GPU=1")
}

/// A folder with the stand-in in it.
fn losing(scene: &Scene) -> PathBuf {
    let folder = scene.file("vulkan");
    std::fs::create_dir_all(&folder).expect("a temporary folder can be written to");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/player/lost.c");
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-o"]).arg(folder.join("libvulkan.so.1")).arg(source).arg("-ldl");
    let made = compiler.output().expect("cc is there, or this test is ignored");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    folder
}

/// Lets that library lose the program's device.
pub(crate) fn lose(command: &mut Command, scene: &Scene, (what, number): (&str, u32)) {
    command.env("LD_LIBRARY_PATH", losing(scene)).env("CROWD_VULKAN", vulkan()).env(what, number.to_string());
    command.env("WGPU_BACKEND", "vulkan");
}

/// One message, and the exit code that the help promises.
pub(crate) fn expect_told(code: Option<i32>, talk: &str, case: &str) {
    assert_eq!(code, Some(5), "{case}: {talk}");
    assert_eq!(talk.matches("crowdplay: error: ").count(), 1, "{case}: {talk}");
    for words in ["the GPU device was lost after ", "run it again", "--backend cpu"] {
        assert!(talk.contains(words), "{case}: {words:?} is missing: {talk}");
    }
    assert!(!talk.contains("panicked"), "{case}: {talk}");
}

/// The first two of these are tried with everything.
const LOSSES: [(&str, u32); 5] = [
    ("CROWD_LOSE_SUBMIT", 6),
    ("CROWD_LOSE_WAIT", 5),
    ("CROWD_LOSE_SUBMIT", 1),
    ("CROWD_LOSE_WAIT", 1),
    ("CROWD_LOSE_WAIT", 8),
];

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1 opts out of GPU tests")]
#[cfg_attr(crowd_no_shim, ignore = "a lost device is made by a C library on Linux, and here is no cc")]
#[test]
fn a_lost_device_is_told_once_and_leaves_no_picture_behind() {
    let scene = Scene::new();
    stand_in(&scene, "cat > /dev/null\nprintf film > \"$last\"");
    let path = format!("{}:{}", scene.path("bin"), std::env::var("PATH").unwrap_or_default());
    let size = ["--count", "9", "--size", "64x36"];
    let headless = ["--headless", "--frames", "12"];
    let runs: [(&str, Vec<&str>); 6] = [
        ("headless", [&headless[..], &["--report", "r.json"]].concat()),
        ("a picture at the end", [&headless[..], &["--out", "a.png"]].concat()),
        ("a film", [&headless[..], &["--out", "a.mp4"]].concat()),
        ("the static floor", [&headless[..], &["--technique", "static-floor"]].concat()),
        ("a second camera", [&headless[..], &["--reference-camera", "--out", "b.png"]].concat()),
        ("bench", vec!["--ab", "b3,bucketed", "--rounds", "9", "--csv", "a.csv"]),
    ];
    let losses = |case| LOSSES.into_iter().take(if case == "headless" { LOSSES.len() } else { 2 });
    for ((case, words), loss) in runs.iter().flat_map(|run| losses(run.0).map(move |loss| (run, loss))) {
        let mut command = player();
        lose(&mut command, &scene, loss);
        command.env("PATH", &path).current_dir(scene.folder());
        if *case == "bench" {
            command.arg("bench");
        }
        let ran = command.arg(scene.pack()).args(size).args(words).output().expect("the program starts");
        expect_told(ran.status.code(), &String::from_utf8_lossy(&ran.stderr), &format!("{case}, {loss:?}"));
        assert_eq!(scene.files(), ["bin", "posts.crowdpack", "vulkan"], "{case}, {loss:?}");
    }
}

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1 opts out of GPU tests")]
#[cfg_attr(crowd_no_shim, ignore = "a lost device is made by a C library on Linux, and here is no cc")]
#[test]
fn the_number_of_frames_that_were_done_is_told() {
    let scene = Scene::new();
    for (number, words) in [(1, "after 0 frames "), (2, "after 1 frame "), (6, "after 5 frames ")] {
        let mut command = player();
        lose(&mut command, &scene, ("CROWD_LOSE_SUBMIT", number));
        command.arg(scene.pack()).args(["--headless", "--frames", "9", "--count", "9", "--size", "64x36"]);
        let ran = command.output().expect("the program starts");
        let talk = String::from_utf8_lossy(&ran.stderr);
        assert!(talk.contains(words), "{talk}");
    }
    // Without a loss the same library is no hindrance.
    let mut command = player();
    lose(&mut command, &scene, ("CROWD_LOSE_SUBMIT", 1000));
    command.arg(scene.pack()).args(["--headless", "--frames", "2", "--count", "9", "--size", "64x36"]);
    let ran = command.output().expect("the program starts");
    assert_eq!(ran.status.code(), Some(0), "{}", String::from_utf8_lossy(&ran.stderr));
}
