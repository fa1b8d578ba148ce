//! Draws the frames, in turn, and gathers the rows.

use super::condition::Condition;
use super::pops::{Pops, measure_pops};
use super::rows::{BenchReport, EqualImage, Judged, Row, SCHEMA_VERSION};
use super::variant::Variant;
use super::words::Asked;
use crate::backend;
use crate::cpu_levels::CpuLevels;
use crate::crowd::{self, Crowd};
use crate::gpu_backend::GpuBackend;
use crate::gpu_device::Gpu;
use crate::memory::{MEGABYTE, check_count, with_baseline};
use crate::picture::Picture;
use crate::plan::{HeadlessPlan, Show};
use crate::stats::{Frame, Spread, overflow_words, skinning_words};
use crate::view::{Viewer, frame_config};
use crate::{Error, Result, Talk};
use crowd_stages::gpu::SkinningChoice;
use crowd_stages::{DrawOptions, FrameConfig, FrameTotals, InstanceRecord, Skinning, Technique, overflow};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::time::Instant;

/// The stages that are not level of detail: deforming and drawing, which Peng 2011 (§6) counts as rendering.
const RENDERING: [&str; 9] = [
    "draw",
    "shadows",
    "play_motion",
    "hold_poses",
    "key_poses",
    "find_leaders",
    "share_poses",
    "blend_palettes",
    "skin_vertices",
];

/// Triangles at full detail up to which pictures are compared: three minutes on software Vulkan.
const MOST_PICTURED: u64 = 1_000_000_000;

/// Measures all techniques at all counts and budgets.
pub fn measure(asked: &Asked, talk: &mut Talk<'_>) -> Result<BenchReport> {
    let plan = &asked.plan;
    let gpu = backend::find_gpu(&plan.machine, talk)?.ok_or(Error::Machine {
        what: "a bench measures a GPU, and there is none".to_owned(),
        remedy: "install a Vulkan driver, in software if need be (on Debian: mesa-vulkan-drivers)",
    })?;
    let pack = crowd::open_pack(&plan.pack)?;
    let samples = plan.machine.samples.unwrap_or(4);
    let aspect = plan.size[0] as f32 / plan.size[1] as f32;
    let (mut rows, mut conditions, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    let conditions_of = |&count: &u32| asked.budgets_of(count).into_iter().map(move |budget| (count, budget));
    for (count, budget) in asked.counts.iter().flat_map(conditions_of) {
        let crowd_plan = plan.crowd.with_count(count);
        let crowd = crowd::gather(&pack, &crowd_plan, aspect)?;
        for remark in crowd.remarks.iter().filter(|remark| !warnings.contains(*remark)).cloned().collect::<Vec<_>>() {
            talk.say(&remark);
            warnings.push(remark);
        }
        let of_count = measure_count(asked, &gpu, crowd, budget, samples, talk)?;
        for condition in &asked.words.assert {
            let (found, holds) = condition.judge(&of_count);
            let Row { count, budget, .. } = of_count[0];
            conditions.push(Judged { condition: condition.to_string(), count, budget, found, holds });
        }
        for row in of_count.iter().filter(|row| !row.overflow.is_empty()) {
            let warning = format!("{} at {}: did not fit: {}", row.technique, row.count, row.overflow.join(", "));
            talk.say(&warning);
            warnings.push(warning);
        }
        rows.extend(of_count);
    }
    Ok(BenchReport {
        schema_version: SCHEMA_VERSION,
        program: format!("crowdplay {}", env!("CARGO_PKG_VERSION")),
        pack: plan.pack.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        adapter: gpu.describe(),
        features: gpu.device.features().iter_names().map(|(name, _)| name.to_owned()).collect(),
        size: plan.size,
        samples,
        alpha: plan.detail.alpha,
        rounds: asked.words.rounds,
        warm_up: asked.words.warm_up,
        rows,
        conditions,
        warnings,
    })
}

/// Frames of one technique.
struct Contender {
    variant: Variant,
    frames: Vec<Frame>,
    /// The CPU's time of each, milliseconds.
    cpu_ms: Vec<f32>,
    last: FrameTotals,
    vertex_runs: Option<u64>,
    /// Of counted frames with anybody: vertex shader runs and triangles.
    runs: Vec<(u64, u32)>,
    poses: Option<u32>,
    overflow: u32,
    /// Where its newest frame's vertices were worked out.
    choice: Option<SkinningChoice>,
    /// How high the water was in its frame before.
    water_bits: u32,
}

fn measure_count(
    asked: &Asked,
    gpu: &Gpu,
    mut crowd: Crowd,
    budget: Option<u32>,
    samples: u32,
    talk: &mut Talk<'_>,
) -> Result<Vec<Row>> {
    let plan = &asked.plan;
    let Show::Headless(HeadlessPlan { dt_s, start_s, .. }) = plan.show else { unreachable!("a bench has no window") };
    let viewer = Viewer::open(&plan.camera, &crowd)?;
    let dt_s = match (asked.words.path, viewer.end_s()) {
        (Some(frames), Some(end_s)) => end_s / (frames - 1) as f32,
        _ => dt_s,
    };
    let given = budget;
    let mut budget = given.unwrap_or_else(|| backend::usual_budget(Some(gpu), &crowd, &plan.detail));
    let asked_for = (budget, plan.detail.budget_in);
    let draws: Vec<DrawOptions> = asked.words.ab.iter().map(|variant| variant.options(plan.detail.draw)).collect();
    check_count(&gpu.device, crowd.instances.len(), &draws)?;
    let mut backend = GpuBackend::new(gpu.clone(), &crowd, plan.size, samples, asked_for)?;
    if let Some(limit_bytes) = plan.machine.vram_bytes {
        budget = backend.fit_memory(&crowd, &plan.detail, limit_bytes, (with_baseline(draws), false), given)?;
        talk.say(&format!("{budget} {} fit {} MB", plan.detail.budget_in.name(), limit_bytes / MEGABYTE));
        if let Some(remark) = backend.room_remark() {
            talk.say(remark);
        }
    }
    let new = |&variant: &Variant| Contender {
        variant,
        frames: Vec::new(),
        cpu_ms: Vec::new(),
        last: FrameTotals::default(),
        vertex_runs: None,
        runs: Vec::new(),
        poses: None,
        overflow: 0,
        choice: None,
        water_bits: 0,
    };
    let mut contenders: Vec<Contender> = asked.words.ab.iter().map(new).collect();
    let (warm_up, rounds) = (asked.words.warm_up, asked.words.rounds);
    if asked.words.ab.iter().any(|variant| variant.fades) {
        // Fades are put into the CPU's instances: it has to know where everyone is.
        backend.end_simulation(&mut crowd)?;
    }
    let mut simulate_ms = Vec::new();
    let config = frame_config(&viewer.at(start_s), plan.size, start_s, &plan.detail, budget);
    backend.show_time(&mut crowd, start_s)?;
    for contender in &contenders {
        backend.settle_skinning(&config, contender.variant.options(plan.detail.draw))?;
    }
    for round in 0..warm_up + rounds {
        let time_s = start_s + round.saturating_sub(warm_up) as f32 * dt_s;
        let config = frame_config(&viewer.at(time_s), plan.size, time_s, &plan.detail, budget);
        let start = Instant::now();
        backend.show_time(&mut crowd, time_s)?;
        if round >= warm_up {
            simulate_ms.push(start.elapsed().as_secs_f32() * 1e3);
        }
        crowd.play(time_s);
        // Whoever comes first finds other caches and clocks than whoever comes last.
        let first = round as usize % contenders.len();
        for turn in 0..asked.words.ab.len() {
            let index = (first + turn) % contenders.len();
            let contender = &mut contenders[index];
            let options = contender.variant.options(plan.detail.draw);
            let asked_for = contender.variant.config(config);
            let config = after_water(asked_for, contender.water_bits);
            if asked.words.ab.iter().any(|variant| variant.fades) {
                backend.set_instances(&shown(&crowd, contender.variant))?;
            }
            backend.bake(&crowd, &config, options)?;
            let start = Instant::now();
            let totals = backend.draw(&config, options)?;
            let frame_ms = start.elapsed().as_secs_f32() * 1e3;
            if round >= warm_up {
                contender.cpu_ms.push(backend.cpu_ms());
                contender.frames.push(Frame::new(
                    round - warm_up,
                    time_s,
                    budget,
                    totals,
                    frame_ms,
                    &backend.timings_ms(),
                ));
                contender.overflow |= totals.overflow;
            }
            if asked_for.slack > 0 && options.technique.has_budget() {
                contender.water_bits = backend.water_bits()?;
            }
            contender.last = totals;
            contender.vertex_runs = backend.vertex_runs();
            if let Some(runs) = contender.vertex_runs.filter(|_| round >= warm_up && totals.triangle_count > 0) {
                contender.runs.push((runs, totals.triangle_count));
            }
            contender.poses = if options.shares_poses() { backend.shared_poses()? } else { None };
            if options.technique == Technique::Bucketed {
                contender.choice = Some(backend.skinning(options));
            }
        }
    }
    for contender in &contenders {
        // As in its own frames: whoever was drawn last may have had others who fade.
        let asked = contender.variant.options(plan.detail.draw).skinning;
        if let Some(words) = contender.choice.as_ref().and_then(|choice| skinning_words(choice, asked)) {
            talk.say(&format!("{}: {words}", contender.variant));
        }
    }
    talk.say(&format!("{} instances: {rounds} frames each of {} techniques", crowd.instances.len(), contenders.len()));
    let count = crowd.instances.len() as u32;
    let simulate_ms = crowd.moving.is_some().then(|| Spread::of(simulate_ms).median);
    let row = |contender| Row { simulate_ms, ..row_of(contender, count, budget) };
    let mut rows: Vec<Row> = contenders.iter().map(row).collect();
    // A flock on the GPU knows no way back.
    let in_the_middle = asked.words.path.is_some() && !backend.simulates();
    backend.end_simulation(&mut crowd)?;
    let pictured = if in_the_middle { rounds / 2 } else { rounds - 1 };
    let time_s = start_s + pictured as f32 * dt_s;
    if in_the_middle {
        crowd.advance(time_s);
        crowd.play(time_s);
    }
    let config = frame_config(&viewer.at(time_s), plan.size, time_s, &plan.detail, budget);
    let mut picture_with = |instances: &[InstanceRecord], variant: Variant, budget: u32| {
        let options = variant.options(plan.detail.draw);
        // All of N: what is left over to keep levels still would be a share of another N, and depend on the picture before.
        let config = variant.config(FrameConfig { budget, slack: 0, ..config });
        backend.set_instances(instances)?;
        backend.bake(&crowd, &config, options)?;
        let totals = backend.draw(&config, options)?;
        Ok::<_, Error>((backend.picture()?, totals))
    };
    let mut picture =
        |instances: &[InstanceRecord], variant: Variant| Ok::<_, Error>(picture_with(instances, variant, budget)?.0);
    let mut references: Vec<(Variant, [Picture; 2])> = Vec::new();
    if crowd.summary.triangles_full > MOST_PICTURED {
        talk.say(&format!("no difference to full detail: that has more than {MOST_PICTURED} triangles"));
    } else {
        for (row, contender) in rows.iter_mut().zip(&contenders) {
            // In the same light and poses.
            let Variant { fades, shadows, .. } = contender.variant;
            let like = Variant { fades, shadows, ..Technique::PseudoInstancing.into() };
            if !references.iter().any(|(known, _)| *known == like) {
                references.push((like, [picture(&shown(&crowd, like), like)?, picture(&[], like)?]));
            }
            let (_, [full_detail, empty]) = references.iter().find(|(known, _)| *known == like).expect("drawn above");
            // The baseline is what the others are compared with; it is slow enough to draw once.
            row.image_rmse = Some(match contender.variant.technique {
                Technique::PseudoInstancing => 0.0,
                _ => difference(&picture(&shown(&crowd, contender.variant), contender.variant)?, full_detail, empty),
            });
        }
    }
    for (variant, than) in asked.words.assert.iter().filter_map(Condition::equal_image) {
        let image_of = |of: Variant| contenders.iter().position(|c| c.variant == of).and_then(|i| rows[i].image_rmse);
        let like = Variant { fades: variant.fades, shadows: variant.shadows, ..Technique::PseudoInstancing.into() };
        let reference = references.iter().find(|(known, _)| *known == like);
        let (Some(wanted), Some((_, [full_detail, empty]))) = (image_of(than), reference) else { continue };
        let other_triangles = picture_with(&shown(&crowd, than), than, budget)?.1.triangle_count;
        let found = least_budget(budget, wanted, |budget| {
            let (drawn, totals) = picture_with(&shown(&crowd, variant), variant, budget)?;
            let image_rmse = difference(&drawn, full_detail, empty);
            Ok(EqualImage { budget, triangles: totals.triangle_count, other_triangles, image_rmse })
        })?;
        let row = contenders.iter().position(|c| c.variant == variant).expect("checked with the words");
        rows[row].as_good_as.extend(found.map(|equal| (than.to_string(), equal)));
    }
    if asked.words.pops {
        let config_of = |frame: u32| {
            let time_s = start_s + frame as f32 * dt_s;
            frame_config(&viewer.at(time_s), plan.size, time_s, &plan.detail, budget)
        };
        backend.set_crowd(&crowd)?;
        let levels = CpuLevels::new(&crowd.data)?;
        for (row, contender) in rows.iter_mut().zip(&contenders) {
            let options = contender.variant.options(plan.detail.draw);
            let config_of = |frame: u32| contender.variant.config(config_of(frame));
            let pops = measure_pops(&mut backend, &mut crowd, &levels, options, rounds, &config_of)?;
            row.pop_rmse = pops.as_ref().map(Pops::rmse);
            row.pop_p999 = pops.as_ref().map(Pops::p999);
            row.pop_px = pops.as_ref().map(|pops| pops.moves().rms_px());
            row.pop_far_share = pops.as_ref().map(|pops| pops.moves().far_share());
            row.level_steps = pops.as_ref().map(|pops| *pops.steps());
        }
    }
    let base = rows[0].frame_ms.median;
    rows.iter_mut().for_each(|row| row.frame_ratio = row.frame_ms.median / base);
    Ok(rows)
}

/// The frame after one of the same contender in which the water stood so high. Its first one has none before it and may not recall that of
/// whoever was drawn last.
fn after_water(config: FrameConfig, water_before_bits: u32) -> FrameConfig {
    let slack = if water_before_bits == 0 { 0 } else { config.slack };
    FrameConfig { water_before_bits, slack, ..config }
}

/// The least budget up to `most` whose picture is at most `wanted` from full detail, to a hundredth; `None` where not even `most` is. More
/// vertices are taken to bring it nearer, which holds but for the last digits.
fn least_budget(most: u32, wanted: f32, mut at: impl FnMut(u32) -> Result<EqualImage>) -> Result<Option<EqualImage>> {
    let mut best = at(most)?;
    if best.image_rmse > wanted {
        return Ok(None);
    }
    let (mut low, mut high) = (1_u32, most);
    while high > low + (low / 100).max(1) {
        // In the middle of the doublings between.
        let middle = libm::sqrt(f64::from(low) * f64::from(high)) as u32;
        let tried = at(middle.clamp(low + 1, high - 1))?;
        if tried.image_rmse <= wanted {
            (high, best) = (tried.budget, tried);
        } else {
            low = tried.budget;
        }
    }
    Ok(Some(best))
}

/// The crowd as a variant shows it: where everyone fades, halfway from the clip after their own.
fn shown(crowd: &Crowd, variant: Variant) -> Cow<'_, [InstanceRecord]> {
    if !variant.fades {
        return Cow::Borrowed(&crowd.instances);
    }
    let fading = |one: &InstanceRecord| {
        let record = &crowd.data.characters[one.character as usize];
        let next = (one.clip - record.clip_offset + 1) % record.clip_count.max(1);
        InstanceRecord {
            leaving_clip: record.clip_offset + next,
            leaving_phase_s: one.phase_s,
            leaving_share: 0.5,
            ..*one
        }
    };
    Cow::Owned(crowd.instances.iter().map(fading).collect())
}

fn row_of(contender: &Contender, count: u32, budget: u32) -> Row {
    let frames = &contender.frames;
    let timed: Vec<(f32, f32)> = frames
        .iter()
        .filter(|frame| !frame.stages_ms.is_empty())
        .map(|frame| {
            let all: f32 = frame.stages_ms.values().sum();
            let rendering: f32 = RENDERING.iter().filter_map(|name| frame.stages_ms.get(name)).sum();
            (all, all - rendering)
        })
        .collect();
    let median = |of: &dyn Fn(&(f32, f32)) -> f32| Spread::of(timed.iter().map(of).collect()).median;
    let has_times = !timed.is_empty();
    let cpu_shares =
        contender.cpu_ms.iter().zip(frames).map(|(cpu_ms, frame)| cpu_ms / frame.frame_ms.max(1e-6)).collect();
    let timings = crate::stats::Timings::over(frames);
    // Drawing all at full detail is what a technique without a budget does.
    let overflow = if contender.variant.technique.has_budget() {
        contender.overflow
    } else {
        contender.overflow & !overflow::BUDGET
    };
    Row {
        count,
        technique: contender.variant.to_string(),
        skinning: contender.choice.as_ref().map_or(Skinning::Vertex, |choice| choice.way).name(),
        budget,
        frames: frames.len() as u32,
        frame_ms: timings.frame_ms,
        frame_ratio: 1.0,
        cpu_ms: Some(Spread::of(contender.cpu_ms.clone()).median),
        cpu_share: Some(Spread::of(cpu_shares).median),
        gpu_ms: has_times.then(|| Spread::of(timed.iter().map(|(all, _)| *all).collect())),
        simulate_ms: None,
        lod_ms: has_times.then(|| median(&|(_, lod)| *lod)),
        lod_share: has_times.then(|| median(&|(all, lod)| if *all > 0.0 { lod / all } else { 0.0 })),
        stages_ms: timings.stages_ms,
        visible: contender.last.visible_count,
        outside: contender.last.outside_count,
        occluded: contender.last.occluded_count,
        vertices: contender.last.vertex_count,
        triangles: contender.last.triangle_count,
        draws: contender.last.draw_count,
        vertex_runs: contender.vertex_runs,
        poses: contender.poses,
        runs_per_triangle: contender
            .vertex_runs
            .filter(|_| contender.last.triangle_count > 0)
            .map(|runs| runs as f32 / contender.last.triangle_count as f32),
        mean_runs_per_triangle: (!contender.runs.is_empty()).then(|| {
            let sum = contender.runs.iter().fold((0, 0), |(runs, all), (r, t)| (runs + r, all + u64::from(*t)));
            sum.0 as f32 / sum.1 as f32
        }),
        most_runs_per_triangle: contender.runs.iter().map(|(r, t)| *r as f32 / *t as f32).max_by(f32::total_cmp),
        as_good_as: BTreeMap::new(),
        image_rmse: None,
        pop_rmse: None,
        pop_p999: None,
        pop_px: None,
        pop_far_share: None,
        level_steps: None,
        overflow: overflow_words(overflow),
    }
}

/// Root mean square difference of two pictures, sRGB 0 to 1, over the pixels in which either shows anyone; 0 where none does.
/// `empty`: the same view without anyone.
fn difference(drawn: &Picture, full_detail: &Picture, empty: &Picture) -> f32 {
    let (mut sum, mut count) = (0.0_f64, 0_u64);
    for ((a, b), nobody) in drawn.pixels.iter().zip(&full_detail.pixels).zip(&empty.pixels) {
        if a == nobody && b == nobody {
            continue;
        }
        count += 3;
        let squares = a.iter().zip(b).take(3).map(|(a, b)| (f64::from(*a) - f64::from(*b)) / 255.0);
        sum += squares.map(|d| d * d).sum::<f64>();
    }
    if count == 0 { 0.0 } else { (sum / count as f64).sqrt() as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_drawn_nothing_yet_looks_for_the_waters_height() {
        let config = FrameConfig { slack: 900, ..FrameConfig::default() };
        let of = |water_bits| {
            let FrameConfig { slack, water_before_bits, .. } = after_water(config, water_bits);
            (slack, water_before_bits)
        };
        assert_eq!((of(0), of(0x4000_0000)), ((0, 0), (900, 0x4000_0000)));
    }

    #[test]
    fn the_least_budget_is_found_to_a_hundredth() {
        let mut tried = 0;
        let mut find = |most: u32, wanted: f32| {
            least_budget(most, wanted, |budget| {
                tried += 1;
                Ok(EqualImage { budget, triangles: budget * 2, image_rmse: 100.0 / budget as f32, other_triangles: 1 })
            })
            .unwrap()
        };
        let found = find(1_000_000, 0.01).expect("10,000 will do");
        assert!((10_000..=10_100).contains(&found.budget) && found.triangles == found.budget * 2, "{found:?}");
        assert_eq!(find(9_000, 0.01), None);
        assert!(tried < 25, "{tried}");
    }

    #[test]
    fn pictures_differ_where_someone_is() {
        let of = |pixels: &[[u8; 4]]| Picture { width: pixels.len() as u32, height: 1, pixels: pixels.to_vec() };
        let (sky, white, black) = ([9, 9, 9, 255], [255; 4], [0, 0, 0, 255]);
        let empty = of(&[sky, sky, sky, sky]);
        let full = of(&[sky, white, white, sky]);
        assert_eq!(difference(&full, &full, &empty), 0.0);
        assert_eq!(difference(&of(&[sky, black, black, sky]), &full, &empty), 1.0);
        let half = difference(&of(&[sky, white, black, sky]), &full, &empty);
        assert!((half - 0.5_f32.sqrt()).abs() < 1e-6, "{half}");
        assert_eq!(difference(&empty, &empty, &empty), 0.0);
    }
}
