//! What a comparison found, and its geometric means over characters.

use crowd_judge::Verdict;
use serde::Serialize;

/// A whole comparison.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// [`crate::report::SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Program and version.
    pub generator: String,
    /// The verb: `compare`.
    pub command: &'static str,
    /// Points a side.
    pub points: u32,
    /// One entry a character.
    pub characters: Vec<CharacterScores>,
    /// Over all characters.
    pub means: Vec<Means>,
    /// Wall-clock seconds of the whole run.
    pub seconds: f64,
}

/// What was found on one character.
#[derive(Debug, Serialize)]
pub struct CharacterScores {
    /// Its name.
    pub name: String,
    /// Triangles of the original.
    pub triangles: u32,
    /// 100 % of all distances, metres.
    pub diagonal_m: f64,
    /// Poses in motion.
    pub moments: u32,
    /// One for each contender and ratio.
    pub scores: Vec<Score>,
}

/// One contender at one ratio.
#[derive(Debug, Serialize)]
pub struct Score {
    /// Its name.
    pub contender: &'static str,
    /// Share of the triangles asked for.
    pub ratio: f64,
    /// Triangles asked for.
    pub target: u32,
    /// At most 1 % above the target.
    pub reached: bool,
    /// Seconds in the simplifier.
    pub seconds: f64,
    /// Clip of the largest distance.
    pub max_clip: Option<String>,
    /// Time of the largest distance.
    pub max_time_s: Option<f32>,
    /// What the judge says; `None` where nothing was left to judge.
    #[serde(serialize_with = "write_verdict")]
    pub verdict: Option<Verdict>,
}

/// Geometric means of one contender at one ratio over the characters where the target was reached.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Means {
    /// Its name.
    pub contender: &'static str,
    /// Share of the triangles asked for.
    pub ratio: f64,
    /// Characters on which the target was reached.
    pub reached: usize,
    /// Characters.
    pub characters: usize,
    /// `None` where no character reached the target.
    #[serde(serialize_with = "write_verdict")]
    pub verdict: Option<Verdict>,
    /// Seconds in the simplifier.
    pub seconds: f64,
}

fn write_verdict<S: serde::Serializer>(verdict: &Option<Verdict>, to: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Fields {
        triangles: u32,
        animated_rms_percent: f64,
        rest_rms_percent: f64,
        mean_percent: f64,
        p99_percent: f64,
        max_percent: f64,
        normal_deg: f64,
        color_rms: f64,
    }
    verdict
        .map(|v| Fields {
            triangles: v.triangles,
            animated_rms_percent: v.animated_rms,
            rest_rms_percent: v.rest_rms,
            mean_percent: v.mean,
            p99_percent: v.p99,
            max_percent: v.max,
            normal_deg: v.normal_deg,
            color_rms: v.color_rms,
        })
        .serialize(to)
}

/// Means of every contender at every ratio, in the order of the first character.
pub(super) fn means_of(characters: &[CharacterScores]) -> Vec<Means> {
    let Some(first) = characters.first() else { return Vec::new() };
    let mean = |score: &Score| {
        let same = |other: &&Score| other.contender == score.contender && other.ratio == score.ratio;
        let scores: Vec<&Score> = characters.iter().filter_map(|c| c.scores.iter().find(same)).collect();
        let reached: Vec<&Score> = scores.into_iter().filter(|score| score.reached).collect();
        let verdicts: Vec<Verdict> = reached.iter().filter_map(|score| score.verdict).collect();
        let of = |value: fn(&Verdict) -> f64| geometric_mean(verdicts.iter().map(value));
        let verdict = Verdict {
            triangles: 0,
            animated_rms: of(|v| v.animated_rms),
            rest_rms: of(|v| v.rest_rms),
            mean: of(|v| v.mean),
            p99: of(|v| v.p99),
            max: of(|v| v.max),
            max_pose: None,
            normal_deg: of(|v| v.normal_deg),
            color_rms: of(|v| v.color_rms),
        };
        Means {
            contender: score.contender,
            ratio: score.ratio,
            reached: reached.len(),
            characters: characters.len(),
            verdict: (!verdicts.is_empty()).then_some(verdict),
            seconds: geometric_mean(reached.iter().map(|score| score.seconds)),
        }
    };
    first.scores.iter().map(mean).collect()
}

/// Zeros count as a tiny value: one perfect level does not make the whole mean perfect.
fn geometric_mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += libm::log(value.max(1e-6));
        count += 1.0;
    }
    if count > 0.0 { libm::exp(sum / count) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scores(name: &str, rms: f64, reached: bool) -> CharacterScores {
        let score = Score {
            contender: "wedge",
            ratio: 0.25,
            target: 10,
            reached,
            seconds: 0.5,
            max_clip: None,
            max_time_s: None,
            verdict: Some(Verdict { animated_rms: rms, ..Verdict::default() }),
        };
        CharacterScores { name: name.to_owned(), triangles: 40, diagonal_m: 1.0, moments: 24, scores: vec![score] }
    }

    #[test]
    fn means_leave_out_what_missed_its_target() {
        let means = means_of(&[scores("a", 1.0, true), scores("b", 4.0, true), scores("c", 1000.0, false)]);
        assert_eq!((means[0].reached, means[0].characters), (2, 3));
        assert!((means[0].verdict.unwrap().animated_rms - 2.0).abs() < 1e-9);
        assert_eq!(means_of(&[scores("c", 1.0, false)])[0].verdict, None);
    }
}
