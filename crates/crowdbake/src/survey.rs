//! Bakes every asset under both criteria and writes what became of it: the table of `docs/REAL_ASSETS.md`.

use crate::bake::{BakedCharacter, bake_character, warning_sentence};
use crate::bake_levels::BakedLevel;
use crate::cli::Paint;
use crate::error::BakeError;
use crate::inspect::grouped;
use crate::picture::{PictureRequest, Pose, draw_picture};
use crate::plan::PlanEntry;
use crate::sample::FrameRate;
use crate::unpack::Unpacked;
use crowd_lod::{Coarsest, Criteria};
use crowd_pack::{AnimationLayout, PackContents};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// What became of one asset.
#[derive(Debug)]
pub struct SurveyRow {
    /// The asset, relative to the folder surveyed where it lies in one.
    pub path: String,
    /// Measurements, or the refusal.
    pub outcome: Result<Measurements, String>,
}

/// Numbers of one asset.
#[derive(Debug, Clone)]
pub struct Measurements {
    /// Vertices in the file.
    pub source_vertices: usize,
    /// Vertices after splitting.
    pub vertices: u32,
    /// Triangles.
    pub triangles: u32,
    /// Wedges beyond the first of their position.
    pub seam_wedges: u32,
    /// Fixed, companion, regular.
    pub classes: [u32; 3],
    /// Clips.
    pub clips: usize,
    /// Frames over all clips.
    pub frames: u32,
    /// Triangles of the coarsest level, `wedge`.
    pub lowest_wedge: u32,
    /// Triangles of the coarsest level, `peng2011`.
    pub lowest_peng: u32,
    /// Largest measured distance at about 25 % and 5 % of the triangles, in percent of the height; `wedge`.
    pub error_percent: [Option<f32>; 2],
    /// Seconds of the `wedge` bake.
    pub seconds: f64,
    /// Bytes of a pack with this character alone.
    pub pack_bytes: u64,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Bakes one asset under both criteria; gives the `wedge` pack for a picture.
pub fn survey_asset(entry: &PlanEntry, shown_path: String) -> (SurveyRow, Option<PackContents>) {
    match measure(entry) {
        Ok((measurements, contents)) => (SurveyRow { path: shown_path, outcome: Ok(measurements) }, Some(contents)),
        Err(error) => {
            // The row has the path already, and where the folder lies is of this machine alone.
            let words = error.source.to_string();
            let words = words.strip_prefix(&format!("{}: ", entry.path.display())).unwrap_or(&words);
            let folder = entry.path.parent().map(|folder| format!("{}/", folder.display())).unwrap_or_default();
            let words = if folder.len() > 1 { words.replace(&folder, "") } else { words.to_owned() };
            (SurveyRow { path: shown_path, outcome: Err(words) }, None)
        }
    }
}

fn measure(entry: &PlanEntry) -> Result<(Measurements, PackContents), BakeError> {
    let started = Instant::now();
    // The table says how far the rules reach.
    let entry = &PlanEntry { coarsest: Some(Coarsest::Last), ..entry.clone() };
    let baked = bake_character(&PlanEntry { criteria: Criteria::Wedge, ..entry.clone() }, false, &|_, _| {})?;
    let seconds = started.elapsed().as_secs_f64();
    let peng = bake_character(&PlanEntry { criteria: Criteria::Peng2011, ..entry.clone() }, false, &|_, _| {})?;
    let contents = crate::assemble::assemble(std::slice::from_ref(&baked), AnimationLayout::default())?;
    let bytes = contents.to_bytes().map_err(|error| BakeError::of(crate::Step::Write, &entry.name, error))?;
    let order = &baked.order;
    let seams = &order.seams;
    let lowest = |baked: &BakedCharacter| baked.order.levels.first().map_or(0, |level| level.triangle_count);
    let measurements = Measurements {
        source_vertices: baked.raw.mesh.positions.len(),
        vertices: order.vertex_source.len() as u32,
        triangles: order.triangles.len() as u32,
        seam_wedges: seams.wedge_count.saturating_sub(seams.position_count),
        classes: [seams.fixed_count, seams.companion_count, seams.regular_count],
        clips: baked.raw.clips.len(),
        frames: baked.animation.clips.iter().map(|clip| clip.frame_count).sum(),
        lowest_wedge: lowest(&baked),
        lowest_peng: lowest(&peng),
        error_percent: [0.25, 0.05].map(|ratio| error_near(&baked, ratio)),
        seconds,
        pack_bytes: bytes.len() as u64,
        warnings: baked.warnings.iter().map(warning_sentence).collect(),
    };
    Ok((measurements, contents))
}

/// Largest distance of the measured level nearest to a share of the triangles, in percent of the height.
fn error_near(baked: &BakedCharacter, ratio: f64) -> Option<f32> {
    let full = f64::from(baked.order.levels.last()?.triangle_count);
    let far = |level: &BakedLevel| libm::fabs(libm::log((level.indices.len() / 3).max(1) as f64 / (full * ratio)));
    let level = baked.levels.quantized.iter().min_by(|a, b| far(a).total_cmp(&far(b)))?;
    // Levels lie about a fifth apart; a mesh that does not reach down has none near.
    let near = far(level) < 0.35 && baked.height_m > 0.0;
    near.then(|| 100.0 * level.error.surface.max_m / baked.height_m)
}

/// Levels at rest and in two clips: where an asset walks or runs, that.
pub fn survey_picture(contents: &PackContents) -> Result<crowd_raster::Target, BakeError> {
    let character = Unpacked::new(contents, 0);
    let moving: Vec<&str> = character
        .manifest
        .clips
        .iter()
        .zip(character.clips)
        .filter(|(_, clip)| clip.frame_count > 1)
        .map(|(named, _)| named.name.as_str())
        .collect();
    let of_kind = |word: &str| moving.iter().find(|name| name.to_lowercase().contains(word)).copied();
    let mut chosen: Vec<&str> = ["walk", "run", "sit", "attack", "death"].into_iter().filter_map(of_kind).collect();
    chosen.extend(moving.iter().copied());
    let mut rows = vec![Pose::Bind];
    for name in chosen {
        let row = Pose::Clip(name.to_owned(), None);
        if rows.len() < 3 && !rows.contains(&row) {
            rows.push(row);
        }
    }
    let request = PictureRequest {
        ratios: vec![1.0, 0.25, 0.1, 0.05],
        rows,
        paint: Paint::Shaded,
        size: [320, 420],
        turn_deg: 25.0,
    };
    draw_picture(&character, &request)
}

/// The document.
pub fn to_markdown(rows: &[SurveyRow], rate: FrameRate) -> String {
    let mut out = format!(
        "# Real assets\n\n\
         Made by `crowdbake survey FOLDER -o docs/REAL_ASSETS.md`; do not edit by hand.\n\n\
         Every asset is baked with all its clips at {rate}, once under each of the criteria. Seam wedges: vertices \
         that share their position with another one of different texture coordinate or material. Classes as in Peng 2011, \
         section 4.2, counted on wedges. Lowest: triangles of the coarsest level under `--coarsest last`. Error: largest distance to full detail over \
         the measured frames, at about 25 % and 5 % of the triangles, in percent of the height. Seconds: one bake under the \
         default criteria, by the clock, with whatever else the machine did meanwhile.\n\n\
         | asset | vertices in file | vertices split | triangles | seam wedges | fixed / companion / regular | clips (frames) | lowest `wedge` | lowest `peng2011` | max error 25 % / 5 % | s | pack bytes | warnings |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    for row in rows {
        if let Ok(m) = &row.outcome {
            write_measurements(&mut out, &row.path, m);
        }
    }
    let refused: Vec<(&str, &str)> =
        rows.iter().filter_map(|row| row.outcome.as_ref().err().map(|why| (row.path.as_str(), why.as_str()))).collect();
    if !refused.is_empty() {
        out.push_str("\n## Refused\n\n| asset | message |\n|---|---|\n");
        for (path, why) in refused {
            let _ = writeln!(out, "| {} | {} |", cell(path), cell(why));
        }
    }
    let warned = rows.iter().filter_map(|row| Some((row.path.as_str(), row.outcome.as_ref().ok()?)));
    let warned: Vec<_> = warned.filter(|(_, m)| !m.warnings.is_empty()).collect();
    if !warned.is_empty() {
        out.push_str("\n## Warnings\n\n");
        for (path, m) in warned {
            let _ = writeln!(out, "- {}", cell(path));
            for warning in &m.warnings {
                let _ = writeln!(out, "  - {}", cell(warning));
            }
        }
    }
    out
}

fn write_measurements(out: &mut String, path: &str, m: &Measurements) {
    let [fixed, companion, regular] = m.classes.map(grouped);
    let [quarter, twentieth] = m.error_percent.map(|e| e.map_or("–".to_owned(), |e| format!("{e:.2} %")));
    let lowest =
        |count: u32| format!("{} ({:.1} %)", grouped(count), 100.0 * f64::from(count) / f64::from(m.triangles.max(1)));
    let _ = writeln!(
        out,
        "| {} | {} | {} | {} | {} | {fixed} / {companion} / {regular} | {} ({}) | {} | {} | {quarter} / {twentieth} | {:.1} | {} | {} |",
        cell(path),
        grouped(m.source_vertices as u64),
        grouped(m.vertices),
        grouped(m.triangles),
        grouped(m.seam_wedges),
        m.clips,
        grouped(m.frames),
        lowest(m.lowest_wedge),
        lowest(m.lowest_peng),
        m.seconds,
        grouped(m.pack_bytes),
        m.warnings.len(),
    );
}

/// A name that cannot break out of a table.
fn cell(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>().replace('|', "\\|")
}

/// A file name for the picture of an asset: its path with `-` for what separates.
fn picture_name(shown_path: &str) -> String {
    let name: String =
        shown_path.chars().map(|c| if c.is_alphanumeric() || c == '_' || c == '.' { c } else { '-' }).collect();
    name.trim_matches('-').to_owned() + ".png"
}

/// File names for pictures of assets, none twice: of those that flatten to one name, the later ones get a number.
pub fn picture_names(shown_paths: &[String]) -> Vec<String> {
    let plain: Vec<String> = shown_paths.iter().map(|path| picture_name(path)).collect();
    // Some file systems take upper and lower case for one.
    let key = |name: &str| name.to_lowercase();
    let mut taken: BTreeSet<String> = BTreeSet::new();
    let all: BTreeSet<String> = plain.iter().map(|name| key(name)).collect();
    let unique = |name: String| {
        if taken.insert(key(&name)) {
            return name;
        }
        let stem = name.trim_end_matches(".png");
        let free = (2_u32..)
            .map(|number| format!("{stem}-{number}.png"))
            .find(|name| !taken.contains(&key(name)) && !all.contains(&key(name)))
            .expect("there are more numbers than assets");
        taken.insert(key(&free));
        free
    };
    plain.into_iter().map(unique).collect()
}

/// The path as the table shows it: relative to the input that holds it.
pub fn shown_path(path: &Path, inputs: &[std::path::PathBuf]) -> String {
    let relative = inputs.iter().filter(|input| input.is_dir()).find_map(|input| path.strip_prefix(input).ok());
    relative.unwrap_or(path).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_have_their_own_table_and_cannot_break_it() {
        let rows = [SurveyRow { path: "a|b.glb".to_owned(), outcome: Err("mesh 0:\nbad".to_owned()) }];
        let text = to_markdown(&rows, FrameRate::Fixed(30.0));
        assert!(text.contains("| a\\|b.glb | mesh 0: bad |"), "{text}");
    }

    #[test]
    fn pictures_are_named_by_their_path() {
        assert_eq!(picture_name("kaykit/props/a b.gltf"), "kaykit-props-a-b.gltf.png");
        let paths = ["a/b.glb", "a b.glb", "a-b.glb-2", "A-b.glb", "c.glb"].map(str::to_owned);
        let names = ["a-b.glb.png", "a-b.glb-3.png", "a-b.glb-2.png", "A-b.glb-4.png", "c.glb.png"];
        assert_eq!(picture_names(&paths), names);
    }
}
