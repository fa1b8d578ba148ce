//! Frames without a window: a fixed time step, pictures, a report. Nothing in here knows of windows.

use crate::backend::{self, Backend};
use crate::crowd::Crowd;
use crate::film::Film;
use crate::governor::Governor;
use crate::memory::{check_count, table};
use crate::picture::{write_file, write_stdout};
use crate::plan::{DetailPlan, HeadlessPlan, PictureName, Plan};
use crate::progress::Progress;
use crate::stats::{self, Frame, Report, Spread, Timings, skinning_words};
use crate::view::{self, Viewer, frame_config};
use crate::{Error, Result, Talk};
use crowd_stages::{BudgetIn, Fit, Levels, Skinning, View, Weight};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// Renders all frames; the report, not yet written.
pub fn render(
    plan: &Plan,
    headless: &HeadlessPlan,
    crowd: &mut Crowd,
    viewer: Viewer,
    stdout: &mut dyn Write,
    talk: &mut Talk<'_>,
) -> Result<Report> {
    let gpu = backend::find_gpu(&plan.machine, talk)?;
    let detail = backend::settle_technique(&plan.detail, gpu.as_ref(), talk);
    let mut budget = detail.budget.unwrap_or_else(|| backend::usual_budget(gpu.as_ref(), crowd, &detail));
    let largest = backend::largest_budget(crowd, detail.budget_in);
    let mut most = if detail.target_ms.is_some() { budget.max(largest) } else { budget };
    let samples = plan.machine.samples.unwrap_or(4);
    if let Some(gpu) = &gpu {
        check_count(&gpu.device, crowd.instances.len(), &[detail.draw])?;
    }
    let mut backend = Backend::new(gpu, crowd, plan.size, samples, (most, detail.budget_in))?;
    if let Some(limit_bytes) = plan.machine.vram_bytes {
        // With a target the budget is only where it begins.
        let kept = detail.budget.filter(|_| detail.target_ms.is_none());
        let fitted = backend.fit_memory(crowd, &detail, limit_bytes, plan.reference_camera, kept)?;
        most = fitted.unwrap_or(most);
        // A target begins at the usual budget and rises to what fits.
        budget = if detail.target_ms.is_some() { budget.min(most) } else { most };
    }
    let mut governor = detail.target_ms.map(|target_ms| Governor::new(target_ms, budget, most));
    let mut frames = Vec::new();
    let mut pictures = Vec::new();
    let mut warnings = Vec::new();
    if detail.draw.shadows > 0 && backend.word() == "cpu" {
        let message = "the software rasteriser draws no shadows (--shadows)".to_owned();
        talk.say(&message);
        warnings.push(message);
    }
    let mut film = match &headless.out {
        Some(PictureName::Film(path)) => Some(Film::begin(path, headless.dt_s)?),
        _ => None,
    };
    let lacks = [
        (plan.machine.vram_bytes.is_some(), "the software rasteriser takes no GPU memory (--vram)"),
        (plan.reference_camera, "the software rasteriser has no reference camera (--reference-camera)"),
        (detail.draw.view != View::Shaded, "the software rasteriser shows people as they look (--view)"),
    ];
    for (_, message) in lacks.into_iter().filter(|(is_asked, _)| *is_asked && backend.word() == "cpu") {
        talk.say(message);
        warnings.push(message.to_owned());
    }
    let mut recording = None;
    let mut progress = Progress::new(headless.frames);
    for number in 0..headless.frames {
        let time_s = headless.start_s + number as f32 * headless.dt_s;
        let camera = viewer.at(time_s);
        if plan.record_camera.is_some() {
            view::record(&mut recording, time_s, &camera);
        }
        let config = frame_config(&camera, plan.size, time_s, &detail, budget);
        let simulate_ms = backend.show_time(crowd, time_s)?;
        if backend.poses_on_cpu(detail.draw) {
            crowd.play(time_s);
        }
        backend.bake(crowd, &config, detail.draw)?;
        let start = Instant::now();
        let mut watch = |share| {
            if let Some(word) = progress.word(number, share) {
                talk.say(&word);
            }
        };
        let totals = backend.draw(crowd, &config, detail.draw, &mut watch)?;
        let frame_ms = start.elapsed().as_secs_f32() * 1e3;
        let frame = Frame::new(number, time_s, budget, totals, frame_ms, &backend.timings_ms());
        let frame = Frame { simulate_ms, ..frame.of(crowd) };
        let messages = stats::overflow_messages(&totals, (budget, detail.budget_in), detail.max_px);
        // The first frame compiles shaders.
        if let Some(governor) = governor.as_mut().filter(|_| number > 0) {
            budget = governor.next(frame.work_ms());
        }
        frames.push(frame);
        for message in messages {
            if !warnings.contains(&message) && warnings.len() < 16 {
                talk.say(&format!("frame {number}: {message}"));
                warnings.push(message);
            }
        }
        if let Some(name) = headless.out.as_ref().filter(|name| name.wants(number, headless.frames)) {
            let mut picture = backend.picture()?;
            if plan.reference_camera {
                let aspect = plan.size[0] as f32 / plan.size[1] as f32;
                let other = view::reference_camera(crowd, &camera, aspect);
                let other = frame_config(&other, plan.size, time_s, &detail, config.budget);
                if let Some(other) = backend.reference_picture([&config, &other], detail.draw)? {
                    picture.put_into_corner(&other.reduced());
                }
            }
            let png = picture.to_png();
            match (&mut film, name.file_of(number, headless.frames)) {
                (Some(film), _) => film.add(&png)?,
                (None, Some(file)) => {
                    write_file(&file, &png)?;
                    pictures.push(file.display().to_string());
                }
                (None, None) => write_stdout(stdout, &png)?,
            }
        }
        if let Some(word) = progress.word(number, 1.0) {
            talk.say(&word);
        }
    }
    if let (Some(film), Some(PictureName::Film(path))) = (film, &headless.out) {
        film.end()?;
        pictures.push(path.display().to_string());
    }
    if let Some(complaint) = governor.as_ref().and_then(Governor::complaint) {
        talk.say(&complaint);
        warnings.push(complaint);
    }
    write_recording(plan, recording.as_ref())?;
    let spent = detail.draw.technique.has_budget().then_some((budget, detail.budget_in));
    say_what_came_out(crowd, &frames, &pictures, spent, backend.word() == "gpu", talk);
    if headless.out.is_none() && plan.report.is_none() && plan.record_camera.is_none() {
        talk.say("nothing was written; --out picture.png or --report stats.json does");
    }
    if plan.machine.vram_bytes.is_some() && backend.word() == "gpu" {
        talk.say(&format!("GPU memory by part:{}", table(&backend.memory())));
        if let Some(remark) = backend.room_remark() {
            talk.say(remark);
        }
    }
    let mut report = report(plan, &detail, crowd, budget, backend.word(), backend.describe());
    report.simulator = backend.simulator(crowd);
    report.samples = samples;
    report.dt_s = headless.dt_s;
    report.set_memory(&backend.memory());
    if let Some(choice) = backend.skinning(detail.draw) {
        report.skinning = choice.way.name();
        report.skinning_ms = choice.measured_ms;
        let is_refused = choice.refused.is_some() || choice.sharing_refused.is_some();
        if is_refused && detail.draw.skinning != Skinning::Auto {
            let words = skinning_words(&choice, detail.draw.skinning).unwrap_or_default();
            talk.say(&words);
            report.warnings.push(words);
        }
    }
    report.timings = Timings::of(&frames);
    report.frames = frames;
    report.pictures = pictures;
    report.warnings.extend(warnings);
    Ok(report)
}

/// Writes where the camera was, if that is wanted.
pub fn write_recording(plan: &Plan, recording: Option<&crowd_scene::CameraPath>) -> Result<()> {
    match (&plan.record_camera, recording) {
        (Some(file), Some(path)) => write_file(file, path.write().as_bytes()),
        _ => Ok(()),
    }
}

fn say_what_came_out(
    crowd: &Crowd,
    frames: &[Frame],
    pictures: &[String],
    budget: Option<(u32, BudgetIn)>,
    compiles: bool,
    talk: &mut Talk<'_>,
) {
    let Some(last) = frames.last() else { return };
    talk.say(&format!(
        "{}, {} visible; {} of {} triangles, {} vertices{}",
        who_is_there(last.present, crowd.summary.instances),
        last.visible,
        last.triangles,
        last.present_triangles,
        last.vertices,
        budget.map_or_else(String::new, |(budget, counts)| format!(", budget {budget} {}", counts.name()))
    ));
    talk.say(&time_words(&Timings::of(frames), frames.len(), compiles));
    match pictures {
        [] => {}
        [only] => talk.say(&format!("wrote {only}")),
        [first, .., last] => talk.say(&format!("wrote {first} to {last}")),
    }
}

/// How many there are, and of how many, where not everyone has come or some have left.
fn who_is_there(present: u32, all: u32) -> String {
    if present == all { format!("{all} instances") } else { format!("{present} of {all} instances present") }
}

/// What frames took. `compiles`: the first one compiled shaders, too.
fn time_words(timings: &Timings, frames: usize, compiles: bool) -> String {
    let Spread { median, p95, .. } = timings.frame_ms;
    match (frames, compiles) {
        (0 | 1, true) => format!("first frame, with compilation of shaders: {median:.1} ms"),
        (0 | 1, false) => format!("1 frame: {median:.1} ms"),
        _ => {
            let why = if compiles { ", which compiles shaders" } else { "" };
            let counted = timings.frames;
            format!("{frames} frames, median {median:.1} ms, p95 {p95:.1} ms (of {counted}, without the first{why})")
        }
    }
}

/// A report without frames, for one sample a pixel.
pub fn report(
    plan: &Plan,
    detail: &DetailPlan,
    crowd: &Crowd,
    budget: u32,
    backend: &'static str,
    adapter: stats::Adapter,
) -> Report {
    Report {
        schema_version: stats::SCHEMA_VERSION,
        program: format!("crowdplay {}", env!("CARGO_PKG_VERSION")),
        pack: plan.pack.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        backend,
        adapter,
        size: plan.size,
        samples: 1,
        technique: detail.draw.technique.name(),
        levels: match detail.draw.levels() {
            Levels::Continuous => "continuous",
            Levels::Quantized => "quantized",
        },
        fit: match detail.draw.fit {
            Fit::Fill => "fill",
            Fit::Plain => "eq1",
        },
        morph: detail.draw.morphs(),
        occlusion: detail.draw.occludes() && backend == "gpu",
        skinning: Skinning::Vertex.name(),
        skinning_ms: None,
        shadows: if backend == "gpu" { detail.draw.shadows } else { 0 },
        fog_m: detail.sight_m,
        simulator: None,
        budget,
        budget_in: detail.budget_in.name(),
        slack_share: detail.slack_share,
        vram_bytes: plan.machine.vram_bytes,
        alpha: detail.alpha,
        weight: match detail.weight {
            Weight::Area => "area",
            Weight::AreaDistance => "area-distance",
            Weight::Error => "error",
        },
        crowd: crowd.summary.clone(),
        dt_s: 0.0,
        gpu_bytes: 0,
        gpu_memory: BTreeMap::new(),
        frames: Vec::new(),
        timings: Timings::default(),
        pictures: Vec::new(),
        warnings: crowd.remarks.clone(),
    }
}

/// Writes the report to its file or to standard output.
pub fn write_report(report: &Report, path: &Path, stdout: &mut dyn Write) -> Result<()> {
    let mut text = serde_json::to_vec_pretty(report)
        .map_err(|e| Error::Output { path: path.to_owned(), source: std::io::Error::other(e) })?;
    text.push(b'\n');
    if path == Path::new("-") { write_stdout(stdout, &text) } else { write_file(path, &text) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timings(times_ms: &[f32]) -> Timings {
        Timings { frames: times_ms.len() as u32, frame_ms: Spread::of(times_ms.to_vec()), ..Default::default() }
    }

    #[test]
    fn one_frame_is_no_median_and_of_more_the_first_is_not_counted() {
        let one = timings(&[900.0]);
        assert_eq!(time_words(&one, 1, true), "first frame, with compilation of shaders: 900.0 ms");
        assert_eq!(time_words(&one, 1, false), "1 frame: 900.0 ms");
        let words = time_words(&timings(&[4.0, 6.0]), 3, true);
        assert_eq!(words, "3 frames, median 5.0 ms, p95 6.0 ms (of 2, without the first, which compiles shaders)");
        assert!(time_words(&timings(&[4.0, 6.0]), 3, false).ends_with("(of 2, without the first)"));
    }

    #[test]
    fn who_has_not_come_or_has_left_is_not_counted_as_there() {
        assert_eq!(who_is_there(160, 160), "160 instances");
        assert_eq!(who_is_there(155, 160), "155 of 160 instances present");
    }
}
