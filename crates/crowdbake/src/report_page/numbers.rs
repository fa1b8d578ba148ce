//! The table of a character's measured levels.

use super::html::{Text, length, percent};
use super::sections::Portrait;
use super::shown_levels::frame_time_s;
use crate::inspect::grouped;
use crowd_pack::ManifestMeasured;
use std::fmt::Write;

/// Rows shown at once; with more, the table opens on demand.
const OPEN_ROWS: usize = 20;

/// Writes the levels shown with what was measured there, as a short table beside the viewer.
pub(crate) fn write_summary(out: &mut String, portrait: &Portrait<'_>) {
    let record = portrait.character.record;
    let told: Vec<_> = portrait.explanation.targets.iter().filter_map(|t| Some((t, t.measured.as_ref()?))).collect();
    if told.is_empty() {
        return;
    }
    let refitted = |triangles: u32| refitted_rms_m(portrait, triangles);
    let any_refitted = told.iter().any(|(target, _)| refitted(target.level.triangles).is_some());
    let refitted_head = if any_refitted { "<th scope=\"col\">Refitted<br/>(RMS)</th>" } else { "" };
    let _ = write!(
        out,
        "<div><table class=\"numbers summary\"><thead><tr><th scope=\"col\">Level</th><th scope=\"col\">Triangles</th>\
         <th scope=\"col\">Off by<br/>(RMS)</th>{refitted_head}<th scope=\"col\">Worst<br/>point</th><th scope=\"col\">One pixel<br/>RMS at</th></tr></thead><tbody>",
    );
    for (target, measured) in told {
        let refitted_cell = match refitted(target.level.triangles) {
            _ if !any_refitted => String::new(),
            Some(rms_m) => format!("<td>{}</td>", length(rms_m)),
            None => "<td>–</td>".to_owned(),
        };
        let _ = write!(out, "<tr><td>{}</td>", percent(target.ratio));
        if target.reached {
            let _ = write!(
                out,
                "<td>{}</td><td>{}</td>{refitted_cell}<td>{}</td><td>{}</td></tr>",
                grouped(target.level.triangles),
                length(measured.rms_m),
                length(measured.max_m),
                pixel_height(measured.rms_m, record.height_m)
            );
        } else {
            let columns = 4 + usize::from(any_refitted);
            let _ = write!(out, "<td colspan=\"{columns}\">not reached</td></tr>");
        }
    }
    out.push_str(
        "</tbody></table><p class=\"small soft\">Distances of this level to full detail over all clips. Last column: how tall the \
         character is on the screen when the RMS distance is one pixel, as <code>bake --px</code> counts; \
         <code>--px 1@240:max</code> counts the bound, which no point exceeds.</p></div>",
    );
}

/// The RMS distance of the refitted level of so many triangles, metres.
fn refitted_rms_m(portrait: &Portrait<'_>, triangles: u32) -> Option<f32> {
    let stored = portrait.character.manifest.discrete.iter().zip(portrait.character.discrete_levels());
    let mut refitted = stored.filter(|(_, level)| level.is_refit() && level.triangle_count == triangles);
    refitted.next().map(|(discrete, _)| discrete.measured.rms_m)
}

/// Writes the table, finest level first.
pub(crate) fn write_numbers(out: &mut String, portrait: &Portrait<'_>) {
    let measured = &portrait.character.manifest.measured;
    if measured.is_empty() {
        return;
    }
    let open = if measured.len() <= OPEN_ROWS { " open=\"open\"" } else { "" };
    let name = Text(&portrait.character.manifest.name);
    let _ = write!(
        out,
        "<details{open}><summary>The numbers of {} measured levels</summary>\
         <div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Measured levels of {name}\">\
         <table class=\"numbers\"><thead><tr><th scope=\"col\">Level</th><th scope=\"col\">Triangles</th>\
         <th scope=\"col\">Vertices</th><th scope=\"col\">RMS</th><th scope=\"col\">Largest</th>\
         <th scope=\"col\">Bound</th><th scope=\"col\">Bound at<br/>720 px tall</th><th scope=\"col\">Texture<br/>drift</th>\
         <th scope=\"col\">Normals</th><th scope=\"col\">Poked<br/>through</th>\
         <th scope=\"col\" class=\"words\">Largest in</th></tr></thead><tbody>",
        measured.len()
    );
    let discrete = portrait.character.manifest.discrete.iter().zip(portrait.character.discrete_levels());
    for (discrete, stored) in discrete {
        let refitted = if stored.is_refit() { ", refitted" } else { "" };
        write_row(out, portrait, &discrete.measured, &format!("{}{refitted}", Text(&discrete.name)));
    }
    for level in measured.iter().rev() {
        let share = f64::from(level.triangle_count) / f64::from(portrait.character.record.triangle_count.max(1));
        write_row(out, portrait, level, &percent(share));
    }
    out.push_str(
        "</tbody></table></div><p class=\"small soft\">Poked through: share of the surface that has come out through a layer which covers \
         it at full detail, as a head through its helmet.</p></details>",
    );
}

/// `name`: escaped already.
fn write_row(out: &mut String, portrait: &Portrait<'_>, level: &ManifestMeasured, name: &str) {
    let _ = write!(
        out,
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.1} px</td><td>{:.1} texels</td><td>{:.1}°</td><td>{:.2} %</td><td class=\"words\">{}</td></tr>",
        name,
        grouped(level.triangle_count),
        grouped(level.vertex_count),
        length(level.rms_m),
        length(level.max_m),
        length(level.bound_m),
        level.bound_px,
        level.uv_drift_p95_texels,
        level.normal_mean_deg,
        level.poked_share * 100.0,
        moment(portrait, level)
    );
}

/// The height on the screen below which the distance is less than a pixel.
fn pixel_height(distance_m: f32, height_m: f32) -> String {
    let height_px = f64::from(height_m) / f64::from(distance_m);
    if height_px.is_finite() && height_px < 1e5 { format!("{height_px:.0} px") } else { "–".to_owned() }
}

/// Clip and time of the largest distance, escaped.
fn moment(portrait: &Portrait<'_>, level: &ManifestMeasured) -> String {
    let clip = level.max_clip as usize;
    let named = portrait.character.manifest.clips.get(clip).zip(portrait.character.clips.get(clip));
    let Some((manifest, record)) = named else { return "–".to_owned() };
    let time_s = frame_time_s(record.duration_s, level.max_frame, record.frame_count);
    format!("{}, {time_s:.2} s (frame {})", Text(&manifest.name), level.max_frame)
}
