//! What we ask of our own levels: factors on what others reach, and how far we are.

use super::metrics::{ANIMATED_RMS, COLOR, IMAGE, MAX, METRICS, Metric, NORMAL, REST_RMS, UV};
use super::published::PublishedCell;
use super::scores::{CharacterScores, find, geometric_mean};
use crowd_judge::Verdict;
use serde::Serialize;

/// A bar at one ratio.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bar {
    /// Who is to be better.
    pub ours: &'static str,
    /// Key of the metric.
    pub metric: &'static str,
    /// Than whom; of several the best one.
    pub than: String,
    /// Share of the triangles.
    pub ratio: f64,
    /// Ours divided by theirs: geometric mean over the characters on which both reached the target. For single cells the
    /// largest over all characters and metrics.
    pub found: f64,
    /// At most this.
    pub allowed: f64,
    /// Whether it is.
    pub met: bool,
}

/// Ours may be worse than the best peer by this factor in no single cell.
const CELL_FACTOR: f64 = 1.03;

struct Rule {
    ours: &'static str,
    metric: Metric,
    than: &'static str,
    factor: f64,
    /// `None` for every ratio.
    only_at: Option<f64>,
}

const fn rule(ours: &'static str, metric: Metric, than: &'static str, factor: f64) -> Rule {
    Rule { ours, metric, than, factor, only_at: None }
}

const RULES: [Rule; 6] = [
    rule("wedge", ANIMATED_RMS, "meshopt-global", 0.85),
    rule("refit", ANIMATED_RMS, "meshopt-best", 0.7),
    rule("refit", ANIMATED_RMS, "gltfpack-se1", 0.25),
    Rule { ours: "wedge", metric: MAX, than: "bind", factor: 0.7, only_at: Some(0.25) },
    Rule { ours: "wedge", metric: UV, than: "gltfpack-se1", factor: 0.5, only_at: Some(0.25) },
    Rule { ours: "refit", metric: UV, than: "gltfpack-se1", factor: 0.5, only_at: Some(0.25) },
];
/// Against the best peer of each ratio.
const BEST_PEER_FACTOR: f64 = 0.85;
const BEST_PEER_METRICS: [Metric; 3] = [COLOR, NORMAL, IMAGE];
/// In motion as at rest.
const MOTION_FACTOR: f64 = 1.15;

/// All bars that the contenders and ratios of these scores can show. `cells`: single ones too, which takes enough points.
pub(super) fn bars_of(
    characters: &[CharacterScores],
    published: &[PublishedCell],
    peers: &[&'static str],
    cells: bool,
) -> Vec<Bar> {
    let Some(first) = characters.first() else { return Vec::new() };
    let mut ratios: Vec<f64> = first.scores.iter().map(|score| score.ratio).collect();
    ratios.sort_by(|a, b| b.total_cmp(a));
    ratios.dedup();
    let mut bars = Vec::new();
    for rule in &RULES {
        for &ratio in ratios.iter().filter(|&&ratio| rule.only_at.is_none_or(|only| only == ratio)) {
            let found = quotient(characters, ratio, rule.ours, rule.than, &rule.metric);
            bars.extend(found.map(|found| bar(rule.ours, &rule.metric, rule.than, ratio, found, rule.factor)));
        }
    }
    for ours in ["wedge", "refit"] {
        for metric in &BEST_PEER_METRICS {
            for &ratio in &ratios {
                let quotients =
                    peers.iter().filter_map(|&peer| Some((quotient(characters, ratio, ours, peer, metric)?, peer)));
                let best = quotients.max_by(|a, b| a.0.total_cmp(&b.0));
                bars.extend(best.map(|(found, peer)| bar(ours, metric, peer, ratio, found, BEST_PEER_FACTOR)));
            }
        }
        for &ratio in ratios.iter().filter(|_| cells) {
            let worst = characters.iter().filter_map(|character| motion_quotient(character, ours, ratio));
            let worst = worst.max_by(|a, b| a.0.total_cmp(&b.0));
            bars.extend(worst.map(|(found, name)| {
                bar(
                    ours,
                    &ANIMATED_RMS,
                    &format!("its own {} on {name}", REST_RMS.heading),
                    ratio,
                    found,
                    MOTION_FACTOR,
                )
            }));
        }
    }
    if !cells {
        return bars;
    }
    for &ratio in &ratios {
        let mut cells: Vec<_> = characters.iter().flat_map(|character| cells_of(character, peers, ratio)).collect();
        cells.sort_by(|a, b| b.0.total_cmp(&a.0));
        // All that are lost, and the worst where none is.
        let lost = cells.iter().filter(|(found, ..)| *found > CELL_FACTOR).count();
        cells.truncate(lost.max(1));
        bars.extend(cells.iter().map(|(found, metric, than)| bar("refit", metric, than, ratio, *found, CELL_FACTOR)));
    }
    for &ratio in &ratios {
        let worst = published.iter().filter(|cell| cell.ratio == ratio).max_by(|a, b| a.found.total_cmp(&b.found));
        bars.extend(worst.and_then(|cell| {
            let metric = METRICS.iter().find(|metric| metric.key == cell.metric)?;
            let than = format!("{} on {}, judged elsewhere", cell.peer, cell.character);
            Some(bar("refit", metric, &than, ratio, cell.found, CELL_FACTOR))
        }));
    }
    bars
}

fn bar(ours: &'static str, metric: &Metric, than: &str, ratio: f64, found: f64, allowed: f64) -> Bar {
    Bar { ours, metric: metric.key, than: than.to_owned(), ratio, found, allowed, met: found <= allowed }
}

/// Ours divided by theirs, over the characters on which both reached the target.
fn quotient(characters: &[CharacterScores], ratio: f64, ours: &str, theirs: &str, metric: &Metric) -> Option<f64> {
    let value = |character: &CharacterScores, contender: &str| {
        let score = find(character, contender, ratio).filter(|score| score.reached)?;
        (metric.of)(score.verdict.as_ref()?).map(|value| value.max(1e-6))
    };
    let of = |character: &CharacterScores| Some(value(character, ours)? / value(character, theirs)?);
    geometric_mean(characters.iter().filter_map(of))
}

fn motion_quotient<'a>(character: &'a CharacterScores, ours: &str, ratio: f64) -> Option<(f64, &'a str)> {
    let verdict: Verdict = find(character, ours, ratio).filter(|score| score.reached)?.verdict?;
    // A level without any error at rest has no quotient.
    (verdict.rest_rms > 1e-3 && character.moments > 0)
        .then(|| (verdict.animated_rms / verdict.rest_rms, character.name.as_str()))
}

/// Ours against the best that any peer near the target reached, for the metrics in which no cell may be lost.
fn cells_of(character: &CharacterScores, peers: &[&'static str], ratio: f64) -> Vec<(f64, &'static Metric, String)> {
    let Some(ours) = find(character, "refit", ratio).filter(|score| score.reached) else { return Vec::new() };
    let Some(verdict) = ours.verdict else { return Vec::new() };
    let counted =
        |metric: &&Metric| [ANIMATED_RMS, IMAGE, COLOR, NORMAL].iter().any(|counted| counted.key == metric.key);
    let cell = |metric: &'static Metric| {
        let ours = (metric.of)(&verdict)?;
        let theirs = peers.iter().filter_map(|&peer| {
            let score = find(character, peer, ratio).filter(|score| score.is_near())?;
            Some(((metric.of)(score.verdict.as_ref()?)?, peer))
        });
        let (best, peer) = theirs.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((ours.max(1e-6) / best.max(1e-6), metric, format!("{peer} on {}", character.name)))
    };
    METRICS.iter().filter(counted).filter_map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::scores::tests::scores;

    #[test]
    fn a_bar_is_met_or_not_by_the_characters_both_reached() {
        let characters = [
            scores("a", &[("wedge", 0.5, 100), ("meshopt-global", 1.0, 100)]),
            scores("b", &[("wedge", 0.98, 100), ("meshopt-global", 1.0, 100)]),
            scores("c", &[("wedge", 0.001, 200), ("meshopt-global", 1.0, 100)]),
        ];
        let bars = bars_of(&characters, &[], &["meshopt-global"], true);
        let first = &bars[0];
        assert_eq!((first.ours, first.than.as_str(), first.met), ("wedge", "meshopt-global", true));
        assert!((first.found - 0.7).abs() < 1e-9, "{first:?}");
        let worse = [scores("a", &[("wedge", 0.9, 100), ("meshopt-global", 1.0, 100)])];
        assert!(!bars_of(&worse, &[], &[], true)[0].met);
    }

    #[test]
    fn motion_is_held_against_rest() {
        let bars = bars_of(&[scores("a", &[("wedge", 1.2, 100)])], &[], &[], true);
        assert_eq!(bars.len(), 1);
        assert!(!bars[0].met && bars[0].than.ends_with("on a"), "{bars:?}");
    }

    #[test]
    fn the_worst_cell_judged_elsewhere_shows() {
        let cell = |peer, found| PublishedCell {
            character: "a".to_owned(),
            ratio: 0.25,
            metric: "color_rms",
            least: 1.0,
            peer,
            ours: found,
            found,
        };
        let bars = bars_of(&[scores("a", &[("refit", 1.0, 100)])], &[cell("x", 0.9), cell("blender", 1.04)], &[], true);
        let bar = bars.last().unwrap();
        assert_eq!((bar.than.as_str(), bar.metric, bar.met), ("blender on a, judged elsewhere", "color_rms", false));
    }

    #[test]
    fn few_points_judge_no_single_cell() {
        let lost = [scores("a", &[("refit", 1.1, 100), ("meshopt-best", 1.0, 100)])];
        let of = |cells| bars_of(&lost, &[], &["meshopt-best"], cells);
        assert!(of(true).iter().any(|bar| bar.allowed == CELL_FACTOR && !bar.met));
        let means = of(false);
        assert!(!means.is_empty() && means.iter().all(|bar| ![CELL_FACTOR, MOTION_FACTOR].contains(&bar.allowed)));
    }

    #[test]
    fn one_lost_cell_shows_whatever_the_mean() {
        let row = |ours, theirs, count| [("refit", ours, 100), ("meshopt-best", theirs, count)];
        let cell = |characters: &[CharacterScores]| {
            let bars = bars_of(characters, &[], &["meshopt-best"], true);
            bars.into_iter().find(|bar| bar.allowed == CELL_FACTOR).unwrap()
        };
        let won = scores("a", &row(0.1, 1.0, 100));
        let lost_again = || scores("b", &row(1.1, 1.0, 100));
        let found = cell(&[won, lost_again()]);
        assert!(!found.met && found.than == "meshopt-best on b", "{found:?}");
        // Another one behind it is shown too.
        let further = scores("c", &row(1.05, 1.0, 100));
        let bars = bars_of(&[lost_again(), further], &[], &["meshopt-best"], true);
        let shown: Vec<&str> =
            bars.iter().filter(|bar| bar.allowed == CELL_FACTOR).map(|bar| bar.than.as_str()).collect();
        assert!(shown.contains(&"meshopt-best on b") && shown.contains(&"meshopt-best on c"), "{shown:?}");
        assert!(bars.iter().filter(|bar| bar.allowed == CELL_FACTOR).all(|bar| !bar.met));
        // A peer far below the target gives no cell.
        let bars = bars_of(&[scores("b", &row(1.1, 1.0, 80))], &[], &["meshopt-best"], true);
        assert!(bars.iter().all(|bar| bar.allowed != CELL_FACTOR));
    }
}
