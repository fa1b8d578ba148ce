//! What a material has beside its base colour (glTF 2.0, section 3.9, and the extensions that refine it by numbers alone).
//!
//! Nothing here refuses a character: what cannot be carried to exports is left out and named.

use gltf::json::Root;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode, Material};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use serde_json::{Map, Value};

use super::images::ImageTable;
use super::materials::{TextureUse, read_texture, texture_use};
use crate::names::shorten;
use crate::refusal::{Asset, Warnings};
use crate::{RawFinish, RawTexture};

const REDUCED: &str = "material-reduced";
const OLD_MODEL: &str = "KHR_materials_pbrSpecularGlossiness";
const SPECULAR: &str = "KHR_materials_specular";
/// Extensions of which every number is carried, or that another step reads.
const CARRIED: [&str; 4] = ["KHR_materials_emissive_strength", "KHR_materials_ior", SPECULAR, OLD_MODEL];

/// A texture beside that of the base colour: its name in the material, its index, its coordinates.
type Slot = (&'static str, usize, TextureUse);

/// Emissive, normal, metallic-roughness, occlusion, specular, specular colour.
fn slots(material: &Material) -> [Option<Slot>; 6] {
    let emissive =
        material.emissive_texture.as_ref().map(|i| ("emissiveTexture", i.index.value(), texture_use(Some(i))));
    let metal = material.pbr_metallic_roughness.metallic_roughness_texture.as_ref();
    let metal = metal.map(|i| ("metallicRoughnessTexture", i.index.value(), texture_use(Some(i))));
    let normal = material.normal_texture.as_ref().map(|n| {
        let uses = TextureUse::of(n.tex_coord, n.extensions.as_ref().and_then(|e| transform(&e.others)).as_ref());
        ("normalTexture", n.index.value(), uses)
    });
    let occlusion = material.occlusion_texture.as_ref().map(|o| {
        let uses = TextureUse::of(o.tex_coord, o.extensions.as_ref().and_then(|e| transform(&e.others)).as_ref());
        ("occlusionTexture", o.index.value(), uses)
    });
    let specular = |name: &'static str| -> Option<Slot> {
        let info = material.extensions.as_ref()?.others.get(SPECULAR)?.get(name)?;
        let info: Info = serde_json::from_value(info.clone()).ok()?;
        Some((name, info.index.value(), texture_use(Some(&info))))
    };
    [emissive, normal, metal, occlusion, specular("specularTexture"), specular("specularColorTexture")]
}

fn transform(others: &Map<String, Value>) -> Option<TextureTransform> {
    serde_json::from_value(others.get("KHR_texture_transform")?.clone()).ok()
}

/// The coordinates of the first texture there is, for materials whose base colour has none.
pub(super) fn first_use(material: &Material) -> Option<TextureUse> {
    slots(material).into_iter().flatten().next().map(|(_, _, uses)| uses)
}

/// Reads it all. `kept`: the coordinates that the mesh keeps.
pub(super) fn read_finish(
    asset: Asset<'_>,
    root: &Root,
    images: &mut ImageTable<'_, '_>,
    (place, material): (&str, &Material),
    kept: &TextureUse,
    warnings: &mut Warnings,
) -> RawFinish {
    let mut carry = |slot: Option<Slot>| -> Option<RawTexture> {
        let (name, texture, uses) = slot?;
        let problem = if uses == *kept {
            match read_texture(asset, root, images, (place, texture), warnings) {
                Ok(texture) => return Some(texture),
                Err(error) => error.to_string(),
            }
        } else if uses.uv_set != kept.uv_set {
            format!(
                "it reads TEXCOORD_{} and the material's first texture TEXCOORD_{}, and one set is kept; give both the same",
                uses.uv_set, kept.uv_set
            )
        } else {
            "its KHR_texture_transform is not that of the material's first texture; give both the same".to_owned()
        };
        warnings.add(REDUCED, &format!("{place}: {name}"), 1, format!("left out of exports: {problem}"));
        None
    };
    let slots = slots(material);
    let (had_emissive, had_metal) = (slots[0].is_some(), slots[2].is_some());
    let [emissive, normal, metal, occlusion, specular_texture, specular_color_texture] = slots.map(&mut carry);

    let pbr = &material.pbr_metallic_roughness;
    let mut finish = RawFinish {
        metallic: unit(pbr.metallic_factor.0, 1.0),
        roughness: unit(pbr.roughness_factor.0, 1.0),
        metallic_roughness: metal,
        normal: normal.map(|texture| (texture, finite(material.normal_texture.as_ref().map_or(1.0, |n| n.scale), 1.0))),
        occlusion: occlusion
            .map(|texture| (texture, unit(material.occlusion_texture.as_ref().map_or(1.0, |o| o.strength.0), 1.0))),
        emissive: material.emissive_factor.0.map(|channel| unit(channel, 0.0)),
        emissive_texture: emissive,
        specular_texture,
        specular_color_texture,
        blend: matches!(material.alpha_mode, Checked::Valid(AlphaMode::Blend)),
        ..RawFinish::default()
    };
    // A factor says little without the texture that it weighs: better dull than all of it metal or alight.
    if had_metal && metal.is_none() {
        (finish.metallic, finish.roughness) = (0.0, 1.0);
    }
    if had_emissive && emissive.is_none() {
        finish.emissive = [0.0; 3];
    }
    if let Some(extensions) = &material.extensions {
        read_extensions(&extensions.others, place, &mut finish, warnings);
    }
    finish
}

fn read_extensions(others: &Map<String, Value>, place: &str, finish: &mut RawFinish, warnings: &mut Warnings) {
    let mut left_out = |name: &str, what: &str| {
        warnings.add(REDUCED, &format!("{place}: {}", shorten(name)), 1, format!("left out of exports: {what}"));
    };
    let number = |value: Option<&Value>| value.and_then(Value::as_f64).map(|number| number as f32);
    if let Some(strength) = others.get(CARRIED[0]).and_then(|e| number(e.get("emissiveStrength"))) {
        finish.emissive_strength = finite(strength, 1.0).max(0.0);
    }
    if let Some(ior) = others.get(CARRIED[1]) {
        let ior = finite(number(ior.get("ior")).unwrap_or(1.5), 1.5);
        finish.ior = Some(if ior == 0.0 { 0.0 } else { ior.max(1.0) });
    }
    if let Some(specular) = others.get(SPECULAR) {
        let factor = unit(number(specular.get("specularFactor")).unwrap_or(1.0), 1.0);
        let color = specular.get("specularColorFactor").and_then(Value::as_array);
        let channel = |at: usize| number(color.and_then(|color| color.get(at))).unwrap_or(1.0);
        finish.specular = Some((factor, [0, 1, 2].map(|at| finite(channel(at), 1.0).max(0.0))));
    }
    if let Some(old) = others.get(OLD_MODEL) {
        finish.metallic = 0.0;
        finish.roughness = 1.0 - unit(number(old.get("glossinessFactor")).unwrap_or(1.0), 1.0);
        left_out(
            OLD_MODEL,
            "of this archived extension the diffuse colour and the glossiness stay; export the file with metal and roughness",
        );
    }
    for name in others.keys().filter(|name| !CARRIED.contains(&name.as_str())) {
        left_out(name, "this extension is not carried; the material's other properties are");
    }
}

fn finite(number: f32, otherwise: f32) -> f32 {
    if number.is_finite() { number } else { otherwise }
}

fn unit(number: f32, otherwise: f32) -> f32 {
    finite(number, otherwise).clamp(0.0, 1.0)
}
