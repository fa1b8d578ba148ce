//! The report: what each frame came to, and how long it took. JSON with a schema number.

use crowd_stages::gpu::SkinningChoice;
use crowd_stages::{BudgetIn, FrameTotals, Skinning, overflow};
use serde::Serialize;
use std::collections::BTreeMap;

/// Number of the report's shape; grows when a key changes its meaning or goes.
pub const SCHEMA_VERSION: u32 = 1;

/// The whole report.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Program and version.
    pub program: String,
    /// The pack's file name, without folder.
    pub pack: String,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// What drew.
    pub adapter: Adapter,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
    /// A [`crowd_stages::Technique`] by name.
    pub technique: &'static str,
    /// `continuous` or `quantized`; without meaning where there is no budget.
    pub levels: &'static str,
    /// How the budget is split: `fill` or `eq1`.
    pub fit: &'static str,
    /// Vertices move between levels.
    pub morph: bool,
    /// Hidden instances are left out.
    pub occlusion: bool,
    /// Where vertices were worked out in the last frame: `vertex`, `palettes` or `compute`.
    pub skinning: &'static str,
    /// GPU milliseconds a frame of those three, where they were tried to the end (--skinning auto).
    pub skinning_ms: Option<[f32; 3]>,
    /// Shadow maps of the sun; 0 without shadows.
    pub shadows: u32,
    /// Metres after which a twentieth is left of what is seen; 0 without fog.
    pub fog_m: f32,
    /// Who simulates the flock, `gpu` or `cpu`; `null` where the crowd is none.
    pub simulator: Option<&'static str>,
    /// Vertices, or triangles, a frame: N.
    pub budget: u32,
    /// Which of them: `vertices` or `triangles`.
    pub budget_in: &'static str,
    /// Share of the budget that may be left over so that levels keep still.
    pub slack_share: f32,
    /// GPU memory that might be taken, bytes; `null` where nobody said.
    pub vram_bytes: Option<u64>,
    /// Exponent of the split.
    pub alpha: f32,
    /// `area` or `area-distance`.
    pub weight: &'static str,
    /// The crowd.
    pub crowd: Crowd,
    /// Seconds between frames; 0 in a window, where the clock decides.
    pub dt_s: f32,
    /// Bytes of GPU memory asked for; 0 without a GPU.
    pub gpu_bytes: u64,
    /// The same by what they are for.
    pub gpu_memory: BTreeMap<&'static str, u64>,
    /// Frames, in order.
    pub frames: Vec<Frame>,
    /// Times over all frames but the first, which pays for shader compilation (with one frame: that one); `timings.frames` says how many.
    pub timings: Timings,
    /// Pictures written.
    pub pictures: Vec<String>,
    /// What was said on standard error besides.
    pub warnings: Vec<String>,
}

impl Report {
    /// Takes note of GPU memory by what it is for.
    pub fn set_memory(&mut self, parts: &[(&'static str, u64)]) {
        self.gpu_memory = parts.iter().copied().collect();
        self.gpu_bytes = self.gpu_memory.values().sum();
    }
}

/// Why vertices are worked out where they are when `asked` was asked for, in words: times tried, somebody who may fade, or what did not fit.
pub fn skinning_words(choice: &SkinningChoice, asked: Skinning) -> Option<String> {
    if let Some(why) = &choice.refused {
        return Some(format!("vertices are skinned by the vertex shader: {why}"));
    }
    if let Some(why) = &choice.sharing_refused {
        return Some(format!("poses are not shared: {why}"));
    }
    if takes_palettes_for_fades(choice, asked) {
        return Some(format!("skinning: {} (somebody may fade, so nothing was measured)", choice.way.name()));
    }
    let tried = |(way, ms): (Skinning, f32)| format!("{} {ms:.2} ms", way.name());
    let ms = choice.measured_ms?;
    let all: Vec<String> = Skinning::WAYS.into_iter().zip(ms).map(tried).collect();
    Some(format!("skinning: {} ({})", choice.way.name(), all.join(", ")))
}

/// Whether `auto` was left no choice by those who fade.
pub fn takes_palettes_for_fades(choice: &SkinningChoice, asked: Skinning) -> bool {
    asked == Skinning::Auto && choice.fades && choice.refused.is_none()
}

/// What drew.
#[derive(Debug, Clone, Serialize, Default, PartialEq, Eq)]
pub struct Adapter {
    /// The adapter's name, or `crowd-raster`.
    pub name: String,
    /// `Vulkan`, `Metal`, ... or `cpu`.
    pub backend: String,
    /// Driver.
    pub driver: String,
    /// Its version.
    pub driver_version: String,
    /// `DiscreteGpu`, `IntegratedGpu`, `Cpu`, ...
    pub device_type: String,
}

/// The crowd at full detail.
#[derive(Debug, Clone, Serialize, Default, PartialEq)]
pub struct Crowd {
    /// Instances.
    pub instances: u32,
    /// Characters used.
    pub characters: Vec<String>,
    /// Clips used, `character/clip`.
    pub clips: Vec<String>,
    /// Vertices of all instances at full detail.
    pub vertices_full: u64,
    /// Vertices of all instances' coarsest levels.
    pub vertices_least: u64,
    /// Triangles of all instances at full detail.
    pub triangles_full: u64,
    /// Metres between neighbours; 0 from a layout file.
    pub spacing_m: f32,
    /// Seed.
    pub seed: u32,
}

/// One frame.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct Frame {
    /// Number, from 0.
    pub frame: u32,
    /// Time shown, seconds.
    pub time_s: f32,
    /// Vertices, or triangles, it might have: N.
    pub budget: u32,
    /// Instances there were: of a simulator's people those who had come and not left.
    pub present: u32,
    /// Their triangles at full detail.
    pub present_triangles: u64,
    /// Instances drawn.
    pub visible: u32,
    /// Instances left out because the frustum does not meet them.
    pub outside: u32,
    /// Instances in the frustum that were left out because others or walls hide them (--occlusion on).
    pub occluded: u32,
    /// Instances of a simulator that could not be drawn.
    pub refused: u32,
    /// Vertices selected.
    pub vertices: u32,
    /// Vertices that Eq. 1 as printed comes to, for comparison; 0 where there is no budget.
    pub eq1_vertices: u32,
    /// Pixels that no level's error exceeds, with --lod-metric error; else 0.
    pub threshold_px: f32,
    /// Triangles drawn.
    pub triangles: u32,
    /// Draws that draw anything.
    pub draws: u32,
    /// Least budget that draws all visible instances.
    pub min_vertices: u32,
    /// What did not fit: `budget`, `vertices`, `triangles`.
    pub overflow: Vec<&'static str>,
    /// Vertices needed when they overflowed.
    pub needed_vertices: u32,
    /// Triangles needed when they overflowed.
    pub needed_triangles: u32,
    /// From recording to finished, milliseconds.
    pub frame_ms: f32,
    /// Before that: moving everyone on and, where the CPU does that, sending them over; `null` where nobody moves, and in a window.
    pub simulate_ms: Option<f32>,
    /// GPU (or CPU) milliseconds by stage, where offered.
    pub stages_ms: BTreeMap<&'static str, f32>,
}

impl Frame {
    /// A frame from what the stages counted.
    pub fn new(
        frame: u32,
        time_s: f32,
        budget: u32,
        totals: FrameTotals,
        frame_ms: f32,
        stages: &[(&'static str, f32)],
    ) -> Self {
        Self {
            frame,
            time_s,
            budget,
            present: 0,
            present_triangles: 0,
            visible: totals.visible_count,
            outside: totals.outside_count,
            occluded: totals.occluded_count,
            refused: totals.refused_count,
            vertices: totals.vertex_count,
            eq1_vertices: totals.wanted_count,
            threshold_px: totals.threshold_px,
            triangles: totals.triangle_count,
            draws: totals.draw_count,
            min_vertices: totals.min_vertex_count,
            overflow: overflow_words(totals.overflow),
            needed_vertices: totals.needed_vertices,
            needed_triangles: totals.needed_triangles,
            frame_ms,
            simulate_ms: None,
            stages_ms: stages.iter().copied().collect(),
        }
    }
}

impl Frame {
    /// The same with who was there.
    #[must_use]
    pub fn of(self, crowd: &crate::crowd::Crowd) -> Self {
        Self { present: crowd.instances.len() as u32, present_triangles: crowd.present_triangles(), ..self }
    }

    /// What the GPU took, milliseconds; the whole frame where it does not say.
    pub fn work_ms(&self) -> f32 {
        if self.stages_ms.is_empty() { self.frame_ms } else { self.stages_ms.values().sum() }
    }
}

/// The overflow bits by name.
pub fn overflow_words(bits: u32) -> Vec<&'static str> {
    let names = [(overflow::BUDGET, "budget"), (overflow::VERTICES, "vertices"), (overflow::TRIANGLES, "triangles")];
    names.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, name)| *name).collect()
}

/// What an overflow means and what helps, a sentence each.
pub fn overflow_messages(
    totals: &FrameTotals,
    (budget, budget_in): (u32, BudgetIn),
    max_px: Option<f32>,
) -> Vec<String> {
    let mut messages = Vec::new();
    if totals.overflow & overflow::BUDGET != 0 {
        messages.push(format!(
            "budget: the coarsest levels of the {} visible instances have {} {}, the budget is {budget}; raise --budget",
            totals.visible_count,
            totals.min_vertex_count,
            budget_in.name()
        ));
    }
    if totals.refused_count > 0 {
        messages.push(format!(
            "instances: {} of the simulator's are not drawn: past the end, of a character or clip that is not there, or not finite",
            totals.refused_count
        ));
    }
    if let Some(max_px) = max_px.filter(|max_px| totals.threshold_px > *max_px) {
        messages.push(format!(
            "error: {:.2} pixels is the least that a budget of {budget} holds, {max_px} asked for (--max-px); raise --budget",
            totals.threshold_px
        ));
    }
    if totals.overflow & overflow::VERTICES != 0 {
        messages.push(format!(
            "vertices: {} needed, the frame's list holds fewer; instances past its end are not drawn; use fewer instances or a smaller --budget",
            totals.needed_vertices
        ));
    }
    if totals.overflow & overflow::TRIANGLES != 0 {
        messages.push(format!(
            "triangles: {} needed, the frame's index buffer holds fewer; instances past its end are not drawn; use a smaller --budget",
            totals.needed_triangles
        ));
    }
    messages
}

/// Times over the frames.
#[derive(Debug, Clone, Serialize, Default, PartialEq)]
pub struct Timings {
    /// Frames counted: all but the first, or that one where there is no other.
    pub frames: u32,
    /// Whole frames.
    pub frame_ms: Spread,
    /// By stage.
    pub stages_ms: BTreeMap<&'static str, Spread>,
}

/// Middle and tail of a set of times, milliseconds.
#[derive(Debug, Clone, Copy, Serialize, Default, PartialEq)]
pub struct Spread {
    /// Half are shorter; of an even number the mean of the two in the middle.
    pub median: f32,
    /// 95 % are not longer.
    pub p95: f32,
    /// Shortest.
    pub min: f32,
    /// Longest.
    pub max: f32,
}

impl Spread {
    /// Of some times; zeros of none. The tail by nearest rank, so it is a time that was measured.
    pub fn of(mut times_ms: Vec<f32>) -> Self {
        if times_ms.is_empty() {
            return Self::default();
        }
        times_ms.sort_by(f32::total_cmp);
        let n = times_ms.len();
        let p95 = times_ms[(n * 95).div_ceil(100).max(1) - 1];
        let median = times_ms[(n - 1) / 2].midpoint(times_ms[n / 2]);
        Self { median, p95, min: times_ms[0], max: times_ms[n - 1] }
    }
}

impl Timings {
    /// Over all frames but the first.
    pub fn of(frames: &[Frame]) -> Self {
        Self::over(if frames.len() > 1 { &frames[1..] } else { frames })
    }

    /// Over all of them.
    pub fn over(counted: &[Frame]) -> Self {
        let mut stages: BTreeMap<&'static str, Vec<f32>> = BTreeMap::new();
        for (stage, ms) in counted.iter().flat_map(|f| &f.stages_ms) {
            stages.entry(stage).or_default().push(*ms);
        }
        Self {
            frames: counted.len() as u32,
            frame_ms: Spread::of(counted.iter().map(|f| f.frame_ms).collect()),
            stages_ms: stages.into_iter().map(|(stage, times)| (stage, Spread::of(times))).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_are_of_what_was_measured() {
        assert_eq!(Spread::of(vec![]), Spread::default());
        assert_eq!(Spread::of(vec![3.0]), Spread { median: 3.0, p95: 3.0, min: 3.0, max: 3.0 });
        let hundred: Vec<f32> = (1..=100).rev().map(|i| i as f32).collect();
        assert_eq!(Spread::of(hundred), Spread { median: 50.5, p95: 95.0, min: 1.0, max: 100.0 });
        assert_eq!([vec![9.0, 1.0], vec![9.0, 1.0, 2.0]].map(|times| Spread::of(times).median), [5.0, 2.0]);
    }

    #[test]
    fn the_first_frame_is_not_timed_unless_it_is_the_only_one() {
        let frame = |i: u32, ms: f32| Frame::new(i, 0.0, 0, FrameTotals::default(), ms, &[("cull", ms)]);
        let many = Timings::of(&[frame(0, 900.0), frame(1, 5.0), frame(2, 7.0)]);
        assert_eq!((many.frames, many.frame_ms.max, many.stages_ms["cull"].min), (2, 7.0, 5.0));
        assert_eq!(Timings::of(&[frame(0, 900.0)]).frame_ms.median, 900.0);
    }

    #[test]
    fn where_somebody_may_fade_auto_says_so_and_nobody_else() {
        let fading = SkinningChoice {
            way: Skinning::Palettes,
            is_settled: true,
            fades: true,
            measured_ms: None,
            refused: None,
            sharing_refused: None,
        };
        let words = skinning_words(&fading, Skinning::Auto).expect("it says why");
        assert!(words.contains("palettes") && words.contains("may fade"), "{words}");
        assert_eq!(skinning_words(&fading, Skinning::Palettes), None);
        let measured = SkinningChoice { fades: false, measured_ms: Some([3.0, 2.0, 4.0]), ..fading.clone() };
        assert!(skinning_words(&measured, Skinning::Auto).is_some_and(|words| words.contains("2.00 ms")));
        let refused = SkinningChoice { refused: Some("too large".into()), way: Skinning::Vertex, ..fading };
        assert!(!takes_palettes_for_fades(&refused, Skinning::Auto));
        assert!(skinning_words(&refused, Skinning::Auto).is_some_and(|words| words.contains("too large")));
    }

    #[test]
    fn overflow_bits_have_names_and_remedies() {
        let bits = overflow::BUDGET | overflow::TRIANGLES;
        assert_eq!(overflow_words(bits), ["budget", "triangles"]);
        let totals = FrameTotals { overflow: bits, min_vertex_count: 77, needed_triangles: 88, ..Default::default() };
        let messages = overflow_messages(&totals, (50, BudgetIn::Triangles), None);
        assert_eq!(messages.len(), 2);
        let coarse = FrameTotals { threshold_px: 2.0, ..Default::default() };
        let count = |max_px| overflow_messages(&coarse, (50, BudgetIn::Vertices), max_px).len();
        assert_eq!([count(None), count(Some(3.0)), count(Some(1.0))], [0, 0, 1]);
        assert!(messages[0].contains("77 triangles") && messages[0].contains("50") && messages[1].contains("88"));
    }
}
