//! gltfpack, the program, where it is on PATH: run until its count fits the target, and read back.

use super::MadeLevel;
use super::contenders::Contender;
use super::subject::{Subject, own_poses};
use crate::error::Cause;
use crate::size::resize;
use crate::views;
use crowd_judge::{Level, SkinnedMesh};
use crowd_source::{Limits, RawCharacter};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Nothing quantised, nothing resampled, all names kept.
const FLAGS: [&str; 13] = ["-noq", "-kn", "-km", "-kv", "-af", "0", "-ar", "16", "-at", "24", "-as", "24", "-tr"];
/// Runs for one level.
const MOST_RUNS: usize = 8;
/// A count not further below the target than this share is near enough.
const NEAR_ENOUGH: f64 = 0.99;

/// What is wrong with gltfpack here; `None` where it answers.
pub(super) fn refusal() -> Option<String> {
    match Command::new("gltfpack").arg("-v").stdin(Stdio::null()).output() {
        Ok(_) => None,
        Err(error) => Some(format!("gltfpack is left out: {error}; `npm install -g gltfpack` brings it")),
    }
}

/// One level: the largest found that is not above the target; the smallest where none is small enough.
pub(super) fn make_level(subject: &Subject, contender: Contender, target: u32) -> Result<Option<MadeLevel>, Cause> {
    let folder = tempfile::tempdir().map_err(|source| Cause::Input { path: std::env::temp_dir(), source })?;
    let input = copy_asset(&subject.path, folder.path())?;
    let output = folder.path().join("level.glb");
    let best = contender == Contender::GltfpackBest;
    let full = subject.raw.mesh.triangles.len() as f64;
    // The knob: the ratio itself, or the error, searched on a logarithmic scale. Larger errors leave fewer triangles.
    let (mut low, mut high) = if best { (1e-5_f64, 1.0_f64) } else { (1e-4, 1.0) };
    let mut knob = if best { 0.02 } else { (f64::from(target) / full).clamp(low, high) };
    let mut kept: Option<(usize, MadeLevel)> = None;
    for _ in 0..MOST_RUNS {
        let started = Instant::now();
        run(&input, &output, best, knob)?;
        let seconds = started.elapsed().as_secs_f64();
        let raw = crowd_source::load_character(&output, &Limits::default());
        let count = raw.as_ref().map_or(0, |raw| raw.mesh.triangles.len());
        let fits = count <= target as usize;
        let better = match &kept {
            None => true,
            Some((kept, _)) if *kept <= target as usize => fits && count > *kept,
            Some((kept, _)) => count < *kept,
        };
        if let Ok(mut raw) = raw
            && better
        {
            // It works on the file as it is.
            subject.size.map(|asked| resize(&mut raw, asked)).transpose()?;
            kept = Some((count, MadeLevel { level: read_back(subject, &raw)?, seconds }));
        }
        if fits && count as f64 >= NEAR_ENOUGH * f64::from(target) {
            break;
        }
        // A ratio that leaves too many must fall, an error that leaves too many must rise.
        if fits == best {
            high = knob
        } else {
            low = knob
        }
        let guess = knob * f64::from(target) / count.max(1) as f64;
        let middle = (low * high).sqrt();
        knob = if !best && guess > low && guess < high { guess } else { middle };
        if high / low < 1.0005 {
            break;
        }
    }
    Ok(kept.map(|(_, level)| level))
}

fn run(input: &Path, output: &Path, best: bool, knob: f64) -> Result<(), Cause> {
    let knob = format!("{knob:.7}");
    let simplify: &[&str] =
        if best { &["-si", "0.0005", "-sv", "-sp", "-se", &knob] } else { &["-si", &knob, "-se", "1"] };
    let mut command = Command::new("gltfpack");
    command.arg("-i").arg(input).arg("-o").arg(output).args(FLAGS).args(simplify);
    let done = command.stdin(Stdio::null()).output();
    let done = done.map_err(|source| Cause::Input { path: PathBuf::from("gltfpack"), source })?;
    if done.status.success() {
        return Ok(());
    }
    let words = String::from_utf8_lossy(&done.stderr).lines().last().unwrap_or_default().to_owned();
    Err(Cause::Input { path: PathBuf::from("gltfpack"), source: std::io::Error::other(words) })
}

/// The asset and the files that it names, in a folder of our own: the program writes beside them.
fn copy_asset(path: &Path, folder: &Path) -> Result<PathBuf, Cause> {
    let fail = |path: &Path, source| Cause::Input { path: path.to_owned(), source };
    let from = path.parent().unwrap_or(Path::new("."));
    let real = from.canonicalize().map_err(|source| fail(from, source))?;
    let copy = |file: &Path, to: &Path| {
        to.parent()
            .map_or(Ok(()), std::fs::create_dir_all)
            .and_then(|()| std::fs::copy(file, to))
            .map_err(|e| fail(file, e))
    };
    for named in crowd_source::named_files(path) {
        if let Ok(relative) = named.strip_prefix(&real) {
            copy(&named, &folder.join(relative))?;
        }
    }
    let input = folder.join(path.file_name().unwrap_or_default());
    copy(path, &input)?;
    Ok(input)
}

/// What came back, with its own joints and clips, and the original's materials by name.
fn read_back(subject: &Subject, raw: &RawCharacter) -> Result<Level, Cause> {
    let material = |m: u16| {
        let name = &raw.materials[usize::from(m)].name;
        let same = subject.raw.materials.iter().position(|material| material.name == *name);
        same.map_or_else(|| m.min(subject.raw.materials.len() as u16 - 1), |place| place as u16)
    };
    let mesh = &raw.mesh;
    let mesh = SkinnedMesh {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        uvs: mesh.uvs.clone(),
        colors: mesh.colors.clone(),
        joints: mesh.joints.clone(),
        weights: mesh.weights.clone(),
        triangles: mesh.triangles.clone(),
        triangle_materials: views::triangle_materials(mesh).into_iter().map(material).collect(),
    };
    Ok(Level { mesh, poses: Some(own_poses(raw, &subject.moments)?) })
}
