//! An inspection as text for people.

use super::{CharacterInspection, Inspection, MeasuredInspection};
use crate::talk::printable;
use crate::units::counted;
use std::fmt::Write;

/// The document as a text for people. Writing to a `String` cannot fail, so the results of `write!` are not looked at.
pub fn to_text(inspection: &Inspection) -> String {
    let mut out = String::new();
    let _ = write!(out, "{}: {}, {} bytes", inspection.file, inspection.kind, grouped(inspection.bytes));
    if let (Some(generator), Some(layout)) = (&inspection.generator, inspection.animation_layout) {
        let _ =
            write!(out, ", {}, matrices {layout}, by {generator}", counted(inspection.characters.len(), "character"));
    }
    let _ = writeln!(out, ", {} of {} bytes", counted(inspection.images, "image"), grouped(inspection.image_bytes));
    for character in &inspection.characters {
        write_character(&mut out, character);
    }
    // Names come from files, and a terminal obeys what it is shown.
    out.chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect()
}

fn write_character(out: &mut String, character: &CharacterInspection) {
    let c = character;
    let _ = writeln!(out, "\n{} (from {})", c.name, c.source);
    if let Some(line) = &c.copyright {
        let _ = writeln!(out, "  copyright     {}", shortened(line));
    }
    let _ = writeln!(out, "  full detail   {} triangles, {} vertices", grouped(c.triangles), grouped(c.vertices));
    if let (Some(vertices), Some(triangles), Some(levels)) = (c.coarsest_vertices, c.coarsest_triangles, c.levels) {
        let _ = writeln!(
            out,
            "  coarsest      {} triangles, {} vertices; {} levels between, criteria {}",
            grouped(triangles),
            grouped(vertices),
            grouped(levels as u64),
            c.criteria.as_deref().unwrap_or("-"),
        );
    }
    if let (Some(height), Some(radius)) = (c.height_m, c.radius_m) {
        let _ = writeln!(out, "  size          {height:.3} m high, sphere of {radius:.3} m over all clips");
    }
    let s = c.seams;
    let _ = writeln!(
        out,
        "  seams         {} positions, {} wedges, {} positions on seams",
        grouped(s.positions),
        grouped(s.wedges),
        grouped(s.seam_positions)
    );
    let _ = writeln!(
        out,
        "  classes       {} regular, {} companion, {} fixed ({} on open borders)",
        grouped(s.regular),
        grouped(s.companion),
        grouped(s.fixed),
        grouped(s.on_border)
    );
    if let Some(odd) = s.odd.words() {
        let _ = writeln!(out, "  odd           {odd}");
    }
    if let Some(b) = c.blocked {
        let _ = writeln!(
            out,
            "  blocked       {} fixed, {} seam, {} topology, {} flip; {} free, where the detail was ended",
            b.fixed, b.seam, b.topology, b.flip, b.ended
        );
    }
    let rigid = c.parts.iter().filter(|part| part.rigid).count();
    let _ = writeln!(
        out,
        "  skeleton      {}; {}, {rigid} of them rigid",
        counted(c.joints, "joint"),
        counted(c.parts.len(), "part")
    );
    for material in &c.materials {
        let texture = material.texture.map_or("no texture".to_owned(), |[w, h]| format!("texture {w}x{h}"));
        let mask = if material.alpha_cutoff > 0.0 { ", masked" } else { "" };
        let _ = writeln!(out, "  material      {}: {texture}{mask}", material.name);
    }
    if let Some(animation) = &c.animation {
        let _ = writeln!(out, "  animation     {}", animation.words());
    }
    if let Some(i) = c.impostors {
        let [around, up] = i.directions;
        let _ = writeln!(
            out,
            "  impostors     {} texels, {around} directions around, {up} up, {} poses of each of {}, {} bytes",
            i.tile_px,
            i.poses_a_clip,
            counted(i.clips as usize, "clip"),
            grouped(i.bytes)
        );
    }
    for clip in &c.clips {
        let _ = write!(out, "  clip          {}: {:.2} s", clip.name, clip.duration_s);
        if let (Some(frames), Some(speed), Some(gap)) = (clip.frames, clip.ground_speed_m_s, clip.loop_gap_m) {
            let _ = write!(out, ", {frames} frames, walks at {speed:.2} m/s, loop gap {gap:.3} m");
        }
        if let (Some(contacts), Some(slide)) = (clip.contacts.filter(|&count| count > 0), clip.slide_m_s) {
            let rooted = clip.rooted_slide_m_s.unwrap_or_default();
            let _ =
                write!(out, ", feet stand {contacts} times, slide at {slide:.3} m/s, {rooted:.3} on the clip's path");
        }
        out.push('\n');
    }
    write_levels(out, c);
    for warning in &c.warnings {
        let _ = writeln!(out, "  warning       {warning}");
    }
}

/// A line of a file's own words: the beginning of it, on one line, without marks that steer a terminal.
fn shortened(words: &str) -> String {
    const MOST: usize = 300;
    let line: String = words.replace(['\r', '\n'], " ").chars().take(MOST).collect();
    format!("{}{}", printable(&line), if words.chars().count() > MOST { "..." } else { "" })
}

/// Rows of quantised levels that the table for people shows, spread over all; JSON has all of them.
const SHOWN_LEVELS: usize = 16;

fn write_levels(out: &mut String, c: &CharacterInspection) {
    let Some(table_bytes) = c.table_bytes else { return };
    let _ = writeln!(
        out,
        "  levels        {} quantised, {} discrete, {} bytes of tables",
        c.measured.len(),
        c.discrete.len(),
        grouped(table_bytes)
    );
    let _ = writeln!(
        out,
        "                {:>9} {:>8} {:>8} {:>8} {:>8} {:>7} {:>7} {:>6} {:>6}  worst",
        "triangles", "vertices", "rms mm", "max mm", "bound mm", "px@720", "texels", "deg", "poked",
    );
    for discrete in &c.discrete {
        let _ = write!(out, "                {}", level_row(&discrete.measured));
        let refitted = if discrete.refitted { ", refitted" } else { "" };
        let missed = if discrete.reached { "" } else { ", not reached" };
        let _ = writeln!(out, "; {}: {}{refitted}{missed}", discrete.name, discrete.target);
    }
    let step = c.measured.len().div_ceil(SHOWN_LEVELS).max(1);
    for level in c.measured.iter().rev().step_by(step) {
        let _ = writeln!(out, "                {}", level_row(level));
    }
}

fn level_row(level: &MeasuredInspection) -> String {
    let found = level.max_m > 0.0;
    let worst = if found { format!("{}:{}", level.max_clip, level.max_frame) } else { "-".to_owned() };
    format!(
        "{:>9} {:>8} {:>8.3} {:>8.3} {:>8.3} {:>7.2} {:>7.2} {:>6.2} {:>5.2}%  {worst}",
        level.triangles,
        level.vertices,
        level.rms_m * 1e3,
        level.max_m * 1e3,
        level.bound_m * 1e3,
        level.bound_px,
        level.uv_drift_p95_texels,
        level.normal_mean_deg,
        level.poked_share * 100.0,
    )
}

/// Digits in groups of three.
pub(crate) fn grouped(number: impl Into<u64>) -> String {
    let digits = number.into().to_string();
    let mut out = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped() {
        assert_eq!([grouped(7_u32), grouped(1000_u32), grouped(1_234_567_u32)], ["7", "1,000", "1,234,567"]);
    }
}
