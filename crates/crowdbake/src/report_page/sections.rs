//! One character's part of the page.

use super::chart::{Chart, Curve, to_svg};
use super::draw_layouts::Layout;
use super::draw_sheets::{Drawn, Row, Sheet};
use super::html::{Text, jpeg_address, length, percent};
use super::shown_levels::{RATIOS, ShownLevel, WorstFrame};
use super::{numbers, poked_chart, stuck};
use crate::explain::Explanation;
use crate::heat::{RAMP, red_distance_m};
use crate::inspect::grouped;
use crate::unpack::Unpacked;
use std::fmt::Write;

/// Columns of pictures that fit beside the text; with more, the table takes the whole window and scrolls.
const MOST_COLUMNS: usize = 8;

/// Everything that one character's part is made of.
pub(crate) struct Portrait<'a> {
    pub character: &'a Unpacked<'a>,
    pub levels: Vec<ShownLevel>,
    pub missed_ratios: Vec<f64>,
    pub at_rest: Sheet,
    pub worst: Option<(WorstFrame, Sheet)>,
    pub layouts: Vec<Layout>,
    pub other_textures: usize,
    pub explanation: Explanation,
    pub stuck: Drawn,
    pub thumbnail: Drawn,
}

/// Writes the part. `id`: unique within the page, a letter and digits.
pub(crate) fn write_portrait(out: &mut String, portrait: &Portrait<'_>, id: &str) {
    let name = Text(&portrait.character.manifest.name);
    let _ = write!(
        out,
        "<section class=\"character\" id=\"{id}\" aria-labelledby=\"{id}-h\"><h2 id=\"{id}-h\">{name}</h2>"
    );
    write_facts(out, portrait);
    out.push_str("<div class=\"front\">");
    write_viewer(out, portrait, id);
    numbers::write_summary(out, portrait);
    out.push_str("</div>");
    let _ =
        write!(out, "<h3>At rest</h3><p class=\"soft\">The pose the file was made in. Full detail on the left.</p>");
    write_sheet(out, portrait, &portrait.at_rest, &format!("{id}-0"), "at rest");
    if let Some((frame, sheet)) = &portrait.worst {
        let (clip, share) = (Text(&frame.clip), percent(frame.share));
        let _ = write!(
            out,
            "<h3>At its worst: {clip}, {:.2} s</h3><p class=\"soft\">The moment in which the level of {share} lies \
             furthest from full detail, of all frames measured.</p>",
            frame.time_s
        );
        write_sheet(out, portrait, sheet, &format!("{id}-1"), "in its worst frame");
    }
    write_chart(out, portrait, id);
    write_poked(out, portrait.character, id);
    numbers::write_numbers(out, portrait);
    stuck::write_stuck(out, portrait);
    write_layouts(out, portrait);
    out.push_str("</section>");
}

fn write_facts(out: &mut String, portrait: &Portrait<'_>) {
    let (record, manifest) = (portrait.character.record, portrait.character.manifest);
    let clips = portrait.character.clips;
    let still = clips.iter().filter(|clip| clip.frame_count == 1).count();
    let still = if still == 0 { String::new() } else { format!(" ({still} of one frame)") };
    let frames: u64 = portrait.character.clips.iter().map(|clip| u64::from(clip.frame_count)).sum();
    let _ = write!(
        out,
        "<ul class=\"facts\"><li><b>{}</b> triangles down to <b>{}</b></li><li><b>{}</b> vertices down to <b>{}</b></li>\
         <li><b>{}</b> tall</li><li><b>{}</b> {}{still}, {} frames</li><li><b>{}</b> joints</li><li>animation {}</li><li>from {}</li></ul>",
        grouped(record.triangle_count),
        grouped(record.min_triangle_count),
        grouped(record.vertex_count),
        grouped(record.min_vertex_count),
        length(record.height_m),
        clips.len(),
        if clips.len() == 1 { "clip" } else { "clips" },
        grouped(frames),
        grouped(record.joint_count),
        crate::inspect::inspect_animation(portrait.character).words(),
        Text(&manifest.source)
    );
}

/// What a level is called, escaped: `Full detail`, `25 %`, `25 %, lod2`, `lod2, refitted`.
pub(crate) fn level_name(shown: &ShownLevel, character: &Unpacked<'_>) -> String {
    if shown.full {
        return "Full detail".to_owned();
    }
    let mut names: Vec<String> = shown.ratios.iter().map(|&ratio| percent(ratio)).collect();
    names.extend(shown.discrete.iter().map(|&number| Text(&character.manifest.discrete[number].name).to_string()));
    if names.is_empty() {
        let share = f64::from(shown.level.triangle_count) / f64::from(character.record.triangle_count.max(1));
        names.push(percent(share));
    }
    if shown.refitted {
        names.push("refitted".to_owned());
    }
    names.join(", ")
}

fn write_viewer(out: &mut String, portrait: &Portrait<'_>, id: &str) {
    let options = |chosen: usize| {
        let option = |(place, shown): (usize, &ShownLevel)| {
            let mark = if place == chosen { " selected=\"selected\"" } else { "" };
            let (name, triangles) = (level_name(shown, portrait.character), grouped(shown.level.triangle_count));
            format!("<option value=\"{place}\"{mark}>{name} · {triangles} triangles</option>")
        };
        portrait.levels.iter().enumerate().map(option).collect::<String>()
    };
    let tenth = portrait.levels.iter().position(|shown| shown.ratios.contains(&0.1));
    let chosen = tenth.unwrap_or(portrait.levels.len() - 1);
    // What somebody would export, where the pack has it: the refitted level stands after the one it was made from.
    let refitted = portrait
        .levels
        .get(chosen + 1)
        .filter(|next| next.refitted && next.level.triangle_count == portrait.levels[chosen].level.triangle_count);
    let chosen = chosen + usize::from(refitted.is_some());
    let worst = portrait.worst.as_ref().map(|(frame, _)| {
        format!("<option value=\"1\">At its worst: {}, {:.2} s</option>", Text(&frame.clip), frame.time_s)
    });
    let rows: String = Row::ALL
        .iter()
        .enumerate()
        .map(|(place, &row)| format!("<option value=\"{place}\">{}</option>", row_name(row)))
        .collect();
    let _ = write!(
        out,
        "<div class=\"viewer\" data-of=\"{id}\" hidden=\"hidden\"><div class=\"stage\" data-part=\"stage\">\
         <img data-part=\"image-a\" alt=\"\"/><img data-part=\"image-b\" alt=\"\"/>\
         <span class=\"tag\" data-part=\"name-a\"></span><span class=\"tag\" data-part=\"name-b\"></span></div>\
         <div class=\"controls\"><label>Curtain <input type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" \
         data-part=\"cut\"/></label>\
         <label>Left <select data-part=\"left\">{}</select></label>\
         <label>Right <select data-part=\"right\">{}</select></label>\
         <label>Pose <select data-part=\"pose\"><option value=\"0\">At rest</option>{}</select></label>\
         <label>Shown as <select data-part=\"row\">{rows}</select></label>\
         <p class=\"small soft\">Drag the curtain, or choose any picture below.</p></div>",
        options(0),
        options(chosen),
        worst.unwrap_or_default()
    );
    out.push_str("</div>");
}

fn row_name(row: Row) -> &'static str {
    match row {
        Row::Textured => "Textured",
        Row::Edges => "Wireframe",
        Row::Classes => "Vertex classes",
        Row::Distance => "Distance",
    }
}

fn write_sheet(out: &mut String, portrait: &Portrait<'_>, sheet: &Sheet, id: &str, pose: &str) {
    let name = Text(&portrait.character.manifest.name);
    let wide = if portrait.levels.len() > MOST_COLUMNS { " wide" } else { "" };
    let _ = write!(
        out,
        "<div class=\"scroll{wide}\" tabindex=\"0\" role=\"region\" aria-label=\"{name} {pose}, level by level\">\
         <table class=\"sheet\" data-sheet=\"{id}\"><colgroup><col/>"
    );
    portrait.levels.iter().for_each(|_| out.push_str("<col/>"));
    out.push_str("</colgroup><thead><tr><td></td>");
    for shown in &portrait.levels {
        let mut note = if shown.coarsest { "<br/>the coarsest".to_owned() } else { String::new() };
        for &number in &shown.discrete {
            let target = crate::lod_target::LodTarget(portrait.character.manifest.discrete[number].target);
            let _ = write!(note, "<br/>asked: {}", target.words());
        }
        let _ = write!(
            out,
            "<th scope=\"col\"><b>{}</b>{} triangles{note}</th>",
            level_name(shown, portrait.character),
            grouped(shown.level.triangle_count)
        );
    }
    out.push_str("</tr></thead><tbody>");
    for (place, (row, drawn)) in Row::ALL.iter().zip(&sheet.rows).enumerate() {
        let _ = write!(out, "<tr><th scope=\"row\"><b>{}</b>", row_name(*row));
        write_legend(out, *row, portrait.character.record.height_m);
        out.push_str("</th>");
        for (level, (shown, drawn)) in portrait.levels.iter().zip(drawn).enumerate() {
            let what =
                format!("{name} {pose}, {}, {}", level_name(shown, portrait.character), row_name(*row).to_lowercase());
            out.push_str("<td><span class=\"cell\">");
            write_image(out, drawn, &what, &format!(" data-row=\"{place}\" data-level=\"{level}\""));
            write_furthest(out, drawn, shown);
            out.push_str("</td>");
        }
        out.push_str("</tr>");
    }
    out.push_str("</tbody></table></div>");
}

/// The ring around the point that lies furthest away, and its distance; closes the cell.
fn write_furthest(out: &mut String, drawn: &Drawn, shown: &ShownLevel) {
    match drawn.furthest {
        Some((distance_m, [x, y])) if !shown.full => {
            let place = [x, y].map(|share| share.clamp(0.0, 1.0) * 100.0);
            let _ = write!(
                out,
                "<span class=\"ring\" style=\"left:{:.1}%;top:{:.1}%\"></span></span><span class=\"under\">up to <b>{}</b></span>",
                place[0],
                place[1],
                length(distance_m)
            );
        }
        _ => out.push_str("</span>"),
    }
}

/// `what`: escaped already. `more`: further attributes.
pub(crate) fn write_image(out: &mut String, drawn: &Drawn, what: &str, more: &str) {
    let [width, height] = drawn.size;
    let _ = write!(
        out,
        "<img src=\"{}\" width=\"{width}\" height=\"{height}\" decoding=\"async\" alt=\"{what}\"{more}/>",
        jpeg_address(&drawn.jpeg)
    );
}

fn write_legend(out: &mut String, row: Row, height_m: f32) {
    match row {
        Row::Textured => out.push_str("As it is drawn in the game."),
        Row::Edges => out.push_str("Where the triangles are left."),
        Row::Classes => out.push_str(
            "<span class=\"dot\" style=\"background:#de860c\"></span>on a seam: moves with its partner<br/>\
             <span class=\"dot\" style=\"background:#c41620\"></span>where seams meet, or on an open border",
        ),
        Row::Distance => {
            out.push_str("Full detail, painted with how far away the level is. The ring marks the furthest point.");
            let stops: Vec<String> = RAMP.iter().map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
            let red_m = red_distance_m(height_m);
            let _ = write!(
                out,
                "<span class=\"ramp\" style=\"background:linear-gradient(90deg,{})\"></span>\
                 <span class=\"stops\"><span>0</span><span>{}</span><span>{}+</span></span>",
                stops.join(","),
                // The ramp follows the root of the distance.
                length(red_m / 4.0),
                length(red_m)
            );
        }
    }
}

fn write_chart(out: &mut String, portrait: &Portrait<'_>, id: &str) {
    let character = portrait.character;
    let measured = &character.manifest.measured;
    let curve = |name, class, of: fn(&crowd_pack::ManifestMeasured) -> f32| Curve {
        name,
        class,
        points: measured.iter().map(|level| (level.triangle_count, of(level))).collect(),
    };
    let stored = character.manifest.discrete.iter().zip(character.discrete_levels());
    let refitted = Curve {
        name: "RMS of refitted levels",
        class: "refit",
        points: stored
            .filter(|(_, level)| level.is_refit())
            .map(|(discrete, _)| (discrete.measured.triangle_count, discrete.measured.rms_m))
            .collect(),
    };
    let marks = RATIOS.iter().filter(|ratio| !portrait.missed_ratios.contains(ratio));
    let chart = Chart {
        character: &character.manifest.name,
        full_triangle_count: character.record.triangle_count,
        height_m: character.record.height_m,
        marks: marks.map(|&ratio| (ratio, character.level_of_ratio(ratio).0.triangle_count)).collect(),
        curves: vec![
            curve("largest distance", "max", |m| m.max_m),
            curve("RMS distance", "rms", |m| m.rms_m),
            curve("bound over all frames", "bound", |m| m.bound_m),
            refitted,
        ],
    };
    out.push_str("<h3>How far each level is from full detail</h3>");
    match to_svg(&chart, id) {
        Some(svg) => {
            let _ = write!(
                out,
                "<p class=\"soft\">Over the frames of all clips. RMS is what the surface as a whole is off by, largest is \
                 its worst point. Where a curve crosses a dotted line, the error is one pixel for a character that tall on \
                 the screen.</p><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Error curves\">{svg}</div>"
            );
        }
        None => out.push_str("<p class=\"soft\">No level differs from full detail, or none was measured.</p>"),
    }
}

/// Where no level has anything that pokes through, nobody asks.
fn write_poked(out: &mut String, character: &Unpacked<'_>, id: &str) {
    let measured = &character.manifest.measured;
    let points: Vec<(u32, f32)> = measured.iter().map(|level| (level.triangle_count, level.poked_share)).collect();
    let (name, full) = (&character.manifest.name, character.record.triangle_count);
    if let Some(svg) = poked_chart::to_svg(name, full, &points, &format!("{id}-poked")) {
        let _ = write!(
            out,
            "<h3>What pokes through</h3><p class=\"soft\">The share of the surface that full detail covers with a layer (hair, \
             cloth, armour) and that lies outside of it here, mean over the measured frames.</p><div class=\"scroll\" \
             tabindex=\"0\" role=\"region\" aria-label=\"Curve of what pokes through\">{svg}</div>"
        );
    }
}

fn write_layouts(out: &mut String, portrait: &Portrait<'_>) {
    out.push_str("<h3>Seams over the texture</h3>");
    if portrait.layouts.is_empty() {
        out.push_str("<p class=\"soft\">No material has a texture.</p>");
        return;
    }
    out.push_str(
        "<p class=\"soft\"><span class=\"dot\" style=\"background:#de860c\"></span>UV seams \
         <span class=\"dot\" style=\"background:#c41620;margin-left:1em\"></span>open borders \
         <span style=\"margin-left:1em\">thin and white: the other edges.</span></p>",
    );
    let name = Text(&portrait.character.manifest.name);
    for layout in &portrait.layouts {
        let materials = layout.materials.join(", ");
        let [width, height] = layout.texture_size;
        let captions = [
            format!(
                "Full detail: {} seam edges, {} open ones. Texture of {}, {width} x {height}.",
                grouped(layout.seam_count),
                grouped(layout.border_count),
                Text(&materials)
            ),
            format!(
                "{} triangles: {} seam edges are left.",
                grouped(layout.low_triangle_count),
                grouped(layout.low_seam_count)
            ),
        ];
        out.push_str("<div class=\"layouts\">");
        for (drawn, caption) in layout.pictures.iter().zip(&captions) {
            out.push_str("<figure>");
            write_image(out, drawn, &format!("UV layout of {name} over its texture"), "");
            let _ = write!(out, "<figcaption>{caption}</figcaption></figure>");
        }
        out.push_str("</div>");
    }
    if portrait.other_textures > 0 {
        let _ = write!(out, "<p class=\"soft\">{} more textures are not shown.</p>", portrait.other_textures);
    }
}
