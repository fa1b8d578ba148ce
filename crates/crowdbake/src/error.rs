//! Why a command failed, wrapped once: the step, the character and the cause.

use crate::units::counted;
use std::path::PathBuf;

/// Exit code: everything was done.
pub const DONE: u8 = 0;
/// Exit code: an input was refused, or has no character or clip of the name asked for.
pub const INPUT_REFUSED: u8 = 1;
/// Exit code: the command line is wrong.
pub const USAGE: u8 = 2;
/// Exit code: an output could not be written.
pub const OUTPUT_FAILED: u8 = 3;
/// Exit code: a pack does not keep its promises.
pub const VERIFICATION_FAILED: u8 = 4;
/// Exit code: with `--strict`, a level asked for is not reached.
pub const TARGET_MISSED: u8 = 5;

/// The steps of the commands, in the order of a bake; their names stand in reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// Find the inputs.
    Plan,
    /// Read the asset.
    Load,
    /// Keep the clips asked for.
    SelectClips,
    /// Sample clips into palettes.
    Sample,
    /// Round normals and weights to what the pack stores.
    Quantize,
    /// Order the collapses and measure levels.
    Simplify,
    /// Bound every vertex in every frame.
    Bound,
    /// Choose, measure and store levels.
    Levels,
    /// Turn results into records.
    Assemble,
    /// Draw impostors.
    Impostors,
    /// Write the output.
    Write,
    /// Read a pack.
    Read,
    /// Choose a level of a pack.
    ChooseLevel,
    /// Draw.
    Draw,
    /// Judge levels against the original.
    Judge,
    /// Check a pack.
    Verify,
}

impl Step {
    /// The step's name, as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Load => "load",
            Self::SelectClips => "select-clips",
            Self::Sample => "sample",
            Self::Quantize => "quantize",
            Self::Simplify => "simplify",
            Self::Bound => "bound",
            Self::Levels => "levels",
            Self::Assemble => "assemble",
            Self::Impostors => "impostors",
            Self::Write => "write",
            Self::Read => "read",
            Self::ChooseLevel => "choose-level",
            Self::Draw => "draw",
            Self::Judge => "judge",
            Self::Verify => "verify",
        }
    }
}

/// A failure of a command: in which step, for which character, and why.
#[derive(Debug, thiserror::Error)]
#[error("{}{}: {source}", .character.as_ref().map(|c| format!("{c}: ")).unwrap_or_default(), .step.name())]
pub struct BakeError {
    /// The step that failed.
    pub step: Step,
    /// The character it worked on; `None` where it is about the whole run.
    pub character: Option<String>,
    /// Why; boxed, so that a result stays small.
    pub source: Box<Cause>,
}

impl BakeError {
    /// A failure that concerns one character.
    pub fn of(step: Step, character: &str, cause: impl Into<Cause>) -> Self {
        Self { step, character: Some(character.to_owned()), source: Box::new(cause.into()) }
    }

    /// A failure of the whole run.
    pub fn whole(step: Step, cause: impl Into<Cause>) -> Self {
        Self { step, character: None, source: Box::new(cause.into()) }
    }

    /// The exit code that this failure asks for.
    pub fn exit_code(&self) -> u8 {
        match &*self.source {
            Cause::Output { .. } => OUTPUT_FAILED,
            Cause::Pack(_) if self.step == Step::Write => OUTPUT_FAILED,
            Cause::OutputIsInput { .. }
            | Cause::OutputIsPartOfInput { .. }
            | Cause::OutputTwice { .. }
            | Cause::PictureTooLarge { .. } => USAGE,
            Cause::ChecksFailed { .. } => VERIFICATION_FAILED,
            Cause::TargetMissed { .. } => TARGET_MISSED,
            _ => INPUT_REFUSED,
        }
    }
}

/// What went wrong, with the evidence.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Cause {
    /// The asset was refused.
    #[error(transparent)]
    Source(#[from] crowd_source::Error),
    /// Sampling was refused.
    #[error(transparent)]
    Anim(#[from] crowd_anim::Error),
    /// Simplification was refused.
    #[error(transparent)]
    Lod(#[from] crowd_lod::Error),
    /// The pack was refused or not written.
    #[error(transparent)]
    Pack(#[from] crowd_pack::Error),
    /// A character cannot be judged.
    #[error(transparent)]
    Judge(#[from] crowd_judge::Error),
    /// An image did not decode.
    #[error(transparent)]
    Raster(#[from] crowd_raster::Error),
    /// The inputs do not name characters.
    #[error(transparent)]
    Plan(#[from] crate::plan::PlanError),
    /// `--clips` or `clips = [...]` asks for what is not there.
    #[error("clip `{asked}`: no clip of that name; the character has {found}")]
    ClipNotFound {
        /// Name or pattern asked for.
        asked: String,
        /// The clips there are.
        found: String,
    },
    /// Too much by our own rule.
    #[error("{what}: found {found}, allowed {allowed}; {remedy}")]
    Limit {
        /// Of what.
        what: &'static str,
        /// Found.
        found: u64,
        /// Allowed.
        allowed: u64,
        /// What the user can do.
        remedy: &'static str,
    },
    /// A manifest is text, the name is none.
    #[error("{}: the name is no UTF-8 text, which a manifest needs; rename the file", .path.display())]
    NameNotText {
        /// The file.
        path: PathBuf,
    },
    /// A clip moves or scales a joint beyond all sizes.
    #[error(
        "clip `{clip}` at {seconds:.2} s: joint `{joint}`: numbers up to {found:e}, allowed up to 1e6; the file moves or scales it there"
    )]
    PoseTooLarge {
        /// The clip.
        clip: String,
        /// When.
        seconds: f32,
        /// The joint's node.
        joint: String,
        /// The largest number of its matrix.
        found: f32,
    },
    /// All clips have the weight 0.
    #[error("all clips have the weight 0, one must count; see --clip-weight, or clip_weights in the manifest")]
    NothingWeighs,
    /// A measured number is none, or none that a pack holds.
    #[error(
        "{error}; numbers of this size come of very large or very small ones in the file: scale it to metres, and its texture coordinates to few textures"
    )]
    NotStorable {
        /// What is wrong, where.
        error: crowd_pack::Error,
    },
    /// A size was asked for that a character cannot have.
    #[error(
        "--scale or --height: {factor} times the file's size, allowed a number with which all lies within 1000000 m"
    )]
    Resize {
        /// What the file's lengths would be multiplied by.
        factor: f32,
    },
    /// A height was asked for of something flat.
    #[error(
        "--height: the character has no height in the pose at rest; allowed is --scale, so many times the file's size"
    )]
    NoHeight,
    /// `--strict` and the file was repaired.
    #[error("{} with --strict; the first: {}", counted(.warnings.len(), "warning"), .warnings.first().map_or("", |w| w.as_str()))]
    Warned {
        /// The warnings, as sentences.
        warnings: Vec<String>,
    },
    /// No character of that name in the pack.
    #[error("character `{asked}`: the pack has {found}")]
    CharacterNotFound {
        /// Name asked for.
        asked: String,
        /// The names there are.
        found: String,
    },
    /// The pack holds several characters and none was named.
    #[error("the pack holds {count} characters ({found}); name one with --character")]
    CharacterNeeded {
        /// How many.
        count: usize,
        /// The names there are.
        found: String,
    },
    /// No level of that name in the pack.
    #[error("level `{asked}`: the pack stores {found}; store some with bake --lod-ratio, --error or --px")]
    LevelNotFound {
        /// Name asked for.
        asked: String,
        /// The names there are.
        found: String,
    },
    /// `--strict` and no level is as small as asked for.
    #[error("target missed: asked for {asked} {what}, the coarsest level has {coarsest}; {blocked}")]
    TargetMissed {
        /// Triangles or vertices.
        what: &'static str,
        /// Asked for.
        asked: u64,
        /// Of the coarsest level.
        coarsest: u64,
        /// What keeps it from going further.
        blocked: String,
    },
    /// Reading failed.
    #[error("{path}: {source}")]
    Input {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// Writing failed.
    #[error("{path}: {source}")]
    Output {
        /// The file, or `standard output`.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// An output names an input.
    #[error("{path}: is an input too; inputs are never overwritten, choose another output")]
    OutputIsInput {
        /// The file.
        path: PathBuf,
    },
    /// An output names a file that an input reads.
    #[error("{path}: {asset} reads this file; inputs are never overwritten, choose another output")]
    OutputIsPartOfInput {
        /// The file.
        path: PathBuf,
        /// The asset that names it.
        asset: PathBuf,
    },
    /// Two outputs name one file.
    #[error("{path}: two outputs are this file; choose another name for one of them")]
    OutputTwice {
        /// The file.
        path: PathBuf,
    },
    /// More pixels than one picture may have.
    #[error(
        "{columns} columns of {rows} rows of {width}x{height} pixels: found {found} pixels, allowed {allowed}; \
         ask for fewer --ratios or --clip, or a smaller --size"
    )]
    PictureTooLarge {
        /// Levels.
        columns: usize,
        /// Poses.
        rows: usize,
        /// Of a cell, pixels.
        width: u32,
        /// Of a cell, pixels.
        height: u32,
        /// Pixels of the whole picture.
        found: u64,
        /// Pixels allowed.
        allowed: u64,
    },
    /// No triangle of the character has an area.
    #[error(
        "all {triangles} triangles are degenerate: two corners at one place; a character needs at least one with three corners \
         apart"
    )]
    OnlyDegenerate {
        /// Triangles in the file.
        triangles: usize,
    },
    /// Nothing could be baked.
    #[error("nothing of {} could be baked; no pack was written", counted(*.count, "input"))]
    NothingBaked {
        /// Inputs tried.
        count: usize,
    },
    /// `verify` found broken promises.
    #[error("{failed} of {checked} checks failed")]
    ChecksFailed {
        /// Checks that failed.
        failed: usize,
        /// Checks made.
        checked: usize,
    },
}

impl Cause {
    /// True when whoever reads our output went away: that is success.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Output { source, .. } if source.kind() == std::io::ErrorKind::BrokenPipe)
    }
}
