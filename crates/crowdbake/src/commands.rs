//! What each verb does, from words to exit code.

mod export;

use export::export;

use crate::bake::{BakedCharacter, bake_plan};
use crate::cli::{
    BakeArgs, BakeOptions, Cli, Command, CompareArgs, ExplainArgs, InspectArgs, PictureArgs, PrintConfigArgs,
    ReportArgs, SurveyArgs, VerifyArgs,
};
use crate::compare::{self, CompareRequest, Contender};
use crate::error::{BakeError, Cause, DONE, INPUT_REFUSED, Step, USAGE};
use crate::explain::Explanation;
use crate::inspect::{inspect_asset, inspect_pack};
use crate::output::{expect_writable, print, refuse_inputs, refuse_twins, seen_from, write_whole};
use crate::picture::{PictureRequest, Pose, draw_picture, refuse_large_picture};
use crate::plan::{Plan, make_plan};
use crate::report::{CharacterReport, PackReport, Report, SCHEMA_VERSION, SectionReport, refused_inputs, to_json};
use crate::report_page::make_page;
use crate::select_clips::patterns_without_clips;
use crate::talk::{Loudness, Talk};
use crate::units::counted;
use crate::unpack::{Unpacked, choose_character, is_pack, open};
use crate::{survey, verify};
use clap::{CommandFactory, Parser};
use crowd_judge::JudgeOptions;
use crowd_pack::{Pack, PackContents, WriteReport};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Runs the program: `args` with the program's name first. Gives the exit code.
pub fn run<A: Into<OsString> + Clone>(
    args: impl IntoIterator<Item = A>,
    out: &mut dyn Write,
    err: &mut (dyn Write + Send),
) -> u8 {
    run_in(args, out, err, false)
}

/// Like [`run`]; `terminal` says that `err` is one, so that progress may be drawn on it.
pub fn run_in<A: Into<OsString> + Clone>(
    args: impl IntoIterator<Item = A>,
    out: &mut dyn Write,
    err: &mut (dyn Write + Send),
    terminal: bool,
) -> u8 {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(words) => return say_words(&words, out, err, terminal),
    };
    let loudness = match (cli.quiet, cli.verbose) {
        (true, _) => Loudness::Quiet,
        (_, true) => Loudness::Verbose,
        _ => Loudness::Normal,
    };
    let mut talk = Talk::new(err, loudness, terminal);
    let result = match cli.command {
        Command::Bake(args) => bake(&args, out, &mut talk),
        Command::Inspect(args) => inspect(&args, out),
        Command::Verify(args) => verify_pack(&args, out, &talk),
        Command::Export(args) => export(&args, &talk),
        Command::Picture(args) => picture(&args, &talk),
        Command::Report(args) => report(&args, &mut talk),
        Command::Explain(args) => explain(&args, out),
        Command::Survey(args) => make_survey(&args, out, &mut talk),
        Command::Compare(args) => compare(&args, out, &talk),
        Command::PrintConfig(args) => print_config(&args, out, &talk),
        Command::Completions { shell } => completions(shell, out),
    };
    match result {
        Ok(code) => code,
        Err(error) if error.source.is_broken_pipe() => DONE,
        Err(error) => {
            talk.error(&error);
            error.exit_code()
        }
    }
}

/// Help and version go to stdout with 0, usage errors to stderr with 2.
fn say_words(words: &clap::Error, out: &mut dyn Write, err: &mut (dyn Write + Send), terminal: bool) -> u8 {
    let rendered = words.render();
    if !words.use_stderr() {
        // A closed pipe is success.
        let _ = write!(out, "{rendered}").and_then(|()| out.flush());
        return DONE;
    }
    let colored = terminal && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let text = if colored { rendered.ansi().to_string() } else { rendered.to_string() };
    let _ = write!(err, "{text}");
    USAGE
}

fn bake(args: &BakeArgs, out: &mut dyn Write, talk: &mut Talk<'_>) -> Result<u8, BakeError> {
    let started = Instant::now();
    let mut plan = make_plan(&args.inputs, &args.options, args.animation_layout);
    plan.ask_for_levels(&args.levels);
    if let Some(tile_px) = args.impostors {
        plan.impostors_px = tile_px;
    }
    refuse_many_levels(&plan)?;
    let mut code = say_plan(&plan, talk);
    let outputs: Vec<&Path> = std::iter::once(&args.output).chain(&args.report).map(PathBuf::as_path).collect();
    refuse_twins(&outputs)?;
    outputs.iter().try_for_each(|output| refuse_inputs(output, &plan.inputs))?;
    outputs.iter().try_for_each(|output| expect_writable(output))?;
    let results = in_threads(args.jobs, || {
        talk.start_progress(plan.entries.len());
        let results = bake_plan(&plan, args.strict, talk);
        talk.end_progress();
        results
    });
    for pattern in patterns_without_clips(&plan.entries, &results) {
        talk.warn(format_args!("clips: `{pattern}` finds no clip in any character"));
    }
    let entries = std::mem::take(&mut plan.entries);
    let characters: Vec<CharacterReport> =
        entries.iter().zip(&results).map(|(entry, result)| CharacterReport::new(entry, result)).collect();
    let mut baked = Vec::new();
    for result in results {
        match result {
            Ok(character) => baked.push(character),
            Err(error) => code = code.max(error.exit_code()),
        }
    }
    let mut report = Report {
        schema_version: SCHEMA_VERSION,
        generator: format!("crowdbake {}", env!("CARGO_PKG_VERSION")),
        command: "bake",
        pack: None,
        characters,
        refused_inputs: refused_inputs(&plan),
        seconds: 0.0,
        jobs: if args.jobs == 0 { rayon::current_num_threads() } else { args.jobs },
        exit_code: code,
    };
    match write_pack(&baked, &plan, entries.len() + plan.refused.len(), args, talk) {
        Ok(pack) => report.pack = Some(pack),
        Err(error) => {
            talk.error(&error);
            report.exit_code = code.max(error.exit_code());
        }
    }
    report.seconds = started.elapsed().as_secs_f64();
    let json = to_json(&report);
    if let Some(path) = &args.report {
        write_whole(path, json.as_bytes())?;
    }
    if args.json {
        print(out, &json)?;
    }
    Ok(report.exit_code)
}

/// More discrete levels than a pack holds are refused before anything is baked.
fn refuse_many_levels(plan: &Plan) -> Result<(), BakeError> {
    let allowed = crowd_pack::limits::DISCRETE_LEVELS;
    let many = plan.entries.iter().find(|entry| entry.levels.targets.len() as u64 > allowed);
    many.map_or(Ok(()), |entry| {
        let found = entry.levels.targets.len() as u64;
        let remedy = "ask for fewer with --lod-ratio, --error and --px";
        Err(BakeError::of(Step::Plan, &entry.name, Cause::Limit { what: "discrete levels", found, allowed, remedy }))
    })
}

/// Writes the good characters; none is a failure.
fn write_pack(
    baked: &[BakedCharacter],
    plan: &Plan,
    tried: usize,
    args: &BakeArgs,
    talk: &Talk<'_>,
) -> Result<PackReport, BakeError> {
    if baked.is_empty() {
        return Err(BakeError::whole(Step::Assemble, Cause::NothingBaked { count: tried }));
    }
    let mut contents = crate::assemble::assemble(baked, plan.animation_layout)?;
    if plan.impostors_px > 0 {
        let since = Instant::now();
        let impostors = in_threads(args.jobs, || crate::impostors::bake_impostors(&contents, plan.impostors_px))?;
        crate::assemble::add_impostors(&mut contents, &impostors);
        let (px, bytes) = (plan.impostors_px, contents.impostor_bytes.len() as u64);
        let seconds = since.elapsed().as_secs_f64();
        talk.note(format_args!("impostors of {px} texels: {} bytes, {seconds:.1} s", crate::inspect::grouped(bytes)));
    }
    let written: WriteReport = contents.write(&args.output).map_err(|error| BakeError::whole(Step::Write, error))?;
    talk.note(format_args!(
        "{}: {}, {} bytes",
        args.output.display(),
        counted(baked.len(), "character"),
        crate::inspect::grouped(written.pack_bytes)
    ));
    let sections = written.sections.into_iter().map(|(name, bytes)| SectionReport { name, bytes });
    Ok(PackReport {
        path: args.output.to_string_lossy().into_owned(),
        bytes: written.pack_bytes,
        sections: sections.collect(),
    })
}

/// Says what the plan found odd; gives the exit code so far.
fn say_plan(plan: &Plan, talk: &Talk<'_>) -> u8 {
    for note in &plan.notes {
        talk.warn(note);
    }
    for refused in &plan.refused {
        talk.error(refused);
    }
    if plan.refused.is_empty() { DONE } else { INPUT_REFUSED }
}

/// Runs `work` on a pool of that many threads; 0 for one a core.
fn in_threads<R: Send>(jobs: usize, work: impl FnOnce() -> R + Send) -> R {
    if jobs == 0 {
        return work();
    }
    match rayon::ThreadPoolBuilder::new().num_threads(jobs).build() {
        Ok(pool) => pool.install(work),
        // The system gives no more threads: the shared pool gives the same bytes.
        Err(_) => work(),
    }
}

fn inspect(args: &InspectArgs, out: &mut dyn Write) -> Result<u8, BakeError> {
    let inspection = if is_pack(&args.input) {
        let pack = Pack::open(&args.input).map_err(|error| BakeError::whole(Step::Read, error))?;
        let bytes = std::fs::metadata(&args.input).map(|file| file.len()).unwrap_or_default();
        inspect_pack(&args.input, bytes, pack.contents())
    } else {
        inspect_asset(&args.input)?
    };
    let text = if args.json { to_json(&inspection) } else { crate::inspect::to_text(&inspection) };
    print(out, &text)?;
    Ok(DONE)
}

fn verify_pack(args: &VerifyArgs, out: &mut dyn Write, talk: &Talk<'_>) -> Result<u8, BakeError> {
    #[derive(serde::Serialize)]
    struct Verification<'a> {
        schema_version: u32,
        pack: String,
        passed: bool,
        checks: &'a [verify::Check],
    }
    let opened = std::fs::metadata(&args.pack)
        .map_err(|source| Cause::Input { path: args.pack.clone(), source })
        .map_err(|cause| BakeError::whole(Step::Read, cause))
        .map(|_| Pack::open(&args.pack))?;
    let checks = match opened {
        Ok(pack) => {
            let mut checks = vec![verify::Check {
                character: String::new(),
                check: "file-is-whole",
                passed: true,
                detail: "checksums and records".to_owned(),
            }];
            checks.extend(verify::verify(pack.contents(), args.levels));
            checks
        }
        Err(error @ crowd_pack::Error::Io { .. }) => return Err(BakeError::whole(Step::Read, error)),
        Err(error) => vec![verify::Check {
            character: String::new(),
            check: "file-is-whole",
            passed: false,
            detail: error.to_string(),
        }],
    };
    let failed = checks.iter().filter(|check| !check.passed).count();
    let text = if args.json {
        to_json(&Verification {
            schema_version: SCHEMA_VERSION,
            pack: args.pack.to_string_lossy().into_owned(),
            passed: failed == 0,
            checks: &checks,
        })
    } else {
        let line = |check: &verify::Check| {
            let word = if check.passed { "ok    " } else { "FAILED" };
            let who = if check.character.is_empty() { String::new() } else { format!("{}: ", check.character) };
            crate::talk::printable(&format!("{word} {who}{}: {}", check.check, check.detail)) + "\n"
        };
        checks.iter().map(line).collect()
    };
    print(out, &text)?;
    if failed > 0 {
        let cause = Cause::ChecksFailed { failed, checked: checks.len() };
        return Err(BakeError::whole(Step::Verify, cause));
    }
    talk.detail(format_args!("{} checks passed", checks.len()));
    Ok(DONE)
}

fn picture(args: &PictureArgs, talk: &Talk<'_>) -> Result<u8, BakeError> {
    refuse_large_picture(args.ratios.len(), args.clip.len().max(1), args.size)?;
    refuse_inputs(&args.output, std::slice::from_ref(&args.input))?;
    expect_writable(&args.output)?;
    let opened = open(&args.input, &args.options)?;
    let contents = opened.contents();
    let character = Unpacked::new(contents, choose_character(contents, args.character.as_deref())?);
    let time_of = |row: usize| args.time.get(row).or(args.time.first()).copied();
    let pose = |(row, name): (usize, &String)| match name.as_str() {
        "bind" => Pose::Bind,
        clip => Pose::Clip(clip.to_owned(), time_of(row)),
    };
    let mut rows: Vec<Pose> = args.clip.iter().enumerate().map(pose).collect();
    if rows.is_empty() {
        rows.push(Pose::Bind);
    }
    let request =
        PictureRequest { ratios: args.ratios.clone(), rows, paint: args.paint, size: args.size, turn_deg: args.turn };
    let picture = draw_picture(&character, &request)?;
    write_whole(&args.output, &crowd_raster::encode_png(&picture))?;
    talk.note(format_args!("{}: {}x{}", args.output.display(), picture.width, picture.height));
    Ok(DONE)
}

fn compare(args: &CompareArgs, out: &mut dyn Write, talk: &Talk<'_>) -> Result<u8, BakeError> {
    let started = Instant::now();
    let plan = make_plan(&args.inputs, &BakeOptions::default(), None);
    let mut code = say_plan(&plan, talk);
    if let Some(output) = &args.output {
        refuse_inputs(output, &plan.inputs)?;
        expect_writable(output)?;
    }
    let usual = if args.quick { JudgeOptions::QUICK } else { JudgeOptions::FULL };
    let options = JudgeOptions { points: args.points.unwrap_or(usual.points), ..usual };
    let mut contenders = args.ours.clone();
    let default_peers = || Contender::PEERS.into_iter().filter(|peer| !(args.quick && peer.is_gltfpack())).collect();
    contenders.extend(args.peers.clone().unwrap_or_else(default_peers));
    let contenders = compare::keep_present(contenders, talk);
    let request = CompareRequest { ratios: args.ratios.clone(), contenders, options };
    let mut characters = Vec::new();
    for entry in &plan.entries {
        talk.note(format_args!("{}", entry.name));
        match compare::compare_character(entry, &request, talk) {
            Ok(scores) => characters.push(scores),
            Err(error) => {
                talk.error(&error);
                code = code.max(error.exit_code());
            }
        }
    }
    let comparison = compare::sum_up(characters, &request, started.elapsed().as_secs_f64());
    if let Some(output) = &args.output {
        write_whole(output, compare::to_markdown(&comparison).as_bytes())?;
    }
    if args.json {
        print(out, &to_json(&comparison))?;
    } else if args.output.is_none() {
        print(out, &compare::to_text(&comparison))?;
    }
    Ok(code)
}

fn report(args: &ReportArgs, talk: &mut Talk<'_>) -> Result<u8, BakeError> {
    refuse_inputs(&args.output, std::slice::from_ref(&args.input))?;
    expect_writable(&args.output)?;
    let opened = open(&args.input, &args.options)?;
    let contents = opened.contents();
    let chosen = choose_characters(contents, &args.character)?;
    let title = args.input.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    talk.start_progress(chosen.len());
    let page = make_page(contents, &title, &chosen, &|name, share| talk.advance(share, name, "draw"));
    talk.end_progress();
    let page = page?;
    write_whole(&args.output, page.as_bytes())?;
    talk.note(format_args!(
        "{}: {}, {} bytes",
        args.output.display(),
        counted(chosen.len(), "character"),
        crate::inspect::grouped(page.len() as u64)
    ));
    Ok(DONE)
}

/// The characters named, each once, in the pack's order; all where none is named.
fn choose_characters(contents: &PackContents, names: &[String]) -> Result<Vec<usize>, BakeError> {
    if names.is_empty() {
        return Ok((0..contents.characters.len()).collect());
    }
    let chosen: Result<BTreeSet<usize>, _> = names.iter().map(|name| choose_character(contents, Some(name))).collect();
    Ok(chosen?.into_iter().collect())
}

fn explain(args: &ExplainArgs, out: &mut dyn Write) -> Result<u8, BakeError> {
    #[derive(serde::Serialize)]
    struct Explained {
        schema_version: u32,
        pack: String,
        characters: Vec<Explanation>,
    }
    let opened = open(&args.input, &args.options)?;
    let contents = opened.contents();
    let (mut characters, mut text) = (Vec::new(), String::new());
    for index in choose_characters(contents, &args.character)? {
        let character = Unpacked::new(contents, index);
        let explanation = crate::explain::explain(&character, &args.ratio);
        if !text.is_empty() {
            text.push('\n');
        }
        text.push_str(&crate::explain::to_text(&explanation));
        characters.push(explanation);
    }
    if args.json {
        let pack = args.input.to_string_lossy().into_owned();
        text = to_json(&Explained { schema_version: SCHEMA_VERSION, pack, characters });
    }
    print(out, &text)?;
    Ok(DONE)
}

fn make_survey(args: &SurveyArgs, out: &mut dyn Write, talk: &mut Talk<'_>) -> Result<u8, BakeError> {
    let options = BakeOptions { fps: args.fps, ..BakeOptions::default() };
    let plan = make_plan(&args.inputs, &options, None);
    let mut code = say_plan(&plan, talk);
    if let Some(output) = &args.output {
        refuse_inputs(output, &plan.inputs)?;
        expect_writable(output)?;
    }
    talk.start_progress(plan.entries.len());
    let mut rows = Vec::new();
    let shown_paths: Vec<String> =
        plan.entries.iter().map(|entry| survey::shown_path(&entry.path, &args.inputs)).collect();
    let picture_names = survey::picture_names(&shown_paths);
    for ((entry, shown), picture_name) in plan.entries.iter().zip(shown_paths).zip(picture_names) {
        talk.advance(0.0, &shown, "survey");
        let (row, contents) = survey::survey_asset(entry, shown.clone());
        match &row.outcome {
            Ok(m) => talk.note(format_args!(
                "{shown}: {} triangles down to {} (wedge), {} (peng2011), {:.1} s",
                m.triangles, m.lowest_wedge, m.lowest_peng, m.seconds
            )),
            Err(why) => {
                talk.note(format_args!("{shown}: refused: {why}"));
                code = code.max(INPUT_REFUSED);
            }
        }
        if let (Some(folder), Some(contents)) = (&args.pictures, contents) {
            let path = folder.join(picture_name);
            refuse_inputs(&path, std::slice::from_ref(&entry.path))?;
            let picture = survey::survey_picture(&contents)?;
            write_whole(&path, &crowd_raster::encode_png(&picture))?;
        }
        talk.advance(1.0, &shown, "done");
        rows.push(row);
    }
    talk.end_progress();
    let text = survey::to_markdown(&rows, args.fps.unwrap_or_default());
    match &args.output {
        Some(path) => write_whole(path, text.as_bytes())?,
        None => print(out, &text)?,
    }
    Ok(code)
}

fn print_config(args: &PrintConfigArgs, out: &mut dyn Write, talk: &Talk<'_>) -> Result<u8, BakeError> {
    let mut plan = make_plan(&args.inputs, &args.options, None);
    plan.ask_for_levels(&args.levels);
    let code = say_plan(&plan, talk);
    let file = args.output.as_deref().filter(|file| !crowd_pack::whole_file::is_device(file));
    if let Some(file) = file {
        let sources: Vec<PathBuf> = plan.entries.iter().map(|entry| entry.path.clone()).collect();
        refuse_inputs(file, &[&args.inputs[..], &sources].concat())?;
        if plan.entries.is_empty() && !args.inputs.is_empty() {
            return Ok(code);
        }
        plan.entries.iter_mut().for_each(|entry| entry.path = seen_from(&entry.path, file));
    }
    if let Some(entry) = plan.entries.iter().find(|entry| entry.path.to_str().is_none()) {
        return Err(BakeError::whole(Step::Plan, Cause::NameNotText { path: entry.path.clone() }));
    }
    let printed = "Paths are relative to this file: leave it in the folder where it was printed, or write it with -o.";
    let paths = if file.is_some() { "Paths are relative to this file." } else { printed };
    let text = crate::crowd_toml::write(&plan, paths);
    match &args.output {
        Some(file) => write_whole(file, text.as_bytes())?,
        None => print(out, &text)?,
    }
    Ok(code)
}

fn completions(shell: clap_complete::Shell, out: &mut dyn Write) -> Result<u8, BakeError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "crowdbake", &mut script);
    print(out, &String::from_utf8_lossy(&script))?;
    Ok(DONE)
}
