//! The meanings: which characters a command line names, and how each is to be baked.

use crate::bake_levels::LevelsAsked;
use crate::cli::{BakeOptions, CriteriaWord, FramesWord, LayoutWord, LevelOptions, StorageWord};
use crate::crowd_toml::{self, Settings};
use crate::error::{BakeError, Cause, Step};
use crate::sample::FrameRate;
use crate::size::SizeAsked;
use crate::store_animation::StorageAsked;
use crowd_lod::{AttributeWeights, Coarsest, Criteria, FrameChoice};
use crowd_pack::{AnimationLayout, JointStorage, ManifestTarget};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Folders below a given one that are looked into: deeper trees are loops or mistakes.
const FOLDER_DEPTH: usize = 32;

/// Share of the triangles that [`Coarsest::Useful`] always reaches.
const ALWAYS_REACHED: f32 = 0.02;
/// Share at which orders that are to reach further end at the latest.
const LOWEST_DEFAULT: f32 = 0.005;

/// What a bake will do.
#[derive(Debug, Default)]
pub struct Plan {
    /// Characters in the order of the pack.
    pub entries: Vec<PlanEntry>,
    /// How matrices are stored.
    pub animation_layout: AnimationLayout,
    /// Texels of an impostor's side; 0 for none.
    pub impostors_px: u32,
    /// Inputs that name no character.
    pub refused: Vec<BakeError>,
    /// What people should know: names made unique, files named twice.
    pub notes: Vec<String>,
    /// The first manifest that says how matrices are stored.
    pub(crate) layout_said_by: Option<PathBuf>,
    /// A later manifest that says otherwise.
    pub(crate) layout_dispute: Option<PlanError>,
    /// Every file read, manifests too: outputs may not be one of them.
    pub inputs: Vec<PathBuf>,
}

/// One character to bake.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanEntry {
    /// The asset.
    pub path: PathBuf,
    /// Unique name in the pack.
    pub name: String,
    /// Frames a second.
    pub fps: FrameRate,
    /// Which collapses are allowed.
    pub criteria: Criteria,
    /// Names or patterns of the clips to keep; `None` for all.
    pub clips: Option<Vec<String>>,
    /// Which frames count.
    pub frames: FrameChoice,
    /// Names or patterns of clips and how much each counts; where several match, their product.
    pub clip_weights: Vec<(String, f32)>,
    /// What a collapse minds beside shape.
    pub attribute_weights: AttributeWeights,
    /// Discrete levels.
    pub levels: LevelsAsked,
    /// How large; `None` for as the file has it.
    pub size: Option<SizeAsked>,
    /// Where the continuous detail ends; `None` where that is useful, see [`PlanEntry::coarsest`].
    pub coarsest: Option<Coarsest>,
    /// How animation is stored.
    pub storage: StorageAsked,
}

impl PlanEntry {
    /// A file with the defaults, named by its stem.
    pub fn of_file(path: &Path) -> Self {
        entry_of(Found { path: path.to_owned(), settings: Settings::default() }, &BakeOptions::default())
    }

    /// Where the order ends: as asked for, or else where Peng's rules end it, or where it stops being useful. A share that a discrete level
    /// asks for stays within reach.
    pub fn coarsest(&self) -> Coarsest {
        let shares = self.levels.targets.iter().filter_map(|target| match target.0 {
            ManifestTarget::Ratio(share) => Some(share),
            _ => None,
        });
        let smallest = shares.fold(1.0, f32::min);
        match self.coarsest {
            Some(asked) => asked,
            None if self.criteria == Criteria::Peng2011 => Coarsest::Last,
            None if smallest < ALWAYS_REACHED => Coarsest::Share(smallest.min(LOWEST_DEFAULT)),
            None => Coarsest::Useful,
        }
    }
}

/// Why an input names no character.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// Nothing there.
    #[error("{0}: no such file or folder, allowed are .glb, .gltf, .obj and .toml files, folders and patterns")]
    NoSuchInput(PathBuf),
    /// A pattern without a match.
    #[error("{0}: the pattern matches no .glb, .gltf or .obj file")]
    NothingMatches(String),
    /// A folder without assets.
    #[error("{0}: no .glb, .gltf or .obj file in it or below it")]
    EmptyFolder(PathBuf),
    /// Neither an asset nor a manifest.
    #[error("{path}: found {found}, allowed .glb, .gltf, .obj, .toml or a folder")]
    UnknownKind {
        /// The file.
        path: PathBuf,
        /// Its ending.
        found: String,
    },
    /// A pattern that cannot be read.
    #[error("{pattern}: {source}")]
    Pattern {
        /// The pattern.
        pattern: String,
        /// What is wrong with it.
        source: glob::PatternError,
    },
    /// A manifest is wrong.
    #[error("{path}: {key}: {problem}")]
    Config {
        /// The manifest.
        path: PathBuf,
        /// Where, as in `characters[1].clips`.
        key: String,
        /// Found and allowed.
        problem: String,
    },
    /// Reading failed.
    #[error("{path}: {source}")]
    Io {
        /// File or folder.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
}

/// A file on its way to an entry.
struct Found {
    path: PathBuf,
    settings: Settings,
}

/// Expands inputs to characters. Never fails: what names no character is in [`Plan::refused`].
pub fn make_plan(inputs: &[PathBuf], options: &BakeOptions, layout: Option<LayoutWord>) -> Plan {
    let mut plan = Plan::default();
    let mut found = Vec::new();
    for input in inputs {
        match expand(input, &mut plan) {
            Ok(files) => found.extend(files),
            Err(cause) => plan.refused.push(BakeError::whole(Step::Plan, Cause::Plan(cause))),
        }
    }
    drop_repeated(&mut found, &mut plan.notes);
    plan.inputs.extend(found.iter().map(|file| file.path.clone()));
    plan.entries = found.into_iter().map(|file| entry_of(file, options)).collect();
    make_names_unique(&mut plan);
    if let Some(layout) = layout {
        plan.animation_layout = match layout {
            LayoutWord::Premultiplied3x4 => AnimationLayout::Premultiplied3x4,
            LayoutWord::Split4x4 => AnimationLayout::Split4x4,
        };
    } else if let Some(dispute) = plan.layout_dispute.take() {
        plan.refused.push(BakeError::whole(Step::Plan, Cause::Plan(dispute)));
        plan.entries.clear();
    }
    store_as_papers(&mut plan);
    plan
}

/// The papers' layout has full floats of every frame.
fn store_as_papers(plan: &mut Plan) {
    if plan.animation_layout != AnimationLayout::Split4x4 {
        return;
    }
    for entry in &mut plan.entries {
        let other_storage = entry.storage.storage.is_some_and(|storage| storage != JointStorage::F32);
        let other_error = entry.storage.error_share != StorageAsked::default().error_share;
        for (asked, what) in [(other_storage, "animation_storage"), (other_error, "animation_error")] {
            if asked {
                let name = &entry.name;
                plan.notes.push(format!("{name}: the 4x4 layout holds floats of all frames, {what} says nothing"));
            }
        }
        entry.storage = StorageAsked::papers();
    }
}

impl Plan {
    /// Lets the command line say which discrete levels to store: its targets win over those of manifests, and `--refit` adds.
    pub fn ask_for_levels(&mut self, options: &LevelOptions) {
        let targets: Vec<_> =
            [&options.lod_ratio, &options.error, &options.px].into_iter().flatten().copied().collect();
        for entry in &mut self.entries {
            if !targets.is_empty() {
                entry.levels.targets.clone_from(&targets);
            }
            entry.levels.refit |= options.refit;
        }
    }
}

/// The name of criteria in manifests, packs and reports.
pub fn criteria_name(criteria: Criteria) -> &'static str {
    match criteria {
        Criteria::Wedge => "wedge",
        Criteria::Peng2011 => "peng2011",
    }
}

/// The name of a choice of frames in manifests and reports.
pub fn frames_name(frames: FrameChoice) -> &'static str {
    match frames {
        FrameChoice::Auto => "auto",
        FrameChoice::All => "all",
        FrameChoice::Bind => "bind",
    }
}

fn expand(input: &Path, plan: &mut Plan) -> Result<Vec<Found>, PlanError> {
    let plain = |path| Found { path, settings: Settings::default() };
    if input.is_dir() {
        let mut files = Vec::new();
        walk(input, FOLDER_DEPTH, &mut files)?;
        if files.is_empty() {
            return Err(PlanError::EmptyFolder(input.to_owned()));
        }
        return Ok(files.into_iter().map(plain).collect());
    }
    if input.exists() {
        return match ending(input).as_str() {
            "toml" => expand_manifest(input, plan),
            "glb" | "gltf" | "obj" => Ok(vec![plain(input.to_owned())]),
            other => {
                let found = if other.is_empty() { "no ending".to_owned() } else { format!(".{other}") };
                Err(PlanError::UnknownKind { path: input.to_owned(), found })
            }
        };
    }
    let pattern = input.to_string_lossy();
    if !pattern.contains(['*', '?', '[']) {
        return Err(PlanError::NoSuchInput(input.to_owned()));
    }
    let matches = glob::glob(&pattern)
        .map_err(|source| PlanError::Pattern { pattern: pattern.to_string(), source })?
        .filter_map(Result::ok);
    let mut files: Vec<PathBuf> = matches.filter(|path| is_asset(path) && path.is_file()).collect();
    files.sort();
    if files.is_empty() {
        return Err(PlanError::NothingMatches(pattern.to_string()));
    }
    Ok(files.into_iter().map(plain).collect())
}

fn expand_manifest(path: &Path, plan: &mut Plan) -> Result<Vec<Found>, PlanError> {
    let io = |source| PlanError::Io { path: path.to_owned(), source };
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return Err(io(std::io::Error::new(std::io::ErrorKind::InvalidInput, "is no plain file")));
    }
    let text = std::fs::read_to_string(path).map_err(io)?;
    let manifest = crowd_toml::read(&text).map_err(|wrong| PlanError::Config {
        path: path.to_owned(),
        key: wrong.key,
        problem: wrong.problem,
    })?;
    plan.inputs.push(path.to_owned());
    if let Some(layout) = manifest.animation_layout {
        match &plan.layout_said_by {
            Some(first) if plan.animation_layout != layout => {
                let problem = format!(
                    "found another layout than in {}, and a pack has one: leave one out, or say it with --animation-layout",
                    first.display()
                );
                let key = "pack.animation_layout".to_owned();
                plan.layout_dispute.get_or_insert(PlanError::Config { path: path.to_owned(), key, problem });
            }
            Some(_) => {}
            None => {
                plan.animation_layout = layout;
                plan.layout_said_by = Some(path.to_owned());
            }
        }
    }
    plan.impostors_px = plan.impostors_px.max(manifest.impostors_px.unwrap_or(0));
    let folder = path.parent().unwrap_or(Path::new(""));
    let characters = manifest.characters.into_iter();
    Ok(characters.map(|(source, settings)| Found { path: folder.join(source), settings }).collect())
}

/// All assets below a folder, in order of their paths. Links to folders are not followed: they may form loops.
fn walk(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) -> Result<(), PlanError> {
    let fail = |source| PlanError::Io { path: folder.to_owned(), source };
    let mut items = std::fs::read_dir(folder)
        .and_then(|items| items.map(|item| item.map(|item| item.path())).collect::<Result<Vec<_>, _>>())
        .map_err(fail)?;
    items.sort();
    for item in items {
        if item.is_dir() {
            if depth > 0 && !item.is_symlink() {
                walk(&item, depth - 1, files)?;
            }
        } else if is_asset(&item) {
            files.push(item);
        }
    }
    Ok(())
}

fn is_asset(path: &Path) -> bool {
    matches!(ending(path).as_str(), "glb" | "gltf" | "obj")
}

fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// A file that two inputs name is baked once, unless a manifest gives it settings of its own.
fn drop_repeated(found: &mut Vec<Found>, notes: &mut Vec<String>) {
    let mut seen = BTreeSet::new();
    found.retain(|file| {
        if file.settings != Settings::default() {
            return true;
        }
        let real = file.path.canonicalize().unwrap_or_else(|_| file.path.clone());
        let first = seen.insert(real);
        if !first {
            notes.push(format!("{}: named twice, baked once", file.path.display()));
        }
        first
    });
}

/// The command line wins over the manifest's entry, which already holds the manifest's defaults.
fn entry_of(found: Found, options: &BakeOptions) -> PlanEntry {
    let stem = found.path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let criteria = options.criteria.map(|word| match word {
        CriteriaWord::Wedge => Criteria::Wedge,
        CriteriaWord::Peng2011 => Criteria::Peng2011,
    });
    let frames = options.frames.map(|word| match word {
        FramesWord::Auto => FrameChoice::Auto,
        FramesWord::All => FrameChoice::All,
        FramesWord::Bind => FrameChoice::Bind,
    });
    let clip_weights = (!options.clip_weight.is_empty()).then(|| options.clip_weight.clone());
    let mut attribute_weights = found.settings.attribute_weights.unwrap_or_default();
    for (name, weight) in &options.attribute_weight {
        crate::cli::weigh_attribute(&mut attribute_weights, name, *weight);
    }
    PlanEntry {
        attribute_weights,
        name: found.settings.name.or(stem).unwrap_or_else(|| "character".to_owned()),
        fps: options.fps.or(found.settings.fps).unwrap_or_default(),
        criteria: criteria.or(found.settings.criteria).unwrap_or_default(),
        clips: options.clips.clone().or(found.settings.clips),
        frames: frames.or(found.settings.frames).unwrap_or_default(),
        clip_weights: clip_weights.or(found.settings.clip_weights).unwrap_or_default(),
        size: options.size().or(found.settings.size),
        coarsest: options.coarsest.or(found.settings.coarsest),
        storage: StorageAsked {
            storage: options.animation_storage.or(found.settings.animation_storage).and_then(StorageWord::storage),
            error_share: options
                .animation_error
                .or(found.settings.animation_error)
                .unwrap_or(StorageAsked::default().error_share),
            ..StorageAsked::default()
        },
        levels: LevelsAsked {
            targets: found.settings.lods.unwrap_or_default(),
            refit: found.settings.refit.unwrap_or_default(),
        },
        path: found.path,
    }
}

/// The second `knight` becomes `knight-2`, said aloud.
fn make_names_unique(plan: &mut Plan) {
    let mut taken: BTreeSet<String> = BTreeSet::new();
    let all: BTreeSet<String> = plan.entries.iter().map(|entry| entry.name.clone()).collect();
    for entry in &mut plan.entries {
        if taken.insert(entry.name.clone()) {
            continue;
        }
        let free = (2_u32..)
            .map(|number| format!("{}-{number}", entry.name))
            .find(|name| !taken.contains(name) && !all.contains(name))
            .expect("there are more numbers than characters");
        plan.notes.push(format!("{}: the name `{}` is taken, baked as `{free}`", entry.path.display(), entry.name));
        taken.insert(free.clone());
        entry.name = free;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lod_target::LodTarget;

    fn folder_with(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for file in files {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, b"").unwrap();
        }
        folder
    }

    fn names(plan: &Plan) -> Vec<&str> {
        plan.entries.iter().map(|entry| entry.name.as_str()).collect()
    }

    #[test]
    fn a_folder_is_walked_in_order_and_names_are_made_unique() {
        let folder = folder_with(&["b/knight.glb", "a/knight.gltf", "a/knight.bin", "c.OBJ", "knight-2.glb"]);
        let plan = make_plan(&[folder.path().to_owned()], &BakeOptions::default(), None);
        assert_eq!(names(&plan), ["knight", "knight-3", "c", "knight-2"]);
        assert_eq!(plan.notes.len(), 1);
        assert!(plan.refused.is_empty());
    }

    #[test]
    fn patterns_match_assets_only_and_a_repeated_file_is_baked_once() {
        let folder = folder_with(&["a.glb", "b.glb", "b.png"]);
        let pattern = folder.path().join("*");
        let plan = make_plan(&[pattern, folder.path().join("a.glb")], &BakeOptions::default(), None);
        assert_eq!(names(&plan), ["a", "b"]);
        assert!(plan.notes[0].contains("named twice"), "{:?}", plan.notes);
    }

    #[test]
    fn each_wrong_input_is_refused_by_itself() {
        let folder = folder_with(&["a.glb", "readme.txt", "empty/x.png"]);
        let at = |name: &str| folder.path().join(name);
        let inputs = [at("gone.glb"), at("readme.txt"), at("empty"), at("*.obj"), at("a.glb")];
        let plan = make_plan(&inputs, &BakeOptions::default(), None);
        assert_eq!(names(&plan), ["a"]);
        let words: Vec<String> = plan.refused.iter().map(ToString::to_string).collect();
        for (line, part) in words.iter().zip(["no such file", "found .txt", "no .glb", "matches no"]) {
            assert!(line.starts_with("plan: ") && line.contains(part), "{line}");
        }
        assert_eq!(words.len(), 4);
    }

    #[test]
    fn an_order_reaches_what_a_discrete_level_asks_for() {
        let mut entry = PlanEntry::of_file(Path::new("a.glb"));
        assert_eq!(entry.coarsest(), Coarsest::Useful);
        let ask = |share: &str| vec![LodTarget::parse_ratio(share).unwrap()];
        for (share, coarsest) in
            [("2%", Coarsest::Useful), ("1%", Coarsest::Share(0.005)), ("0.1%", Coarsest::Share(0.001))]
        {
            entry.levels.targets = ask(share);
            assert_eq!(entry.coarsest(), coarsest, "{share}");
        }
        entry.criteria = Criteria::Peng2011;
        assert_eq!(entry.coarsest(), Coarsest::Last);
        entry.coarsest = Some(Coarsest::Triangles(40));
        assert_eq!(entry.coarsest(), Coarsest::Triangles(40));
    }

    #[test]
    fn manifests_that_ask_for_two_layouts_are_refused_unless_the_command_line_settles_it() {
        let folder = folder_with(&["a.glb", "b.glb", "c.glb"]);
        let manifest = |file: &str, layout: &str| {
            let pack =
                if layout.is_empty() { String::new() } else { format!("[pack]\nanimation_layout = '{layout}'\n") };
            let path = folder.path().join(format!("{file}.toml"));
            std::fs::write(&path, format!("{pack}[[characters]]\nsource = '{file}.glb'\n")).unwrap();
            path
        };
        let (a, b, c) = (manifest("a", "4x4"), manifest("b", "3x4"), manifest("c", ""));
        let plan = make_plan(&[a.clone(), c.clone(), b.clone()], &BakeOptions::default(), None);
        let words = plan.refused[0].to_string();
        assert!(words.contains("b.toml: pack.animation_layout") && words.contains("a.toml"), "{words}");
        assert!(plan.entries.is_empty() && plan.refused.len() == 1);
        let settled = make_plan(&[a.clone(), b], &BakeOptions::default(), Some(LayoutWord::Premultiplied3x4));
        assert_eq!((settled.animation_layout, settled.entries.len()), (AnimationLayout::Premultiplied3x4, 2));
        let alike = make_plan(&[a, c], &BakeOptions::default(), None);
        assert_eq!((alike.animation_layout, alike.refused.len()), (AnimationLayout::Split4x4, 0));
    }

    #[test]
    fn the_command_line_wins_over_the_entry_and_the_entry_over_the_defaults() {
        let folder = folder_with(&["a.glb", "b.glb"]);
        let text = "[defaults]\nfps = 20\nclips = ['x']\n[[characters]]\nsource = 'a.glb'\nname = 'first'\nfps = 24\n\
                    criteria = 'peng2011'\n[[characters]]\nsource = 'b.glb'\n";
        std::fs::write(folder.path().join("crowd.toml"), text).unwrap();
        let inputs = [folder.path().join("crowd.toml")];
        let plan = make_plan(&inputs, &BakeOptions::default(), None);
        assert_eq!(names(&plan), ["first", "b"]);
        assert_eq!((plan.entries[0].fps, plan.entries[1].fps), (FrameRate::Fixed(24.0), FrameRate::Fixed(20.0)));
        assert_eq!(plan.entries[0].criteria, Criteria::Peng2011);
        assert_eq!(plan.entries[1].clips.as_deref(), Some(&["x".to_owned()][..]));
        let options = BakeOptions { fps: Some(FrameRate::Auto), ..BakeOptions::default() };
        assert!(make_plan(&inputs, &options, None).entries.iter().all(|entry| entry.fps == FrameRate::Auto));
    }
}
