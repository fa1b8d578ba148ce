//! What the command line means: one plan, all defaults decided, no file opened yet.

mod contradictions;
mod picture_name;
mod seen_from;
mod who_where;

pub use picture_name::PictureName;
pub use who_where::{ClipPlan, CrowdPlan, FeedPlan, HeightPlan, ImpostorsPlan, LayoutPlan, MotionPlanWord, Simulator};

use crate::budget_words::STEADY_PERCENT;
use crate::cli::{
    Args, BackendWord, COUNT, FitWord, IMPOSTORS_PX, MetricWord, PoseRates, SimulatorWord, Switch, WeightWord,
};
use crate::memory::MEGABYTE;
use crate::{Error, Result};
use contradictions::{
    check_budget, check_impostors, check_occlusion, check_reference, check_sharing, check_simulator, check_skinning,
    check_unheeded, check_view, check_window,
};
use crowd_stages::{BudgetIn, DrawOptions, Fit, Levels, Technique, Weight};
use std::path::{Path, PathBuf};
use who_where::{clips, height, impostors, layout, motion};

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
    /// A window.
    Window(WindowPlan),
    /// Pictures and a report.
    Headless(HeadlessPlan),
}

/// A window.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowPlan {
    /// Frames after which it closes; `None`: stays open.
    pub frames: Option<u32>,
    /// Time of the first frame, seconds.
    pub start_s: f32,
    /// Seconds of the crowd a second of the clock; 0: it stands still.
    pub time_scale: f32,
    /// Numbers and controls are shown.
    pub overlay: bool,
    /// Picture of the window at its last frame, or when it is closed before.
    pub screenshot: Option<PathBuf>,
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
        if let Some(file) = &args.window.screenshot {
            picture_name::expect_png(file)?;
        }
        Show::Window(WindowPlan {
            frames: args.frames,
            start_s: args.start,
            time_scale: args.window.time_scale,
            overlay: !args.window.no_overlay,
            screenshot: args.window.screenshot.clone(),
        })
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
    check_window(args)?;
    check_budget(args)?;
    check_unheeded(args)?;
    check_occlusion(args)?;
    check_skinning(args)?;
    check_simulator(args)?;
    check_reference(args)?;
    check_view(args)?;
    check_impostors(args)?;
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
            count: args.count.unwrap_or(COUNT),
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
            impostors: impostors(args),
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
            impostors_px: args.impostors.unwrap_or(IMPOSTORS_PX),
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    fn planned(words: &[&str]) -> Result<Plan> {
        let words = ["crowdplay", "p.crowdpack"].iter().chain(words);
        plan(&Args::try_parse_from(words).expect("the words are clap's to accept"))
    }

    #[test]
    fn options_that_exclude_each_other_are_usage_errors() {
        let table: &[&[&str]] = &[
            &["--headless", "--out", "-", "--report", "-"],
            &["--backend", "cpu", "--adapter", "x"],
            &["--dt", "0.1"],
            &["--impostors", "20", "--technique", "reform"],
            &["--impostors", "20", "--fit", "eq1"],
            &["--impostors", "20", "--lod-metric", "error"],
            &["--impostors", "20", "--backend", "cpu"],
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
            &["--flock", "10", "--count", "4"],
            &["--flock", "--count", "1000001"],
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
    fn impostors_are_kept_where_they_may_be_drawn() {
        let of = |words: &[&str]| planned(words).expect("these words agree").crowd.impostors;
        // In a window one may switch over to what draws them.
        assert_eq!([of(&[]), of(&["--technique", "reform"])], [ImpostorsPlan::IfThere; 2]);
        assert_eq!(
            [of(&["--headless"]), of(&["--headless", "--impostors", "9"])],
            [ImpostorsPlan::IfThere, ImpostorsPlan::Asked]
        );
        for words in [&["--impostors", "0"][..], &["--headless", "--fit", "eq1"], &["--headless", "--backend", "cpu"]] {
            assert_eq!(of(words), ImpostorsPlan::Off, "{words:?}");
        }
    }

    #[test]
    fn a_flock_is_counted_by_its_own_word_or_by_count() {
        let of = |words: &[&str]| planned(words).expect("these words agree").crowd.layout;
        for (words, count) in [
            (&["--flock", "10"][..], 10),
            (&["--flock", "--count", "4"], 4),
            (&["--count", "4", "--flock"], 4),
            (&["--flock"], COUNT),
        ] {
            assert_eq!(of(words), LayoutPlan::Feed(FeedPlan::Flock { count }), "{words:?}");
        }
    }

    #[test]
    fn defaults() {
        let plan = planned(&[]).unwrap();
        let window = WindowPlan { frames: None, start_s: 0.0, time_scale: 1.0, overlay: true, screenshot: None };
        assert_eq!(plan.show, Show::Window(window));
        assert_eq!(plan.crowd.clips, ClipPlan::Usual);
        assert_eq!(plan.detail.draw, DrawOptions::default());
        // What engines get by one call.
        let camera = crowd_scene::overlook(glam::Vec3::ZERO, glam::Vec3::ONE, 1.5);
        let config = crate::view::frame_config(&camera, [640, 360], 0.0, &plan.detail, 123_456);
        assert_eq!(config, config.with_usual_detail());
        assert!(config.slack > 0 && config.dot_area_px2 > 0.0);
        let named = HeightPlan::Named(vec![("a".into(), 2.0), ("b=c".into(), 0.5)]);
        assert_eq!(planned(&["--height", "a=2,b=c=0.5"]).unwrap().crowd.height, named);
        assert_eq!(planned(&["--height", "1.8"]).unwrap().crowd.height, HeightPlan::All(1.8));
        assert_eq!(planned(&["--layout", "a.toml"]).unwrap().crowd.layout, LayoutPlan::File("a.toml".into()));
    }
}
