//! The words of the command line. What they mean is in `plan`.

mod values;

use values::{
    glb_parser, output_parser, parse_attribute_weight, parse_clip_weight, parse_jobs, parse_share, parse_size,
    parse_time, parse_turn, png_parser,
};
pub(crate) use values::{parse_size_number, weigh_attribute};

use crate::compare::Contender;
use crate::lod_target::{LodTarget, parse_coarsest};
use crate::sample::FrameRate;
use crate::size::SizeAsked;
use clap::{Args, Parser, Subcommand, ValueEnum};
use crowd_lod::Coarsest;
use crowd_pack::JointStorage;
use std::path::PathBuf;

/// Most that a clip may count.
pub const MOST_CLIP_WEIGHT: f32 = 1000.0;

/// Bakes rigged, textured characters into packs with a continuous level of detail.
#[derive(Debug, Parser)]
#[command(name = "crowdbake", version, max_term_width = 110, after_help = EXAMPLES, propagate_version = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Say nothing but errors.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say what each step does and how long it takes.
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

const EXAMPLES: &str = "\
Examples:
  crowdbake bake knight.glb -o knight.crowdpack           one character
  crowdbake bake characters/ 'more/*.gltf' -o cast.crowdpack   folders and patterns
  crowdbake inspect cast.crowdpack                        what is in it
  crowdbake export cast.crowdpack --character knight --ratio 0.1 -o low.glb
  crowdbake picture cast.crowdpack -o levels.png          see the levels
  crowdbake report cast.crowdpack -o report.html          a page to look at
  crowdbake explain cast.crowdpack --ratio 5%             why a level goes no lower, and what to change
  crowdbake verify cast.crowdpack                         check every promise

Exit codes: 0 done, 1 an input was refused or has no character or clip of that name, 2 wrong command line, 3 an output could not be written, 4 verification failed, 5 with --strict a level asked for is not reached. A batch goes on past a refused file, writes the good ones, and ends with the worst code.
Data goes to standard output, talk to standard error. NO_COLOR and a closed pipe are respected.";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Bake characters into one pack.
    #[command(after_help = BAKE_EXAMPLES)]
    Bake(BakeArgs),
    /// Show what is in a pack or in a source asset.
    #[command(after_help = INSPECT_EXAMPLES)]
    Inspect(InspectArgs),
    /// Check a pack: checksums, records, every promise of its levels, its measured errors.
    #[command(after_help = "Example:\n  crowdbake verify cast.crowdpack --json | jq .checks")]
    Verify(VerifyArgs),
    /// Write a level of a character as a glTF binary with skin, clips and materials.
    ///
    /// The file has one mesh and one skin, which lists the joints of the source's first skin in their order, used or not, so that engines can exchange meshes under
    /// one skeleton. Joints of other skins and of rigid parts follow at the end.
    #[command(after_help = EXPORT_EXAMPLES)]
    Export(ExportArgs),
    /// Draw levels of detail side by side.
    #[command(after_help = PICTURE_EXAMPLES)]
    Picture(PictureArgs),
    /// Make one page (HTML) with pictures, curves and tables of every character.
    #[command(after_help = REPORT_EXAMPLES)]
    Report(ReportArgs),
    /// Say whether a level is reached, how far off it is and where, and what holds the coarsest one back.
    #[command(after_help = EXPLAIN_EXAMPLES)]
    Explain(ExplainArgs),
    /// Bake every asset of a folder under both criteria and write a table of the results.
    #[command(after_help = "Example:\n  crowdbake survey assets/ -o REAL_ASSETS.md --pictures pictures/")]
    Survey(SurveyArgs),
    /// Judge levels of ours and of other simplifiers side by side.
    #[command(after_help = COMPARE_EXAMPLES)]
    Compare(CompareArgs),
    /// Show what a bake would do, as a crowd.toml.
    #[command(after_help = "Example:\n  crowdbake print-config characters/ --fps 24 -o crowd.toml")]
    PrintConfig(PrintConfigArgs),
    /// Write completions for a shell to standard output.
    #[command(after_help = "Example:\n  crowdbake completions bash > /etc/bash_completion.d/crowdbake")]
    Completions {
        /// The shell.
        shell: clap_complete::Shell,
    },
}

const BAKE_EXAMPLES: &str = "\
Inputs:
  file.glb file.gltf file.obj   one character each
  folder/                       every .glb, .gltf and .obj in it and below it, in order of their paths
  'folder/*.glb'                a pattern (* ? [a-z] and ** for any depth), quoted so that the shell leaves it alone
  crowd.toml                    a manifest; paths in it are relative to it:
      [defaults]                    # all keys are optional
      fps = 30
      criteria = \"wedge\"            # or \"peng2011\"
      [pack]
      impostors = 16                # also animation_layout
      [[characters]]
      source = \"knight.glb\"
      name = \"knight\"               # default: the file's stem
      clips = [\"Idle\", \"Walk*\"]     # default: all; also fps, criteria, frames
      lod_ratio = [0.5, \"25%\"]      # also error = [\"5mm\", \"0.5%\"], px = [\"1@240\", \"1@720:max\"], refit = true
      clip_weights = { Walk = 2.0 }  # default: all count alike
      attribute_weights = { uv = 2.0 }  # uv, normal, color, layers; default: 1
      scale = 0.01                  # a file in centimetres; or height = 1.8 (metres)
      animation_storage = \"f16\"     # auto, f32, f16 or quantized; animation_error = 0.1 (percent)
  The command line wins over a [[characters]] entry, and that over [defaults].

Examples:
  crowdbake bake knight.glb wolf.glb -o cast.crowdpack
  crowdbake bake crowd.toml -o cast.crowdpack --report bake.json
  crowdbake bake characters/ -o cast.crowdpack --clips '*idle*,*walk*,*run*' --fps 24
  crowdbake bake knight.glb -o knight.crowdpack --lod-ratio 50%,25%,10% --refit   then export --lod all
  crowdbake bake knight.glb -o knight.crowdpack --px 1@720,1@240,1@80
  crowdbake bake fox.glb -o fox.crowdpack --scale 0.01                            a file in centimetres";

const INSPECT_EXAMPLES: &str = "\
Examples:
  crowdbake inspect cast.crowdpack
  crowdbake inspect knight.glb                            without baking: counts, seams, classes, clips
  crowdbake inspect cast.crowdpack --json | jq '.characters[].name'";

const EXPORT_EXAMPLES: &str = "\
Examples:
  crowdbake export knight.crowdpack --triangles 1500 -o knight_low.glb
  crowdbake export cast.crowdpack --character knight --ratio 0.1 -o knight_10.glb
  crowdbake export cast.crowdpack --character knight --lods 1,0.5,0.25,0.1 -o knight.glb
                                                          writes knight.lod0.glb to knight.lod3.glb
  crowdbake export cast.crowdpack --character knight --ratio 0.1 --refit -o knight_10.glb
  crowdbake export cast.crowdpack --character knight --lod all -o knight.glb
                                                          what bake stored: knight.lod1.glb, knight.lod2.glb, ...
The largest level within the target is written. Where no level is small enough the coarsest one is, with a warning; with --strict that is an error.";

const PICTURE_EXAMPLES: &str = "\
Examples:
  crowdbake picture knight.glb -o levels.png              100, 25, 10 and 5 % at rest
  crowdbake picture cast.crowdpack --character knight --clip Walk --time 0.4 -o walk.png
  crowdbake picture knight.glb --clip bind --clip Walk --clip Run -o rows.png
  crowdbake picture knight.glb --paint classes -o seams.png";

const COMPARE_EXAMPLES: &str = "\
Examples:
  crowdbake compare knight.glb fox.glb
  crowdbake compare knight.glb --quick --ours wedge --peers meshopt-global --ratios 25%,5%
  crowdbake compare characters/ --json > compared.json
  crowdbake compare characters/ -o docs/benchmarks/levels.md
Levels are judged in poses that no bake has seen: 24 moments half way between sampled frames, spread over all clips, and the pose at rest. Distances are in percent of the diagonal of the character's box.";

const REPORT_EXAMPLES: &str = "\
Examples:
  crowdbake report cast.crowdpack -o report.html          all characters
  crowdbake report cast.crowdpack --character knight -o knight.html
  crowdbake report knight.glb -o knight.html              baked on the way
The page needs no other file and no network. Seven characters make about 6 MB; with more than eight, pictures get smaller.";

const EXPLAIN_EXAMPLES: &str = "\
Examples:
  crowdbake explain cast.crowdpack
  crowdbake explain cast.crowdpack --character knight --ratio 10%,5%
  crowdbake explain cast.crowdpack --json | jq '.characters[].causes'";

/// Options that say how to bake; shared by everything that bakes.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "How to bake")]
pub struct BakeOptions {
    /// Which collapses are allowed [default: wedge].
    #[arg(long, value_enum, value_name = "RULE")]
    pub criteria: Option<CriteriaWord>,
    /// Frames a second at which clips are sampled, 1 to 240; auto takes for each clip the rate of its keys, so that they fall on frames (20 to
    /// 60, or 30 where keys are uneven) [default: auto].
    #[arg(long, value_parser = FrameRate::parse, value_name = "N|auto")]
    pub fps: Option<FrameRate>,
    /// Clips to keep: names or patterns (`*walk*`, in any case), separated by commas; every name has to be there, and of patterns one
    /// that finds a clip [default: all].
    #[arg(long, value_delimiter = ',', value_name = "CLIP,...")]
    pub clips: Option<Vec<String>>,
    /// Frames that the error is averaged over [default: auto].
    #[arg(long, value_enum, value_name = "WHICH")]
    pub frames: Option<FramesWord>,
    /// Let a clip (name or pattern) count W times as much as the others, 0 to 1000; may be repeated [default: all count alike].
    #[arg(long, value_parser = parse_clip_weight, value_name = "CLIP=W")]
    pub clip_weight: Vec<(String, f32)>,
    /// Mind what a surface shows W times as much as by default, 0 to 1000: uv (textures that slide), normal, color (vertex colours, and
    /// parts that would be missed), layers (parts that come through each other); may be repeated. 0 minds shape alone.
    #[arg(long, value_parser = parse_attribute_weight, value_name = "NAME=W")]
    pub attribute_weight: Vec<(String, f32)>,
    /// Bake it F times as large as the file has it: 0.01 for a file in centimetres, whose characters come out as high as houses [default: 1].
    #[arg(long, value_parser = parse_size_number, value_name = "F", conflicts_with = "height", allow_negative_numbers = true)]
    pub scale: Option<f32>,
    /// Bake it so many metres high, in the pose at rest; from 20 m on `crowdplay` takes a character for centimetres, unless told `--height source`
    /// [default: as the file has it].
    #[arg(long, value_parser = parse_size_number, value_name = "M", allow_negative_numbers = true)]
    pub height: Option<f32>,
    /// Where the continuous detail ends: once a level has at most so many triangles (40), this share of them (0.5%), or where nothing
    /// may collapse any more (last) [default: 0.5%, not below 16 triangles or 2%; last under peng2011].
    #[arg(long, value_parser = parse_coarsest, value_name = "N|R|last")]
    pub coarsest: Option<Coarsest>,
    /// How a joint of a frame is stored: f32 (48 bytes), f16 (24) or quantized (a rotation, a scale and a translation, 16); auto takes for each
    /// character the smallest with which vertices stay within --animation-error [default: auto].
    #[arg(long, value_enum, value_name = "HOW")]
    pub animation_storage: Option<StorageWord>,
    /// What stored animation may be off from the sampled clips at any vertex and time, in percent of the character's height, 0 to 10: clips also
    /// keep as few frames as that allows. 0 keeps what was sampled, bit for bit; what lies between sampled frames is --fps [default: 0.1].
    #[arg(long, value_parser = parse_animation_error, value_name = "PERCENT")]
    pub animation_error: Option<f32>,
}

impl BakeOptions {
    /// How large, where the command line says so.
    pub fn size(&self) -> Option<SizeAsked> {
        self.scale.map(SizeAsked::Factor).or(self.height.map(SizeAsked::HeightM))
    }
}

/// How joints are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StorageWord {
    /// The smallest that stays within the error.
    Auto,
    /// Three rows of four floats.
    F32,
    /// The same of half floats.
    F16,
    /// A quaternion, a scale and a translation in 16 bytes.
    Quantized,
}

impl StorageWord {
    /// What it asks for; `None` leaves the choice to the bake.
    pub fn storage(self) -> Option<JointStorage> {
        match self {
            Self::Auto => None,
            Self::F32 => Some(JointStorage::F32),
            Self::F16 => Some(JointStorage::F16),
            Self::Quantized => Some(JointStorage::Quantized),
        }
    }
}

/// Percent of the height, with or without the sign, as a share.
pub(crate) fn parse_animation_error(text: &str) -> Result<f32, String> {
    let text = text.trim();
    match text.strip_suffix('%').unwrap_or(text).trim_end().parse::<f32>() {
        Ok(percent) if (0.0..=10.0).contains(&percent) => Ok(percent / 100.0),
        _ => Err(format!("found {text}, allowed 0 to 10, percent of the height")),
    }
}

/// Texels of a tile's side; 0 for none.
pub(crate) fn parse_impostors(text: &str) -> Result<u32, String> {
    match text.trim().parse::<u32>() {
        Ok(0) => Ok(0),
        Ok(px) if px.is_power_of_two() && (8..=crowd_pack::limits::IMPOSTOR_TILE_PX).contains(&px) => Ok(px),
        _ => Err(format!("found {text}, allowed 8, 16, 32, 64 or 128, or 0 for none")),
    }
}

/// Which frames count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FramesWord {
    /// Up to 64 that stand for all others, checked on all afterwards.
    Auto,
    /// All of them: slower, and memory grows with vertices times frames.
    All,
    /// The bind pose alone, as tools do that know no clips.
    Bind,
}

/// Options that say which discrete levels a pack stores.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Discrete levels, beside the continuous detail")]
pub struct LevelOptions {
    /// Levels of these shares of the triangles, as in 0.5,0.25 or 50%,25%.
    #[arg(long, value_delimiter = ',', value_parser = LodTarget::parse_ratio, value_name = "R,...")]
    pub lod_ratio: Vec<LodTarget>,
    /// For each distance the coarsest level found that stays within it: 5mm, 2cm, 0.005 (metres), or 0.5% of the height. Every point in
    /// every frame counts (the measured bound, a quarter above the largest distance found); 5mm:rms takes the root mean square.
    #[arg(long, value_delimiter = ',', value_parser = LodTarget::parse_error, value_name = "E,...")]
    pub error: Vec<LodTarget>,
    /// For each P@H the coarsest level found that is off by P pixels at most where the character is H pixels high on the screen:
    /// 1@720,1@240,1@80 gives a chain. P alone is P@720. The root mean square over surface and frames counts; single points are off by
    /// more, and the bake prints by how much. 1@240:max holds for every point in every frame, and keeps far more triangles.
    #[arg(long, value_delimiter = ',', value_parser = LodTarget::parse_pixels, value_name = "P@H,...")]
    pub px: Vec<LodTarget>,
    /// Move the vertices of discrete levels, and fit their skin weights, so that they lie closest to full detail over the frames.
    #[arg(long)]
    pub refit: bool,
}

/// Peng's criteria or ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CriteriaWord {
    /// Charge for seams, textures, normals and lost parts: reaches 2 % and less on real assets.
    Wedge,
    /// The classes of Peng 2011, section 4.2, to the letter.
    Peng2011,
}

/// `bake`.
#[derive(Debug, Args)]
pub struct BakeArgs {
    /// Assets, folders, patterns or crowd.toml manifests.
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// The pack to write; replaced whole or not at all.
    #[arg(short, long, value_parser = output_parser(), value_name = "OUT.crowdpack")]
    pub output: PathBuf,
    /// How to bake.
    #[command(flatten)]
    pub options: BakeOptions,
    /// Discrete levels.
    #[command(flatten)]
    pub levels: LevelOptions,
    /// How the pack stores a joint's matrix [default: 3x4].
    #[arg(long, value_enum, value_name = "LAYOUT", help_heading = "How to bake")]
    pub animation_layout: Option<LayoutWord>,
    /// Draw each character small from around, PX texels (a power of two from 8 to 128) a picture, at up to eight moments of a clip: `crowdplay
    /// --impostors` then shows those who are a few pixels high as one such picture. 16 texels do for people of 15 pixels; twice as many
    /// take three times the bytes. 0: none [default: 0].
    #[arg(long, value_parser = parse_impostors, value_name = "PX", help_heading = "How to bake")]
    pub impostors: Option<u32>,
    /// Refuse a character whose file had to be repaired (what the import warns of, triangles left out), or of whose levels asked for two come
    /// out as one, or one as full detail (exit code 1), and one whose levels do not reach a share asked for (exit code 5).
    #[arg(long, help_heading = "How to bake")]
    pub strict: bool,
    /// Threads, up to 256; 0 for one a core. The pack's bytes do not depend on it.
    #[arg(short, long, default_value_t = 0, value_parser = parse_jobs, value_name = "N", help_heading = "How to bake")]
    pub jobs: usize,
    /// Write a report (JSON): steps and their seconds, counts before and after, warnings.
    #[arg(long, value_parser = output_parser(), value_name = "FILE.json", help_heading = "Reporting")]
    pub report: Option<PathBuf>,
    /// Print the report to standard output.
    #[arg(long, help_heading = "Reporting")]
    pub json: bool,
}

/// How the animation section stores matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LayoutWord {
    /// Three texels a joint, inverse bind matrix multiplied in.
    #[value(name = "3x4")]
    Premultiplied3x4,
    /// Four texels a joint and inverse bind matrices apart, as in Dong 2019.
    #[value(name = "4x4")]
    Split4x4,
}

/// `inspect`.
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// A pack or an asset.
    #[arg(value_name = "PACK|ASSET")]
    pub input: PathBuf,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// `verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// The pack.
    #[arg(value_name = "PACK")]
    pub pack: PathBuf,
    /// Levels looked at for each character, spread over all of them.
    #[arg(long, default_value_t = 48, value_name = "N")]
    pub levels: usize,
    /// Print JSON instead of lines.
    #[arg(long)]
    pub json: bool,
}

/// `export`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("target").required(true).args(["triangles", "ratio", "vertices", "lods", "lod"])))]
pub struct ExportArgs {
    /// A pack, or an asset to be baked on the way.
    #[arg(value_name = "PACK|ASSET")]
    pub input: PathBuf,
    /// The character; may be left out when there is one.
    #[arg(long, value_name = "NAME")]
    pub character: Option<String>,
    /// At most so many triangles.
    #[arg(long, value_name = "N", help_heading = "Which level")]
    pub triangles: Option<u32>,
    /// At most this share of the triangles, as in 0.25 or 25%.
    #[arg(long, value_name = "R", value_parser = parse_share, help_heading = "Which level")]
    pub ratio: Option<f64>,
    /// At most so many vertices.
    #[arg(long, value_name = "K", help_heading = "Which level")]
    pub vertices: Option<u32>,
    /// Several shares; one file each.
    #[arg(long, value_name = "R,...", value_delimiter = ',', value_parser = parse_share, help_heading = "Which level")]
    pub lods: Option<Vec<f64>>,
    /// A discrete level that bake stored, by its name (see inspect), or `all`: one file each.
    #[arg(long, value_name = "NAME", help_heading = "Which level")]
    pub lod: Option<String>,
    /// Move the vertices to where they lie closest to full detail over the frames; stored levels are as bake left them.
    #[arg(long, conflicts_with = "lod")]
    pub refit: bool,
    /// The file to write, or a folder (`FOLDER/`), which gets NAME.glb; --lods write OUT.lod0.glb, OUT.lod1.glb, ...
    #[arg(short, long, value_parser = glb_parser(), value_name = "OUT.glb")]
    pub output: PathBuf,
    /// A target that no level reaches is an error (exit code 5).
    #[arg(long)]
    pub strict: bool,
}

/// `picture`.
#[derive(Debug, Args)]
pub struct PictureArgs {
    /// A pack, or an asset to be baked on the way.
    #[arg(value_name = "PACK|ASSET")]
    pub input: PathBuf,
    /// The picture to write.
    #[arg(short, long, value_parser = png_parser(), value_name = "OUT.png")]
    pub output: PathBuf,
    /// The character; may be left out when there is one.
    #[arg(long, value_name = "NAME")]
    pub character: Option<String>,
    /// Shares of the triangles, one column each.
    #[arg(long, value_delimiter = ',', value_parser = parse_share, default_value = "1,0.25,0.1,0.05", value_name = "R,...")]
    pub ratios: Vec<f64>,
    /// Clip, or `bind` for the pose at rest; give it several times for several rows [default: bind].
    #[arg(long, value_name = "NAME")]
    pub clip: Vec<String>,
    /// Seconds into the clip; one for all rows or one for each [default: the middle].
    #[arg(long, value_parser = parse_time, value_name = "T", allow_negative_numbers = true)]
    pub time: Vec<f32>,
    /// What the colours say.
    #[arg(long, value_enum, default_value_t = Paint::Shaded)]
    pub paint: Paint,
    /// Pixels of one cell.
    #[arg(long, value_parser = parse_size, default_value = "320x420", value_name = "WxH")]
    pub size: [u32; 2],
    /// Degrees to turn the character, -360 to 360; 0 looks it in the face.
    #[arg(long, default_value_t = 25.0, value_parser = parse_turn, value_name = "DEG", allow_negative_numbers = true)]
    pub turn: f32,
    /// How to bake, for an asset.
    #[command(flatten)]
    pub options: BakeOptions,
}

/// What the colours of a picture say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Paint {
    /// Textures and light.
    Shaded,
    /// Vertex classes: grey regular, amber companion, red fixed.
    Classes,
    /// Textures and edges.
    Wireframe,
    /// Full detail, coloured by its distance to the level: grey none, dark red from 2 % of the height on.
    Error,
}

/// `report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// A pack, or an asset to be baked on the way.
    #[arg(value_name = "PACK|ASSET")]
    pub input: PathBuf,
    /// The page to write; replaced whole or not at all.
    #[arg(short, long, value_parser = output_parser(), value_name = "OUT.html")]
    pub output: PathBuf,
    /// A character; may be repeated [default: all].
    #[arg(long, value_name = "NAME")]
    pub character: Vec<String>,
    /// How to bake, for an asset.
    #[command(flatten)]
    pub options: BakeOptions,
}

/// `explain`.
#[derive(Debug, Args)]
pub struct ExplainArgs {
    /// A pack, or an asset to be baked on the way.
    #[arg(value_name = "PACK|ASSET")]
    pub input: PathBuf,
    /// A character; may be repeated [default: all].
    #[arg(long, value_name = "NAME")]
    pub character: Vec<String>,
    /// Shares of the triangles that you want, as 0.1 or 10%: reached or not, and the error there.
    #[arg(long, value_delimiter = ',', value_parser = parse_share, value_name = "R,...")]
    pub ratio: Vec<f64>,
    /// Print JSON instead of lines.
    #[arg(long)]
    pub json: bool,
    /// How to bake, for an asset.
    #[command(flatten)]
    pub options: BakeOptions,
}

/// `survey`.
#[derive(Debug, Args)]
pub struct SurveyArgs {
    /// Assets, folders, patterns or manifests.
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// The table to write (Markdown) [default: standard output].
    #[arg(short, long, value_parser = output_parser(), value_name = "FILE.md")]
    pub output: Option<PathBuf>,
    /// A folder for one picture a character: levels at rest and in motion.
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// Frames a second at which clips are sampled, 1 to 240; auto takes for each clip the rate of its keys, so that they fall on frames (20 to
    /// 60, or 30 where keys are uneven) [default: auto].
    #[arg(long, value_parser = FrameRate::parse, value_name = "N|auto")]
    pub fps: Option<FrameRate>,
}

/// `compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Assets, folders, patterns or manifests; of what these say, names, sizes and frames a second count: all are to simplify alike.
    #[arg(required = true, value_name = "ASSET")]
    pub inputs: Vec<PathBuf>,
    /// Shares of the triangles, as in 0.5,0.25 or 50%,25%.
    #[arg(long, value_delimiter = ',', value_parser = parse_share, default_value = "50%,25%,10%,5%,2%", value_name = "R,...")]
    pub ratios: Vec<f64>,
    /// Fewer points and no pictures: for tuning. Single cells are then shown but not held against a bar.
    #[arg(long)]
    pub quick: bool,
    /// Points a side: small parts, as eyes, have few of them, and chance decides there [default: 10000; with --quick 2000].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    pub points: Option<u32>,
    /// Which of our own take part.
    #[arg(long, value_delimiter = ',', default_value = "wedge,refit,bind,peng2011", value_name = "NAME,...")]
    pub ours: Vec<Contender>,
    /// Which others take part [default: all; with --quick all but gltfpack].
    #[arg(long, value_delimiter = ',', value_name = "NAME,...")]
    pub peers: Option<Vec<Contender>>,
    /// Write the tables as a document (Markdown) instead of printing them.
    #[arg(short, long, value_parser = output_parser(), value_name = "FILE.md")]
    pub output: Option<PathBuf>,
    /// Print JSON instead of tables.
    #[arg(long)]
    pub json: bool,
}

/// `print-config`.
#[derive(Debug, Args)]
pub struct PrintConfigArgs {
    /// Inputs, as for `bake`; none shows the defaults alone.
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// The manifest to write, its paths relative to its folder [default: standard output, paths as from the current folder].
    #[arg(short, long, value_parser = output_parser(), value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// How to bake.
    #[command(flatten)]
    pub options: BakeOptions,
    /// Discrete levels.
    #[command(flatten)]
    pub levels: LevelOptions,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_words_fit_together() {
        Cli::command().debug_assert();
    }
}
