//! Materials, textures and images of an exported file: as the source had them, images byte by byte.

use crate::glb::GlbBuffer;
use crate::unpack::Unpacked;
use crowd_pack::{Finish, FinishTexture, MaterialRecord, NONE, material_flags};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// An image of the pack: whether it is one of the finishes' images, and its index.
type ImageKey = (bool, u32);

/// Textures of the document: one per image and sampler.
#[derive(Default)]
pub(crate) struct Textures {
    keys: Vec<(ImageKey, u32)>,
}

impl Textures {
    fn of(&mut self, image: ImageKey, sampler: u32) -> usize {
        let key = (image, sampler);
        self.keys.iter().position(|known| *known == key).unwrap_or_else(|| {
            self.keys.push(key);
            self.keys.len() - 1
        })
    }

    fn of_record(&mut self, material: &MaterialRecord) -> usize {
        self.of((false, material.image), (material.flags >> material_flags::WRAP_U_SHIFT) & 0xff)
    }

    fn of_finish(&mut self, texture: &FinishTexture) -> usize {
        self.of((true, texture.image), texture.sampler.into())
    }

    fn images(&self) -> Vec<ImageKey> {
        let images: BTreeSet<ImageKey> = self.keys.iter().map(|key| key.0).collect();
        images.into_iter().collect()
    }

    /// Puts them into the document, their images into the buffer.
    pub(crate) fn add_to(&self, character: &Unpacked<'_>, document: &mut Map<String, Value>, buffer: &mut GlbBuffer) {
        if self.keys.is_empty() {
            return;
        }
        let images = self.images();
        let samplers: BTreeSet<u32> = self.keys.iter().map(|key| key.1).collect();
        let samplers: Vec<u32> = samplers.into_iter().collect();
        let textures = self.keys.iter().map(|(image, sampler)| {
            let source = images.binary_search(image).expect("listed above");
            let sampler = samplers.binary_search(sampler).expect("listed above");
            if encoding(character, *image) == WEBP {
                json!({ "sampler": sampler, "extensions": { "EXT_texture_webp": { "source": source } } })
            } else {
                json!({ "sampler": sampler, "source": source })
            }
        });
        document.insert("textures".into(), textures.collect());
        document.insert("samplers".into(), samplers.iter().map(|&sampler| sampler_json(sampler)).collect());
        let images: Vec<Value> = images.iter().map(|&image| image_json(character, image, buffer)).collect();
        document.insert("images".into(), Value::Array(images));
    }
}

/// Bits 4 to 11 of a material's flags in glTF's numbers.
fn sampler_json(sampler: u32) -> Value {
    let wrap = |bits: u32| [10497, 33071, 33648][(bits & material_flags::WRAP_MASK).min(2) as usize];
    let filters = sampler >> (material_flags::FILTER_SHIFT - material_flags::WRAP_U_SHIFT);
    let mag = [9729, 9728][(filters & 1) as usize];
    let min = [9987, 9984, 9985, 9986, 9728, 9729][(filters >> 1).min(5) as usize];
    json!({ "magFilter": mag, "minFilter": min, "wrapS": wrap(sampler), "wrapT": wrap(sampler >> 2) })
}

const WEBP: u32 = 2;

fn encoding(character: &Unpacked<'_>, (of_finish, index): ImageKey) -> u32 {
    let contents = character.contents;
    let images = if of_finish { &contents.finish_images } else { &contents.images };
    images[index as usize].encoding
}

fn image_json(character: &Unpacked<'_>, (of_finish, index): ImageKey, buffer: &mut GlbBuffer) -> Value {
    let contents = character.contents;
    let (images, all_bytes, names) = match of_finish {
        false => (&contents.images, &contents.image_bytes, &contents.finishes.image_names),
        true => (&contents.finish_images, &contents.finish_bytes, &contents.finishes.finish_image_names),
    };
    let record = images[index as usize];
    let bytes = &all_bytes[record.byte_offset as usize..][..record.byte_count as usize];
    let kind = ["image/png", "image/jpeg", "image/webp"][record.encoding as usize];
    let mut json = json!({ "bufferView": buffer.raw(bytes), "mimeType": kind });
    if let Some(name) = names.get(index as usize).filter(|name| !name.is_empty()) {
        json["name"] = json!(name);
    }
    json
}

/// A material of the character, by its number there.
pub(crate) fn material_json(character: &Unpacked<'_>, material: u32, textures: &mut Textures) -> Value {
    let record = &character.materials[material as usize];
    let finish = character.finish(material);
    let mut json = json!({ "pbrMetallicRoughness": surface_json(record, &finish, textures) });
    let name = &character.manifest.materials[material as usize];
    if !name.is_empty() {
        json["name"] = json!(name);
    }
    if let Some(texture) = &finish.normal {
        json["normalTexture"] = json!({ "index": textures.of_finish(texture) });
        if texture.weight != 1.0 {
            json["normalTexture"]["scale"] = json!(texture.weight);
        }
    }
    if let Some(texture) = &finish.occlusion {
        json["occlusionTexture"] = json!({ "index": textures.of_finish(texture) });
        if texture.weight != 1.0 {
            json["occlusionTexture"]["strength"] = json!(texture.weight);
        }
    }
    if finish.emissive != [0.0; 3] {
        json["emissiveFactor"] = json!(finish.emissive);
    }
    if let Some(texture) = &finish.emissive_texture {
        json["emissiveTexture"] = json!({ "index": textures.of_finish(texture) });
    }
    if finish.blend {
        json["alphaMode"] = json!("BLEND");
    } else if record.alpha_cutoff > 0.0 {
        json["alphaMode"] = json!("MASK");
        json["alphaCutoff"] = json!(record.alpha_cutoff);
    }
    if record.flags & material_flags::DOUBLE_SIDED != 0 {
        json["doubleSided"] = json!(true);
    }
    let extensions = extensions_json(record, &finish, textures);
    if !extensions.is_empty() {
        json["extensions"] = Value::Object(extensions);
    }
    json
}

/// Base colour, metal and roughness.
fn surface_json(record: &MaterialRecord, finish: &Finish, textures: &mut Textures) -> Value {
    let mut surface = json!({});
    // What the record shows may have light of its own in it; the file says the two apart again.
    let (color, texture) = match &finish.base {
        Some(base) => (base.color, base.texture.as_ref().map(|texture| textures.of_finish(texture))),
        None => (record.base_color, (record.image != NONE).then(|| textures.of_record(record))),
    };
    let color = color.map(|channel| channel.clamp(0.0, 1.0));
    if color != [1.0; 4] {
        surface["baseColorFactor"] = json!(color);
    }
    if let Some(index) = texture {
        surface["baseColorTexture"] = json!({ "index": index });
    }
    if finish.metallic != 1.0 {
        surface["metallicFactor"] = json!(finish.metallic);
    }
    if finish.roughness != 1.0 {
        surface["roughnessFactor"] = json!(finish.roughness);
    }
    if let Some(texture) = &finish.metallic_roughness {
        surface["metallicRoughnessTexture"] = json!({ "index": textures.of_finish(texture) });
    }
    surface
}

fn extensions_json(record: &MaterialRecord, finish: &Finish, textures: &mut Textures) -> Map<String, Value> {
    let mut extensions = Map::new();
    if record.flags & material_flags::UNLIT != 0 {
        extensions.insert("KHR_materials_unlit".into(), json!({}));
    }
    if finish.emissive_strength != 1.0 {
        extensions
            .insert("KHR_materials_emissive_strength".into(), json!({ "emissiveStrength": finish.emissive_strength }));
    }
    if let Some(ior) = finish.ior {
        extensions.insert("KHR_materials_ior".into(), json!({ "ior": ior }));
    }
    if let Some([factor, r, g, b]) = finish.specular {
        let mut specular = json!({ "specularFactor": factor, "specularColorFactor": [r, g, b] });
        if let Some(texture) = &finish.specular_texture {
            specular["specularTexture"] = json!({ "index": textures.of_finish(texture) });
        }
        if let Some(texture) = &finish.specular_color_texture {
            specular["specularColorTexture"] = json!({ "index": textures.of_finish(texture) });
        }
        extensions.insert("KHR_materials_specular".into(), specular);
    }
    extensions
}

/// `extensionsUsed` and `extensionsRequired`, where there are any.
pub(crate) fn used_extensions(
    character: &Unpacked<'_>,
    materials: &[Value],
    textures: &Textures,
) -> Map<String, Value> {
    let of_materials = materials.iter().filter_map(|material| material.get("extensions")?.as_object());
    let mut names: BTreeSet<&str> = of_materials.flat_map(Map::keys).map(String::as_str).collect();
    let webp = textures.images().iter().any(|&image| encoding(character, image) == WEBP);
    let mut lists = Map::new();
    if webp {
        names.insert("EXT_texture_webp");
        lists.insert("extensionsRequired".into(), json!(["EXT_texture_webp"]));
    }
    if !names.is_empty() {
        lists.insert("extensionsUsed".into(), json!(names));
    }
    lists
}
