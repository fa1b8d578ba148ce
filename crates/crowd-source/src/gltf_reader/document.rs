//! JSON text in, a checked glTF document out: version, required extensions, nothing else decided yet.

use gltf::json::Root;
use serde_json::{Map, Value};

use crate::names::shorten;
use crate::refusal::{Asset, Warnings};
use crate::{RawCredits, Result};

/// Extensions that change what must be read and that this reader knows.
const SUPPORTED: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_texture_webp",
    "KHR_materials_unlit",
    "KHR_materials_pbrSpecularGlossiness",
];

/// Extensions that only refine a surface beyond its base colour, or add things that are no part of a character: a file
/// that requires them still gives the right shape, motion and base colour.
const HARMLESS: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_xmp_json_ld",
];

/// Extensions that change what is seen, which we leave out when the file only *uses* them.
const LEFT_OUT: &[(&str, &str)] = &[
    ("EXT_mesh_gpu_instancing", "each instanced mesh appears once; turn instances into nodes before export"),
    ("KHR_animation_pointer", "only translation, rotation and scale of nodes are animated"),
    ("KHR_materials_variants", "the default variant is used"),
    ("KHR_node_visibility", "hidden nodes are read like any other; remove them before export"),
    ("MSFT_lod", "the full level is used"),
];

/// What to do about Draco.
pub(super) const DRACO_REMEDY: &str =
    "decompress the file first, for instance with `gltf-pipeline -i in.glb -o out.glb`, or use EXT_meshopt_compression";

/// Reads the JSON chunk as it stands.
pub(super) fn parse_json(asset: Asset<'_>, json: &[u8]) -> Result<Value> {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    serde_json::from_slice(json).map_err(|e| asset.format("JSON", format!("not a glTF document: {}", say(&e))))
}

/// Reads the JSON chunk and refuses what we cannot honour.
pub(super) fn parse_document(asset: Asset<'_>, json: &[u8], warnings: &mut Warnings) -> Result<Root> {
    let mut value = parse_json(asset, json)?;
    let Some(fields) = value.as_object_mut() else {
        return Err(asset.format("JSON", "not a glTF document: the text is no object"));
    };
    check_version(asset, fields)?;
    check_required_extensions(asset, fields)?;
    warn_about_used_extensions(fields, warnings);
    complete_omissions(fields);
    serde_json::from_value(value).map_err(|e| {
        // The text itself, asked again, also knows line and column.
        let located = serde_json::from_slice::<Root>(json).err().unwrap_or(e);
        asset.format("JSON", format!("not a glTF 2.0 document: {}", say(&located)))
    })
}

/// Bytes of a copyright or of extras that are kept.
const LONGEST_CREDIT: usize = 64 << 10;

/// Our own entry of `asset.extras` in exports, and what earlier ones had in its place: they tell of one level, so they are nobody's credit.
const OWN_EXTRAS: [&str; 5] = ["crowdbake", "character", "vertices", "triangles", "triangles_of_full_detail"];

/// What the document says of its makers.
pub(super) fn read_credits(root: &Root, warnings: &mut Warnings) -> RawCredits {
    let mut kept = |what: &str, text: String| {
        if text.len() <= LONGEST_CREDIT {
            return text;
        }
        let message =
            format!("{} bytes, at most {LONGEST_CREDIT} are kept; exports will not have it. Shorten it", text.len());
        warnings.add("credits-left-out", what, 1, message);
        String::new()
    };
    let extras =
        root.asset.extras.as_ref().and_then(|extras| serde_json::from_str::<Map<String, Value>>(extras.get()).ok());
    let extras = extras.map_or(String::new(), |mut entries| {
        let is_export = root.asset.generator.as_deref().is_some_and(|generator| generator.starts_with("crowdbake"));
        OWN_EXTRAS.iter().take(if is_export { 5 } else { 1 }).for_each(|own| drop(entries.remove(*own)));
        if entries.is_empty() { String::new() } else { Value::Object(entries).to_string() }
    });
    RawCredits {
        copyright: kept("asset.copyright", root.asset.copyright.clone().unwrap_or_default()),
        extras: kept("asset.extras", extras),
    }
}

/// An error's words without what they quote at length: a wrong string may be a whole buffer.
fn say(error: &serde_json::Error) -> String {
    let words = error.to_string();
    if words.len() <= 160 {
        return words;
    }
    format!("{} at line {} column {}", shorten(&words), error.line(), error.column())
}

fn check_version(asset: Asset<'_>, fields: &Map<String, Value>) -> Result<()> {
    let meta = fields.get("asset").and_then(Value::as_object);
    let Some(version) = meta.and_then(|m| m.get("version")).and_then(Value::as_str) else {
        return Err(asset.format("asset", "no `version`; a glTF document says `\"asset\": {\"version\": \"2.0\"}`"));
    };
    if !matches!(parse_version(version), Some((2, _))) {
        return Err(asset.unsupported(
            "asset",
            format!("glTF version `{}`", shorten(version)),
            "convert the file to glTF 2.0",
        ));
    }
    let Some(min) = meta.and_then(|m| m.get("minVersion")) else { return Ok(()) };
    match min.as_str().and_then(parse_version) {
        Some(min) if min <= (2, 0) => Ok(()),
        _ => Err(asset.unsupported(
            "asset",
            format!("glTF minVersion {}", shorten(&min.to_string())),
            "export the file as glTF 2.0",
        )),
    }
}

fn parse_version(text: &str) -> Option<(u32, u32)> {
    let (major, minor) = text.split_once('.')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

fn check_required_extensions(asset: Asset<'_>, fields: &Map<String, Value>) -> Result<()> {
    for name in extension_names(fields, "extensionsRequired") {
        if SUPPORTED.contains(&name) || HARMLESS.contains(&name) {
            continue;
        }
        let remedy = match name {
            "KHR_draco_mesh_compression" => DRACO_REMEDY,
            "KHR_texture_basisu" => "convert the KTX2 textures to PNG, JPEG or WebP",
            _ => "export the file without it",
        };
        return Err(asset.unsupported("extensionsRequired", format!("the extension {}", shorten(name)), remedy));
    }
    Ok(())
}

fn warn_about_used_extensions(fields: &Map<String, Value>, warnings: &mut Warnings) {
    for name in extension_names(fields, "extensionsUsed") {
        if let Some((name, remedy)) = LEFT_OUT.iter().find(|(known, _)| *known == name) {
            warnings.add("extension-ignored", name, 1, format!("the extension {name} is ignored: {remedy}"));
        }
    }
}

fn extension_names<'a>(fields: &'a Map<String, Value>, list: &str) -> impl Iterator<Item = &'a str> {
    fields.get(list).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
}

/// Fills in what glTF lets a file leave out and the document types do not.
fn complete_omissions(fields: &mut Map<String, Value>) {
    let list = |fields: &mut Map<String, Value>, name: &str| -> Vec<Value> {
        match fields.get_mut(name) {
            Some(Value::Array(values)) => std::mem::take(values),
            _ => Vec::new(),
        }
    };
    let mut animations = list(fields, "animations");
    for animation in &mut animations {
        // A channel without a target node (a pointer into something else, say) moves nothing of ours.
        if let Some(Value::Array(channels)) = animation.get_mut("channels") {
            channels.retain(|c| c.get("target").is_some_and(|t| t.get("node").is_some()));
        }
    }
    if !animations.is_empty() {
        fields.insert("animations".into(), Value::Array(animations));
    }
    let mut scenes = list(fields, "scenes");
    for scene in &mut scenes {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    if !scenes.is_empty() {
        fields.insert("scenes".into(), Value::Array(scenes));
    }
}

/// The name of a thing for messages: `mesh 3 \`torso\``.
pub(super) fn describe(kind: &str, index: usize, name: Option<&String>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} `{}`", shorten(name)),
        _ => format!("{kind} {index}"),
    }
}
