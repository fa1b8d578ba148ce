//! The explanation as lines for people.

use super::{Cause, Explanation, Furthest, Place, Target};
use crate::inspect::{MeasuredInspection, grouped};
use crate::units::{length, percent};
use std::fmt::Write;

/// Places listed before the rest is only counted.
const LISTED_PLACES: usize = 10;

/// Lines for people. Writing to a `String` cannot fail, so the results of `write!` are not looked at.
///
pub fn to_text(explanation: &Explanation) -> String {
    let e = explanation;
    let mut out = String::new();
    let share = f64::from(e.coarsest.triangles) / f64::from(e.full.triangles.max(1));
    let _ = writeln!(
        out,
        "{} (from {}): the coarsest level has {} of {} triangles ({}), criteria {}",
        e.character,
        e.source,
        grouped(e.coarsest.triangles),
        grouped(e.full.triangles),
        percent(share),
        e.criteria
    );
    for target in &e.targets {
        write_target(&mut out, target);
    }
    for level in &e.stored {
        let refitted = if level.refitted { ", refitted" } else { "" };
        let _ = write!(
            out,
            "  stored        {} ({}): {}{refitted}",
            level.name,
            level.target,
            grouped(level.measured.triangles)
        );
        write_measured(&mut out, &level.measured);
        out.push('\n');
    }
    write_held(&mut out, e);
    for cause in &e.causes {
        let _ = writeln!(out, "  {:>6} x      {}", grouped(cause.count), cause.what);
        if cause.cause != Cause::LastPiece {
            let _ = writeln!(out, "                change: {}", cause.remedy);
        }
        if let Some(flag) = cause.flag {
            let _ = writeln!(out, "                or bake with {flag}");
        }
    }
    if let Some(odd) = e.odd.words() {
        let _ = writeln!(out, "  odd           {odd}");
    }
    for place in e.places.iter().take(LISTED_PLACES) {
        write_place(&mut out, place);
    }
    let rest = &e.places[e.places.len().min(LISTED_PLACES)..];
    if !rest.is_empty() {
        let count: u32 = rest.iter().map(|place| place.count).sum();
        let _ = writeln!(out, "  where         {} more in {} other places", grouped(count), rest.len());
    }
    // Names come from files, and a terminal obeys what it is shown.
    out.split_inclusive('\n').map(|line| crate::talk::printable(line.trim_end_matches('\n')) + "\n").collect()
}

fn write_held(out: &mut String, e: &Explanation) {
    if e.free_positions > 0 {
        let _ = writeln!(
            out,
            "  free          {} positions could still move: the bake ended the detail here, --coarsest N or last goes on",
            grouped(e.free_positions)
        );
    }
    if e.free_positions == 0 || e.stuck_positions > 0 {
        let o = e.obstacles;
        let _ = writeln!(
            out,
            "  held          {} positions: {} fixed, {} seam, {} topology, {} flip",
            grouped(e.stuck_positions),
            grouped(o.fixed),
            grouped(o.seam),
            grouped(o.topology),
            grouped(o.flip)
        );
    }
}

fn write_target(out: &mut String, target: &Target) {
    let word = if target.reached { "reached" } else { "not reached" };
    let _ =
        write!(out, "  target        {} ({} triangles): {word}, ", percent(target.ratio), grouped(target.triangles));
    let nearest = if target.reached { "the level" } else { "the coarsest level" };
    let _ = write!(out, "{nearest} has {}", grouped(target.level.triangles));
    if let Some(measured) = &target.measured {
        write_measured(out, measured);
    }
    out.push('\n');
    if !target.furthest.is_empty() {
        let places: Vec<String> = target.furthest.iter().map(|place| furthest_words(place, &target.furthest)).collect();
        let _ = writeln!(out, "                furthest off at joints {}", places.join(", "));
    }
}

fn write_measured(out: &mut String, measured: &MeasuredInspection) {
    let _ = write!(
        out,
        "; off by {} RMS, {} at its worst point (clip {}, frame {}), every point within {}",
        length(measured.rms_m),
        length(measured.max_m),
        measured.max_clip,
        measured.max_frame,
        length(measured.bound_m),
    );
}

fn write_place(out: &mut String, place: &Place) {
    let _ = write!(out, "  where         {} on {}", grouped(place.count), place.material);
    if let [part] = place.parts.as_slice()
        && *part != place.material
    {
        let _ = write!(out, " (part {part})");
    }
    let _ = write!(out, " at joint {}", place.joint);
    let causes: Vec<String> = place.causes.iter().map(|(cause, count)| format!("{count} {}", cause.name())).collect();
    let _ = writeln!(out, ": {}", causes.join(", "));
}

/// A joint and how far off; with the material where the joint moves several.
fn furthest_words(place: &Furthest, all: &[Furthest]) -> String {
    let several = all.iter().filter(|other| other.joint == place.joint).count() > 1;
    let of = if several { format!(" ({})", place.material) } else { String::new() };
    let rest = if place.at_rest { " (at rest)" } else { "" };
    format!("{}{of} {}{rest}", place.joint, length(place.max_m))
}
