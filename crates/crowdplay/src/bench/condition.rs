//! Conditions on what came out, as typed: `bucketed/b0 <= 0.25`.

use super::rows::Row;
use super::variant::Variant;
use crowd_stages::{DrawOptions, Technique};
use std::fmt;
use std::str::FromStr;

/// What a condition is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Median of whole frames, milliseconds.
    Frame,
    /// Their 95th percentile.
    FrameP95,
    /// Median of the GPU's time, milliseconds.
    Gpu,
    /// Median of what the CPU does for a frame, milliseconds.
    Cpu,
    /// Its part of the frame.
    CpuShare,
    /// Everything but skinning and drawing.
    Lod,
    /// Its part of the GPU's time.
    LodShare,
    /// The draw.
    Draw,
    /// The shadow maps, their selection included.
    Shadows,
    /// Triangles of the last frame.
    Triangles,
    /// Vertices of the last frame.
    Vertices,
    /// Instances that others hide in the last frame.
    Hidden,
    /// Draws of the last frame.
    Draws,
    /// Vertex shader runs of the last frame.
    VertexRuns,
    /// The same for each triangle.
    RunsPerTriangle,
    /// Vertex shader runs of all frames over their triangles.
    MeanRunsPerTriangle,
    /// The most runs for each triangle of any frame.
    MostRunsPerTriangle,
    /// Triangles with the least budget whose picture is as near to full detail as the other's.
    TrianglesAtEqualImage,
    /// Poses worked out for the last frame.
    Poses,
    /// The same for each visible instance.
    PoseShare,
    /// Difference of the last frame to full detail.
    Image,
    /// What changes in the picture by levels alone.
    Pop,
    /// How far the surface moves by them, RMS.
    PopPx,
    /// The mean of its square: pop energy.
    PopEnergy,
    /// The most quantised levels that anybody goes from one frame to the next.
    LevelSteps,
    /// Share of those who go farther than to the next one.
    LevelStepsBeyondNext,
}

impl Quantity {
    const NAMES: [(&'static str, Self); 26] = [
        ("frame_ms", Self::Frame),
        ("frame_p95_ms", Self::FrameP95),
        ("gpu_ms", Self::Gpu),
        ("cpu_ms", Self::Cpu),
        ("cpu_share", Self::CpuShare),
        ("lod_ms", Self::Lod),
        ("lod_share", Self::LodShare),
        ("draw_ms", Self::Draw),
        ("shadows_ms", Self::Shadows),
        ("triangles", Self::Triangles),
        ("vertices", Self::Vertices),
        ("hidden", Self::Hidden),
        ("draws", Self::Draws),
        ("vertex_runs", Self::VertexRuns),
        ("runs_per_triangle", Self::RunsPerTriangle),
        ("mean_runs_per_triangle", Self::MeanRunsPerTriangle),
        ("most_runs_per_triangle", Self::MostRunsPerTriangle),
        ("triangles_at_equal_image", Self::TrianglesAtEqualImage),
        ("poses", Self::Poses),
        ("pose_share", Self::PoseShare),
        ("image_rmse", Self::Image),
        ("pop_rmse", Self::Pop),
        ("pop_px", Self::PopPx),
        ("pop_energy", Self::PopEnergy),
        ("most_level_steps", Self::LevelSteps),
        ("level_steps_beyond_next", Self::LevelStepsBeyondNext),
    ];

    /// Its value in a row; `None` where the adapter does not measure it.
    pub fn of(self, row: &Row) -> Option<f64> {
        match self {
            Self::Frame => Some(row.frame_ms.median.into()),
            Self::FrameP95 => Some(row.frame_ms.p95.into()),
            Self::Gpu => row.gpu_ms.map(|spread| spread.median.into()),
            Self::Cpu => row.cpu_ms.map(f64::from),
            Self::CpuShare => row.cpu_share.map(f64::from),
            Self::Lod => row.lod_ms.map(f64::from),
            Self::LodShare => row.lod_share.map(f64::from),
            Self::Draw => row.stages_ms.get("draw").map(|spread| spread.median.into()),
            Self::Shadows => row.stages_ms.get("shadows").map(|spread| spread.median.into()),
            Self::Triangles => Some(row.triangles.into()),
            // Has two rows: see `judge`.
            Self::TrianglesAtEqualImage => None,
            Self::Vertices => Some(row.vertices.into()),
            Self::Hidden => Some(row.occluded.into()),
            Self::Draws => Some(row.draws.into()),
            Self::VertexRuns => row.vertex_runs.map(|runs| runs as f64),
            Self::RunsPerTriangle => row.runs_per_triangle.map(f64::from),
            Self::MeanRunsPerTriangle => row.mean_runs_per_triangle.map(f64::from),
            Self::MostRunsPerTriangle => row.most_runs_per_triangle.map(f64::from),
            Self::Poses => row.poses.map(f64::from),
            Self::PoseShare => row.poses.map(|poses| f64::from(poses) / f64::from(row.visible.max(1))),
            Self::Image => row.image_rmse.map(f64::from),
            Self::Pop => row.pop_rmse.map(f64::from),
            Self::PopPx => row.pop_px.map(f64::from),
            Self::PopEnergy => row.pop_px.map(|px| f64::from(px) * f64::from(px)),
            Self::LevelSteps => row.level_steps.map(|steps| steps.most().into()),
            Self::LevelStepsBeyondNext => row.level_steps.map(|steps| steps.share_beyond_next().into()),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Comparison {
    AtMost,
    Below,
    AtLeast,
    Above,
}

impl Comparison {
    /// The longer ones first, for they begin alike.
    const SIGNS: [(&'static str, Self); 4] =
        [("<=", Self::AtMost), (">=", Self::AtLeast), ("<", Self::Below), (">", Self::Above)];

    fn holds(self, found: f64, limit: f64) -> bool {
        match self {
            Self::AtMost => found <= limit,
            Self::Below => found < limit,
            Self::AtLeast => found >= limit,
            Self::Above => found > limit,
        }
    }
}

/// A condition: a quantity of a technique, or its ratio to another's, against a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    text: String,
    quantity: Quantity,
    variant: Variant,
    than: Option<Variant>,
    comparison: Comparison,
    limit: f64,
}

impl Condition {
    /// Techniques it names, with their switches.
    pub fn variants(&self) -> impl Iterator<Item = Variant> {
        [Some(self.variant), self.than].into_iter().flatten()
    }

    /// Whether it is about what only `--pops` measures.
    pub fn needs_pops(&self) -> bool {
        use Quantity::{LevelSteps, LevelStepsBeyondNext, Pop, PopEnergy, PopPx};
        matches!(self.quantity, Pop | PopPx | PopEnergy | LevelSteps | LevelStepsBeyondNext)
    }

    /// Why the quantity is not measured of one of its techniques, whatever the adapter; `draw`: the switches of the whole bench.
    pub fn unmeasured(&self, draw: DrawOptions) -> Option<String> {
        self.variants().find_map(|variant| {
            let options = variant.options(draw);
            let why = match self.quantity {
                _ if self.needs_pops() && options.occludes() => {
                    "with occlusion culling, levels of the frame before are not kept"
                }
                _ if self.needs_pops() && options.technique == Technique::StaticFloor => {
                    "the floor is baked anew for each frame"
                }
                Quantity::Poses | Quantity::PoseShare if !options.share_poses => "poses are shared with +share alone",
                Quantity::Shadows if options.shadows == 0 => "it draws no shadows: +shadows or --shadows",
                _ => return None,
            };
            Some(format!("{self}: not measured of {variant}: {why}"))
        })
    }

    /// Whose least budget for which other's image has to be found.
    pub fn equal_image(&self) -> Option<(Variant, Variant)> {
        let than = self.than.filter(|_| self.quantity == Quantity::TrianglesAtEqualImage)?;
        Some((self.variant, than))
    }

    /// What was found among the rows of one count, and whether the condition holds. A quantity that was not measured, or a ratio to
    /// nothing, is not a number and holds nothing.
    pub fn judge(&self, rows: &[Row]) -> (f64, bool) {
        let row = |variant: Variant| {
            let name = variant.to_string();
            rows.iter().find(|row| row.technique == name)
        };
        let value = |variant: Variant| self.quantity.of(row(variant)?);
        let as_good = |than: Variant| row(self.variant)?.as_good_as.get(&than.to_string());
        let found = match self.than {
            Some(than) if self.quantity == Quantity::TrianglesAtEqualImage => {
                as_good(than).map(|equal| f64::from(equal.triangles) / f64::from(equal.other_triangles.max(1)))
            }
            None => value(self.variant),
            Some(than) => value(self.variant).zip(value(than)).map(|(a, b)| a / b),
        };
        let found = found.unwrap_or(f64::NAN);
        (found, self.comparison.holds(found, self.limit))
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = |what: &str| format!("found {text:?}: {what}; allowed for example 'bucketed/b0 <= 0.25'");
        let sign = |&(sign, comparison): &(&'static str, Comparison)| Some((text.split_once(sign)?, comparison));
        let ((left, right), comparison) =
            Comparison::SIGNS.iter().find_map(sign).ok_or_else(|| wrong("no <=, <, >= or >"))?;
        let limit: f64 = right.trim().parse().map_err(|_| wrong("no number on the right"))?;
        if left.starts_with("triangles_at_equal_image") && !left.contains('/') {
            return Err(wrong("equal to whose image? A/B"));
        }
        if !limit.is_finite() {
            return Err(wrong("the number is not finite"));
        }
        let (name, of) = left.split_once(':').unwrap_or(("frame_ms", left));
        let known = Quantity::NAMES.iter().find(|(known, _)| *known == name.trim());
        let names = || Quantity::NAMES.map(|(name, _)| name).join(", ");
        let quantity = known.ok_or_else(|| wrong(&format!("no quantity `{}` ({})", name.trim(), names())))?.1;
        let technique = |name: &str| name.trim().parse::<Variant>().map_err(|e| wrong(&e));
        let (variant, than) = match of.split_once('/') {
            Some((a, b)) => (technique(a)?, Some(technique(b)?)),
            None => (technique(of)?, None),
        };
        Ok(Self { text: text.trim().to_owned(), quantity, variant, than, comparison, limit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::rows::EqualImage;
    use crate::stats::Spread;

    fn row(technique: Technique, ms: f32) -> Row {
        let frame_ms = Spread { median: ms, p95: 2.0 * ms, min: ms, max: 3.0 * ms };
        Row { technique: technique.name().to_owned(), frame_ms, triangles: 100, ..Row::default() }
    }

    #[test]
    fn conditions_hold_or_do_not() {
        let rows = [row(Technique::PseudoInstancing, 8.0), row(Technique::Bucketed, 2.0)];
        for (text, found, holds) in [
            ("bucketed/b0 <= 0.25", 0.25, true),
            ("bucketed/b0 < 0.25", 0.25, false),
            (" frame_p95_ms:bucketed/pseudo-instancing>0.2", 0.25, true),
            ("triangles: bucketed >= 101", 100.0, false),
            ("frame_ms:b0 <= 8", 8.0, true),
        ] {
            let condition: Condition = text.parse().unwrap();
            assert_eq!(condition.judge(&rows), (found, holds), "{text}");
        }
    }

    #[test]
    fn triangles_at_equal_images_are_those_of_the_budget_found() {
        let mut rows = [row(Technique::Discrete, 8.0), row(Technique::Bucketed, 2.0)];
        let condition: Condition = "triangles_at_equal_image:bucketed/b2 <= 0.6".parse().unwrap();
        assert!(!condition.judge(&rows).1, "no budget was found");
        let equal = EqualImage { budget: 70, triangles: 55, other_triangles: 100, image_rmse: 0.1 };
        rows[1].as_good_as.insert("discrete".to_owned(), equal);
        assert_eq!(condition.judge(&rows), (0.55, true));
    }

    #[test]
    fn what_was_not_measured_holds_nothing() {
        let rows = [row(Technique::Bucketed, 2.0)];
        for text in ["lod_share:bucketed <= 1", "lod_share:bucketed > 0", "bucketed/b0 <= 9", "bucketed/b0 >= 0"] {
            let (found, holds) = text.parse::<Condition>().unwrap().judge(&rows);
            assert!(found.is_nan() && !holds, "{text}");
        }
    }

    #[test]
    fn nonsense_is_refused_with_the_reason() {
        for (text, word) in [
            ("bucketed/b0", "no <="),
            ("bucketed <= fast", "no number"),
            ("bucketed <= inf", "finite"),
            ("speed:bucketed <= 1", "no quantity"),
            ("b9 <= 1", "b9"),
            ("b0/ <= 1", "found"),
            ("triangles_at_equal_image:bucketed <= 1", "whose"),
        ] {
            let error = text.parse::<Condition>().unwrap_err();
            assert!(error.contains(word) && error.contains("allowed"), "{text}: {error}");
        }
    }
}
