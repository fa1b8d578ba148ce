//! Who stands where and does what, as the words say.

use crate::cli::{AROUND, Args, BackendWord, COUNT, FitWord, MOST_BOIDS, MetricWord};
use crate::{Error, Result};
use crowd_scene::Layout;
use crowd_stages::Technique;
use std::path::PathBuf;

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
    /// Whether impostors take memory.
    pub impostors: ImpostorsPlan,
}

/// Whether impostors take memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImpostorsPlan {
    /// Nobody will be one.
    Off,
    /// Where the pack has them.
    IfThere,
    /// The same, and it is said where it has none.
    Asked,
}

impl CrowdPlan {
    /// How many people were asked for.
    pub fn people(&self) -> u32 {
        match self.layout {
            LayoutPlan::Feed(FeedPlan::Flock { count }) => count,
            _ => self.count,
        }
    }

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

pub(super) fn layout(args: &Args) -> Result<LayoutPlan> {
    if let Some(path) = &args.trajectories {
        let rate_hz = args.trajectory_rate.map(f64::from);
        return Ok(LayoutPlan::Feed(FeedPlan::Trajectories { path: path.clone(), rate_hz }));
    }
    if let Some(said) = args.flock {
        let count = flock_count(args, said)?;
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

/// How many flock: `--flock` says it, or `--count`, not both.
fn flock_count(args: &Args, said: Option<u32>) -> Result<u32> {
    match (said, args.count) {
        (Some(said), Some(count)) => Err(Error::Parameter {
            option: "--flock",
            found: format!("{said} with --count {count}"),
            allowed: format!("one of the two: --flock {said}, or --flock --count {count}"),
        }),
        (None, Some(count)) if i64::from(count) > MOST_BOIDS => Err(Error::Parameter {
            option: "--count",
            found: format!("{count} with --flock"),
            allowed: format!("1 to {MOST_BOIDS} with --flock"),
        }),
        (said, count) => Ok(said.or(count).unwrap_or(COUNT)),
    }
}

/// People who walk change clips by their speed, and nobody tells them otherwise.
pub(super) fn motion(args: &Args) -> Result<MotionPlanWord> {
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

/// In a window one may switch over to what draws them.
pub(super) fn impostors(args: &Args) -> ImpostorsPlan {
    let is_bucketed = args.technique.is_none_or(|technique| technique == Technique::Bucketed);
    let is_drawn = is_bucketed && args.fit == FitWord::Fill && args.lod_metric == MetricWord::Size;
    let may_be_drawn = args.backend != BackendWord::Cpu && (is_drawn || !args.headless);
    match args.impostors {
        Some(px) if px > 0.0 => ImpostorsPlan::Asked,
        None if may_be_drawn => ImpostorsPlan::IfThere,
        _ => ImpostorsPlan::Off,
    }
}

pub(super) fn clips(words: &[String]) -> ClipPlan {
    match words {
        [] => ClipPlan::Usual,
        [all] if all.eq_ignore_ascii_case("all") => ClipPlan::All,
        names => ClipPlan::Named(names.to_vec()),
    }
}

pub(super) fn height(words: &[String]) -> Result<HeightPlan> {
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
