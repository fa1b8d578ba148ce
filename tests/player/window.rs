//! The window, opened in a display without a screen (Xvfb) on whatever Vulkan there is.

use crate::{Scene, player};
use image::RgbImage;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{AtomEnum, ClientMessageEvent, ConnectionExt, EventMask, ImageFormat, Window};
use x11rb::rust_connection::RustConnection;

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
        let number = number.trim();
        assert!(number.parse::<u32>().is_ok(), "Xvfb does not start, and says {number:?}: see what `Xvfb :9` says");
        Self { server, name: format!(":{number}") }
    }

    /// The player in a window on it, a point a pixel.
    fn start(&self, scene: &Scene, words: &[&str]) -> Player {
        Player::new(self.command(scene, words))
    }

    fn command(&self, scene: &Scene, words: &[&str]) -> Command {
        let mut command = player();
        command.env("DISPLAY", &self.name).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command.env("XDG_RUNTIME_DIR", scene.folder()).current_dir(scene.folder());
        command.env("WINIT_X11_SCALE_FACTOR", "1").arg(scene.pack()).args(words);
        command
    }

    /// Runs it to its end; it must succeed.
    fn show(&self, scene: &Scene, words: &[&str]) {
        let (code, talk) = self.start(scene, words).end();
        assert_eq!(code, Some(0), "{words:?}: {talk}");
    }

    /// Waits until that player's picture is on the screen, and finds its window.
    fn window_drawn(&self, player: &mut Player) -> (RustConnection, Window) {
        let (server, screen) = x11rb::connect(Some(&self.name)).expect("the server is ours");
        let root = server.setup().roots[screen].root;
        let since = Instant::now();
        loop {
            assert!(player.is_running() && since.elapsed() < PATIENCE, "it shows nothing");
            std::thread::sleep(Duration::from_millis(50));
            let tree = server.query_tree(root).expect("sent").reply().expect("there is a root");
            let shown = tree.children.into_iter().find(|window| shows_a_picture(&server, *window).unwrap_or(false));
            if let Some(window) = shown {
                return (server, window);
            }
        }
    }
}

/// Whether it is a window of the player's with more than a colour or two in it. Windows come and go: not all can be asked.
fn shows_a_picture(server: &RustConnection, window: Window) -> Option<bool> {
    let name = server.get_property(false, window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 64).ok()?.reply().ok()?;
    let size = server.get_geometry(window).ok()?.reply().ok()?;
    let image =
        server.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, size.width, size.height, !0).ok()?.reply().ok()?;
    let colours: std::collections::BTreeSet<&[u8]> = image.data.chunks_exact(4).collect();
    Some(name.value.starts_with(b"crowdplay") && colours.len() > 2)
}

/// A running player, listened to.
struct Player {
    child: Child,
    talk: JoinHandle<Vec<u8>>,
}

impl Player {
    fn new(mut command: Command) -> Self {
        let mut child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
        let mut said = child.stderr.take().expect("it was piped");
        let talk = std::thread::spawn(move || {
            let mut talk = Vec::new();
            // What came before a failure is worth having.
            let _ = said.read_to_end(&mut talk);
            talk
        });
        Self { child, talk }
    }

    fn is_running(&mut self) -> bool {
        self.child.try_wait().expect("the child is ours").is_none()
    }

    /// Exit code and talk, in good time.
    fn end(mut self) -> (Option<i32>, String) {
        let since = Instant::now();
        while self.is_running() {
            if since.elapsed() > PATIENCE {
                self.child.kill().expect("the child is ours");
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        let code = self.child.wait().expect("the child is ours").code();
        let talk = self.talk.join().expect("it only reads");
        (code, String::from_utf8_lossy(&talk).into_owned())
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // One that has ended cannot be killed, which is no trouble.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
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
    let still = [&crowd[..], &["--start", "2", "--time-scale", "0"]].concat();
    display.show(&scene, &[&still[..], &["--no-overlay", "--screenshot", "bare.png"]].concat());
    display.show(&scene, &[&still[..], &["--screenshot", "whole.png", "--report", "whole.json"]].concat());
    let report = std::fs::read(scene.file("whole.json")).expect("the report is there");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("it is JSON");
    // The best adapter need not be one that can draw to this display.
    let adapter = report["adapter"]["name"].as_str().expect("it names the adapter");
    let alike = ["--backend", "gpu", "--adapter", adapter, "--dt", "0", "--start", "2"];
    scene.render(&[&crowd[..], &alike, &["--out", &scene.path("plain.png")]].concat());
    let [plain, bare, whole] = ["plain.png", "bare.png", "whole.png"].map(|name| read(&scene, name));
    assert_eq!([bare.dimensions(), whole.dimensions()], [(700, 500); 2]);
    assert!(differing(&plain, &bare, 0..700) < 0.002, "{}", differing(&plain, &bare, 0..700));
    // Numbers and controls on the left, times on the right, the crowd between them.
    assert!(differing(&bare, &whole, 10..320) > 0.9 && differing(&bare, &whole, 560..690) > 0.3);
    assert!(differing(&bare, &whole, 370..460) < 0.002);
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

/// The window's report counts what the headless one does: pictures of the window's size, and who simulates.
#[cfg_attr(any(crowd_no_gpu, crowd_no_display), ignore = "needs an adapter and Xvfb")]
#[test]
fn all_of_the_memory_is_counted_and_stays_within_what_may_be_taken() {
    let (display, scene) = (Display::new(), Scene::new());
    let size = ["--size", "640x400", "--msaa", "1", "--frames", "3", "--report", "seen.json"];
    let canvas_bytes = 2 * 2560 * 400;
    let flock = ["--flock", "60", "--simulate", "gpu"];
    let rows: &[(&[&str], u64)] = &[
        (&["--count", "3000"], 0),
        (&["--count", "3000", "--screenshot", "seen.png"], canvas_bytes),
        (&["--count", "3000", "--reference-camera"], canvas_bytes),
        (&flock, 0),
    ];
    for (row, pictures) in rows {
        display.show(&scene, &[&size[..], &["--skinning", "compute", "--vram", "15"], row].concat());
        let report = std::fs::read(scene.file("seen.json")).expect("the report is there");
        let report: serde_json::Value = serde_json::from_slice(&report).expect("it is JSON");
        let parts = report["gpu_memory"].as_object().expect("parts by name");
        let bytes = |name: &str| parts.get(name).and_then(serde_json::Value::as_u64);
        assert_eq!(bytes("picture"), Some(*pictures), "{row:?}: {parts:?}");
        assert_eq!(bytes("simulator").is_some_and(|bytes| bytes > 0), *row == flock, "{row:?}: {parts:?}");
        let taken = report["gpu_bytes"].as_u64().expect("a count");
        assert_eq!(parts.values().filter_map(serde_json::Value::as_u64).sum::<u64>(), taken, "{row:?}");
        assert!(taken <= 15 << 20, "{row:?}: {taken}");
        // A picture's room was kept free, whether or not it was needed.
        if *row != flock {
            assert!(taken + canvas_bytes - pictures + 100 > 15 << 20, "{row:?}: {taken}");
        }
    }
}

#[cfg_attr(any(crowd_no_gpu, crowd_no_display), ignore = "needs an adapter and Xvfb")]
#[test]
fn a_display_that_goes_away_ends_the_program() {
    let (mut display, scene) = (Display::new(), Scene::new());
    let mut run = display.start(&scene, &["--count", "4", "--size", "64x48"]);
    display.window_drawn(&mut run);
    display.server.kill().expect("the child is ours");
    let (code, talk) = run.end();
    assert!(code.is_some_and(|code| code != 0) && !talk.contains("panicked"), "{code:?}: {talk}");
}

#[cfg_attr(any(crowd_no_gpu, crowd_no_display), ignore = "needs an adapter and Xvfb")]
#[test]
fn a_window_that_is_closed_early_is_pictured_and_one_that_is_taken_away_is_not() {
    let (display, scene) = (Display::new(), Scene::new());
    let words = ["--count", "4", "--size", "64x48", "--frames", "1000000", "--screenshot"];
    let mut run = display.start(&scene, &[&words[..], &["closed.png"]].concat());
    let (server, window) = display.window_drawn(&mut run);
    ask_to_close(&server, window);
    let (code, talk) = run.end();
    assert!(code == Some(0) && talk.contains("closed after frame"), "{code:?}: {talk}");
    assert_eq!(read(&scene, "closed.png").dimensions(), (64, 48));

    let mut run = display.start(&scene, &[&words[..], &["gone.png"]].concat());
    let (server, window) = display.window_drawn(&mut run);
    server.destroy_window(window).expect("sent").check().expect("the window is there");
    let (code, talk) = run.end();
    assert!(code == Some(3) && talk.contains("gone.png") && !talk.contains("panicked"), "{code:?}: {talk}");
    assert!(!scene.file("gone.png").exists());
}

/// As a click on the window's cross does.
fn ask_to_close(server: &RustConnection, window: Window) {
    let [protocols, close] = ["WM_PROTOCOLS", "WM_DELETE_WINDOW"]
        .map(|name| server.intern_atom(false, name.as_bytes()).expect("sent").reply().expect("it has a number").atom);
    let event = ClientMessageEvent::new(32, window, protocols, [close, x11rb::CURRENT_TIME, 0, 0, 0]);
    server.send_event(false, window, EventMask::NO_EVENT, event).expect("sent").check().expect("the window is there");
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

#[cfg_attr(any(crowd_no_gpu, crowd_no_display), ignore = "needs an adapter and Xvfb")]
#[cfg_attr(crowd_no_shim, ignore = "a lost device is made by a C library on Linux, and here is no cc")]
#[cfg(unix)]
#[test]
fn a_lost_device_closes_the_window_with_a_word() {
    let (scene, display) = (Scene::new(), Display::new());
    for (what, number) in [("SUBMIT", 1), ("SUBMIT", 4), ("SUBMIT", 13), ("WAIT", 1), ("WAIT", 6)] {
        let what = format!("CROWD_LOSE_{what}");
        let mut command = display.command(&scene, &["--count", "9", "--size", "320x200", "--reference-camera"]);
        crate::lost::lose(&mut command, &scene, (&what, number));
        let (code, talk) = Player::new(command).end();
        crate::lost::expect_told(code, &talk, &format!("{what}={number}"));
    }
}
