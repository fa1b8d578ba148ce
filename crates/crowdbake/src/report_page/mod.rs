//! `crowdbake report`: one page for people who would rather look than read.
//!
//! Everything is inside the file: pictures by `crowd-raster` as JPEG data addresses, curves as SVG, style and script. The
//! same pack gives the same bytes. One module a thing on the page: `shown_levels` chooses, `draw_sheets` and `draw_layouts`
//! draw, `chart`, `poked_chart`, `numbers`, `stuck` and `sections` write. (The JSON that `bake --report` writes is [`crate::report`].)
//!
//! Size: seven shipped characters stay under 10 MB by picture sizes and JPEG quality alone; on a page of more characters
//! pictures shrink with their number, and once more where the page still came out too large.

mod chart;
mod draw_layouts;
mod draw_sheets;
mod html;
mod marks;
mod numbers;
mod poked_chart;
mod sections;
mod shown_levels;
mod stuck;

use crate::draw_level::{Surfaces, pose_character};
use crate::error::{BakeError, Cause, Step};
use crate::explain::{explain, stuck_positions};
use crate::inspect::grouped;
use crate::unpack::Unpacked;
use crowd_pack::{LodRecord, PackContents};
use draw_sheets::{Studio, camera_turn_deg};
use html::{Text, jpeg_address, length, percent};
use sections::{Portrait, write_portrait};
use shown_levels::{RATIOS, missed_ratios, shown_levels, worst_frame};
use std::fmt::Write;

/// Characters whose pictures have their full size.
const FULL_SIZE_CHARACTERS: f32 = 8.0;
/// A page is mailed and opened everywhere: with more bytes it is drawn once more, smaller.
const MOST_BYTES: usize = 9_500_000;
/// Levels whose pictures have their full size.
const USUAL_COLUMNS: f32 = 7.0;
/// Pictures do not shrink below this share of their pixels.
const SMALLEST_SCALE: f32 = 0.2;

/// The share whose error stands in the list of characters.
const TOLD_RATIO: f64 = 0.1;

/// Told about the character that is drawn and the share of it that has been added, 0..=1.
pub type Watch<'a> = &'a (dyn Fn(&str, f32) + Sync);

/// The page about some characters of a pack.
///
/// `title`: the pack's name as shown. `chosen`: indices of characters, in the order of the page.
///
/// # Errors
/// An image that does not decode.
pub fn make_page(
    contents: &PackContents,
    title: &str,
    chosen: &[usize],
    watch: Watch<'_>,
) -> Result<String, BakeError> {
    let scale = (FULL_SIZE_CHARACTERS / chosen.len().max(1) as f32).clamp(SMALLEST_SCALE, 1.0);
    let page = make_page_at(contents, title, chosen, scale, watch)?;
    let Some(smaller) = smaller_scale(page.len(), scale) else { return Ok(page) };
    let page = make_page_at(contents, title, chosen, smaller, watch)?;
    // Pictures have a least size, so that even this may be too large.
    let fits = page.len() <= MOST_BYTES || smaller <= SMALLEST_SCALE;
    if fits { Ok(page) } else { make_page_at(contents, title, chosen, SMALLEST_SCALE, watch) }
}

/// The scale that a page of so many bytes is drawn with once more; `None` where it may stay.
fn smaller_scale(bytes: usize, scale: f32) -> Option<f32> {
    // Pictures are nearly all of a page, and their bytes go with their pixels; a little less, so that once more mostly will do.
    let fitting = scale * 0.95 * MOST_BYTES as f32 / bytes as f32;
    (bytes > MOST_BYTES && scale > SMALLEST_SCALE).then(|| fitting.max(SMALLEST_SCALE))
}

/// The page with pictures of `scale` times their full number of pixels.
fn make_page_at(
    contents: &PackContents,
    title: &str,
    chosen: &[usize],
    scale: f32,
    watch: Watch<'_>,
) -> Result<String, BakeError> {
    let mut cards = String::new();
    let mut links = String::new();
    let mut parts = String::new();
    for (place, &index) in chosen.iter().enumerate() {
        let character = Unpacked::new(contents, index);
        let name = character.manifest.name.as_str();
        let portrait =
            draw_portrait(&character, scale, watch).map_err(|cause| BakeError::of(Step::Draw, name, cause))?;
        let id = format!("c{place}");
        write_card(&mut cards, &portrait, &id);
        let _ = write!(links, "<li><a href=\"#{id}\">{}</a></li>", Text(name));
        write_portrait(&mut parts, &portrait, &id);
    }
    Ok(assemble(contents, title, chosen.len(), &cards, &links, &parts))
}

fn draw_portrait<'a>(character: &'a Unpacked<'a>, scale: f32, watch: Watch<'_>) -> Result<Portrait<'a>, Cause> {
    let name = character.manifest.name.as_str();
    let surfaces = Surfaces::load(character)?;
    let rest_palette = character.rest_palette();
    let turn_deg = camera_turn_deg(&pose_character(character, &rest_palette));
    let levels = shown_levels(character);
    let scale = scale * (USUAL_COLUMNS / levels.len() as f32).min(1.0);
    let worst = worst_frame(character);
    let sheets = if worst.is_some() { 2.0 } else { 1.0 };
    let tell = |share: f32| watch(name, share / sheets);
    let studio = Studio::new(character, &surfaces, &rest_palette, turn_deg, scale);
    let at_rest = studio.draw_sheet(&levels, &tell);
    let worst = worst.map(|frame| {
        let sheet = Studio::new(character, &surfaces, &frame.palette, turn_deg, scale).draw_sheet(&levels, &tell);
        (frame, sheet)
    });
    let record = character.record;
    let coarsest = LodRecord { vertex_count: record.min_vertex_count, triangle_count: record.min_triangle_count };
    let (layouts, other_textures) = draw_layouts::draw_layouts(character, scale)?;
    Ok(Portrait {
        missed_ratios: missed_ratios(character),
        explanation: explain(character, &RATIOS),
        stuck: studio.draw_stuck(coarsest, &stuck_positions(character)),
        thumbnail: studio.draw_thumbnail(),
        character,
        levels,
        at_rest,
        worst,
        layouts,
        other_textures,
    })
}

/// A character in the list at the top.
fn write_card(cards: &mut String, portrait: &Portrait<'_>, id: &str) {
    let record = portrait.character.record;
    let verdict = match portrait.missed_ratios.first() {
        Some(&missed) => format!("does not reach {}", percent(missed)),
        None => error_words(portrait),
    };
    let [width, height] = portrait.thumbnail.size;
    let _ = write!(
        cards,
        "<li><a href=\"#{id}\"><span class=\"shot\"><img src=\"{}\" width=\"{width}\" height=\"{height}\" alt=\"\"/></span>\
         <span class=\"words\"><b>{}</b><br/>{} triangles<br/><span class=\"soft\">{verdict}</span></span></a></li>",
        jpeg_address(&portrait.thumbnail.jpeg),
        Text(&portrait.character.manifest.name),
        grouped(record.triangle_count)
    );
}

/// How far off a character is at a tenth of its triangles.
fn error_words(portrait: &Portrait<'_>) -> String {
    let tenth = portrait.explanation.targets.iter().find(|target| target.ratio == TOLD_RATIO);
    match tenth.and_then(|target| target.measured.as_ref()) {
        Some(measured) => format!("{} RMS off at {}", length(measured.rms_m), percent(TOLD_RATIO)),
        None => "all shares reached".to_owned(),
    }
}

fn assemble(
    contents: &PackContents,
    title: &str,
    character_count: usize,
    cards: &str,
    links: &str,
    parts: &str,
) -> String {
    let title = Text(title);
    let count = if character_count == 1 { "One character".to_owned() } else { format!("{character_count} characters") };
    let (style, script) = (include_str!("style.css"), include_str!("viewer.js"));
    let generator = Text(&contents.manifest.generator);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
         script-src 'unsafe-inline'\"/>\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\
         <title>{title}: levels of detail</title><style>\n{style}</style></head><body>\
         <header class=\"top\"><p class=\"small soft\">{title}</p><h1>{count}, level by level</h1>\
         <p class=\"lead\">How each character looks with half its triangles, with a tenth, with as few as it can bear: \
         standing, and in the moment that suits it least. Every picture is drawn from the pack.</p>\
         <ul class=\"cast\">{cards}</ul></header>\
         <nav aria-label=\"Characters\"><ul>{links}</ul></nav>\n<main>{parts}</main>\
         <footer>Made by crowdbake {} from a pack of {generator}. Distances are those of closest points between a level and \
         full detail, in both directions, over frames of all clips; in pictures of distance, those of the points of full \
         detail in the pose shown.</footer>\
         <script>\n{script}</script></body></html>\n",
        env!("CARGO_PKG_VERSION")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_is_too_large_is_drawn_smaller_until_pictures_would_say_nothing() {
        assert_eq!(smaller_scale(MOST_BYTES, 1.0), None);
        let smaller = smaller_scale(2 * MOST_BYTES, 1.0).unwrap();
        assert!((0.4..0.5).contains(&smaller), "{smaller}");
        assert_eq!(smaller_scale(100 * MOST_BYTES, 1.0), Some(SMALLEST_SCALE));
        assert_eq!(smaller_scale(100 * MOST_BYTES, SMALLEST_SCALE), None, "it ends");
    }
}
