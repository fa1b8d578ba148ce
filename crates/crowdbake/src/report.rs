//! What a bake did, as JSON: steps and their seconds, counts before and after, warnings. Schema 2.

use crate::assemble::manifest_measured;
use crate::bake::{BakedCharacter, StepTime};
use crate::bake_levels::BakedLevel;
use crate::error::BakeError;
use crate::inspect::{AnimationInspection, DiscreteInspection, MeasuredInspection, inspect_measured};
use crate::plan::{Plan, PlanEntry, criteria_name, frames_name};
use crowd_pack::JointStorage;
use serde::Serialize;

/// Version of every JSON document this program prints; a change that could break a reader raises it.
pub const SCHEMA_VERSION: u32 = 2;

/// The report of a bake.
#[derive(Debug, Serialize)]
pub struct Report {
    /// [`SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Program and version.
    pub generator: String,
    /// The verb: `bake`.
    pub command: &'static str,
    /// The pack, when one was written.
    pub pack: Option<PackReport>,
    /// One entry a character of the plan, in the pack's order, refused ones too.
    pub characters: Vec<CharacterReport>,
    /// Inputs that named no character.
    pub refused_inputs: Vec<String>,
    /// Wall-clock seconds of the whole run.
    pub seconds: f64,
    /// Threads.
    pub jobs: usize,
    /// The exit code of the run.
    pub exit_code: u8,
}

/// The file written.
#[derive(Debug, Serialize)]
pub struct PackReport {
    /// Its path as given.
    pub path: String,
    /// Bytes.
    pub bytes: u64,
    /// Name and bytes of each section, in file order.
    pub sections: Vec<SectionReport>,
}

/// A section of the file.
#[derive(Debug, Serialize)]
pub struct SectionReport {
    /// Name.
    pub name: String,
    /// Bytes.
    pub bytes: u64,
}

/// One character.
#[derive(Debug, Serialize)]
pub struct CharacterReport {
    /// Name in the pack.
    pub name: String,
    /// The asset.
    pub source: String,
    /// `baked` or `refused`.
    pub status: &'static str,
    /// Why it was refused.
    pub error: Option<String>,
    /// Criteria of the order.
    pub criteria: &'static str,
    /// Frames a second asked for; null for each clip at the rate of its keys.
    pub fps: Option<f32>,
    /// Seconds of each step.
    pub steps: Vec<StepTime>,
    /// As found in the file.
    pub before: Option<Counts>,
    /// The coarsest level: what the continuous detail reaches down to.
    pub after: Option<Counts>,
    /// Vertices after splitting along seams: full detail in the pack.
    pub full_detail: Option<Counts>,
    /// Joints, clips, frames.
    pub animation: Option<AnimationCounts>,
    /// Which frames counted, and how well they stood for all.
    pub frames: FramesReport,
    /// Quantised levels, coarsest first.
    pub measured: Vec<MeasuredInspection>,
    /// Discrete levels, finest first.
    pub discrete: Vec<DiscreteInspection>,
    /// Positions that cannot move at the coarsest level, by what holds them.
    pub blocked: Option<BlockedReport>,
    /// Import and bake warnings.
    pub warnings: Vec<WarningReport>,
}

/// Sizes of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Vertices.
    pub vertices: u32,
    /// Triangles.
    pub triangles: u32,
}

/// Sizes of the animation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnimationCounts {
    /// Matrices a frame.
    pub joints: u32,
    /// Clips.
    pub clips: u32,
    /// How they are stored.
    #[serde(flatten)]
    pub stored: AnimationInspection,
    /// What was allowed, metres.
    pub allowed_m: f32,
    /// Smaller storages that would have been off by more than allowed.
    pub passed_over: Vec<PassedOverReport>,
}

/// A storage that a character's matrices do not fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PassedOverReport {
    /// Which.
    pub storage: &'static str,
    /// How far a vertex would be off, metres.
    pub error_m: f32,
    /// In which clip.
    pub clip: String,
}

/// Which frames the error was averaged over.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FramesReport {
    /// `auto`, `all` or `bind`.
    pub choice: &'static str,
    /// Frames that counted; 0 for the bind pose alone.
    pub used: u32,
    /// Times frames were added because the check failed.
    pub reruns: u32,
    /// How far the mean error over these frames lies off that over all, as a share; null where all counted.
    pub deviation: Option<f32>,
    /// Error of the worst of all frames over that of the worst of these; null where all counted.
    pub worst_ratio: Option<f32>,
    /// Whether both lie within what is allowed; null where all counted.
    pub holds: Option<bool>,
}

/// Positions that cannot move at the coarsest level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct BlockedReport {
    /// On an open border or of class fixed.
    pub fixed: u32,
    /// On a seam without a partner.
    pub seam: u32,
    /// Link condition.
    pub topology: u32,
    /// Flipped triangle.
    pub flip: u32,
    /// Could still move: the detail was ended before.
    pub ended: u32,
}

/// A warning.
#[derive(Debug, Serialize)]
pub struct WarningReport {
    /// Stable name.
    pub code: &'static str,
    /// Where.
    pub place: String,
    /// How many things it happened to.
    pub count: u64,
    /// A sentence for people.
    pub message: String,
}

impl CharacterReport {
    /// What became of an entry of the plan.
    pub fn new(entry: &PlanEntry, result: &Result<BakedCharacter, BakeError>) -> Self {
        let mut report = Self {
            name: entry.name.clone(),
            source: entry.path.to_string_lossy().into_owned(),
            status: "refused",
            error: None,
            criteria: criteria_name(entry.criteria),
            fps: Some(entry.fps.code()).filter(|fps| *fps > 0.0),
            steps: Vec::new(),
            before: None,
            after: None,
            full_detail: None,
            animation: None,
            frames: FramesReport {
                choice: frames_name(entry.frames),
                used: 0,
                reruns: 0,
                deviation: None,
                worst_ratio: None,
                holds: None,
            },
            measured: Vec::new(),
            discrete: Vec::new(),
            blocked: None,
            warnings: Vec::new(),
        };
        match result {
            Err(error) => report.error = Some(error.to_string()),
            Ok(baked) => report.fill(baked),
        }
        report
    }

    fn fill(&mut self, baked: &BakedCharacter) {
        let (order, animation) = (&baked.order, &baked.animation);
        let passed_over = |(storage, error_m, clip): &(JointStorage, f32, String)| PassedOverReport {
            storage: storage.name(),
            error_m: *error_m,
            clip: clip.clone(),
        };
        let of_level = |level: Option<&crowd_lod::Level>| {
            level.map(|level| Counts { vertices: level.vertex_count, triangles: level.triangle_count })
        };
        self.status = "baked";
        self.steps = baked.steps.clone();
        self.before = Some(Counts {
            vertices: baked.raw.mesh.positions.len() as u32,
            triangles: baked.raw.mesh.triangles.len() as u32,
        });
        self.full_detail = of_level(order.levels.last());
        self.after = of_level(order.levels.first());
        self.animation = Some(AnimationCounts {
            joints: baked.raw.joints.len() as u32,
            clips: animation.clips.len() as u32,
            stored: AnimationInspection::of_bake(baked),
            allowed_m: animation.allowed_m,
            passed_over: animation.passed_over.iter().map(passed_over).collect(),
        });
        self.frames = FramesReport {
            choice: self.frames.choice,
            used: order.frames.used,
            reruns: order.frames.rerun_count,
            deviation: order.frames.check.map(|check| check.deviation),
            worst_ratio: order.frames.check.map(|check| check.worst_ratio),
            holds: order.frames.check.map(|check| check.holds),
        };
        let measured = |level: &BakedLevel| {
            let measured = manifest_measured(baked, level);
            let clip = animation.clips.get(measured.max_clip as usize).map(|clip| clip.name.as_str());
            inspect_measured(&measured, clip)
        };
        self.measured = baked.levels.quantized.iter().map(measured).collect();
        let discrete = baked.levels.discrete.iter().map(|discrete| DiscreteInspection {
            name: discrete.name.clone(),
            target: discrete.target.words(),
            reached: discrete.reached,
            refitted: discrete.level.own.is_some(),
            measured: measured(&discrete.level),
        });
        self.discrete = discrete.collect();
        self.blocked = Some(BlockedReport {
            fixed: order.blocked.fixed,
            seam: order.blocked.seam,
            topology: order.blocked.topology,
            flip: order.blocked.flip,
            ended: order.blocked.ended,
        });
        let warnings = baked.warnings.iter().map(|warning| WarningReport {
            code: warning.code,
            place: warning.place.clone(),
            count: warning.count,
            message: warning.message.clone(),
        });
        self.warnings = warnings.collect();
    }
}

/// Inputs that named no character, as sentences.
pub fn refused_inputs(plan: &Plan) -> Vec<String> {
    plan.refused.iter().map(ToString::to_string).collect()
}

/// A document as indented JSON with a line end.
pub fn to_json(document: &impl Serialize) -> String {
    // Maps with text keys and finite or null numbers: serialisation has nothing to fail on.
    serde_json::to_string_pretty(document).map(|json| json + "\n").unwrap_or_default()
}
