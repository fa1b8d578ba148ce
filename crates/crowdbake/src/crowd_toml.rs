//! Reads and writes `crowd.toml`. Every complaint names its path, as in `characters[1].clips`.

use crate::cli::{MOST_CLIP_WEIGHT, StorageWord, parse_animation_error, parse_size_number, weigh_attribute};
use crate::lod_target::{LodTarget, coarsest_words, parse_coarsest};
use crate::plan::{Plan, PlanEntry, criteria_name, frames_name};
use crate::sample::FrameRate;
use crate::size::SizeAsked;
use crate::store_animation::StorageAsked;
use clap::ValueEnum;
use crowd_lod::{AttributeWeights, Coarsest, Criteria, FrameChoice};
use crowd_pack::{AnimationLayout, ManifestTarget};
use std::path::PathBuf;
use toml::{Table, Value};

/// What a manifest says about one character; `None` where it says nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Settings {
    /// Name in the pack.
    pub name: Option<String>,
    /// Frames a second.
    pub fps: Option<FrameRate>,
    /// Which collapses are allowed.
    pub criteria: Option<Criteria>,
    /// Clips to keep.
    pub clips: Option<Vec<String>>,
    /// Which frames count.
    pub frames: Option<FrameChoice>,
    /// How much clips count.
    pub clip_weights: Option<Vec<(String, f32)>>,
    /// What a collapse minds beside shape.
    pub attribute_weights: Option<AttributeWeights>,
    /// Discrete levels.
    pub lods: Option<Vec<LodTarget>>,
    /// Move their vertices.
    pub refit: Option<bool>,
    /// How large.
    pub size: Option<SizeAsked>,
    /// Where the continuous detail ends.
    pub coarsest: Option<Coarsest>,
    /// How joints are stored.
    pub animation_storage: Option<StorageWord>,
    /// What vertices may be off by for it, as a share of the height.
    pub animation_error: Option<f32>,
}

/// A manifest.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CrowdToml {
    /// How matrices are stored.
    pub animation_layout: Option<AnimationLayout>,
    /// Texels of an impostor's side; 0 for none.
    pub impostors_px: Option<u32>,
    /// Source (relative to the manifest) and settings of each character, the defaults filled in.
    pub characters: Vec<(PathBuf, Settings)>,
}

/// What is wrong and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// As in `characters[1].clips`.
    pub key: String,
    /// Found and allowed.
    pub problem: String,
}

fn wrong<T>(key: impl Into<String>, problem: impl Into<String>) -> Result<T, Wrong> {
    Err(Wrong { key: key.into(), problem: problem.into() })
}

/// Keys that `[defaults]` and `[[characters]]` share.
const SETTINGS: [&str; 15] = [
    "fps",
    "criteria",
    "clips",
    "frames",
    "clip_weights",
    "attribute_weights",
    "lod_ratio",
    "error",
    "px",
    "refit",
    "coarsest",
    "animation_storage",
    "animation_error",
    "scale",
    "height",
];

/// Reads a manifest's text.
pub fn read(text: &str) -> Result<CrowdToml, Wrong> {
    let table: Table = text.parse().or_else(|error: toml::de::Error| {
        let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
        wrong(format!("line {line}"), error.message().to_owned())
    })?;
    expect_keys(&table, "", &["pack", "defaults", "characters"])?;
    let defaults = match table.get("defaults") {
        None => Settings::default(),
        Some(value) => {
            let defaults = expect_table(value, "defaults")?;
            expect_keys(defaults, "defaults.", &SETTINGS)?;
            read_settings(defaults, "defaults")?
        }
    };
    let Some(characters) = table.get("characters") else {
        return wrong("characters", "missing, at least one [[characters]] is needed");
    };
    let Value::Array(characters) = characters else {
        return wrong("characters", format!("found {}, allowed [[characters]] tables", kind(characters)));
    };
    let mut read = CrowdToml {
        animation_layout: read_layout(&table)?,
        impostors_px: read_impostors(&table)?,
        characters: Vec::new(),
    };
    for (index, value) in characters.iter().enumerate() {
        let key = format!("characters[{index}]");
        let character = expect_table(value, &key)?;
        expect_keys(character, &format!("{key}."), &[&["source", "name"], &SETTINGS[..]].concat())?;
        let Some(source) = read_text(character, &key, "source")? else {
            return wrong(format!("{key}.source"), "missing, the path of a .glb, .gltf or .obj file is needed");
        };
        let settings = read_settings(character, &key)?;
        if let Some(name) = &settings.name {
            let first = read.characters.iter().position(|(_, earlier)| earlier.name.as_ref() == Some(name));
            if let Some(first) = first {
                return wrong(format!("{key}.name"), format!("`{name}` is the name of characters[{first}] already"));
            }
        }
        let settings = Settings {
            name: settings.name,
            fps: settings.fps.or(defaults.fps),
            criteria: settings.criteria.or(defaults.criteria),
            clips: settings.clips.or_else(|| defaults.clips.clone()),
            frames: settings.frames.or(defaults.frames),
            clip_weights: settings.clip_weights.or_else(|| defaults.clip_weights.clone()),
            attribute_weights: settings.attribute_weights.or(defaults.attribute_weights),
            lods: settings.lods.or_else(|| defaults.lods.clone()),
            refit: settings.refit.or(defaults.refit),
            size: settings.size.or(defaults.size),
            coarsest: settings.coarsest.or(defaults.coarsest),
            animation_storage: settings.animation_storage.or(defaults.animation_storage),
            animation_error: settings.animation_error.or(defaults.animation_error),
        };
        read.characters.push((PathBuf::from(source), settings));
    }
    if read.characters.is_empty() {
        return wrong("characters", "found none, at least one is needed");
    }
    Ok(read)
}

fn read_layout(table: &Table) -> Result<Option<AnimationLayout>, Wrong> {
    let Some(pack) = table.get("pack") else { return Ok(None) };
    let pack = expect_table(pack, "pack")?;
    expect_keys(pack, "pack.", &["animation_layout", "impostors"])?;
    match read_text(pack, "pack", "animation_layout")?.as_deref() {
        None => Ok(None),
        Some("3x4") => Ok(Some(AnimationLayout::Premultiplied3x4)),
        Some("4x4") => Ok(Some(AnimationLayout::Split4x4)),
        Some(other) => wrong("pack.animation_layout", format!("found \"{other}\", allowed \"3x4\" or \"4x4\"")),
    }
}

fn read_impostors(table: &Table) -> Result<Option<u32>, Wrong> {
    let Some(value) = table.get("pack").and_then(|pack| pack.get("impostors")) else { return Ok(None) };
    crate::cli::parse_impostors(&value.to_string()).map(Some).or_else(|problem| wrong("pack.impostors", problem))
}

fn read_settings(table: &Table, key: &str) -> Result<Settings, Wrong> {
    let criteria = match read_text(table, key, "criteria")?.as_deref() {
        None => None,
        Some("wedge") => Some(Criteria::Wedge),
        Some("peng2011") => Some(Criteria::Peng2011),
        Some(other) => {
            let problem = format!("found \"{other}\", allowed \"wedge\" or \"peng2011\"");
            return wrong(format!("{key}.criteria"), problem);
        }
    };
    let fps = match table.get("fps") {
        None => None,
        Some(Value::Integer(fps)) if (1..=240).contains(fps) => Some(FrameRate::Fixed(*fps as f32)),
        Some(Value::Float(fps)) if (1.0..=240.0).contains(fps) => Some(FrameRate::Fixed(*fps as f32)),
        Some(Value::String(word)) if word == "auto" => Some(FrameRate::Auto),
        Some(other) => {
            return wrong(format!("{key}.fps"), format!("found {other}, allowed a number from 1 to 240, or \"auto\""));
        }
    };
    let frames = match read_text(table, key, "frames")?.as_deref() {
        None => None,
        Some("auto") => Some(FrameChoice::Auto),
        Some("all") => Some(FrameChoice::All),
        Some("bind") => Some(FrameChoice::Bind),
        Some(other) => {
            return wrong(format!("{key}.frames"), format!("found \"{other}\", allowed \"auto\", \"all\" or \"bind\""));
        }
    };
    let (name, clips) = (read_text(table, key, "name")?, read_clips(table, key)?);
    let refit = match table.get("refit") {
        None => None,
        Some(Value::Boolean(refit)) => Some(*refit),
        Some(other) => return wrong(format!("{key}.refit"), format!("found {other}, allowed true or false")),
    };
    let (clip_weights, lods) = (read_clip_weights(table, key)?, read_lods(table, key)?);
    let attribute_weights = read_attribute_weights(table, key)?;
    let (size, coarsest) = (read_size(table, key)?, read_coarsest(table, key)?);
    let (animation_storage, animation_error) = (read_storage(table, key)?, read_animation_error(table, key)?);
    Ok(Settings {
        name,
        fps,
        criteria,
        clips,
        frames,
        clip_weights,
        attribute_weights,
        lods,
        refit,
        size,
        coarsest,
        animation_storage,
        animation_error,
    })
}

fn read_storage(table: &Table, key: &str) -> Result<Option<StorageWord>, Wrong> {
    let Some(word) = read_text(table, key, "animation_storage")? else { return Ok(None) };
    StorageWord::from_str(&word, false).map(Some).or_else(|_| {
        let problem = format!("found \"{word}\", allowed \"auto\", \"f32\", \"f16\" or \"quantized\"");
        wrong(format!("{key}.animation_storage"), problem)
    })
}

/// A number of percent, or a word as on the command line.
fn read_animation_error(table: &Table, key: &str) -> Result<Option<f32>, Wrong> {
    let text = match table.get("animation_error") {
        None => return Ok(None),
        Some(Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
    };
    parse_animation_error(&text).map(Some).or_else(|problem| wrong(format!("{key}.animation_error"), problem))
}

/// `scale` or `height`, not both.
fn read_size(table: &Table, key: &str) -> Result<Option<SizeAsked>, Wrong> {
    let number = |field: &str| {
        let Some(value) = table.get(field) else { return Ok(None) };
        parse_size_number(&value.to_string()).map(Some).or_else(|problem| wrong(format!("{key}.{field}"), problem))
    };
    match (number("scale")?, number("height")?) {
        (Some(_), Some(_)) => wrong(format!("{key}.height"), "found beside scale, allowed one of the two"),
        (factor, height) => Ok(factor.map(SizeAsked::Factor).or(height.map(SizeAsked::HeightM))),
    }
}

/// A number of triangles, or a word as on the command line.
fn read_coarsest(table: &Table, key: &str) -> Result<Option<Coarsest>, Wrong> {
    let text = match table.get("coarsest") {
        None => return Ok(None),
        Some(Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
    };
    parse_coarsest(&text).map(Some).or_else(|problem| wrong(format!("{key}.coarsest"), problem))
}

/// Discrete levels: `lod_ratio`, then `error`, then `px`, each a list of numbers or of words as on the command line.
fn read_lods(table: &Table, key: &str) -> Result<Option<Vec<LodTarget>>, Wrong> {
    type Parse = fn(&str) -> Result<LodTarget, String>;
    let fields: [(&str, Parse); 3] =
        [("lod_ratio", LodTarget::parse_ratio), ("error", LodTarget::parse_error), ("px", LodTarget::parse_pixels)];
    let (mut targets, mut any) = (Vec::new(), false);
    for (field, parse) in fields {
        let Some(value) = table.get(field) else { continue };
        any = true;
        let Value::Array(items) = value else {
            return wrong(format!("{key}.{field}"), format!("found {}, allowed a list", kind(value)));
        };
        for (index, item) in items.iter().enumerate() {
            let text = match item {
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            let target = parse(&text).or_else(|problem| wrong(format!("{key}.{field}[{index}]"), problem))?;
            targets.push(target);
        }
    }
    Ok(any.then_some(targets))
}

fn read_clip_weights(table: &Table, key: &str) -> Result<Option<Vec<(String, f32)>>, Wrong> {
    let Some(value) = table.get("clip_weights") else { return Ok(None) };
    let key = format!("{key}.clip_weights");
    let mut weights = Vec::new();
    for (clip, value) in expect_table(value, &key)? {
        let weight = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
        match weight {
            Some(weight) if (0.0..=f64::from(MOST_CLIP_WEIGHT)).contains(&weight) => {
                weights.push((clip.clone(), weight as f32));
            }
            _ => return wrong(format!("{key}.{clip}"), format!("found {value}, allowed a number from 0 to 1000")),
        }
    }
    Ok(Some(weights))
}

fn read_attribute_weights(table: &Table, key: &str) -> Result<Option<AttributeWeights>, Wrong> {
    let Some(value) = table.get("attribute_weights") else { return Ok(None) };
    let key = format!("{key}.attribute_weights");
    let mut weights = AttributeWeights::default();
    for (name, value) in expect_table(value, &key)? {
        let weight = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
        match weight {
            Some(weight) if (0.0..=f64::from(MOST_CLIP_WEIGHT)).contains(&weight) => {
                if !weigh_attribute(&mut weights, name, weight as f32) {
                    return wrong(format!("{key}.{name}"), "unknown key, allowed uv, normal, color, layers");
                }
            }
            _ => return wrong(format!("{key}.{name}"), format!("found {value}, allowed a number from 0 to 1000")),
        }
    }
    Ok(Some(weights))
}

fn read_clips(table: &Table, key: &str) -> Result<Option<Vec<String>>, Wrong> {
    let Some(value) = table.get("clips") else { return Ok(None) };
    let key = format!("{key}.clips");
    let Value::Array(items) = value else {
        return wrong(key, format!("found {}, allowed a list of names or patterns", kind(value)));
    };
    let mut clips = Vec::new();
    for (index, item) in items.iter().enumerate() {
        match item {
            Value::String(clip) if !clip.is_empty() => clips.push(clip.clone()),
            other => return wrong(format!("{key}[{index}]"), format!("found {other}, allowed a name or a pattern")),
        }
    }
    if clips.is_empty() {
        return wrong(key, "found an empty list, at least one clip is needed; leave the key out for all clips");
    }
    Ok(Some(clips))
}

fn read_text(table: &Table, key: &str, field: &str) -> Result<Option<String>, Wrong> {
    match table.get(field) {
        None => Ok(None),
        Some(Value::String(text)) if !text.is_empty() => Ok(Some(text.clone())),
        Some(other) => wrong(format!("{key}.{field}"), format!("found {other}, allowed a text that is not empty")),
    }
}

fn expect_table<'a>(value: &'a Value, key: &str) -> Result<&'a Table, Wrong> {
    match value {
        Value::Table(table) => Ok(table),
        other => wrong(key, format!("found {}, allowed a table", kind(other))),
    }
}

fn expect_keys(table: &Table, prefix: &str, allowed: &[&str]) -> Result<(), Wrong> {
    match table.keys().find(|key| !allowed.contains(&key.as_str())) {
        Some(unknown) => wrong(format!("{prefix}{unknown}"), format!("unknown key, allowed {}", allowed.join(", "))),
        None => Ok(()),
    }
}

fn kind(value: &Value) -> &'static str {
    value.type_str()
}

/// The plan as a manifest that gives the same plan again, with sources as the plan has them.
/// `paths`: a line about them.
pub fn write(plan: &Plan, paths: &str) -> String {
    let text = |text: &str| Value::String(text.to_owned()).to_string();
    let layout = match plan.animation_layout {
        AnimationLayout::Premultiplied3x4 => "3x4",
        AnimationLayout::Split4x4 => "4x4",
    };
    let mut out = format!(
        "# {paths}\n\n[pack]\nanimation_layout = {}  # 3x4 or 4x4\n\
         impostors = {}  # texels of small pictures for far characters: 8 to 128, 0 for none\n\n[defaults]\nfps = \"auto\"  # the rate of each clip's keys; or frames a second\n\
         criteria = {}  # wedge or peng2011\n# clips = [\"Idle\", \"Walk*\"]  # default: all\n\
         frames = {}  # auto, all or bind\n# clip_weights = {{ Walk = 2.0 }}  # default: all count alike\n\
         # attribute_weights = {{ uv = 2.0 }}  # uv, normal, color, layers; default: 1\n\
         # lod_ratio = [\"50%\", \"25%\"]  # discrete levels; also error = [\"5mm\"], px = [\"1@240\"], refit = true\n\
         # scale = 0.01  # times the file's size; or height = 1.8, metres at rest; default: as the file has it\n\
         # coarsest = \"0.5%\"  # where the continuous detail ends: triangles, a share, or \"last\"; default: where it is useful\n\
         # animation_storage = \"quantized\"  # auto, f32, f16 or quantized; animation_error = 0.1, in percent of the height\n",
        text(layout),
        plan.impostors_px,
        text(criteria_name(Criteria::default())),
        text(frames_name(FrameChoice::default())),
    );
    for entry in &plan.entries {
        let source = entry.path.to_string_lossy();
        out.push_str(&format!("\n[[characters]]\nsource = {}\nname = {}\n", text(&source), text(&entry.name)));
        if let FrameRate::Fixed(fps) = entry.fps {
            out.push_str(&format!("fps = {fps:?}\n"));
        }
        if entry.criteria != Criteria::default() {
            out.push_str(&format!("criteria = {}\n", text(criteria_name(entry.criteria))));
        }
        if let Some(clips) = &entry.clips {
            let clips: Vec<String> = clips.iter().map(|clip| text(clip)).collect();
            out.push_str(&format!("clips = [{}]\n", clips.join(", ")));
        }
        if entry.frames != FrameChoice::default() {
            out.push_str(&format!("frames = {}\n", text(frames_name(entry.frames))));
        }
        if !entry.clip_weights.is_empty() {
            let weights = entry.clip_weights.iter().map(|(clip, weight)| format!("{} = {weight:?}", text(clip)));
            out.push_str(&format!("clip_weights = {{ {} }}\n", weights.collect::<Vec<_>>().join(", ")));
        }
        if entry.attribute_weights != AttributeWeights::default() {
            let AttributeWeights { uv, normal, color, layers } = entry.attribute_weights;
            out.push_str(&format!(
                "attribute_weights = {{ uv = {uv:?}, normal = {normal:?}, color = {color:?}, layers = {layers:?} }}\n"
            ));
        }
        match entry.size {
            Some(SizeAsked::Factor(factor)) => out.push_str(&format!("scale = {factor:?}\n")),
            Some(SizeAsked::HeightM(height_m)) => out.push_str(&format!("height = {height_m:?}\n")),
            None => {}
        }
        if let Some(coarsest) = entry.coarsest {
            out.push_str(&format!("coarsest = {}\n", text(&coarsest_words(coarsest))));
        }
        let (storage, default) = (entry.storage, StorageAsked::default());
        if let Some(storage) = storage.storage.filter(|_| plan.animation_layout == AnimationLayout::Premultiplied3x4) {
            out.push_str(&format!("animation_storage = {}\n", text(storage.name())));
        }
        if storage.error_share != default.error_share && plan.animation_layout == AnimationLayout::Premultiplied3x4 {
            out.push_str(&format!("animation_error = {:?}\n", storage.error_share * 100.0));
        }
        write_lods(&mut out, entry);
    }
    if plan.entries.is_empty() {
        out.push_str(
            "\n# [[characters]]\n# source = \"knight.glb\"\n# name = \"knight\"  # default: the file's stem\n",
        );
    }
    out
}

fn write_lods(out: &mut String, entry: &PlanEntry) {
    let kind = |target: &LodTarget| match target.0 {
        ManifestTarget::Ratio(_) => "lod_ratio",
        ManifestTarget::ErrorM(_)
        | ManifestTarget::ErrorHeight(_)
        | ManifestTarget::RmsM(_)
        | ManifestTarget::RmsHeight(_) => "error",
        ManifestTarget::Pixels(..) | ManifestTarget::RmsPixels(..) => "px",
    };
    for field in ["lod_ratio", "error", "px"] {
        let targets = entry.levels.targets.iter().filter(|target| kind(target) == field);
        let words: Vec<String> = targets.map(|target| Value::String(target.to_string()).to_string()).collect();
        if !words.is_empty() {
            out.push_str(&format!("{field} = [{}]\n", words.join(", ")));
        }
    }
    if entry.levels.refit {
        out.push_str("refit = true\n");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake_levels::LevelsAsked;

    #[test]
    fn complaints_name_their_path() {
        let character = "[[characters]]\nsource = 'a.glb'\n";
        for (text, key) in [
            ("x = 1", "x"),
            ("[defaults]\nname = 'x'", "defaults.name"),
            ("[defaults]\nfps = 0", "defaults.fps"),
            ("characters = 3", "characters"),
            ("", "characters"),
            (&format!("{character}frames = 'some'"), "characters[0].frames"),
            (&format!("{character}clip_weights = {{ Walk = -1 }}"), "characters[0].clip_weights.Walk"),
            (&format!("{character}attribute_weights = {{ uv = -1 }}"), "characters[0].attribute_weights.uv"),
            (&format!("{character}attribute_weights = {{ colour = 1 }}"), "characters[0].attribute_weights.colour"),
            (&format!("{character}lod_ratio = [0.5, 25]"), "characters[0].lod_ratio[1]"),
            (&format!("{character}error = '5mm'"), "characters[0].error"),
            (&format!("{character}px = ['1@']"), "characters[0].px[0]"),
            (&format!("{character}refit = 1"), "characters[0].refit"),
            (&format!("{character}coarsest = '2 feet'"), "characters[0].coarsest"),
            (&format!("{character}coarsest = -1"), "characters[0].coarsest"),
            (&format!("{character}scale = 0"), "characters[0].scale"),
            (&format!("{character}height = 'tall'"), "characters[0].height"),
            (&format!("{character}height = 2\nscale = 2"), "characters[0].height"),
            ("[[characters]]\nname = 'x'", "characters[0].source"),
            (&format!("{character}{character}clips = 'Walk'"), "characters[1].clips"),
            (&format!("{character}{character}clips = ['a', 3]"), "characters[1].clips[1]"),
            (&format!("{character}clips = []"), "characters[0].clips"),
            (&format!("{character}criteria = 'best'"), "characters[0].criteria"),
            (&format!("{character}name = 'x'\n{character}name = 'x'"), "characters[1].name"),
            (&format!("{character}colour = 'red'"), "characters[0].colour"),
            (&format!("[pack]\nanimation_layout = '2x2'\n{character}"), "pack.animation_layout"),
            (&format!("{character}animation_storage = 'f8'\n"), "characters[0].animation_storage"),
            (&format!("{character}animation_error = 11\n"), "characters[0].animation_error"),
            ("[[characters]]\nsource = ", "line 2"),
        ] {
            assert_eq!(read(text).unwrap_err().key, key, "{text}");
        }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let mut plan = Plan { animation_layout: AnimationLayout::Split4x4, ..Plan::default() };
        plan.entries.push(PlanEntry::of_file(std::path::Path::new("odd \"name\"\\x.glb")));
        plan.entries.push(PlanEntry {
            fps: FrameRate::Fixed(12.5),
            criteria: Criteria::Peng2011,
            clips: Some(vec!["Walk*".to_owned()]),
            frames: FrameChoice::Bind,
            coarsest: Some(Coarsest::Share(0.0125)),
            size: Some(SizeAsked::Factor(0.01)),
            clip_weights: vec![("Run \"fast\"".to_owned(), 0.25), ("Walk".to_owned(), 3.0)],
            attribute_weights: AttributeWeights { uv: 2.5, layers: 0.0, ..AttributeWeights::default() },
            levels: LevelsAsked {
                targets: vec![
                    LodTarget::parse_ratio("0.25").unwrap(),
                    LodTarget::parse_error("5mm").unwrap(),
                    LodTarget::parse_error("0.5%").unwrap(),
                    LodTarget::parse_pixels("1@240").unwrap(),
                ],
                refit: true,
            },
            ..PlanEntry::of_file(std::path::Path::new("b.obj"))
        });
        let back = read(&write(&plan, "Paths are relative to this file.")).unwrap();
        assert_eq!(back.animation_layout, Some(AnimationLayout::Split4x4));
        assert_eq!(back.characters[0].0, plan.entries[0].path);
        assert_eq!(back.characters[0].1.name.as_deref(), Some(plan.entries[0].name.as_str()));
        let second = &back.characters[1].1;
        assert_eq!((second.fps, second.criteria), (Some(FrameRate::Fixed(12.5)), Some(Criteria::Peng2011)));
        assert_eq!(second.clips, plan.entries[1].clips);
        assert_eq!(second.frames, Some(FrameChoice::Bind));
        assert_eq!(second.lods.as_ref(), Some(&plan.entries[1].levels.targets));
        assert_eq!((second.refit, second.coarsest), (Some(true), Some(Coarsest::Share(0.0125))));
        assert_eq!(second.size, Some(SizeAsked::Factor(0.01)));
        assert_eq!(second.attribute_weights, Some(plan.entries[1].attribute_weights));
        assert_eq!(second.clip_weights.as_deref(), Some(&plan.entries[1].clip_weights[..]));
    }
}
