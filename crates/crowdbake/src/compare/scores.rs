//! What a comparison found, and its geometric means over characters.

use super::bars::Bar;
use super::metrics::{METRICS, Metric};
use super::published::PublishedCell;
use crowd_judge::Verdict;
use serde::Serialize;
use serde::ser::SerializeMap;

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
    /// Whether pictures were drawn.
    pub pictures: bool,
    /// One entry a character.
    pub characters: Vec<CharacterScores>,
    /// Over all characters.
    pub means: Vec<Means>,
    /// What we ask of ourselves, as far as the contenders and ratios of this run show it.
    pub bars: Vec<Bar>,
    /// `refit` held against what other tools reached elsewhere, where a character of this run is one of those.
    pub published: Vec<PublishedCell>,
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
    /// Seconds in the simplifier; of the whole process for another program.
    pub seconds: f64,
    /// Clip of the largest distance.
    pub max_clip: Option<String>,
    /// Time of the largest distance.
    pub max_time_s: Option<f32>,
    /// Triangles made.
    pub triangles: Option<u32>,
    /// What the judge says; `None` where nothing was left to judge.
    #[serde(serialize_with = "write_verdict")]
    pub verdict: Option<Verdict>,
}

impl Score {
    /// True when the count lies so near the target that two contenders can be compared on one character: not more than 7 %
    /// below.
    pub fn is_near(&self) -> bool {
        self.reached && self.triangles.is_some_and(|count| f64::from(count) >= 0.93 * f64::from(self.target))
    }
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
    /// One for each of [`METRICS`].
    #[serde(serialize_with = "write_values")]
    pub values: Vec<Option<f64>>,
    /// Seconds in the simplifier.
    pub seconds: f64,
}

fn write_verdict<S: serde::Serializer>(verdict: &Option<Verdict>, to: S) -> Result<S::Ok, S::Error> {
    match verdict {
        Some(verdict) => write_map(METRICS.iter().map(|metric| (metric.of)(verdict)), to),
        None => to.serialize_none(),
    }
}

fn write_values<S: serde::Serializer>(values: &[Option<f64>], to: S) -> Result<S::Ok, S::Error> {
    write_map(values.iter().copied(), to)
}

fn write_map<S: serde::Serializer>(values: impl Iterator<Item = Option<f64>>, to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(METRICS.len()))?;
    for (metric, value) in METRICS.iter().zip(values) {
        map.serialize_entry(metric.key, &value)?;
    }
    map.end()
}

/// Means of every contender at every ratio, in the order of the first character.
pub(super) fn means_of(characters: &[CharacterScores]) -> Vec<Means> {
    let Some(first) = characters.first() else { return Vec::new() };
    let mean = |score: &Score| {
        let scores = characters.iter().filter_map(|c| find(c, score.contender, score.ratio));
        let reached: Vec<&Score> = scores.filter(|score| score.reached).collect();
        let of = |metric: &Metric| geometric_mean(reached.iter().filter_map(|s| (metric.of)(s.verdict.as_ref()?)));
        Means {
            contender: score.contender,
            ratio: score.ratio,
            reached: reached.len(),
            characters: characters.len(),
            values: METRICS.iter().map(of).collect(),
            seconds: geometric_mean(reached.iter().map(|score| score.seconds)).unwrap_or(0.0),
        }
    };
    first.scores.iter().map(mean).collect()
}

/// What a contender scored on a character at a ratio.
pub(super) fn find<'a>(character: &'a CharacterScores, contender: &str, ratio: f64) -> Option<&'a Score> {
    character.scores.iter().find(|score| score.contender == contender && score.ratio == ratio)
}

/// Zeros count as a tiny value: one perfect level does not make the whole mean perfect. `None` for no values.
pub(super) fn geometric_mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += libm::log(value.max(1e-6));
        count += 1.0;
    }
    (count > 0.0).then(|| libm::exp(sum / count))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::compare) fn scores(name: &str, rows: &[(&'static str, f64, u32)]) -> CharacterScores {
        let score = |&(contender, animated_rms, triangles): &(&'static str, f64, u32)| Score {
            contender,
            ratio: 0.25,
            target: 100,
            reached: triangles <= 101,
            seconds: 0.5,
            max_clip: None,
            max_time_s: None,
            triangles: Some(triangles),
            verdict: Some(Verdict { animated_rms, rest_rms: 1.0, ..Verdict::default() }),
        };
        let scores = rows.iter().map(score).collect();
        CharacterScores { name: name.to_owned(), triangles: 400, diagonal_m: 1.0, moments: 24, scores }
    }

    #[test]
    fn means_leave_out_what_missed_its_target() {
        let row = |rms, triangles| [("wedge", rms, triangles)];
        let missed = scores("c", &row(1000.0, 102));
        let means = means_of(&[scores("a", &row(1.0, 100)), scores("b", &row(4.0, 101)), missed]);
        assert_eq!((means[0].reached, means[0].characters), (2, 3));
        assert!((means[0].values[0].unwrap() - 2.0).abs() < 1e-9);
        assert_eq!(means_of(&[scores("c", &row(1.0, 102))])[0].values[0], None);
        assert_eq!(means[0].values[7], None, "no textures, no slide");
    }

    #[test]
    fn far_below_the_target_is_not_near_it() {
        let near = |triangles| scores("a", &[("wedge", 1.0, triangles)]).scores[0].is_near();
        assert_eq!([92, 93, 101, 102].map(near), [false, true, true, false]);
    }
}
