//! What the command line means: one plan, all defaults decided, no file opened yet.

mod contradictions;
mod seen_from;

use crate::budget_words::STEADY_PERCENT;
use crate::cli::{AROUND, Args, BackendWord, FitWord, MetricWord, PoseRates, SimulatorWord, Switch, WeightWord};
use crate::memory::MEGABYTE;
use crate::{Error, Result};
use contradictions::{
    check_budget, check_occlusion, check_reference, check_sharing, check_simulator, check_skinning, check_view,
};
use crowd_scene::Layout;
use crowd_stages::{BudgetIn, DrawOptions, Fit, Levels, Technique, Weight};
use std::path::{Path, PathBuf};

/// Vertices a frame by default on a graphics card, besides the crowd's coarsest levels.
pub const GPU_BUDGET: u32 = 1_000_000;
/// The same where a processor draws: the software rasteriser and software adapters.
pub const SOFTWARE_BUDGET: u32 = 300_000;
/// No default goes beyond this or the crowd's coarsest levels: its triangles still fit a 128 MiB index buffer.
pub const LARGEST_USUAL_BUDGET: u32 = 8_000_000;

/// Everything the player is asked to do.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The pack's file.
    pub pack: PathBuf,
    /// Who stands where.
    pub crowd: CrowdPlan,
    /// Level of detail.
    pub detail: DetailPlan,
    /// From where it is seen.
    pub camera: CameraPlan,
    /// What draws.
    pub machine: MachinePlan,
    /// Picture or window, pixels.
    pub size: [u32; 2],
    /// JSON report; `-` is standard output.
    pub report: Option<PathBuf>,
    /// A second camera is shown in a corner.
    pub reference_camera: bool,
    /// Where the camera went, as a camera path.
    pub record_camera: Option<PathBuf>,
    /// Window or pictures.
    pub show: Show,
}

/// Who stands where.
#[derive(Debug, Clone, PartialEq)]
pub struct CrowdPlan {
    /// Instances.
    pub count: u32,
    /// Places.
    pub layout: LayoutPlan,
    /// Who simulates a flock.
    pub simulator: Simulator,
    /// A file with the walkable area, where the feed has none.
    pub walkable: Option<PathBuf>,
    /// Metres between neighbours; `None`: from the characters' size.
    pub spacing_m: Option<f32>,
    /// Names; empty: all.
    pub characters: Vec<String>,
    /// Which clips.
    pub clips: ClipPlan,
    /// How high they are shown.
    pub height: HeightPlan,
    /// Of the hash that deals out characters, clips and phases.
    pub seed: u32,
    /// What people on their places do from second to second.
    pub motion: MotionPlanWord,
    /// Poses may be held: how fast clips are has to be known.
    pub measures_speeds: bool,
    /// Seconds in which people who walk fade from one gait into the next.
    pub fade_s: f32,
    /// Largest texture side, pixels.
    pub texture_side: u32,
}

impl CrowdPlan {
    /// The same with another number of instances, also where they are a flock.
    pub fn with_count(&self, count: u32) -> Self {
        let layout = match &self.layout {
            LayoutPlan::Feed(FeedPlan::Flock { .. }) => LayoutPlan::Feed(FeedPlan::Flock { count }),
            other => other.clone(),
        };
        Self { count, layout, ..self.clone() }
    }
}

/// Who simulates a flock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Simulator {
    /// The GPU if one draws and is no software, else the CPU.
    Auto,
    /// The GPU; nobody's place ever comes to the CPU.
    Gpu,
    /// The CPU, which sends everyone to the GPU each frame.
    Cpu,
}

/// Places, by name or from a file.
#[derive(Debug, Clone, PartialEq)]
pub enum LayoutPlan {
    /// A layout of `crowd-scene`.
    Named(Layout),
    /// A layout file.
    File(PathBuf),
    /// Not places but ways.
    Feed(FeedPlan),
}

/// People who move.
#[derive(Debug, Clone, PartialEq)]
pub enum FeedPlan {
    /// A simulator's file.
    Trajectories {
        /// The file.
        path: PathBuf,
        /// Frames a second, for a file that does not say.
        rate_hz: Option<f64>,
    },
    /// Reynolds' boids.
    Flock {
        /// People.
        count: u32,
    },
    /// A walk along waypoints, of as many people as the crowd has.
    Walk {
        /// The file; `None`: a rectangle with room for everyone.
        path: Option<PathBuf>,
    },
}

/// Which clips play.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ClipPlan {
    /// All of a character with few clips; idle, walk and run of one with many.
    Usual,
    /// All.
    All,
    /// Those whose name is, or else contains, one of these.
    Named(Vec<String>),
}

/// What people on their places do from second to second.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MotionPlanWord {
    /// Each plays one clip.
    Off,
    /// They go by a graph made from the clips that may play.
    Usual,
    /// By a graph from a file.
    File(PathBuf),
}

/// How high characters are shown.
#[derive(Debug, Clone, PartialEq)]
pub enum HeightPlan {
    /// As baked, except for those that must be in centimetres.
    Usual,
    /// As baked.
    Source,
    /// All so many metres.
    All(f32),
    /// Some by name, metres; the others as usual.
    Named(Vec<(String, f32)>),
}

/// Level of detail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetailPlan {
    /// Vertices a frame; `None`: the crowd's coarsest levels and [`GPU_BUDGET`] or [`SOFTWARE_BUDGET`] more.
    pub budget: Option<u32>,
    /// What it counts.
    pub budget_in: BudgetIn,
    /// Share of it that may be left over so that levels keep still.
    pub slack_share: f32,
    /// Exponent of the split.
    pub alpha: f32,
    /// Weight of an instance.
    pub weight: Weight,
    /// How it is drawn.
    pub draw: DrawOptions,
    /// Pixels of error that should hold.
    pub max_px: Option<f32>,
    /// What a frame may take, milliseconds.
    pub target_ms: Option<f32>,
    /// Height below which somebody is their impostor, where the pack has them, pixels; 0: nobody.
    pub impostors_px: f32,
    /// Height below which somebody may be dots, pixels; 0: nobody.
    pub dots_px: f32,
    /// How far one sees in fog, metres; 0: no fog.
    pub sight_m: f32,
    /// How long poses are held, where they are.
    pub pose_rates: PoseRates,
    /// Depths of the discrete levels; `None`: from heights in pixels.
    pub lod_depths_m: Option<[f32; 2]>,
    /// The user named the technique.
    pub technique_is_given: bool,
}

/// From where the crowd is seen.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraPlan {
    /// Framed so that the crowd fills the picture.
    Framed {
        /// Vertical field of view.
        fov_y_rad: f32,
    },
    /// Given.
    Fixed {
        /// Position, metres.
        eye: [f32; 3],
        /// Looked at, metres.
        target: [f32; 3],
        /// Vertical field of view.
        fov_y_rad: f32,
    },
    /// Around a point.
    Orbit {
        /// 0 is in front of the characters (+Z).
        azimuth_rad: f32,
        /// Above the ground.
        elevation_rad: f32,
        /// Metres.
        distance_m: f32,
        /// `None`: the crowd's middle.
        target: Option<[f32; 3]>,
        /// Vertical field of view.
        fov_y_rad: f32,
    },
    /// From a file, over time.
    Path {
        /// The file; it holds the fields of view, too.
        path: PathBuf,
    },
    /// Made for the crowd, over time.
    Way {
        /// Which.
        way: CameraWay,
        /// Vertical field of view.
        fov_y_rad: f32,
    },
}

/// Camera paths that need no file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraWay {
    /// Once around in 20 s.
    Orbit,
    /// From corner to corner in 20 s.
    Straight,
    /// Down, through, around and up again in 1,000 frames of 1/30 s.
    Walkthrough,
}

/// What draws.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MachinePlan {
    /// GPU, CPU or whichever there is.
    pub backend: BackendWord,
    /// Part of the adapter's name.
    pub adapter: Option<String>,
    /// Samples a pixel, 1 or 4; `None`: 4, but 1 in a window that a processor draws.
    pub samples: Option<u32>,
    /// GPU memory that may be taken, bytes.
    pub vram_bytes: Option<u64>,
}

/// Window or pictures.
#[derive(Debug, Clone, PartialEq)]
pub enum Show {
    /// A window; closes after `frames`.
    Window {
        /// `None`: stays open.
        frames: Option<u32>,
    },
    /// Pictures and a report.
    Headless(HeadlessPlan),
}

/// Frames without a window.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadlessPlan {
    /// At least one.
    pub frames: u32,
    /// Seconds between frames.
    pub dt_s: f32,
    /// Time of the first frame, seconds.
    pub start_s: f32,
    /// Pictures.
    pub out: Option<PictureName>,
}

/// Where pictures go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PictureName {
    /// The last frame, to standard output.
    Stdout,
    /// The last frame, to a file.
    Last(PathBuf),
    /// All frames, to a film.
    Film(PathBuf),
    /// Each frame: text before the number, digits to pad to, text after it.
    Each {
        /// Before.
        before: String,
        /// At least so many digits.
        digits: usize,
        /// After.
        after: String,
    },
}

impl PictureName {
    /// Reads `%d` or `%04d` in the file's name.
    fn parse(out: &Path) -> Result<Self> {
        let Some(text) = out.to_str() else { return Ok(Self::Last(out.to_owned())) };
        if text == "-" {
            return Ok(Self::Stdout);
        }
        let Some((before, rest)) = text.split_once('%') else {
            let is_film = crate::film::is_film(out);
            return Ok(if is_film { Self::Film(out.to_owned()) } else { Self::Last(out.to_owned()) });
        };
        let refused = || Error::Parameter {
            option: "--out",
            found: text.to_owned(),
            allowed: "one %d or %04d for the frame's number".to_owned(),
        };
        let (digits, after) = rest.split_once('d').ok_or_else(refused)?;
        if digits.len() > 2 || !digits.chars().all(|c| c.is_ascii_digit()) || after.contains('%') {
            return Err(refused());
        }
        let digits = digits.parse().unwrap_or(1);
        Ok(Self::Each { before: before.to_owned(), digits, after: after.to_owned() })
    }

    /// File of a frame, if that frame is to be written to a file.
    pub fn file_of(&self, frame: u32, frames: u32) -> Option<PathBuf> {
        match self {
            Self::Stdout => None,
            Self::Last(path) | Self::Film(path) => (frame + 1 == frames).then(|| path.clone()),
            Self::Each { before, digits, after } => {
                Some(PathBuf::from(format!("{before}{frame:0width$}{after}", width = digits)))
            }
        }
    }

    /// Whether the frame's pixels are needed at all.
    pub fn wants(&self, frame: u32, frames: u32) -> bool {
        frame + 1 == frames || matches!(self, Self::Each { .. } | Self::Film(_))
    }
}

/// Decides. The pack is there: clap asked for it.
pub fn plan(args: &Args) -> Result<Plan> {
    let show = if args.headless {
        let out = args.out.as_deref().map(PictureName::parse).transpose()?;
        Show::Headless(HeadlessPlan {
            frames: args.frames.unwrap_or(1),
            dt_s: args.dt.unwrap_or(1.0 / 30.0),
            start_s: args.start,
            out,
        })
    } else {
        Show::Window { frames: args.frames }
    };
    if let Show::Headless(HeadlessPlan { out: Some(PictureName::Stdout), .. }) = &show
        && args.report.as_deref() == Some(Path::new("-"))
    {
        return Err(Error::Parameter {
            option: "--report",
            found: "- together with --out -".to_owned(),
            allowed: "one of the two on standard output".to_owned(),
        });
    }
    if args.backend == BackendWord::Cpu && args.adapter.is_some() {
        return Err(Error::Parameter {
            option: "--adapter",
            found: "with --backend cpu".to_owned(),
            allowed: "gpu or auto".to_owned(),
        });
    }
    if args.weight == WeightWord::AreaDistance && args.alpha <= 1.0 {
        return Err(Error::Parameter {
            option: "--alpha",
            found: args.alpha.to_string(),
            allowed: "more than 1 with --weight area-distance".to_owned(),
        });
    }
    check_budget(args)?;
    check_occlusion(args)?;
    check_skinning(args)?;
    check_simulator(args)?;
    check_reference(args)?;
    check_view(args)?;
    if args.shadows > 0 && args.backend == BackendWord::Cpu {
        return Err(Error::Parameter {
            option: "--shadows",
            found: format!("{} with --backend cpu", args.shadows),
            allowed: "off, since the software rasteriser draws none".to_owned(),
        });
    }
    if args.pose_rates != PoseRates::Off && args.backend == BackendWord::Cpu {
        return Err(Error::Parameter {
            option: "--pose-rates",
            found: "with --backend cpu".to_owned(),
            allowed: "off, since the software rasteriser poses everyone anew".to_owned(),
        });
    }
    check_sharing(args)?;
    Ok(Plan {
        pack: args.pack.clone().unwrap_or_default(),
        crowd: CrowdPlan {
            count: args.count,
            layout: layout(args)?,
            simulator: match args.simulate {
                SimulatorWord::Auto => Simulator::Auto,
                SimulatorWord::Gpu => Simulator::Gpu,
                SimulatorWord::Cpu => Simulator::Cpu,
            },
            walkable: args.walkable.clone(),
            spacing_m: args.spacing,
            characters: args.characters.clone(),
            clips: clips(&args.clips),
            height: height(&args.height)?,
            seed: args.seed,
            motion: motion(args)?,
            measures_speeds: args.pose_rates != PoseRates::Off,
            fade_s: args.fade,
            texture_side: args.texture_side,
        },
        detail: DetailPlan {
            budget: args.budget,
            budget_in: args.room.budget_in.budget_in(),
            slack_share: steady_percent(args) / 100.0,
            alpha: args.alpha,
            weight: match (args.lod_metric, args.weight) {
                (MetricWord::Error, _) => Weight::Error,
                (MetricWord::Size, WeightWord::Area) => Weight::Area,
                (MetricWord::Size, WeightWord::AreaDistance) => Weight::AreaDistance,
            },
            max_px: args.max_px,
            target_ms: args.target_ms,
            impostors_px: args.impostors,
            dots_px: args.dots,
            sight_m: args.fog,
            draw: DrawOptions {
                technique: args.technique.unwrap_or(Technique::Bucketed),
                fit: match args.fit {
                    FitWord::Fill => Fit::Fill,
                    FitWord::Eq1 => Fit::Plain,
                },
                no_morph: args.no_morph,
                no_impostors: false,
                occlusion: args.occlusion == Switch::On,
                skinning: args.skinning.skinning(),
                shadows: args.shadows,
                holds_poses: args.pose_rates != PoseRates::Off,
                share_poses: args.share_poses == Switch::On,
                view: args.view,
                frozen: args.freeze,
                levels: if args.snap_levels { Levels::Quantized } else { Levels::Continuous },
            },
            pose_rates: args.pose_rates,
            lod_depths_m: args.lod_depths,
            technique_is_given: args.technique.is_some(),
        },
        camera: seen_from::camera(args)?,
        machine: MachinePlan {
            backend: args.backend,
            adapter: args.adapter.clone(),
            samples: args.msaa,
            vram_bytes: args.room.vram.map(|megabytes| u64::from(megabytes) * MEGABYTE),
        },
        size: args.size,
        report: args.report.clone(),
        reference_camera: args.reference_camera,
        record_camera: args.record_camera.clone(),
        show,
    })
}

/// Eq. 1 as printed has no water that could stay.
fn steady_percent(args: &Args) -> f32 {
    let has_water = args.fit == FitWord::Fill || args.lod_metric == MetricWord::Error;
    args.room.steady.unwrap_or(if has_water { STEADY_PERCENT } else { 0.0 })
}

fn layout(args: &Args) -> Result<LayoutPlan> {
    if let Some(path) = &args.trajectories {
        let rate_hz = args.trajectory_rate.map(f64::from);
        return Ok(LayoutPlan::Feed(FeedPlan::Trajectories { path: path.clone(), rate_hz }));
    }
    if let Some(count) = args.flock {
        return Ok(LayoutPlan::Feed(FeedPlan::Flock { count }));
    }
    if let Some(way) = &args.walk {
        let path = (way.as_os_str() != AROUND).then(|| way.clone());
        return Ok(LayoutPlan::Feed(FeedPlan::Walk { path }));
    }
    let word = args.layout.as_str();
    if let Some(layout) = Layout::named(word) {
        return Ok(LayoutPlan::Named(layout));
    }
    Ok(match word {
        file if file.contains(['.', '/', '\\']) => LayoutPlan::File(PathBuf::from(file)),
        other => {
            return Err(Error::Parameter {
                option: "--layout",
                found: other.to_owned(),
                allowed: format!("{}, or a file", Layout::names()),
            });
        }
    })
}

/// People who walk change clips by their speed, and nobody tells them otherwise.
fn motion(args: &Args) -> Result<MotionPlanWord> {
    let word = args.motion_graph.as_os_str().to_str().unwrap_or_default();
    let feeds = [("--trajectories", args.trajectories.is_some()), ("--walk", args.walk.is_some())];
    let feed = feeds.into_iter().chain([("--flock", args.flock.is_some())]).find(|(_, is_given)| *is_given);
    match (word, feed) {
        ("off", _) => Ok(MotionPlanWord::Off),
        (_, Some((option, _))) => Err(Error::Parameter {
            option: "--motion-graph",
            found: format!("{} with {option}", args.motion_graph.display()),
            allowed: "off, since people who walk change clips by their speed".to_owned(),
        }),
        ("auto", _) => Ok(MotionPlanWord::Usual),
        _ => Ok(MotionPlanWord::File(args.motion_graph.clone())),
    }
}

fn clips(words: &[String]) -> ClipPlan {
    match words {
        [] => ClipPlan::Usual,
        [all] if all.eq_ignore_ascii_case("all") => ClipPlan::All,
        names => ClipPlan::Named(names.to_vec()),
    }
}

fn height(words: &[String]) -> Result<HeightPlan> {
    let refused = |word: &str| Error::Parameter {
        option: "--height",
        found: word.to_owned(),
        allowed: "metres from 0.01 to 1000, NAME=metres, or source".to_owned(),
    };
    let metres = |word: &str, text: &str| {
        text.trim().parse().ok().filter(|m| (0.01..=1000.0).contains(m)).ok_or_else(|| refused(word))
    };
    match words {
        [] => Ok(HeightPlan::Usual),
        [source] if source.eq_ignore_ascii_case("source") => Ok(HeightPlan::Source),
        [all] if !all.contains('=') => Ok(HeightPlan::All(metres(all, all)?)),
        some => {
            let named = |word: &String| {
                let (name, text) = word.rsplit_once('=').ok_or_else(|| refused(word))?;
                Ok((name.to_owned(), metres(word, text)?))
            };
            Ok(HeightPlan::Named(some.iter().map(named).collect::<Result<_>>()?))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    fn planned(words: &[&str]) -> Result<Plan> {
        let words = ["crowdplay", "p.crowdpack"].iter().chain(words);
        plan(&Args::try_parse_from(words).expect("the words are clap's to accept"))
    }

    #[test]
    fn numbers_in_file_names() {
        let each = PictureName::parse(Path::new("a/frame-%04d.png")).unwrap();
        assert_eq!(each.file_of(7, 10), Some(PathBuf::from("a/frame-0007.png")));
        assert!(each.wants(7, 10));
        let last = PictureName::parse(Path::new("x.png")).unwrap();
        assert_eq!(last.file_of(7, 10), None);
        assert_eq!(last.file_of(9, 10), Some(PathBuf::from("x.png")));
        assert!(!last.wants(7, 10) && last.wants(9, 10));
        for bad in ["%s.png", "%d-%d.png", "100%.png", "%0004d.png"] {
            assert!(PictureName::parse(Path::new(bad)).is_err(), "{bad}");
        }
    }

    #[test]
    fn options_that_exclude_each_other_are_usage_errors() {
        let table: &[&[&str]] = &[
            &["--headless", "--out", "-", "--report", "-"],
            &["--backend", "cpu", "--adapter", "x"],
            &["--weight", "area-distance", "--alpha", "1"],
            &["--target", "1,2,3"],
            &["--occlusion", "on", "--technique", "reform"],
            &["--occlusion", "on", "--fit", "eq1"],
            &["--skinning", "compute", "--technique", "reform"],
            &["--skinning", "palettes", "--backend", "cpu"],
            &["--shadows", "4", "--backend", "cpu"],
            &["--motion-graph", "auto", "--walk"],
            &["--pose-rates", "60", "--backend", "cpu"],
            &["--share-poses", "on", "--skinning", "compute"],
            &["--share-poses", "on", "--pose-rates", "60"],
            &["--motion-graph", "dance.txt", "--flock", "100"],
            &["--simulate", "gpu"],
            &["--view", "levels", "--backend", "cpu"],
            &["--view", "levels", "--technique", "b0"],
            &["--view", "density", "--occlusion", "on"],
            &["--view", "occlusion"],
            &["--reference-camera", "--backend", "cpu"],
            &["--reference-camera", "--occlusion", "on"],
            &["--reference-camera", "--technique", "b2"],
            &["--simulate", "cpu", "--walk"],
            &["--flock", "9", "--simulate", "gpu", "--backend", "cpu"],
            &["--eye", "1,2,3", "--target", "1,2,3"],
            &["--orbit", "0,90,10"],
            &["--layout", "circle"],
            &["--height", "tall"],
            &["--height", "0"],
            &["--height", "a=1,2"],
        ];
        for words in table {
            let error = planned(words).expect_err("these words contradict each other");
            assert_eq!(error.exit_code(), crate::error::EXIT_USAGE, "{words:?}: {error}");
        }
    }

    #[test]
    fn defaults() {
        let plan = planned(&[]).unwrap();
        assert_eq!(plan.show, Show::Window { frames: None });
        assert_eq!(plan.crowd.clips, ClipPlan::Usual);
        assert_eq!(plan.detail.draw, DrawOptions::from(Technique::Bucketed));
        let named = HeightPlan::Named(vec![("a".into(), 2.0), ("b=c".into(), 0.5)]);
        assert_eq!(planned(&["--height", "a=2,b=c=0.5"]).unwrap().crowd.height, named);
        assert_eq!(planned(&["--height", "1.8"]).unwrap().crowd.height, HeightPlan::All(1.8));
        assert_eq!(planned(&["--layout", "a.toml"]).unwrap().crowd.layout, LayoutPlan::File("a.toml".into()));
    }
}
