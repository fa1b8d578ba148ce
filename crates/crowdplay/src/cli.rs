//! The words of the command line. What they mean is decided in `plan.rs`.

mod values;

pub use values::techniques;

use crate::budget_words::BudgetWords;
use crate::window_words::WindowWords;
use clap::{Parser, ValueEnum, ValueHint};
use crowd_stages::{Skinning, Technique, View};
use std::path::PathBuf;
use values::{
    alpha, depths, dots_px, fade, fog, fov, not_negative, pose_rates, positive, rate, samples, shadows, size, triple,
    views,
};

/// `--dots` unless given.
pub const DOTS_PX: f32 = crowd_stages::STAND_IN_PX;

/// `--impostors` unless given.
pub const IMPOSTORS_PX: f32 = crowd_stages::STAND_IN_PX;

/// `--fade` unless given.
pub const FADE_S: f32 = 0.3;

/// `--count` unless given.
pub const COUNT: u32 = 10_000;

/// People of a flock.
pub const MOST_BOIDS: i64 = 1_000_000;

/// `--walk` without a file.
pub const AROUND: &str = "around";

const USAGE: &str = "crowdplay [OPTIONS] <PACK>\n       crowdplay bench [OPTIONS] --ab <NAME,...> <PACK>\n       crowdplay --list-adapters\n       crowdplay --completions <SHELL>";

const EXAMPLES: &str = "\
Examples:
  Look at ten thousand people in a window:
    crowdplay cast.crowdpack

  One picture without a window, and what it cost:
    crowdplay cast.crowdpack --headless --size 1280x720 --out crowd.png --report stats.json

  On a machine without a GPU (no dots, impostors or shadows; --budget says the same N):
    crowdplay cast.crowdpack --headless --backend cpu --out crowd.png

  Sixty pictures of a film, 1/30 s apart:
    crowdplay cast.crowdpack --headless --frames 60 --out frame-%04d.png

  A film of a flight recorded in the window, where ffmpeg is installed:
    crowdplay cast.crowdpack --record-camera flight.txt
    crowdplay cast.crowdpack --camera-path flight.txt --headless --frames 300 --out flight.mp4

  Only two characters, walking, in a street, with half the vertices:
    crowdplay cast.crowdpack --characters mara,oskar --clips walk --layout street --budget 500000

  A hundred thousand that flock, simulated on the GPU:
    crowdplay cast.crowdpack --flock 100000 --simulate gpu

  What JuPedSim simulated, 12 seconds after its start:
    crowdplay cast.crowdpack --trajectories crossing.sqlite --headless --start 12 --out crossing.png

  The numbers alone, to another program:
    crowdplay cast.crowdpack --headless --frames 100 --report - | jq .timings.frame_ms.median

  The papers' baseline, every instance at full detail with a draw of its own:
    crowdplay cast.crowdpack --headless --technique pseudo-instancing --report -

  How the techniques compare on this machine (more: crowdplay bench --help):
    crowdplay bench cast.crowdpack --ab b0,b3,bucketed

  A camera of your own: azimuth 30 degrees, 20 degrees above the ground, 40 m away:
    crowdplay cast.crowdpack --orbit 30,20,40

Files, one entry a line, # begins a comment:
  layout         first line `# crowd layout v1`, then x y z yaw_deg scale character clip phase_s
                 (names, or numbers from 0 in the order of --characters or the pack), or
                 place LAYOUT count x z yaw_deg spacing_m seed
  waypoints      first line `# crowd waypoints v1`, then `route WIDTH` and its points x z [wait_s]
  motion graph   first line `# crowd motion graph v1`, then `state NAME CLIP seconds|turns LEAST MOST` and
                 `way FROM TO fade_s [in-step] [weight W]`; each state must lead to all others
  camera path    first line `# crowd camera path v1`, then time_s, eye x y z, target x y z, fov_deg, or
                 line seconds eye x y z target x y z fov_deg, or
                 orbit seconds target x y z distance elevation_deg from_deg to_deg fov_deg, or
                 walkthrough seconds low x z high x z eye_height fov_deg (no commas)
  trajectories   JuPedSim's database; `# framerate: HZ` and lines id frame x y (Juelich archive); a heading with
                 columns id, time or frame, x, y between blanks, commas, semicolons or tabs (Vadere, others)

Exit codes:
  0 done   1 pack, layout, trajectories, motion graph or camera path refused   2 usage   3 output not written
  5 this machine lacks what was asked for: a GPU (--backend gpu, --adapter), a display (without
  --headless), ffmpeg (a film for --out); or it lost its GPU while frames were drawn

Data goes to standard output (--report -, --out -, --list-adapters), everything else to standard error.";

/// Show a baked crowd: in a window, or as pictures without one.
#[derive(Debug, Clone, Parser)]
#[command(name = "crowdplay", version, override_usage = USAGE, after_help = EXAMPLES, max_term_width = 110)]
pub struct Args {
    /// The pack to show, as written by `crowdbake bake`
    #[arg(value_name = "PACK", value_hint = ValueHint::FilePath,
          required_unless_present_any = ["list_adapters", "completions"])]
    pub pack: Option<PathBuf>,

    /// Instances in the crowd; adapters that bind little at a time draw fewer than this allows (software Vulkan 1,677,721), and say so
    /// [default: 10000]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=4_000_000), help_heading = "Crowd")]
    pub count: Option<u32>,

    /// Where they stand: grid, disc, ranks, street, seats (rings around a stage), or a layout file (its people are all the
    /// crowd)
    #[arg(long, default_value = "grid", value_name = "NAME|FILE", help_heading = "Crowd")]
    pub layout: String,

    /// A crowd simulator's trajectories instead of a layout: JuPedSim's database, the Juelich archive's text, Vadere's
    /// text, or comma-separated values; people come and leave, and it begins anew after its end. Characters wider than 1.2 m
    /// are left out, here and by --walk, unless --characters names them
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with_all = ["count", "layout", "spacing"],
          help_heading = "Crowd")]
    pub trajectories: Option<PathBuf>,

    /// People that walk as a flock: keep apart, go the same way, stay together (Reynolds 1987); begins anew after 10 minutes. How many is
    /// said here or by --count, at most 1000000
    #[arg(long, value_name = "COUNT", num_args = 0..=1, value_parser = clap::value_parser!(u32).range(1..=MOST_BOIDS),
          conflicts_with_all = ["layout", "spacing", "trajectories", "walk"], help_heading = "Crowd")]
    pub flock: Option<Option<u32>>,

    /// Who simulates the flock. The steering is the same; places differ after a while, since sums are added up in another order
    #[arg(long, value_enum, default_value_t = SimulatorWord::Auto, value_name = "WHO", help_heading = "Crowd")]
    pub simulate: SimulatorWord,

    /// People that walk along the waypoints of a file, or without one around a rectangle; how many says --count
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = AROUND, value_hint = ValueHint::FilePath,
          conflicts_with_all = ["layout", "spacing", "trajectories"], help_heading = "Crowd")]
    pub walk: Option<PathBuf>,

    /// Frames a second of trajectories that do not say theirs
    #[arg(long, value_name = "HZ", value_parser = rate, requires = "trajectories", help_heading = "Crowd")]
    pub trajectory_rate: Option<f32>,

    /// What people on their places do from second to second: off (each plays one clip), auto (they stand, walk, run and do what
    /// else their clips have, each for a while, and fade from one into the next, walking and running in step), or a motion
    /// graph file that says which clip for how long, what may follow it and how long they fade
    #[arg(long, default_value = "off", value_name = "off|auto|FILE", value_hint = ValueHint::FilePath, help_heading = "Crowd")]
    pub motion_graph: PathBuf,

    /// Seconds in which people who walk (--walk, --flock, --trajectories) fade from one gait into the next, standing, walking or
    /// running: both clips share in the pose, walking and running in step; 0: they change at once
    #[arg(long, default_value_t = FADE_S, value_name = "S", value_parser = fade, help_heading = "Crowd")]
    pub fade: f32,

    /// Where people may walk, a polygon or several with holes as well-known text (WKT, metres): drawn as ground and as walls
    /// 2.4 m high around it and its holes, which hide who is behind them. Moves nobody
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "trajectories", help_heading = "Crowd")]
    pub walkable: Option<PathBuf>,

    /// Metres between neighbours, raised to what the widest character needs [default: from the characters' size]
    #[arg(long, value_name = "M", value_parser = positive, help_heading = "Crowd")]
    pub spacing: Option<f32>,

    /// Characters to use, by name [default: all of the pack]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', help_heading = "Crowd")]
    pub characters: Vec<String>,

    /// Clips to play, by name or part of a name; `all` for all [default: all, or of a character with more than three
    /// those called idle, walk or run]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', help_heading = "Crowd")]
    pub clips: Vec<String>,

    /// Metres a character is shown high: 1.8 for all, ada=1.8,... for some, `source` for all as baked [default: as
    /// baked, but one of 20 m and more is taken to be in centimetres]
    #[arg(long, value_name = "M|NAME=M,...", value_delimiter = ',', help_heading = "Crowd")]
    pub height: Vec<String>,

    /// Draws another crowd of the same kind
    #[arg(long, default_value_t = 1, help_heading = "Crowd")]
    pub seed: u32,

    /// Vertices for a whole frame, the papers' N [default: what the coarsest levels of the crowd need and 1000000 more,
    /// on software adapters and with --backend cpu 300000 more]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Level of detail")]
    pub budget: Option<u32>,

    /// What the budget counts, how still it keeps, and what memory it has.
    #[command(flatten)]
    pub room: BudgetWords,

    /// Milliseconds of GPU time that a frame may take: the budget falls and rises to hold it, from --budget on
    #[arg(long, value_name = "MS", value_parser = positive, help_heading = "Level of detail")]
    pub target_ms: Option<f32>,

    /// Exponent of the budget's split: larger is fairer to the small ones
    #[arg(long, default_value_t = 3.0, value_parser = alpha, help_heading = "Level of detail")]
    pub alpha: f32,

    /// What an instance's share follows: its projected area, or also its distance (alpha above 1)
    #[arg(long, value_enum, default_value_t = WeightWord::Area, help_heading = "Level of detail")]
    pub weight: WeightWord,

    /// How the crowd is drawn [default: bucketed, or reform where the adapter has no first instance in indirect draws]
    #[arg(long, value_name = "NAME", value_parser = techniques(), help_heading = "Level of detail")]
    pub technique: Option<Technique>,

    /// How the budget is split: filled up to N, or Eq. 1 of the papers as printed, which leaves what near ones cannot use
    #[arg(long, value_enum, default_value_t = FitWord::Fill, help_heading = "Level of detail")]
    pub fit: FitWord,

    /// What the budget is split by: size on the screen (--weight, --alpha), or the levels' bounds, so that one number of
    /// pixels holds for every point of them all
    #[arg(long, value_enum, default_value_t = MetricWord::Size, help_heading = "Level of detail")]
    pub lod_metric: MetricWord,

    /// Pixels that no point should be off by more under the budget; says so when it does not
    #[arg(long, value_name = "PX", value_parser = positive, help_heading = "Level of detail")]
    pub max_px: Option<f32>,

    /// Height in pixels below which somebody may be drawn as a few coloured dots where the budget is short; 0: never (technique
    /// bucketed with --fit fill and --lod-metric size)
    #[arg(long, default_value_t = DOTS_PX, value_name = "PX", value_parser = dots_px, help_heading = "Level of detail")]
    pub dots: f32,

    /// Height in pixels below which somebody is drawn as one small picture of two triangles, where the pack has such (crowdbake bake
    /// --impostors); up to a quarter more they cross over from the coarsest mesh. 0: never, and their pictures take no memory. Where the
    /// budget is short, those below --dots are one dot instead (technique bucketed with --fit fill and --lod-metric size, on a GPU)
    /// [default: 12]
    #[arg(long, value_name = "PX", value_parser = dots_px, help_heading = "Level of detail")]
    pub impostors: Option<f32>,

    /// Bucketed levels change at once instead of moving over into each other
    #[arg(long, help_heading = "Level of detail")]
    pub no_morph: bool,

    /// Where vertices of people are worked out (bucketed alone; the picture is the same, of those who fade but for rounding): by the
    /// vertex shader from two frames of the clip, by the vertex shader from palettes blended beforehand, by a compute stage (each
    /// vertex once, however many passes draw it), or auto: palettes where somebody may fade; elsewhere the first frames try all
    /// three and keep the one that takes this adapter the least time. Where the buffers do not fit, the vertex shader does it and
    /// the report says so
    #[arg(long, value_enum, default_value_t = SkinningWord::Auto, value_name = "WAY", help_heading = "Level of detail")]
    pub skinning: SkinningWord,

    /// Leave out people whom others or walls hide (bucketed alone): who was not hidden in the last frame is drawn first, the
    /// others are tested against its depth and drawn after if anything of them may show, so nobody visible is ever missing.
    /// What is saved goes to the levels of those in sight. The CPU draws the same picture without
    #[arg(long, value_enum, default_value_t = Switch::Off, value_name = "on|off", help_heading = "Level of detail")]
    pub occlusion: Switch,

    /// Fog: off, or the metres after which a twentieth is left of what is seen. Its colour is that of the sky at the horizon; nobody is
    /// culled by it
    #[arg(long, default_value = "off", value_name = "off|M", value_parser = fog, help_heading = "Level of detail")]
    pub fog: f32,

    /// Shadows of the sun: off, or how many maps share the view, 1 to 4 (near ones finer). Everyone throws one, at the coarsest
    /// level whose error is within two texels of the map; ground, walls and the crowd receive it. The CPU draws none
    #[arg(long, default_value = "off", value_name = "off|N", value_parser = shadows, help_heading = "Level of detail")]
    pub shadows: u32,

    /// Poses of far people are held for a while, so that they change 50 times a second nearby and 4 times far away: off, or the metres
    /// from which it is 4 (the time between two poses grows with the squared distance: ERATO), or pixels, as in 1px, by which the
    /// fastest point of a clip may be late. Nobody is held while they fade. The CPU holds none
    #[arg(long, default_value = "off", value_name = "off|M|PXpx", value_parser = pose_rates, help_heading = "Level of detail")]
    pub pose_rates: PoseRates,

    /// People in one pose share its matrices and skinned vertices: each pose that is held is worked out once, for everyone at that level
    /// (with --pose-rates and --skinning palettes or compute; morphs go in quarters then)
    #[arg(long, value_enum, default_value_t = Switch::Off, value_name = "on|off", help_heading = "Level of detail")]
    pub share_poses: Switch,

    /// What the picture shows: people as they look (shaded), or tags over them: their levels between the coarsest mesh (blue) and
    /// full detail (red), triangles a pixel (a hundredth blue, one red), the representation (full detail red, meshes green, coarsest
    /// meshes blue, dots purple), or with --occlusion on who is in sight (green), drawn but hidden (orange), left out (red)
    #[arg(long, value_name = "VIEW", value_parser = views(), default_value = "shaded", help_heading = "Level of detail")]
    pub view: View,

    /// Who is drawn and at which levels stays as in the first frame, so that a moving camera shows what was chosen for it
    #[arg(long, help_heading = "Level of detail")]
    pub freeze: bool,

    /// Metres from which the technique `discrete` draws its second and third level [default: where somebody of 1.8 m is
    /// 200 and 66 pixels high]
    #[arg(long, value_name = "M,M", value_parser = depths, help_heading = "Level of detail")]
    pub lod_depths: Option<[f32; 2]>,

    /// Only levels that have index tables, also where the technique could draw those between
    #[arg(long, help_heading = "Level of detail")]
    pub snap_levels: bool,

    /// A camera that moves: orbit, line (corner to corner), walkthrough (1,000 frames through the crowd), or a camera path
    /// file, with times, positions and fields of view
    #[arg(long, value_name = "NAME|FILE", value_hint = ValueHint::FilePath,
          conflicts_with_all = ["eye", "target", "orbit"], help_heading = "Camera")]
    pub camera_path: Option<PathBuf>,

    /// Camera position in metres (Y is up)
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, requires = "target", conflicts_with = "orbit",
          allow_hyphen_values = true, help_heading = "Camera")]
    pub eye: Option<[f32; 3]>,

    /// Point looked at, in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "Camera")]
    pub target: Option<[f32; 3]>,

    /// Camera around the crowd's middle (or --target): azimuth and elevation in degrees, distance in metres;
    /// azimuth 0 looks the characters in the face
    #[arg(long, value_name = "AZ,EL,DIST", value_parser = triple, allow_hyphen_values = true, help_heading = "Camera")]
    pub orbit: Option<[f32; 3]>,

    /// In a corner of the picture, what a second camera sees that has all of the crowd and the first camera in view: who is drawn, at the
    /// levels chosen for the first one, who is culled as dots, and the edges of its frustum. Not with occlusion culling, nor the
    /// techniques pseudo-instancing and discrete
    #[arg(long, help_heading = "Camera")]
    pub reference_camera: bool,

    /// Write where the camera was, as a camera path file: as steered in the window, or frame by frame
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Camera")]
    pub record_camera: Option<PathBuf>,

    /// Vertical field of view in degrees
    #[arg(long, default_value_t = 45.0, value_name = "DEGREES", value_parser = fov, help_heading = "Camera")]
    pub fov: f32,

    /// No window: render frames, write pictures and a report
    #[arg(long, help_heading = "Output")]
    pub headless: bool,

    /// Frames to render; a window closes after them [default: 1 headless, no end in a window]
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u32).range(1..=1_000_000), help_heading = "Output")]
    pub frames: Option<u32>,

    /// Seconds between frames, without a window [default: 1/30]
    #[arg(long, value_name = "S", value_parser = not_negative, help_heading = "Output")]
    pub dt: Option<f32>,

    /// Time of the first frame in seconds
    #[arg(long, visible_alias = "time", default_value_t = 0.0, value_name = "S", value_parser = not_negative,
          help_heading = "Output")]
    pub start: f32,

    /// Picture or window size in pixels
    #[arg(long, default_value = "1280x720", value_name = "WxH", value_parser = size, help_heading = "Output")]
    pub size: [u32; 2],

    /// PNG of the last frame; with %d or %04d in the name one of each frame (%% is a percent sign); - for standard output; a film of
    /// all frames for a name that ends in mp4, mkv, webm, mov, avi or gif, if ffmpeg is installed
    #[arg(long, value_name = "PNG", requires = "headless", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub out: Option<PathBuf>,

    /// JSON with the frames' totals and times; - for standard output. Medians are over all frames but the first, which pays for shader
    /// compilation (with one frame: that one; timings.frames says how many)
    #[arg(long, value_name = "JSON", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub report: Option<PathBuf>,

    /// What only a window knows.
    #[command(flatten)]
    pub window: WindowWords,

    /// Samples a pixel (--backend cpu: supersampling, four times the work) [default: 4; 1 in a window on a software
    /// adapter]
    #[arg(long, value_name = "1|4", value_parser = samples, help_heading = "Machine")]
    pub msaa: Option<u32>,

    /// What draws: the GPU, the CPU, or the GPU if there is one
    #[arg(long, value_enum, default_value_t = BackendWord::Auto, help_heading = "Machine")]
    pub backend: BackendWord,

    /// The GPU whose name contains this (see --list-adapters)
    #[arg(long, value_name = "NAME", help_heading = "Machine")]
    pub adapter: Option<String>,

    /// List the GPUs and leave
    #[arg(long, help_heading = "Machine")]
    pub list_adapters: bool,

    /// Largest texture side in pixels; larger textures are scaled down
    #[arg(long, default_value_t = 1024, value_name = "PX", value_parser = clap::value_parser!(u32).range(1..=8192), help_heading = "Machine")]
    pub texture_side: u32,

    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,

    /// Print the completions for a shell and leave
    #[arg(long, value_name = "SHELL")]
    pub completions: Option<clap_complete::Shell>,
}

/// `--pose-rates`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseRates {
    /// Poses are always new.
    Off,
    /// Four a second from so many metres on.
    FarM(f32),
    /// As many as keep everything within so many pixels.
    Px(f32),
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// On
    On,
    /// Off
    Off,
}

/// `--skinning`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SkinningWord {
    /// Whichever is fastest here; palettes where somebody may fade
    Auto,
    /// The vertex shader, from two frames
    Vertex,
    /// The vertex shader, from palettes
    Palettes,
    /// A compute stage
    Compute,
}

impl SkinningWord {
    /// What it means.
    pub fn skinning(self) -> Skinning {
        match self {
            Self::Auto => Skinning::Auto,
            Self::Vertex => Skinning::Vertex,
            Self::Palettes => Skinning::Palettes,
            Self::Compute => Skinning::Compute,
        }
    }
}

/// `--weight`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum WeightWord {
    /// Projected area of the bounding sphere (Peng 2011)
    Area,
    /// Area, distance and triangles (Dong 2019)
    AreaDistance,
}

/// `--lod-metric`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MetricWord {
    /// Projected size, as in the papers
    Size,
    /// Baked bound of quantised levels, which no point of them exceeds (what bake's --px P@H:max counts), in pixels
    Error,
}

/// `--fit`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FitWord {
    /// All of N is used whenever more is wanted
    Fill,
    /// Eq. 1 as printed (Peng 2011, Dong 2019)
    Eq1,
}

/// `--backend`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BackendWord {
    /// The GPU if there is one, else the CPU, said on standard error
    Auto,
    /// A GPU, or exit code 5
    Gpu,
    /// The software rasteriser
    Cpu,
}

/// `--simulate`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SimulatorWord {
    /// The GPU, unless it is software or does not draw
    Auto,
    /// The GPU: nobody's place comes back to the CPU, whose work does not grow with the flock
    Gpu,
    /// The CPU, which sends everyone over each frame
    Cpu,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_words_are_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn techniques_have_long_and_short_names() {
        for technique in Technique::ALL {
            for name in [technique.name(), technique.short_name()] {
                let args = Args::try_parse_from(["crowdplay", "p", "--technique", name]).expect("a known name");
                assert_eq!(args.technique, Some(technique));
            }
        }
    }

    #[test]
    fn usage_errors_are_found_before_any_file_is_opened() {
        let table: &[&[&str]] = &[
            &["crowdplay"],
            &["crowdplay", "p", "--count", "0"],
            &["crowdplay", "p", "--eye", "1,2,3"],
            &["crowdplay", "p", "--out", "x.png"],
            &["crowdplay", "p", "--msaa", "3"],
            &["crowdplay", "p", "--alpha", "0"],
            &["crowdplay", "p", "--orbit", "0,1,2", "--camera-path", "c"],
            &["crowdplay", "p", "--technique", "b9"],
        ];
        for words in table {
            assert!(Args::try_parse_from(*words).is_err(), "{words:?}");
        }
        assert!(Args::try_parse_from(["crowdplay", "--list-adapters"]).is_ok());
    }
}
