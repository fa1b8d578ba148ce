//! A fresh folder with some fixtures in it, and `crowdbake` run in it.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Small characters that bake in a moment.
pub const TUBE: &str = "straight_tube_should_keep_its_elbow.glb";
pub const SPHERE: &str = "sphere_with_seam_and_poles.glb";
pub const TWO_MATERIALS: &str = "two_materials_should_keep_their_border.glb";
pub const TRIANGLE: &str = "smallest_character_should_stay_one_triangle.glb";

/// What a run did.
#[derive(Debug)]
pub struct Done {
    pub code: u8,
    pub out: String,
    pub err: String,
}

impl Done {
    /// The run, which must have ended with `code`.
    #[track_caller]
    pub fn expect(self, code: u8) -> Self {
        assert_eq!(self.code, code, "stdout:\n{}\nstderr:\n{}", self.out, self.err);
        self
    }

    /// The run, whose talk must hold all of `parts`.
    #[track_caller]
    pub fn says(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.err.contains(part), "no {part:?} in:\n{}", self.err);
        }
        self
    }

    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).expect("stdout is one JSON document")
    }
}

/// A temporary folder that goes away with the test.
pub struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("the system has a temporary folder") }
    }

    /// A folder with fixtures copied into it.
    pub fn with(fixtures: &[&str]) -> Self {
        let bench = Self::new();
        for fixture in fixtures {
            bench.copy(fixture, fixture);
        }
        bench
    }

    pub fn copy(&self, fixture: &str, name: &str) {
        let to = self.path(name);
        std::fs::create_dir_all(to.parent().expect("a file lies in a folder")).expect("the folder is ours");
        std::fs::copy(crowd_tests::folders::fixtures().join("good").join(fixture), to).expect("the fixture exists");
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).expect("the folder is ours");
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Names of all files and folders, sorted.
    pub fn listing(&self) -> Vec<String> {
        listing(self.folder.path())
    }

    /// Runs the library in this process. Words that begin with `@` are paths in this folder.
    pub fn run(&self, words: &[&str]) -> Done {
        let (mut out, mut err) = (Vec::new(), Vec::new());
        let code = crowdbake::run(self.arguments(words), &mut out, &mut err);
        let text = |bytes| String::from_utf8(bytes).expect("the program speaks UTF-8");
        Done { code, out: text(out), err: text(err) }
    }

    /// The real program, ready to be run with these words.
    pub fn program(&self, words: &[&str]) -> std::process::Command {
        let mut command = std::process::Command::new(program());
        command.args(self.arguments(words).iter().skip(1)).current_dir(self.folder.path());
        command
    }

    /// Runs the real program to its end.
    pub fn run_program(&self, words: &[&str]) -> Done {
        let output = self.program(words).output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("the program speaks UTF-8");
        let code = output.status.code().expect("the program was not killed");
        Done { code: code as u8, out: text(output.stdout), err: text(output.stderr) }
    }

    fn arguments(&self, words: &[&str]) -> Vec<std::ffi::OsString> {
        let word = |word: &&str| match word.strip_prefix('@') {
            Some(name) => self.path(name).into_os_string(),
            None => OsStr::new(word).to_owned(),
        };
        std::iter::once("crowdbake".into()).chain(words.iter().map(word)).collect()
    }
}

pub fn listing(folder: &Path) -> Vec<String> {
    let items = std::fs::read_dir(folder).expect("the folder is ours");
    let mut names: Vec<String> =
        items.map(|item| item.expect("the folder is ours").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// The program beside this test: `target/release/deps/cli-...` is the test, `target/release/crowdbake` the program.
fn program() -> PathBuf {
    let test = std::env::current_exe().expect("the test has a path");
    let folder = test.parent().and_then(Path::parent).expect("tests lie in a folder of the target folder");
    let program = folder.join(format!("crowdbake{}", std::env::consts::EXE_SUFFIX));
    assert!(
        program.is_file(),
        "{} is missing: run `cargo build --release -p crowdbake --bins` first, as tests/run.sh does",
        program.display()
    );
    program
}
