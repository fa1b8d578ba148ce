//! What came out of a bench: a row for each technique and count.

use super::pops::LevelSteps;
use crate::stats::{Adapter, Spread};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Number of the report's shape; grows when a key changes its meaning or goes.
pub const SCHEMA_VERSION: u32 = 1;

/// The whole bench.
#[derive(Debug, Clone, Serialize)]
pub struct BenchReport {
    /// Number of this shape; grows when a key changes its meaning or goes.
    pub schema_version: u32,
    /// Program and version.
    pub program: String,
    /// The pack's file name, without folder.
    pub pack: String,
    /// What drew.
    pub adapter: Adapter,
    /// Features of the device that a technique may use.
    pub features: Vec<String>,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
    /// Exponent of the split.
    pub alpha: f32,
    /// Frames of each technique that count.
    pub rounds: u32,
    /// Frames of each before those.
    pub warm_up: u32,
    /// By count, then in the order of `--ab`.
    pub rows: Vec<Row>,
    /// Every condition at every count.
    pub conditions: Vec<Judged>,
    /// Said on standard error besides.
    pub warnings: Vec<String>,
}

/// One technique at one count and budget.
#[derive(Debug, Clone, Serialize, Default, PartialEq)]
pub struct Row {
    /// Instances.
    pub count: u32,
    /// A technique with its switches, as in `--ab`.
    pub technique: String,
    /// Where its vertices were worked out, a [`crowd_stages::Skinning`] by name.
    pub skinning: &'static str,
    /// Vertices a frame: N.
    pub budget: u32,
    /// Frames counted.
    pub frames: u32,
    /// From recording to finished.
    pub frame_ms: Spread,
    /// Median divided by the first technique's of this count.
    pub frame_ratio: f32,
    /// Median of moving everyone on before a frame, the same for all; `None` where nobody moves. No part of `frame_ms`.
    pub simulate_ms: Option<f32>,
    /// Median of what the CPU does for a frame: recording and submitting it, without waiting for the GPU.
    pub cpu_ms: Option<f32>,
    /// Its median part of the frame.
    pub cpu_share: Option<f32>,
    /// All stages and the draw on the GPU; `None` where the adapter has no timestamps.
    pub gpu_ms: Option<Spread>,
    /// Median of everything but skinning and drawing: culling, levels, bucketing or reforming.
    pub lod_ms: Option<f32>,
    /// Its median part of the GPU's time.
    pub lod_share: Option<f32>,
    /// By stage.
    pub stages_ms: BTreeMap<&'static str, Spread>,
    /// Instances drawn in the last frame.
    pub visible: u32,
    /// Instances of the last frame that the frustum does not meet.
    pub outside: u32,
    /// Instances of the last frame that others hide.
    pub occluded: u32,
    /// Vertices of the last frame.
    pub vertices: u32,
    /// Triangles of the last frame.
    pub triangles: u32,
    /// Draws of the last frame that drew anything.
    pub draws: u32,
    /// Vertex shader runs of the last frame, as the adapter counts them.
    pub vertex_runs: Option<u64>,
    /// The same for each of its triangles: 0.5 to 1 in cache order, up to 3 without any reuse.
    pub runs_per_triangle: Option<f32>,
    /// Vertex shader runs of all counted frames over all their triangles.
    pub mean_runs_per_triangle: Option<f32>,
    /// The most for each triangle of any counted frame.
    pub most_runs_per_triangle: Option<f32>,
    /// Where a condition asks for it: the least budget whose picture is as near to full detail as another technique's, by that one's name.
    pub as_good_as: BTreeMap<String, EqualImage>,
    /// Difference of the last frame to full detail, RMS of sRGB 0 to 1 over the pixels that show anyone; `None` where full detail is too much to
    /// draw.
    pub image_rmse: Option<f32>,
    /// What changes from frame to frame by levels alone, RMS over the pixels that show anyone; `None` unless asked for.
    pub pop_rmse: Option<f32>,
    /// The same of one pixel in a thousand.
    pub pop_p999: Option<f32>,
    /// How far the surface moves from frame to frame by levels alone, RMS over all vertices of full detail, pixels.
    pub pop_px: Option<f32>,
    /// Share of those that move farther than a quarter of a pixel.
    pub pop_far_share: Option<f32>,
    /// How many quantised levels instances go from one frame to the next.
    pub level_steps: Option<LevelSteps>,
    /// Poses of the last frame's visible instances, where they are shared; each dot-drawn one counts as one of its own.
    pub poses: Option<u32>,
    /// What did not fit in some frame.
    pub overflow: Vec<&'static str>,
}

/// A budget that gives a picture as near to full detail as another technique's.
#[derive(Debug, Clone, Copy, Serialize, Default, PartialEq)]
pub struct EqualImage {
    /// N, to a hundredth.
    pub budget: u32,
    /// Triangles drawn with it.
    pub triangles: u32,
    /// Triangles that the other draws for its picture.
    pub other_triangles: u32,
    /// Its difference to full detail.
    pub image_rmse: f32,
}

/// A condition at a count and budget.
#[derive(Debug, Clone, Serialize, PartialEq)]
pub struct Judged {
    /// As typed.
    pub condition: String,
    /// Instances.
    pub count: u32,
    /// Vertices a frame: N.
    pub budget: u32,
    /// Left side; `null` in JSON where it was not measured.
    pub found: f64,
    /// Whether it holds.
    pub holds: bool,
}

/// Columns of the table for spreadsheets.
const COLUMNS: &str = "adapter,driver,device_type,pack,width,height,samples,rounds,count,technique,skinning,budget,frame_ms_median,frame_ms_p95,\
frame_ratio,simulate_ms,cpu_ms,cpu_share,gpu_ms_median,gpu_ms_p95,lod_ms,lod_share,visible,outside,occluded,vertices,triangles,draws,vertex_runs,runs_per_triangle,mean_runs_per_triangle,most_runs_per_triangle,image_rmse,pop_rmse,pop_p999,pop_px,pop_far_share,level_steps_beyond_next,most_level_steps,poses,overflow,features";

impl BenchReport {
    /// Comma-separated values with a header; text with quotes around it.
    pub fn to_csv(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let optional = |value: Option<f32>| value.map(|v| v.to_string()).unwrap_or_default();
        let Adapter { name, driver, driver_version, device_type, .. } = &self.adapter;
        let driver = format!("{driver} {driver_version}");
        let mut csv = format!("{COLUMNS}\n");
        for row in &self.rows {
            let texts = [name, driver.trim(), device_type, &self.pack].map(quoted).join(",");
            let [width, height] = self.size;
            let Row {
                count,
                technique,
                skinning,
                budget,
                frame_ms,
                visible,
                outside,
                occluded,
                vertices,
                triangles,
                draws,
                ..
            } = row;
            let _ = writeln!(
                csv,
                "{texts},{width},{height},{},{},{count},{technique},{skinning},{budget},{},{},{},{},{},{},{},{},{},{},{visible},{outside},{occluded},{vertices},{triangles},{draws},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                self.samples,
                self.rounds,
                frame_ms.median,
                frame_ms.p95,
                row.frame_ratio,
                optional(row.simulate_ms),
                optional(row.cpu_ms),
                optional(row.cpu_share),
                optional(row.gpu_ms.map(|s| s.median)),
                optional(row.gpu_ms.map(|s| s.p95)),
                optional(row.lod_ms),
                optional(row.lod_share),
                row.vertex_runs.map(|runs| runs.to_string()).unwrap_or_default(),
                optional(row.runs_per_triangle),
                optional(row.mean_runs_per_triangle),
                optional(row.most_runs_per_triangle),
                optional(row.image_rmse),
                optional(row.pop_rmse),
                optional(row.pop_p999),
                optional(row.pop_px),
                optional(row.pop_far_share),
                optional(row.level_steps.map(|steps| steps.share_beyond_next())),
                row.level_steps.map(|steps| steps.most().to_string()).unwrap_or_default(),
                row.poses.map(|poses| poses.to_string()).unwrap_or_default(),
                quoted(&row.overflow.join(" ")),
                quoted(&self.features.join(" ")),
            );
        }
        csv
    }

    /// A page for documentation: what was measured, how, and what came out.
    pub fn to_markdown(&self, command: &str) -> String {
        let [width, height] = self.size;
        let Adapter { name, backend, driver, driver_version, .. } = &self.adapter;
        let mut out = format!(
            "# Benchmarks: drawing a crowd\n\nMade by `{command}`; do not edit by hand. {name} ({backend}, {driver} {driver_version}), \
             {width} x {height} pixels, --msaa {}, {} frames of each technique in turn after {} that do not count. \
             Times are medians, milliseconds; *N* the vertices allowed a frame, *ratio* is to the first technique, *simulate* what moving everyone on takes before each frame (no part of it), *CPU ms* what the CPU does for a frame besides (recording and submitting it), *CPU %* its part of the frame, *LOD* is everything on the GPU but skinning and drawing, *LOD %* its \
             part of the GPU's time, *visible* who is drawn, *hidden* who is in the frustum but left out behind others, *runs a triangle* the vertex shader's runs as the adapter counts them (of the last frame; in brackets the most of any, where that is another), *image* the difference to full detail (RMS of sRGB 0 to 1 over the pixels that show anyone), *pop* what changes from frame to frame by levels alone (RMS over the picture, drawn with the levels of the frame before and its own), *pop px* how far the surface moves by that (RMS over all vertices, pixels; where asked for).\n\n",
            self.samples, self.rounds, self.warm_up
        );
        out.push_str("| instances | N | technique | frame ms | p95 | ratio | simulate | CPU ms | CPU % | LOD ms | LOD % | visible | hidden | triangles | vertices | draws | runs a triangle | image | pop | pop px |\n");
        out.push_str("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
        for row in &self.rows {
            let poses = row.poses.map(|poses| format!(", {poses} poses")).unwrap_or_default();
            let _ = writeln!(
                out,
                "| {} | {} | {}{poses} | {:.2} | {:.2} | {:.3} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                row.count,
                row.budget,
                row.technique,
                row.frame_ms.median,
                row.frame_ms.p95,
                row.frame_ratio,
                number(row.simulate_ms, 2),
                number(row.cpu_ms, 2),
                number(row.cpu_share.map(|share| share * 100.0), 2),
                number(row.lod_ms, 3),
                number(row.lod_share.map(|share| share * 100.0), 2),
                row.visible,
                row.occluded,
                row.triangles,
                row.vertices,
                row.draws,
                row.runs(),
                number(row.image_rmse, 4),
                number(row.pop_rmse, 5),
                number(row.pop_px, 4)
            );
        }
        for row in &self.rows {
            for (other, EqualImage { budget, triangles, other_triangles, image_rmse }) in &row.as_good_as {
                let _ = write!(
                    out,
                    "\n{} instances: {} is as near to full detail as {other} at N = {budget}: {triangles} triangles for {other_triangles}, image {image_rmse:.4}.\n",
                    row.count, row.technique
                );
            }
        }
        for (row, steps) in self.rows.iter().filter_map(|row| Some((row, row.level_steps?))) {
            let _ = write!(out, "\n{} instances, levels of {}: {}.\n", row.count, row.technique, steps.words());
        }
        out.push_str(&self.linearity());
        if !self.conditions.is_empty() {
            out.push_str("\n| condition | instances | N | found | holds |\n|---|---|---|---|---|\n");
        }
        for Judged { condition, count, budget, found, holds } in &self.conditions {
            let _ = writeln!(
                out,
                "| {condition} | {count} | {budget} | {found:.4} | {} |",
                if *holds { "yes" } else { "NO" }
            );
        }
        for warning in &self.warnings {
            let _ = write!(out, "\n{warning}\n");
        }
        out
    }

    /// Where nothing but reformation was measured, at several sizes: how its time grows with the triangles (Peng 2011, Table 2).
    fn linearity(&self) -> String {
        let stage = "reform_triangles";
        let times: Vec<(&Row, f32)> =
            self.rows.iter().filter_map(|row| Some((row, row.stages_ms.get(stage)?.median))).collect();
        let [(first, first_ms), _, ..] = times[..] else { return String::new() };
        if times.len() < self.rows.len() || self.rows.iter().any(|row| row.technique != first.technique) {
            return String::new();
        }
        let mut out = String::from("\nReformation alone, and its ratios to the first row:\n\n");
        out.push_str("| instances | triangles | reformation ms | triangles, ratio | reformation, ratio |\n|---|---|---|---|---|\n");
        for (row, ms) in &times {
            let triangles = row.triangles as f32 / first.triangles.max(1) as f32;
            let ratio = (first_ms > 0.0).then(|| ms / first_ms);
            let (count, drawn, ratio) = (row.count, row.triangles, number(ratio, 2));
            let _ = writeln!(out, "| {count} | {drawn} | {ms:.3} | {triangles:.2} | {ratio} |");
        }
        out
    }

    /// A table for people.
    pub fn to_table(&self) -> String {
        let [width, height] = self.size;
        let mut out = format!(
            "{} on {}, {width}x{height}, --msaa {}, {} frames each in turn\n\n",
            self.pack, self.adapter.name, self.samples, self.rounds
        );
        let _ = writeln!(
            out,
            "{:>9} {:>9}  {:<18} {:>10} {:>9} {:>7} {:>9} {:>8} {:>8} {:>9} {:>8} {:>11} {:>10} {:>7} {:>8} {:>8} {:>9} {:>9}",
            "instances",
            "N",
            "technique",
            "frame ms",
            "p95",
            "ratio",
            "GPU ms",
            "LOD ms",
            "LOD %",
            "visible",
            "hidden",
            "triangles",
            "vertices",
            "draws",
            "runs/tri",
            "image",
            "pop",
            "pop px"
        );
        for row in &self.rows {
            let _ = writeln!(
                out,
                "{:>9} {:>9}  {:<18} {:>10.2} {:>9.2} {:>7.3} {:>9} {:>8} {:>8} {:>9} {:>8} {:>11} {:>10} {:>7} {:>8} {:>8} {:>9} {:>9}",
                row.count,
                row.budget,
                row.technique,
                row.frame_ms.median,
                row.frame_ms.p95,
                row.frame_ratio,
                number(row.gpu_ms.map(|s| s.median), 2),
                number(row.lod_ms, 3),
                number(row.lod_share.map(|share| share * 100.0), 2),
                row.visible,
                row.occluded,
                row.triangles,
                row.vertices,
                row.draws,
                number(row.runs_per_triangle, 2),
                number(row.image_rmse, 4),
                number(row.pop_rmse, 5),
                number(row.pop_px, 4)
            );
        }
        out
    }
}

impl Row {
    /// Runs a triangle of the last frame, and the most where that is another number.
    fn runs(&self) -> String {
        let most = number(self.most_runs_per_triangle, 2);
        let last = number(self.runs_per_triangle, 2);
        if most == last || self.most_runs_per_triangle.is_none() { last } else { format!("{last} ({most})") }
    }
}

/// A number with so many digits, or a dash for what was not measured.
fn number(value: Option<f32>, digits: usize) -> String {
    value.map_or("-".to_owned(), |v| format!("{v:.digits$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> BenchReport {
        let row =
            Row { count: 8, technique: "reform".to_owned(), overflow: vec!["budget", "vertices"], ..Row::default() };
        let timed = Row {
            technique: "bucketed".to_owned(),
            lod_ms: Some(0.5),
            gpu_ms: Some(Spread::of(vec![2.0])),
            ..row.clone()
        };
        BenchReport {
            schema_version: SCHEMA_VERSION,
            program: String::new(),
            pack: "a,\"b\".crowdpack".to_owned(),
            adapter: Adapter { name: "card, fast".to_owned(), ..Adapter::default() },
            features: vec!["A".to_owned(), "B".to_owned()],
            size: [64, 32],
            samples: 1,
            alpha: 3.0,
            rounds: 4,
            warm_up: 1,
            rows: vec![row, timed],
            conditions: Vec::new(),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn every_row_has_every_column() {
        let csv = report().to_csv();
        // Commas within quotes are text.
        let columns = |line: &str| line.split('"').step_by(2).map(|part| part.matches(',').count()).sum::<usize>();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| columns(line) == COLUMNS.matches(',').count()), "{csv}");
        assert!(lines[1].starts_with("\"card, fast\",") && lines[1].contains("\"a,\"\"b\"\".crowdpack\""), "{csv}");
    }

    #[test]
    fn the_page_names_its_command_its_machine_and_what_was_missed() {
        let mut report = report();
        let judged = |holds| Judged { condition: "b0 <= 1".to_owned(), count: 8, budget: 99, found: 2.0, holds };
        report.conditions = vec![judged(true), judged(false)];
        let page = report.to_markdown("crowdplay bench x");
        for word in
            ["`crowdplay bench x`", "card, fast", "64 x 32", "| b0 <= 1 | 8 | 99 | 2.0000 | NO |", "| bucketed |"]
        {
            assert!(page.contains(word), "no {word} in\n{page}");
        }
        let columns: Vec<usize> =
            page.lines().filter(|line| line.starts_with("| ")).take(3).map(|line| line.matches('|').count()).collect();
        assert_eq!(columns, [21; 3], "{page}");
    }

    #[test]
    fn growth_of_reformation_is_told_where_nothing_else_was_measured() {
        let mut report = report();
        let row = |count, ms| Row {
            count,
            technique: "reform".to_owned(),
            triangles: count * 300,
            stages_ms: BTreeMap::from([("reform_triangles", Spread::of(vec![ms]))]),
            ..Row::default()
        };
        report.rows = vec![row(2048, 0.95), row(4096, 1.9)];
        let page = report.to_markdown("crowdplay bench x");
        assert!(page.contains("| 4096 | 1228800 | 1.900 | 2.00 | 2.00 |"), "{page}");
        report.rows[1].technique = "bucketed".to_owned();
        assert!(!report.to_markdown("crowdplay bench x").contains("Reformation alone"));
    }

    #[test]
    fn the_table_says_what_was_not_measured() {
        let table = report().to_table();
        let lines: Vec<&str> = table.lines().skip(2).collect();
        assert!(lines[1].contains("reform") && lines[1].contains(" - "), "{table}");
        assert!(lines[2].contains("bucketed") && lines[2].contains("0.500"), "{table}");
    }
}
