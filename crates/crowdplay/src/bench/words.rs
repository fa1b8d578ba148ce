//! The words of `crowdplay bench`: those of the player that say what is seen, and its own.

use super::condition::Condition;
use super::variant::{Variant, variants};
use crate::cli::Args;
use crate::output_paths;
use crate::plan::{self, Plan};
use crate::shell_word::shell_word;
use crate::{Error, Result};
use clap::parser::ValueSource;
use clap::{Args as _, CommandFactory, FromArgMatches, ValueHint};
use std::ffi::OsString;
use std::path::PathBuf;

/// The first word that asks for a bench.
pub const NAME: &str = "bench";

const USAGE: &str = "crowdplay bench [OPTIONS] --ab <NAME,...> <PACK>";

const EXAMPLES: &str = "\
Examples:
  The papers' baseline, their method and ours, 8192 instances:
    crowdplay bench cast.crowdpack --ab b0,b3,bucketed --count 8192

  How each grows with the crowd, as a table for a spreadsheet:
    crowdplay bench cast.crowdpack --ab b0,b3,bucketed --counts 32,512,8192 --csv growth.csv

  A pipeline that fails when ours is not four times as fast as the baseline, or level of detail costs too much:
    crowdplay bench cast.crowdpack --ab b0,bucketed \\
      --assert 'bucketed/b0 <= 0.25' --assert 'lod_share:bucketed <= 0.0665'

Conditions: [QUANTITY:]A/B OP NUMBER, or [QUANTITY:]A OP NUMBER; A and B are techniques of --ab, OP is <=, <, >= or >. They must hold at
every count and budget. Quantities: frame_ms (the median, if none is named), frame_p95_ms, cpu_ms (recording and
submitting), cpu_share (of the frame), gpu_ms, lod_ms (everything but skinning and drawing), lod_share (its
part of gpu_ms), draw_ms, shadows_ms, triangles, vertices, hidden (by others), draws, vertex_runs, runs_per_triangle, mean_runs_per_triangle and
most_runs_per_triangle (of all frames), triangles_at_equal_image (A with the least budget that brings its image_rmse down to B's), poses (worked out, where they are shared), pose_share (of visible), image_rmse (to
full detail), pop_rmse, pop_px, pop_energy (of --pops; the last is pop_px squared), most_level_steps and level_steps_beyond_next (of --pops: how many of the
quantised levels anybody goes from one frame to the next, and the share of those who go farther than one).

Exit codes: those of the player, and 4 when a condition does not hold.";

/// Words of the player that mean nothing here.
const FOREIGN: [&str; 14] = [
    "time_scale",
    "no_overlay",
    "screenshot",
    "target_ms",
    "freeze",
    "view",
    "reference_camera",
    "headless",
    "frames",
    "out",
    "report",
    "technique",
    "list_adapters",
    "completions",
];

/// What only a bench is asked.
#[derive(Debug, Clone, clap::Args)]
pub struct BenchWords {
    /// Techniques that draw in turn, by name: b0, b3, bucketed, bucketed+occlusion, bucketed+compute, ...; the first is what the others are
    /// compared with
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', required = true, value_parser = variants(),
          help_heading = "Bench")]
    pub ab: Vec<Variant>,

    /// Frames of each technique that count
    #[arg(long, default_value_t = 60, value_name = "ROUNDS", value_parser = clap::value_parser!(u32).range(1..=100_000),
          help_heading = "Bench")]
    pub rounds: u32,

    /// Frames of each technique before those, not counted: they compile shaders and fill caches
    #[arg(long, default_value_t = 3, value_name = "ROUNDS", value_parser = clap::value_parser!(u32).range(1..=1000),
          help_heading = "Bench")]
    pub warm_up: u32,

    /// Frames of each technique, evenly spaced over the whole of --camera-path, instead of --rounds frames --dt apart; pictures are compared
    /// at the middle one
    #[arg(long, value_name = "FRAMES", requires = "camera_path", conflicts_with_all = ["rounds", "dt", "start"],
          value_parser = clap::value_parser!(u32).range(2..=100_000), help_heading = "Bench")]
    pub path: Option<u32>,

    /// Sizes of the crowd, one after another, instead of --count
    #[arg(long, value_name = "COUNT,...", value_delimiter = ',', conflicts_with = "count",
          value_parser = clap::value_parser!(u32).range(1..=4_000_000), help_heading = "Bench")]
    pub counts: Vec<u32>,

    /// Vertices for a frame, one after another, instead of --budget
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with = "budget",
          value_parser = clap::value_parser!(u32).range(1..), help_heading = "Bench")]
    pub budgets: Vec<u32>,

    /// Vertices a person, instead of --budget: N grows with the crowd, as that of Peng 2011 does
    #[arg(long, value_name = "VERTICES", conflicts_with_all = ["budget", "budgets"],
          value_parser = clap::value_parser!(u32).range(1..=1_000_000), help_heading = "Bench")]
    pub budget_each: Option<u32>,

    /// Also measure how much of each picture changes by levels alone: every frame once more with the levels of the frame before
    #[arg(long, help_heading = "Bench")]
    pub pops: bool,

    /// One row for each technique and count, comma-separated; - for standard output
    #[arg(long, value_name = "CSV", value_hint = ValueHint::FilePath, help_heading = "Bench")]
    pub csv: Option<PathBuf>,

    /// Everything, as JSON; - for standard output
    #[arg(long, value_name = "JSON", value_hint = ValueHint::FilePath, help_heading = "Bench")]
    pub json: Option<PathBuf>,

    /// A page with a table, for documentation; - for standard output
    #[arg(long, value_name = "MD", value_hint = ValueHint::FilePath, help_heading = "Bench")]
    pub markdown: Option<PathBuf>,

    /// A condition that must hold, or exit code 4; may be given several times
    #[arg(long, value_name = "CONDITION", help_heading = "Bench")]
    pub assert: Vec<Condition>,
}

impl BenchWords {
    /// Where its outputs go, if asked for.
    fn outputs(&self) -> [(&'static str, Option<&PathBuf>); 3] {
        [("--csv", self.csv.as_ref()), ("--json", self.json.as_ref()), ("--markdown", self.markdown.as_ref())]
    }
}

/// A bench as asked for.
#[derive(Debug)]
pub struct Asked {
    /// Its own words.
    pub words: BenchWords,
    /// What is seen.
    pub plan: Plan,
    /// Sizes of the crowd.
    pub counts: Vec<u32>,
    /// Vertices for a frame at each, unless `--budget-each` says them; `None` is the player's usual number.
    pub budgets: Vec<Option<u32>>,
    /// Say nothing but errors.
    pub quiet: bool,
    /// The words as typed, for the page.
    pub typed: String,
}

impl Asked {
    /// Vertices for a frame of so many people, one after another.
    pub fn budgets_of(&self, count: u32) -> Vec<Option<u32>> {
        let each = |each: u32| vec![Some(each.saturating_mul(count))];
        self.words.budget_each.map_or_else(|| self.budgets.clone(), each)
    }
}

/// The words for clap: the player's without those that make no sense here, and the bench's.
pub fn command() -> clap::Command {
    let mut command = Args::command()
        .name("crowdplay bench")
        .bin_name("crowdplay bench")
        .about("Draw a crowd with several techniques in turn and compare their times")
        .override_usage(USAGE)
        .after_help(EXAMPLES);
    for id in FOREIGN {
        command = command.mut_arg(id, |arg| arg.hide(true));
    }
    BenchWords::augment_args(command)
}

/// Reads the words after `crowdplay bench`; the first is ignored, as a program's name is.
///
/// # Errors
/// Clap's, for words it does not know.
pub fn parse(words: impl IntoIterator<Item = OsString>) -> std::result::Result<Result<Asked>, clap::Error> {
    let words: Vec<OsString> = words.into_iter().collect();
    let typed: Vec<String> = words.iter().map(|word| shell_word(&word.to_string_lossy())).collect();
    let matches = command().try_get_matches_from(words)?;
    let mut args = Args::from_arg_matches(&matches)?;
    let words = BenchWords::from_arg_matches(&matches)?;
    let was_typed = |id: &&'static str| matches.value_source(id) == Some(ValueSource::CommandLine);
    if let Some(id) = FOREIGN.into_iter().find(was_typed) {
        let what = format!("--{} is a word of the player, not of bench\n", id.replace('_', "-"));
        return Err(command().error(clap::error::ErrorKind::ArgumentConflict, what));
    }
    args.headless = true;
    Ok(decide(&args, words, format!("crowdplay {}", typed.join(" "))))
}

fn decide(args: &Args, mut words: BenchWords, typed: String) -> Result<Asked> {
    words.rounds = words.path.unwrap_or(words.rounds);
    for (i, technique) in words.ab.iter().enumerate() {
        if words.ab[..i].contains(technique) {
            return Err(refused("--ab", format!("{technique} twice"), "each technique once"));
        }
    }
    if args.motion_graph.as_os_str() != "off" && words.ab.iter().any(|variant| variant.fades) {
        let found = format!("+fades with --motion-graph {}", args.motion_graph.display());
        return Err(refused("--ab", found, "+fades where everyone else plays one clip"));
    }
    for condition in &words.assert {
        if let Some(missing) = condition.variants().find(|variant| !words.ab.contains(variant)) {
            return Err(refused("--assert", format!("{missing} in {condition:?}"), "techniques of --ab"));
        }
    }
    if let Some(condition) =
        words.assert.iter().find(|c| c.equal_image().is_some_and(|(a, _)| !a.technique.has_budget()))
    {
        return Err(refused("--assert", condition.to_string(), "a technique with a budget before the slash"));
    }
    if let Some(condition) = words.assert.iter().find(|c| c.needs_pops() && !words.pops) {
        return Err(refused("--assert", format!("{condition} without --pops"), "it with --pops, which measures that"));
    }
    let outputs: Vec<(&'static str, &PathBuf)> =
        words.outputs().into_iter().filter_map(|(option, path)| Some((option, path?))).collect();
    for (i, (option, path)) in outputs.iter().enumerate() {
        if let Some((other, _)) = outputs[..i].iter().find(|(_, taken)| taken == path) {
            return Err(refused(option, format!("{}, the place of {other}", path.display()), "a place of its own"));
        }
    }
    let mut plan = plan::plan(args)?;
    let counts = if words.counts.is_empty() { vec![plan.crowd.people()] } else { words.counts.clone() };
    if let Some(found) = words.assert.iter().find_map(|condition| condition.unmeasured(plan.detail.draw)) {
        return Err(refused("--assert", found, "what is measured of that technique"));
    }
    if words.ab.iter().any(|variant| variant.rates || variant.shares) {
        // Then --pose-rates says how long those hold poses, not that everyone does.
        plan.crowd.measures_speeds = true;
        plan.detail.draw.holds_poses = false;
    }
    if !words.ab.iter().any(|variant| variant.impostors) {
        plan.crowd.impostors = plan::ImpostorsPlan::Off;
    } else if plan.crowd.impostors == plan::ImpostorsPlan::Off {
        return Err(refused(
            "--ab",
            "+impostors where nobody is one".to_owned(),
            "+impostors with --impostors above 0, --fit fill and --lod-metric size",
        ));
    }
    let budgets = match &words.budgets[..] {
        [] => vec![plan.detail.budget],
        all => all.iter().copied().map(Some).collect(),
    };
    for (option, path) in outputs {
        output_paths::refuse_inputs(&plan, option, path)?;
        output_paths::expect_writable(path)?;
    }
    Ok(Asked { plan, counts, budgets, quiet: args.quiet, typed, words })
}

fn refused(option: &'static str, found: String, allowed: &str) -> Error {
    Error::Parameter { option, found, allowed: allowed.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(words: &[&str]) -> std::result::Result<Result<Asked>, clap::Error> {
        parse(["bench"].iter().chain(words).map(OsString::from))
    }

    use crowd_stages::Technique;

    #[test]
    fn the_words_are_consistent() {
        command().debug_assert();
    }

    #[test]
    fn a_bench_has_the_players_scene_and_its_own_words() {
        let words =
            ["p", "--ab", "b0,bucketed", "--layout", "street", "--counts", "8,64", "--assert", "bucketed/b0<=0.5"];
        let asked = parsed(&words).unwrap().unwrap();
        assert_eq!(asked.words.ab, [Technique::PseudoInstancing, Technique::Bucketed].map(Variant::from));
        assert_eq!(asked.plan.crowd.layout, plan::LayoutPlan::Named(crowd_scene::Layout::Street));
        assert_eq!((asked.counts, asked.budgets), (vec![8, 64], vec![None]));
        assert_eq!(parsed(&["p", "--ab", "b3", "--count", "7"]).unwrap().unwrap().counts, [7]);
        let path = parsed(&["p", "--ab", "b3", "--camera-path", "walkthrough", "--path", "50"]).unwrap().unwrap();
        assert_eq!((path.words.rounds, path.words.path), (50, Some(50)));
        let sweep = parsed(&["p", "--ab", "b3", "--budgets", "9000,20000"]).unwrap().unwrap();
        assert_eq!(sweep.budgets, [Some(9000), Some(20000)]);
        assert_eq!(sweep.budgets_of(7), sweep.budgets);
        let growing = parsed(&["p", "--ab", "b3", "--counts", "8,64", "--budget-each", "200"]).unwrap().unwrap();
        assert_eq!(
            growing.counts.iter().map(|&count| growing.budgets_of(count)).collect::<Vec<_>>(),
            [[Some(1600)], [Some(12800)]]
        );
    }

    #[test]
    fn conditions_on_pops_are_taken_where_those_are_measured() {
        let words = ["p", "--ab", "b3", "--pops", "--assert", "level_steps_beyond_next:b3 < 0.1"];
        assert!(parsed(&words).unwrap().is_ok());
        let words = ["p", "--ab", "b3", "--shadows", "2", "--assert", "shadows_ms:b3 < 9"];
        assert!(parsed(&words).unwrap().is_ok());
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let usage: &[&[&str]] = &[
            &["p"],
            &["--ab", "b0"],
            &["p", "--ab", "b9"],
            &["p", "--ab", "b3+occlusion"],
            &["p", "--ab", "b0", "--headless"],
            &["p", "--ab", "b0", "--technique", "b3"],
            &["p", "--ab", "b0", "--count", "5", "--counts", "6"],
            &["p", "--ab", "b0", "--budget", "5000", "--budgets", "6000"],
            &["p", "--ab", "b0", "--budget", "5000", "--budget-each", "60"],
            &["p", "--ab", "b0", "--assert", "b0 == 1"],
            &["p", "--ab", "b0", "--path", "9"],
            &["p", "--ab", "b0", "--path", "9", "--camera-path", "line", "--rounds", "3"],
        ];
        for words in usage {
            assert!(parsed(words).is_err(), "{words:?}");
        }
        let refused: &[&[&str]] = &[
            &["p", "--ab", "b0,b0"],
            &["p", "--ab", "b0", "--assert", "b3/b0 < 1"],
            &["p", "--ab", "b2,bucketed", "--assert", "triangles_at_equal_image:b2/bucketed < 1"],
            &["p", "--ab", "b3", "--assert", "pop_energy:b3 < 1"],
            &["p", "--ab", "b3", "--assert", "most_level_steps:b3 < 9"],
            &["p", "--ab", "b4", "--pops", "--assert", "pop_px:b4 < 9"],
            &["p", "--ab", "bucketed+occlusion", "--pops", "--assert", "pop_rmse:bucketed+occlusion < 9"],
            &["p", "--ab", "bucketed", "--occlusion", "on", "--pops", "--assert", "pop_px:bucketed < 9"],
            &["p", "--ab", "bucketed", "--assert", "poses:bucketed < 9"],
            &["p", "--ab", "bucketed", "--assert", "shadows_ms:bucketed < 9"],
            &["p", "--ab", "b0", "--csv", "-", "--json", "-"],
            &["p", "--ab", "b0", "--csv", "p"],
        ];
        for words in refused {
            assert!(parsed(words).unwrap().is_err(), "{words:?}");
        }
    }
}
