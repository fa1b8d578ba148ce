//! Judges levels of ours and of other tools side by side, at equal triangle counts over held-out poses.
//!
//! `subject` prepares a character, `contenders` names who takes part, `ours` and `meshopt_peers` make their levels,
//! `crowd-judge` judges them, `scores` sums up over characters, `published` holds single cells against figures of other tools, `bars` says how far all that is from what we ask of ourselves,
//! `tables` writes.

mod bars;
mod contenders;
mod gltfpack;
mod meshopt_peers;
mod metrics;
mod ours;
mod published;
mod scores;
mod subject;
mod tables;

pub use bars::Bar;
pub use contenders::Contender;
pub use metrics::{METRICS, Metric};
pub use published::PublishedCell;
pub use scores::{CharacterScores, Comparison, Means, Score};
pub(crate) use tables::{to_markdown, to_text};

use crate::error::{BakeError, Step};
use crate::plan::PlanEntry;
use crate::talk::Talk;
use crowd_judge::{JudgeOptions, Level};
use rayon::prelude::*;
use std::time::Instant;
use subject::Subject;

/// What to compare.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareRequest {
    /// Shares of the triangles, 0 to 1.
    pub ratios: Vec<f64>,
    /// Who takes part.
    pub contenders: Vec<Contender>,
    /// How much is measured.
    pub options: JudgeOptions,
}

/// A level that a contender made.
struct MadeLevel {
    level: Level,
    /// Seconds that it took; for one order that gives all levels, those of the order.
    seconds: f64,
}

/// Leaves out, aloud, whoever is not there.
pub(crate) fn keep_present(contenders: Vec<Contender>, talk: &Talk<'_>) -> Vec<Contender> {
    if !contenders.iter().any(|contender| contender.is_gltfpack()) {
        return contenders;
    }
    let Some(refusal) = gltfpack::refusal() else { return contenders };
    talk.warn(refusal);
    contenders.into_iter().filter(|contender| !contender.is_gltfpack()).collect()
}

/// Compares on one character.
///
/// # Errors
/// The first step that refuses the character; an original that has no area.
pub(crate) fn compare_character(
    entry: &PlanEntry,
    request: &CompareRequest,
    talk: &Talk<'_>,
) -> Result<CharacterScores, BakeError> {
    let subject = Subject::load(entry, request.options)?;
    let full = subject.raw.mesh.triangles.len() as f64;
    // At least one triangle; the epsilon keeps 0.1 * 30 from becoming 2.
    let targets: Vec<u32> = request.ratios.iter().map(|ratio| ((full * ratio + 1e-6) as u32).max(1)).collect();
    let mut scores = Vec::new();
    for &contender in &request.contenders {
        let started = Instant::now();
        let made = match make_levels(&subject, contender, &targets) {
            Ok(made) => made,
            // Another program's trouble is no reason to stop.
            Err(cause) if contender.is_gltfpack() => {
                talk.warn(format_args!("{}: {}: {cause}", entry.name, contender.name()));
                targets.iter().map(|_| None).collect()
            }
            Err(cause) => return Err(BakeError::of(Step::Simplify, &entry.name, *cause)),
        };
        let made_s = started.elapsed().as_secs_f64();
        for ((level, &target), &ratio) in made.into_iter().zip(&targets).zip(&request.ratios) {
            scores.push(judge_level(&subject, contender, ratio, target, level)?);
        }
        let judged_s = started.elapsed().as_secs_f64() - made_s;
        let name = contender.name();
        talk.detail(format_args!("  {}: {name}: made in {made_s:.2} s, judged in {judged_s:.2} s", entry.name));
    }
    Ok(CharacterScores {
        name: entry.name.clone(),
        triangles: subject.raw.mesh.triangles.len() as u32,
        diagonal_m: subject.judge.diagonal_m(),
        moments: subject.moments.len() as u32,
        scores,
    })
}

/// One level for each target, or `None` where the contender leaves nothing to judge.
fn make_levels(
    subject: &Subject,
    contender: Contender,
    targets: &[u32],
) -> Result<Vec<Option<MadeLevel>>, Box<crate::error::Cause>> {
    if contender.is_ours() {
        ours::make_levels(subject, contender, targets).map_err(|error| Box::new(error.into()))
    } else if contender.is_gltfpack() {
        let made = targets.par_iter().map(|&target| gltfpack::make_level(subject, contender, target));
        made.collect::<Result<Vec<_>, _>>().map_err(Box::new)
    } else {
        Ok(targets.iter().map(|&target| meshopt_peers::make_level(subject, contender, target)).collect())
    }
}

fn judge_level(
    subject: &Subject,
    contender: Contender,
    ratio: f64,
    target: u32,
    level: Option<MadeLevel>,
) -> Result<Score, BakeError> {
    let seconds = level.as_ref().map_or(0.0, |level| level.seconds);
    // A level without any area is not an error of the input: there is nothing to judge.
    let verdict = level.and_then(|level| subject.judge.judge_level(level.level).ok());
    let moment = verdict.and_then(|verdict| verdict.max_pose).map(|pose| &subject.moments[pose as usize]);
    Ok(Score {
        contender: contender.name(),
        ratio,
        target,
        reached: verdict.is_some_and(|verdict| f64::from(verdict.triangles) <= f64::from(target) * 1.01),
        seconds,
        max_clip: moment.map(|moment| moment.clip.clone()),
        max_time_s: moment.map(|moment| moment.time_s),
        triangles: verdict.map(|verdict| verdict.triangles),
        verdict,
    })
}

/// Puts characters together; adds the means and the bars.
pub(crate) fn sum_up(characters: Vec<CharacterScores>, request: &CompareRequest, seconds: f64) -> Comparison {
    let peers = request.contenders.iter().filter(|contender| !contender.is_ours());
    let peers: Vec<&'static str> = peers.map(|contender| contender.name()).collect();
    let published = published::published_cells(&characters);
    Comparison {
        schema_version: crate::report::SCHEMA_VERSION,
        generator: format!("crowdbake {}", env!("CARGO_PKG_VERSION")),
        command: "compare",
        points: request.options.points,
        pictures: request.options.pictures,
        means: scores::means_of(&characters),
        bars: bars::bars_of(&characters, &published, &peers, request.options.points >= JudgeOptions::FULL.points),
        published,
        characters,
        seconds,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn request() -> CompareRequest {
        CompareRequest {
            ratios: vec![0.25],
            contenders: vec![Contender::Wedge, Contender::MeshoptGlobal],
            options: JudgeOptions::QUICK,
        }
    }
}
