//! The player: open packs, run the stages, draw, show. The thin binary is `main.rs`.
//!
//! `cli` holds the words, `plan` their meanings; `crowd` makes a pack into instances; `headless` and `window` show them
//! through `gpu_backend` or `cpu_backend`; `bench` compares techniques; `stats` is the report. [`run`] is the whole program without the process.

pub mod backend;
pub mod bench;
mod bodies;
pub mod budget_words;
pub mod camera_control;
pub mod cli;
pub mod cpu_backend;
pub mod cpu_levels;
pub mod crowd;
pub mod error;
pub mod film;
pub mod governor;
pub mod gpu_backend;
pub mod gpu_device;
pub mod headless;
pub mod loss;
pub mod memory;
pub mod moving;
pub mod output_paths;
pub mod overlay;
pub mod picture;
pub mod plan;
pub mod progress;
pub mod scenery;
pub mod schedules;
mod shell_word;
pub mod simulation;
pub mod stats;
mod step_match;
pub mod surface;
pub mod view;
pub mod window;
pub mod window_words;

pub use error::{Error, Result};

use clap::{CommandFactory, Parser};
use std::ffi::OsString;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// What the player says besides its data: to standard error, or to nobody with `--quiet`.
pub struct Talk<'a> {
    stderr: &'a mut dyn Write,
    quiet: bool,
}

impl<'a> Talk<'a> {
    /// Talks to `stderr`.
    pub fn new(stderr: &'a mut dyn Write, quiet: bool) -> Self {
        Self { stderr, quiet }
    }

    /// A line, unless quiet.
    pub fn say(&mut self, line: &str) {
        if !self.quiet {
            // Nobody listening is no reason to stop.
            let _ = writeln!(self.stderr, "crowdplay: {line}");
        }
    }
}

/// Runs the program: words in (the first is the program's name), data to `stdout`, talk to `stderr`, exit code out.
pub fn run(
    args: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    stdout: &mut dyn Write,
    stderr: &mut dyn Write,
) -> u8 {
    bound_threads();
    let mut words: Vec<OsString> = args.into_iter().map(Into::into).collect();
    // `crowdbake -q bake` is said so; so may `crowdplay -q bench` be.
    let is_quiet = |word: &OsString| word == "-q" || word == "--quiet";
    let flags = words.iter().skip(1).take_while(|word| is_quiet(word)).count();
    if words.get(1 + flags).is_some_and(|word| word == bench::NAME) {
        words[1..=1 + flags].rotate_right(1);
    }
    let asked = match words.get(1).and_then(|word| word.to_str()) {
        Some(bench::NAME) => bench::parse(words.into_iter().skip(1)).map(|asked| Asked::Bench(Box::new(asked))),
        _ => cli::Args::try_parse_from(words).map(|args| Asked::Play(Box::new(args))),
    };
    let outcome = match asked {
        Ok(Asked::Play(args)) => unless_lost(|| follow(&args, stdout, stderr)),
        Ok(Asked::Bench(asked)) => {
            unless_lost(|| (*asked).and_then(|asked| bench::run(&asked, stdout, &mut Talk::new(stderr, asked.quiet))))
        }
        Err(words) => {
            // Help and version are data; a broken pipe is success.
            let text = words.render();
            let _ = if words.use_stderr() { write!(stderr, "{text}") } else { write!(stdout, "{text}") };
            return if words.use_stderr() { error::EXIT_USAGE } else { error::EXIT_DONE };
        }
    };
    match outcome {
        Ok(()) => error::EXIT_DONE,
        Err(error) => {
            let _ = writeln!(stderr, "crowdplay: error: {error}");
            error.exit_code()
        }
    }
}

/// The most threads that are worked on, whatever RAYON_NUM_THREADS asks for: what `crowdbake --jobs` allows.
const MOST_THREADS: usize = 256;

fn bound_threads() {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse::<usize>().ok());
    if asked.is_some_and(|threads| threads > MOST_THREADS) {
        // Whoever made the pool before us chose its size.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(MOST_THREADS).build_global();
    }
}

/// Says of whatever comes of a lost device that it is lost, also of a panic: wgpu has some of its own for that.
fn unless_lost(work: impl FnOnce() -> Result<()>) -> Result<()> {
    loss::forget();
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => Err(loss::latest().unwrap_or(error)),
        Err(panic) => Err(loss::latest().unwrap_or_else(|| resume_unwind(panic))),
    }
}

enum Asked {
    Play(Box<cli::Args>),
    Bench(Box<Result<bench::Asked>>),
}

fn follow(args: &cli::Args, stdout: &mut dyn Write, stderr: &mut dyn Write) -> Result<()> {
    if let Some(shell) = args.completions {
        let mut script = Vec::new();
        clap_complete::generate(shell, &mut cli::Args::command(), "crowdplay", &mut script);
        return picture::write_stdout(stdout, &script);
    }
    let mut talk = Talk::new(stderr, args.quiet);
    if args.list_adapters {
        return list_adapters(stdout, &mut talk);
    }
    let plan = plan::plan(args)?;
    output_paths::refuse_shared(&plan)?;
    output_paths::outputs(&plan).iter().try_for_each(|path| output_paths::expect_writable(path))?;
    if matches!(plan.show, plan::Show::Window(_)) {
        window::expect_display()?;
    }
    let aspect = plan.size[0] as f32 / plan.size[1] as f32;
    let mut crowd = crowd::gather(&crowd::open_pack(&plan.pack)?, &plan.crowd, aspect)?;
    // Errors of files come before remarks on what is in them.
    let viewer = view::Viewer::open(&plan.camera, &crowd)?;
    for remark in &crowd.remarks {
        talk.say(remark);
    }
    let report = match &plan.show {
        plan::Show::Headless(headless) => headless::render(&plan, headless, &mut crowd, viewer, stdout, &mut talk)?,
        plan::Show::Window(shown) => window::show(&plan, shown, crowd, viewer, &mut talk)?,
    };
    plan.report.as_deref().map_or(Ok(()), |path| headless::write_report(&report, path, stdout))
}

fn list_adapters(stdout: &mut dyn Write, talk: &mut Talk<'_>) -> Result<()> {
    let instances = gpu_device::BACKENDS.map(gpu_device::headless_instance);
    let adapters: Vec<wgpu::Adapter> = instances.iter().flat_map(gpu_device::list_adapters).collect();
    if adapters.is_empty() {
        talk.say("no adapter was found; --backend cpu draws without one");
    }
    let line = |adapter: &wgpu::Adapter| {
        let adapter = gpu_device::describe(&adapter.get_info());
        let stats::Adapter { name, backend, driver, driver_version, device_type } = adapter;
        format!("{name}\t{backend}\t{device_type}\t{driver} {driver_version}\n")
    };
    picture::write_stdout(stdout, adapters.iter().map(line).collect::<String>().as_bytes())
}
