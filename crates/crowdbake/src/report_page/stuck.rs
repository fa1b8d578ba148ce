//! What holds the coarsest level: counts, places, remedies, and a picture of them.

use super::draw_sheets::obstacle_color;
use super::html::{Text, percent};
use super::sections::{Portrait, write_image};
use crate::explain::{Cause, CauseCount, Place};
use crate::inspect::grouped;
use std::fmt::Write;

/// Places listed.
const LISTED_PLACES: usize = 8;

/// Writes the section.
pub(crate) fn write_stuck(out: &mut String, portrait: &Portrait<'_>) {
    let e = &portrait.explanation;
    let name = Text(&portrait.character.manifest.name);
    let share = percent(f64::from(e.coarsest.triangles) / f64::from(e.full.triangles.max(1)));
    let missed: Vec<String> = portrait.missed_ratios.iter().map(|&ratio| percent(ratio)).collect();
    if e.free_positions > 0 {
        let missed =
            if missed.is_empty() { String::new() } else { format!(" <b>Not reached: {}.</b>", missed.join(", ")) };
        let _ = write!(
            out,
            "<h3>What holds the coarsest level</h3><p class=\"soft\">Nothing: the bake ended the detail at {} triangles, {share} of full \
             detail.{missed} <code>--coarsest last</code> goes on.</p>",
            grouped(e.coarsest.triangles)
        );
        return;
    }
    if e.causes.iter().all(|cause| cause.cause == Cause::LastPiece) && !e.causes.is_empty() {
        let _ = write!(
            out,
            "<h3>What holds the coarsest level</h3><p class=\"soft\">Nothing: it goes down to {} triangles, the last piece \
             of the character.</p>",
            grouped(e.coarsest.triangles)
        );
        return;
    }
    let verdict = match missed.as_slice() {
        [] => "Every share shown above is reached.".to_owned(),
        missed => format!("<b>Not reached: {}.</b>", missed.join(", ")),
    };
    let _ = write!(
        out,
        "<h3>What holds the coarsest level</h3><p class=\"soft\">It has {} triangles, {share} of full detail. {verdict} \
         {} of its points cannot move any more.</p><div class=\"stuck\"><figure>",
        grouped(e.coarsest.triangles),
        grouped(e.stuck_positions)
    );
    write_image(out, &portrait.stuck, &format!("The coarsest level of {name} with its points that cannot move"), "");
    out.push_str(
        "<figcaption>The coarsest level; each dot is a point that stays.</figcaption></figure><div><ul class=\"bars\">",
    );
    let most = e.causes.first().map_or(1, |cause| cause.count.max(1));
    for cause in &e.causes {
        write_cause(out, cause, most);
    }
    if e.causes.is_empty() {
        let o = e.obstacles;
        let _ = write!(
            out,
            "<li>{} on open borders or fixed, {} on seams, {} that would change the topology, {} that would flip a triangle. \
             This pack does not say where.</li>",
            grouped(o.fixed),
            grouped(o.seam),
            grouped(o.topology),
            grouped(o.flip)
        );
    }
    out.push_str("</ul>");
    write_places(out, &e.places);
    out.push_str("</div></div>");
}

fn write_cause(out: &mut String, cause: &CauseCount, most: u32) {
    let [r, g, b, _] = obstacle_color(cause.cause.obstacle());
    let width = 100.0 * f64::from(cause.count) / f64::from(most);
    let _ = write!(
        out,
        "<li><span class=\"dot\" style=\"background:rgb({r},{g},{b})\"></span><b>{}</b> where {}\
         <span class=\"bar\" style=\"width:{width:.1}%;background:rgb({r},{g},{b})\"></span>\
         <span class=\"fix\">To change it: {}",
        grouped(cause.count),
        cause.what,
        cause.remedy
    );
    if let Some(flag) = cause.flag {
        let _ = write!(out, "; or bake with <code>{flag}</code>");
    }
    out.push_str(".</span></li>");
}

fn write_places(out: &mut String, places: &[Place]) {
    if places.is_empty() {
        return;
    }
    out.push_str(
        "<details open=\"open\"><summary>Where</summary><table class=\"numbers\"><thead><tr>\
         <th scope=\"col\" class=\"words\">Near joint</th><th scope=\"col\" class=\"words\">Material</th>\
         <th scope=\"col\">Points</th></tr></thead><tbody>",
    );
    for place in places.iter().take(LISTED_PLACES) {
        let _ = write!(
            out,
            "<tr><td class=\"words\">{}</td><td class=\"words\">{}</td><td>{}</td></tr>",
            Text(&place.joint),
            Text(&place.material),
            grouped(place.count)
        );
    }
    let rest = &places[places.len().min(LISTED_PLACES)..];
    if !rest.is_empty() {
        let count: u32 = rest.iter().map(|place| place.count).sum();
        let _ = write!(
            out,
            "<tr><td class=\"words\">{} other places</td><td></td><td>{}</td></tr>",
            rest.len(),
            grouped(count)
        );
    }
    out.push_str("</tbody></table></details>");
}
