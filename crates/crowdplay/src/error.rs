//! Why the player stopped, and the exit code that says so.

use crate::shell_word::shell_path;
use std::path::PathBuf;

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// What went wrong, with the evidence.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The pack was refused.
    #[error("{}", pack_words(path, source))]
    Pack {
        /// The file.
        path: PathBuf,
        /// Why.
        source: crowd_pack::Error,
    },
    /// An asset was given where a pack is needed.
    #[error(
        "{}: an asset, and a pack is needed; `crowdbake bake {} -o {}` makes one",
        path.display(),
        shell_path(path),
        shell_path(&path.with_extension("crowdpack"))
    )]
    NotBaked {
        /// The file.
        path: PathBuf,
    },
    /// A layout or a camera path was refused.
    #[error("{path}: {problem}", path = path.display())]
    Scene {
        /// The file.
        path: PathBuf,
        /// The reader's word.
        problem: String,
    },
    /// The crowd could not be set up.
    #[error("{}", stages_words(.0))]
    Stages(#[from] crowd_stages::Error),
    /// An option's value does not fit the pack or the other options.
    #[error("{option}: found {found}, allowed {allowed}")]
    Parameter {
        /// The option as typed.
        option: &'static str,
        /// Found.
        found: String,
        /// Allowed.
        allowed: String,
    },
    /// A file could not be written.
    #[error("{path}: {source}", path = path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// This machine lacks what was asked for: a GPU, a display.
    #[error("{what}; {remedy}")]
    Machine {
        /// What is missing, with the system's word.
        what: String,
        /// What the user can do.
        remedy: &'static str,
    },
    /// The device was lost while frames were drawn.
    #[error(
        "{adapter}: the GPU device was lost after {frames} frame{} ({why}): its driver gave it up, as when a frame takes too long, or restarted; \
         run it again, and if it is lost again draw less (--count, --budget, --size), update the driver, or use --headless --backend cpu",
        if *frames == 1 { "" } else { "s" }
    )]
    Lost {
        /// Its name.
        adapter: String,
        /// Frames that were done by then.
        frames: u32,
        /// wgpu's word.
        why: String,
    },
    /// What was asked for takes more GPU memory than it may.
    #[error(
        "--vram: {:.1} MB allowed; with a budget of {budget} {budget_in}, which is the least there is unless --budget says it, the crowd takes{table}\nuse a smaller --budget if you said one, fewer instances (--count), fewer characters, --skinning vertex, no --shadows, a smaller --size or --texture-side",
        *limit_bytes as f64 / crate::memory::MEGABYTE as f64
    )]
    Memory {
        /// Bytes allowed.
        limit_bytes: u64,
        /// N.
        budget: u32,
        /// What N counts.
        budget_in: &'static str,
        /// What takes how much, a line each.
        table: String,
    },
    /// Conditions of a bench do not hold.
    #[error("conditions that do not hold: {missed} of {of}")]
    Missed {
        /// How many.
        missed: usize,
        /// Of how many, counts and conditions multiplied.
        of: usize,
    },
}

/// The pack's file, once: what the system says of files names them itself.
fn pack_words(path: &std::path::Path, source: &crowd_pack::Error) -> String {
    match source {
        crowd_pack::Error::Io { .. } => source.to_string(),
        _ => format!("{}: {source}", path.display()),
    }
}

/// The library's word, or where that is about calls, what it means for who typed a command.
fn stages_words(error: &crowd_stages::Error) -> String {
    match error {
        // Devices are made here, with all that the adapter offers.
        crowd_stages::Error::Feature { technique, feature, .. } => {
            format!("{technique}: the adapter does not offer {feature}; use --technique reform")
        }
        _ => error.to_string(),
    }
}

/// Done.
pub const EXIT_DONE: u8 = 0;
/// Input refused: pack, layout, camera path.
pub const EXIT_INPUT: u8 = 1;
/// Usage: unknown option, value out of range (clap's number).
pub const EXIT_USAGE: u8 = 2;
/// Output failed.
pub const EXIT_OUTPUT: u8 = 3;
/// A condition of `crowdplay bench --assert` does not hold.
pub const EXIT_MISSED: u8 = 4;
/// The machine lacks a GPU (`--backend gpu`, `--adapter`) or a display (no `--headless`), or lost its GPU meanwhile.
pub const EXIT_MACHINE: u8 = 5;

impl Error {
    /// The exit code: whose fault it was.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Pack { .. } | Self::NotBaked { .. } | Self::Scene { .. } => EXIT_INPUT,
            Self::Stages(
                crowd_stages::Error::NoAdapter(_)
                | crowd_stages::Error::Limit { .. }
                | crowd_stages::Error::OutOfMemory { .. }
                | crowd_stages::Error::DeviceLost(_),
            ) => EXIT_MACHINE,
            Self::Stages(_) => EXIT_INPUT,
            Self::Parameter { .. } => EXIT_USAGE,
            Self::Output { .. } => EXIT_OUTPUT,
            Self::Machine { .. } | Self::Lost { .. } | Self::Memory { .. } => EXIT_MACHINE,
            Self::Missed { .. } => EXIT_MISSED,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn commands_that_are_suggested_can_be_pasted() {
        let words = |path: &str| Error::NotBaked { path: path.into() }.to_string();
        for (path, command) in [
            ("a/mara.glb", "`crowdbake bake a/mara.glb -o a/mara.crowdpack`"),
            ("é 1.glb", "`crowdbake bake 'é 1.glb' -o 'é 1.crowdpack'`"),
            ("it's.obj", r"`crowdbake bake 'it'\''s.obj' -o 'it'\''s.crowdpack'`"),
            ("$(rm x).glb", "`crowdbake bake '$(rm x).glb' -o '$(rm x).crowdpack'`"),
            ("-x.toml", "`crowdbake bake ./-x.toml -o ./-x.crowdpack`"),
        ] {
            assert!(words(path).contains(command), "{}", words(path));
        }
    }

    #[test]
    fn a_missing_feature_is_the_adapters_here_and_the_devices_in_the_library() {
        let technique = crowd_stages::Technique::Bucketed;
        let lacks = crowd_stages::Error::Feature { technique, feature: "F", remedy: "ask for it" };
        assert_eq!(lacks.to_string(), "bucketed: the device was made without F; ask for it");
        let words = Error::Stages(lacks).to_string();
        assert_eq!(words, "bucketed: the adapter does not offer F; use --technique reform");
    }

    #[test]
    fn every_fault_has_its_code() {
        let path = PathBuf::from("a");
        let io = || std::io::Error::other("x");
        let version = crowd_pack::Error::Version { found: 9, supported: 1 };
        let table = [
            (Error::Pack { path: path.clone(), source: version }, 1),
            (Error::NotBaked { path: path.clone() }, 1),
            (Error::Scene { path: path.clone(), problem: "p".into() }, 1),
            (Error::Stages(crowd_stages::Error::NoAdapter("n".into())), 5),
            (Error::Stages(crowd_stages::Error::Image { index: 0, problem: "p".into() }), 1),
            (Error::Parameter { option: "--clips", found: "f".into(), allowed: "a".into() }, 2),
            (Error::Output { path, source: io() }, 3),
            (Error::Machine { what: "w".into(), remedy: "r" }, 5),
            (Error::Lost { adapter: "a".into(), frames: 1, why: "w".into() }, 5),
            (Error::Memory { limit_bytes: 1, budget: 2, budget_in: "vertices", table: String::new() }, 5),
            (Error::Missed { missed: 1, of: 2 }, 4),
        ];
        for (error, code) in table {
            assert_eq!(error.exit_code(), code, "{error}");
        }
    }
}
