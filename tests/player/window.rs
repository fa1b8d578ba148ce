//! The window, opened in a display without a screen (Xvfb) on whatever Vulkan there is.

use crate::{Scene, player};
use image::RgbImage;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Most that a run of a few frames may take.
const PATIENCE: Duration = Duration::from_secs(120);

/// An X server of our own; it ends with the test.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn new() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1024x768x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb is there, or this test is ignored");
        let mut number = String::new();
        let said = server.stdout.take().expect("it was piped");
        BufReader::new(said).read_line(&mut number).expect("Xvfb says its number");
        Self { server, name: format!(":{}", number.trim()) }
    }

    /// The player in a window on it.
    fn start(&self, scene: &Scene, words: &[&str]) -> Child {
        let mut command = player();
        command.env("DISPLAY", &self.name).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command.env("XDG_RUNTIME_DIR", scene.folder()).current_dir(scene.folder());
        command.arg(scene.pack()).args(words).stderr(Stdio::piped()).spawn().expect("the program starts")
    }

    /// Runs it to its end; it must succeed.
    fn show(&self, scene: &Scene, words: &[&str]) {
        let (code, talk) = ended(self.start(scene, words));
        assert_eq!(code, Some(0), "{words:?}: {talk}");
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // One that has ended cannot be killed, which is no trouble.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Exit code and talk, in good time.
fn ended(mut run: Child) -> (Option<i32>, String) {
    let since = Instant::now();
    while run.try_wait().expect("the child is ours").is_none() {
        if since.elapsed() > PATIENCE {
            run.kill().expect("the child is ours");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let done = run.wait_with_output().expect("the child is ours");
    (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
}

fn read(scene: &Scene, name: &str) -> RgbImage {
    image::open(scene.file(name)).expect("the picture is there").to_rgb8()
}

/// Share of the pixels between two columns that differ by more than a rounding.
fn differing(a: &RgbImage, b: &RgbImage, columns: std::ops::Range<u32>) -> f64 {
    let near = |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 2);
    let pixels = a.enumerate_pixels().filter(|(x, ..)| columns.contains(x));
    let (count, differ) = pixels.fold((0u32, 0u32), |(count, differ), (x, y, pixel)| {
        (count + 1, differ + u32::from(!near(&pixel.0, &b.get_pixel(x, y).0)))
    });
    f64::from(differ) / f64::from(count)
}

#[cfg_attr(any(crowd_no_gpu, crowd_no_display), ignore = "needs an adapter and Xvfb")]
#[test]
fn a_window_shows_the_picture_that_headless_draws_and_the_overlay_over_it() {
    let (display, scene) = (Display::new(), Scene::new());
    let crowd = ["--count", "30", "--size", "700x500", "--msaa", "1", "--frames", "3"];
    scene.render(
        &[&crowd[..], &["--backend", "gpu", "--dt", "0", "--start", "2", "--out", &scene.path("plain.png")]].concat(),
    );
    let still = [&crowd[..], &["--start", "2", "--time-scale", "0"]].concat();
    display.show(&scene, &[&still[..], &["--no-overlay", "--screenshot", "bare.png"]].concat());
    display.show(&scene, &[&still[..], &["--screenshot", "whole.png", "--report", "whole.json"]].concat());
    let [plain, bare, whole] = ["plain.png", "bare.png", "whole.png"].map(|name| read(&scene, name));
    assert_eq!([bare.dimensions(), whole.dimensions()], [(700, 500); 2]);
    assert!(differing(&plain, &bare, 0..700) < 0.002, "{}", differing(&plain, &bare, 0..700));
    // Numbers and controls on the left, times on the right, the crowd between them.
    assert!(differing(&bare, &whole, 10..320) > 0.9 && differing(&bare, &whole, 560..690) > 0.3);
    assert!(differing(&bare, &whole, 370..460) < 0.002);
    let report = std::fs::read(scene.file("whole.json")).expect("the report is there");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("it is JSON");
    assert_eq!((report["frames"].as_array().map(Vec::len), &report["size"][0]), (Some(3), &700.into()));
    assert_eq!(report["frames"][2]["time_s"], 2.0);
}

#[cfg_attr(any(crowd_no_gpu, crowd_no_display), ignore = "needs an adapter and Xvfb")]
#[test]
fn every_technique_and_switch_is_shown() {
    let (display, scene) = (Display::new(), Scene::new());
    let few = ["--count", "12", "--frames", "2", "--msaa", "1"];
    let rows: &[&[&str]] = &[
        &["--size", "1x1"],
        &["--size", "200x90", "--technique", "b0", "--shadows", "2", "--fog", "40"],
        &["--size", "640x400", "--technique", "reform", "--view", "levels", "--reference-camera", "--freeze"],
        &["--size", "640x400", "--technique", "b4", "--fit", "eq1", "--motion-graph", "auto"],
        &["--size", "640x400", "--occlusion", "on", "--view", "occlusion", "--target-ms", "5", "--budget", "500"],
        &["--size", "640x400", "--lod-metric", "error", "--max-px", "0.5", "--budget-in", "triangles"],
        &["--size", "640x400", "--pose-rates", "1px", "--skinning", "compute", "--share-poses", "on", "--vram", "400"],
        &["--size", "640x400", "--backend", "cpu", "--screenshot", "cpu.png"],
        &["--size", "640x400", "--flock", "50", "--simulate", "gpu", "--camera-path", "orbit"],
    ];
    for row in rows {
        let few = if row.contains(&"--flock") { &few[2..] } else { &few[..] };
        display.show(&scene, &[few, row].concat());
    }
    assert_eq!(read(&scene, "cpu.png").dimensions(), (640, 400));
}

#[cfg_attr(any(crowd_no_gpu, crowd_no_display), ignore = "needs an adapter and Xvfb")]
#[test]
fn a_display_that_goes_away_ends_the_program() {
    let (mut display, scene) = (Display::new(), Scene::new());
    let mut run = display.start(&scene, &["--count", "4", "--size", "64x48"]);
    let mut talk = BufReader::new(run.stderr.take().expect("it was piped"));
    let mut line = String::new();
    while !line.contains("adapter:") {
        line.clear();
        assert!(talk.read_line(&mut line).expect("it talks") > 0, "it ended before it opened a GPU");
    }
    std::thread::sleep(Duration::from_millis(500));
    display.server.kill().expect("the child is ours");
    let (code, _) = ended(run);
    let rest = talk.lines().map_while(std::result::Result::ok).collect::<Vec<_>>().join("\n");
    assert!(code.is_some_and(|code| code != 0) && !rest.contains("panicked"), "{code:?}: {rest}");
}

#[test]
fn words_that_only_a_window_knows_are_refused_without_one() {
    let scene = Scene::new();
    for words in [&["--time-scale", "2"][..], &["--no-overlay"], &["--frames", "2", "--screenshot", "a.png"]] {
        let ran = crate::crowdplay(&[&[scene.pack().as_str(), "--headless"][..], words].concat());
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.stderr);
    }
    for words in [&["--dt", "0.1"][..], &["--screenshot", "a.png"], &["--time-scale", "-1"]] {
        let ran = crate::crowdplay(&[&[scene.pack().as_str()][..], words].concat());
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.stderr);
    }
}
