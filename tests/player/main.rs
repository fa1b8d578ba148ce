//! The player as a person or a script meets it: words in; pictures, reports, exit codes and talk out.

mod baked;
mod bench;
mod compare;
mod figures;
mod film;
mod lost;
mod memory;
mod motion;
mod moving;
mod outputs;
mod pictures;
mod views;
mod window;
mod words;

use std::path::{Path, PathBuf};

/// What a run came to.
pub(crate) struct Ran {
    pub(crate) code: u8,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

/// Runs the player in this process.
pub(crate) fn crowdplay(words: &[&str]) -> Ran {
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    let words: Vec<&str> = std::iter::once("crowdplay").chain(words.iter().copied()).collect();
    let code = crowdplay::run(words, &mut stdout, &mut stderr);
    Ran { code, stdout, stderr: String::from_utf8(stderr).expect("the player talks in UTF-8") }
}

/// The real program, beside this test: `target/release/deps/player-...` is the test, `target/release/crowdplay` the program.
pub(crate) fn player() -> std::process::Command {
    let test = std::env::current_exe().expect("the test has a path");
    let folder = test.parent().and_then(Path::parent).expect("tests lie in a folder of the target folder");
    let program = folder.join(format!("crowdplay{}", std::env::consts::EXE_SUFFIX));
    assert!(
        program.is_file(),
        "{} is missing: run `cargo build --release -p crowdplay --bins` first, as tests/run.sh does",
        program.display()
    );
    std::process::Command::new(program)
}

/// A folder `bin` with a program called ffmpeg that runs these lines.
#[cfg(unix)]
pub(crate) fn stand_in(scene: &Scene, lines: &str) {
    use std::os::unix::fs::PermissionsExt;
    let folder = scene.file("bin");
    std::fs::create_dir_all(&folder).expect("a temporary folder can be written to");
    let program = folder.join("ffmpeg");
    std::fs::write(&program, format!("#!/bin/sh\nfor last; do :; done\n{lines}\n")).expect("the folder is there");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).expect("the file is ours");
}

/// A folder of its own with a pack of two posts in it.
pub(crate) struct Scene {
    folder: tempfile::TempDir,
}

impl Scene {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("there is a temporary folder");
        figures::write_pack(&folder.path().join("posts.crowdpack"), &figures::TWO_POSTS);
        Self { folder }
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn pack(&self) -> String {
        self.path("posts.crowdpack")
    }

    pub(crate) fn path(&self, name: &str) -> String {
        self.file(name).to_str().expect("temporary folders have plain names").to_owned()
    }

    /// Names of the files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder()).expect("the folder is there");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("readable").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Runs `posts.crowdpack --headless` with more words; it must succeed.
    pub(crate) fn render(&self, words: &[&str]) -> Ran {
        let pack = self.pack();
        let all: Vec<&str> = [pack.as_str(), "--headless"].into_iter().chain(words.iter().copied()).collect();
        let ran = crowdplay(&all);
        assert_eq!(ran.code, 0, "{all:?}: {}", ran.stderr);
        ran
    }

    /// The report of such a run.
    pub(crate) fn report(&self, words: &[&str]) -> serde_json::Value {
        let words: Vec<&str> = words.iter().copied().chain(["--report", "-"]).collect();
        serde_json::from_slice(&self.render(&words).stdout).expect("standard output is the report and nothing else")
    }

    /// The picture of such a run, one sample a pixel.
    pub(crate) fn picture(&self, words: &[&str]) -> image::RgbImage {
        let words: Vec<&str> = words.iter().copied().chain(["--msaa", "1", "--out", "-"]).collect();
        let png = self.render(&words).stdout;
        image::load_from_memory(&png).expect("standard output is a PNG and nothing else").to_rgb8()
    }
}
