//! A comparison as text.

use super::scores::{CharacterScores, Comparison};
use crowd_judge::Verdict;
use std::fmt::Write;

const HEADINGS: &str =
    "ratio  contender         triangles   anim rms  rest rms      mean       p99       max    normal  colour      s";

/// Tables for a terminal.
pub(crate) fn to_text(comparison: &Comparison) -> String {
    let mut out = String::new();
    for character in &comparison.characters {
        write_character(&mut out, character);
    }
    let _ = writeln!(
        out,
        "geometric means over {} character(s), where the target was reached",
        comparison.characters.len()
    );
    let _ = writeln!(out, "{HEADINGS}");
    for ratio in ratios(comparison.means.iter().map(|mean| mean.ratio)) {
        for mean in comparison.means.iter().filter(|mean| mean.ratio == ratio) {
            let reached = format!("{} of {}", mean.reached, mean.characters);
            write_row(&mut out, ratio, mean.contender, &reached, mean.verdict.as_ref(), mean.seconds);
        }
    }
    out
}

fn write_character(out: &mut String, character: &CharacterScores) {
    let _ = writeln!(
        out,
        "{}: {} triangles, {} poses in motion; distances in percent of {:.3} m",
        character.name, character.triangles, character.moments, character.diagonal_m
    );
    let _ = writeln!(out, "{HEADINGS}");
    for ratio in ratios(character.scores.iter().map(|score| score.ratio)) {
        for score in character.scores.iter().filter(|score| score.ratio == ratio) {
            let triangles = match score.verdict {
                Some(verdict) if score.reached => verdict.triangles.to_string(),
                Some(verdict) => format!("{} missed", verdict.triangles),
                None => "nothing left".to_owned(),
            };
            write_row(out, ratio, score.contender, &triangles, score.verdict.as_ref(), score.seconds);
        }
    }
    out.push('\n');
}

fn write_row(out: &mut String, ratio: f64, contender: &str, triangles: &str, verdict: Option<&Verdict>, seconds: f64) {
    let _ = write!(out, "{:>4.3}%  {contender:<16} {triangles:>12}", 100.0 * ratio);
    if let Some(v) = verdict {
        let [a, b, c, d, e] = [v.animated_rms, v.rest_rms, v.mean, v.p99, v.max];
        let _ = write!(out, "  {a:>8.4}  {b:>8.4}  {c:>8.4}  {d:>8.3}  {e:>8.3}");
        let _ = write!(out, "  {:>8.2}  {:>6.4}  {seconds:>5.2}", v.normal_deg, v.color_rms);
    }
    out.push('\n');
}

/// Distinct ratios, largest first.
fn ratios(all: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut ratios: Vec<f64> = all.collect();
    ratios.sort_by(|a, b| b.total_cmp(a));
    ratios.dedup();
    ratios
}
