//! What materials have beside their base colour comes through bake and export, and light of their own is seen.

use crate::bench::{Bench, TWO_MATERIALS};
use crowd_pack::Pack;
use crowd_source::{Limits, load_character};
use serde_json::{Value, json};

/// The material of the fixture that has texture coordinates.
const TEXTURED: usize = 1;
const NAME: &str = "chequered";

/// The JSON and the binary chunk of a `.glb`.
pub fn split(glb: &[u8]) -> (Value, Vec<u8>) {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&glb[20..20 + length]).expect("the first chunk is JSON");
    (json, glb.get(28 + length..).unwrap_or_default().to_vec())
}

pub fn join(document: &Value, mut bin: Vec<u8>) -> Vec<u8> {
    let mut json = serde_json::to_vec(document).unwrap();
    json.resize(json.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bin)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

fn picture(texels: &[[u8; 4]]) -> Vec<u8> {
    crowd_raster::encode_texels(texels.len() as u32, 1, texels)
}

/// The fixture of two materials with all that a material can have: images of one row, known by their widths.
fn finished(change: impl Fn(&mut Value)) -> Vec<u8> {
    let (mut document, mut bin) =
        split(&std::fs::read(crowd_tests::folders::fixtures().join("good").join(TWO_MATERIALS)).unwrap());
    let mut images = Vec::new();
    for (width, name) in ["glow", "bumps", "rough", "shade", "gloss", "tint"].iter().enumerate() {
        bin.resize(bin.len().next_multiple_of(4), 0);
        let bytes = picture(&vec![[40 * width as u8, 255, 0, 255]; width + 2]);
        let views = document["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() }));
        images.push(json!({ "name": name, "bufferView": views.len() - 1, "mimeType": "image/png" }));
        bin.extend(bytes);
    }
    document["buffers"][0]["byteLength"] = json!(bin.len());
    let push = |list: &mut Value, item: Value| {
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    };
    let sampler = push(
        &mut document["samplers"],
        json!({ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9986 }),
    );
    let mut textures = Vec::new();
    for image in images {
        let image = push(&mut document["images"], image);
        textures.push(push(&mut document["textures"], json!({ "source": image, "sampler": sampler })));
    }
    let index = |at: usize| json!({ "index": textures[at] });
    let material = &mut document["materials"][TEXTURED];
    material["emissiveFactor"] = json!([1.0, 0.5, 0.25]);
    material["emissiveTexture"] = index(0);
    material["normalTexture"] = json!({ "index": textures[1], "scale": 0.5 });
    material["pbrMetallicRoughness"]["metallicFactor"] = json!(0.75);
    material["pbrMetallicRoughness"]["roughnessFactor"] = json!(0.25);
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = index(2);
    material["occlusionTexture"] = json!({ "index": textures[3], "strength": 0.5 });
    material["doubleSided"] = json!(true);
    material["extensions"] = json!({
        "KHR_materials_emissive_strength": { "emissiveStrength": 2.0 },
        "KHR_materials_ior": { "ior": 1.25 },
        "KHR_materials_specular": {
            "specularFactor": 0.5, "specularColorFactor": [1.0, 0.5, 0.0],
            "specularTexture": index(4), "specularColorTexture": index(5),
        },
    });
    document["extensionsUsed"] =
        json!(["KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_specular"]);
    change(&mut document);
    join(&document, bin)
}

/// A material of a file with its textures written out: name of the image, how it wraps, its filters (linear where it says none).
fn resolved(document: &Value, material: &Value) -> Value {
    let mut material = material.clone();
    resolve(document, &mut material);
    material
}

fn resolve(document: &Value, value: &mut Value) {
    match value {
        Value::Object(fields) => {
            if let Some(index) = fields.get("index").and_then(Value::as_u64) {
                let texture = &document["textures"][index as usize];
                let sampler = &document["samplers"][texture["sampler"].as_u64().unwrap() as usize];
                let image = &document["images"][texture["source"].as_u64().unwrap() as usize];
                fields.insert(
                    "index".into(),
                    json!([
                        image["name"],
                        sampler["wrapS"],
                        sampler["wrapT"],
                        sampler.get("magFilter").unwrap_or(&json!(9729)),
                        sampler.get("minFilter").unwrap_or(&json!(9987)),
                    ]),
                );
            }
            fields.values_mut().for_each(|field| resolve(document, field));
        }
        Value::Array(items) => items.iter_mut().for_each(|item| resolve(document, item)),
        _ => {}
    }
}

#[test]
fn all_that_a_material_has_comes_through() {
    let bench = Bench::new();
    bench.write("lamp.glb", finished(|_| {}));
    bench.run(&["bake", "@lamp.glb", "-o", "@lamp.crowdpack", "--strict"]).expect(0);
    bench.run(&["export", "@lamp.crowdpack", "--ratio", "0.5", "-o", "@packed.glb"]).expect(0);
    bench.run(&["export", "@lamp.glb", "--ratio", "0.5", "-o", "@direct.glb"]).expect(0);
    assert!(bench.read("packed.glb") == bench.read("direct.glb"), "the way through a pack changes nothing");

    let (source, _) = split(&bench.read("lamp.glb"));
    let (out, bin) = split(&bench.read("packed.glb"));
    let named = |document: &Value, name: &Value| {
        let materials = document["materials"].as_array().unwrap();
        resolved(document, materials.iter().find(|m| m["name"] == *name).expect("materials keep their names"))
    };
    for material in source["materials"].as_array().unwrap() {
        let mut wanted = resolved(&source, material);
        // White is what a file without a factor says.
        let factor = wanted["pbrMetallicRoughness"].as_object_mut().unwrap();
        if factor.get("baseColorFactor").is_some_and(|color| *color == json!([1, 1, 1, 1])) {
            factor.remove("baseColorFactor");
        }
        expect_same(&wanted, &named(&out, &material["name"]), material["name"].as_str().unwrap());
    }
    assert_eq!(out["extensionsUsed"], source["extensionsUsed"]);
    // Images are the bytes they came as.
    let (_, source_bin) = split(&bench.read("lamp.glb"));
    let bytes_of = |document: &Value, bin: &[u8], name: &str| -> Vec<u8> {
        let images = document["images"].as_array().unwrap();
        let image = images.iter().find(|image| image["name"] == name).expect("images keep their names");
        let view = &document["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap_or(0) as usize;
        bin[start..start + view["byteLength"].as_u64().unwrap() as usize].to_vec()
    };
    for name in ["glow", "bumps", "rough", "shade", "gloss", "tint"] {
        assert_eq!(bytes_of(&source, &source_bin, name), bytes_of(&out, &bin, name), "{name}");
    }
    let first = |file: &str| {
        let raw = load_character(&bench.path(file), &Limits::default()).unwrap();
        raw.materials.iter().find(|material| material.name == NAME).unwrap().finish.clone()
    };
    assert_eq!(first("lamp.glb").normal.map(|(_, scale)| scale), Some(0.5));
    assert_eq!(first("packed.glb").emissive, first("lamp.glb").emissive);
}

/// The same values, numbers as numbers (1 is 1.0).
#[track_caller]
fn expect_same(wanted: &Value, found: &Value, place: &str) {
    match (wanted, found) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a - b).abs() < 1e-6, "{place}: {a} became {b}");
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter().zip(b).for_each(|(a, b)| expect_same(a, b, place));
        }
        (Value::Object(a), Value::Object(b)) => {
            let keys = |map: &serde_json::Map<String, Value>| map.keys().cloned().collect::<Vec<_>>();
            assert_eq!(keys(a), keys(b), "{place}");
            a.iter().for_each(|(key, a)| expect_same(a, &b[key], &format!("{place}: {key}")));
        }
        (a, b) => assert_eq!(a, b, "{place}"),
    }
}

#[test]
fn light_of_its_own_is_in_what_is_shown_and_not_in_the_export() {
    let bench = Bench::new();
    // A black surface with a green light: the pack shows green.
    bench.write(
        "lamp.glb",
        finished(|document| {
            let material = &mut document["materials"][TEXTURED];
            material["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.0, 0.0, 0.0, 1.0]);
            material["emissiveFactor"] = json!([0.0, 1.0, 0.0]);
        }),
    );
    bench.run(&["bake", "@lamp.glb", "-o", "@lamp.crowdpack"]).expect(0);
    let pack = Pack::open(&bench.path("lamp.crowdpack")).unwrap();
    let contents = pack.contents();
    let place = contents.manifest.characters[0].materials.iter().position(|name| name == NAME).unwrap();
    let material = contents.materials[place];
    let image = contents.images[material.image as usize];
    let bytes = &contents.image_bytes[image.byte_offset as usize..][..image.byte_count as usize];
    let shown = crowd_raster::decode_picture(bytes).unwrap();
    assert!(shown.color.iter().all(|texel| texel[..3] == [0, 255, 0]), "{:?}", shown.color);
    let finish = &contents.finishes.materials[place];
    assert_eq!(finish.base.as_ref().map(|base| base.color), Some([0.0, 0.0, 0.0, 1.0]));
    assert_eq!(contents.finishes.materials[1 - place].base, None);
}

#[test]
fn what_is_left_out_is_named_and_counts_when_strict() {
    let bench = Bench::new();
    bench.write(
        "lamp.glb",
        finished(|document| {
            let material = &mut document["materials"][TEXTURED];
            material["occlusionTexture"]["texCoord"] = json!(1);
            material["normalTexture"]["extensions"] = json!({ "KHR_texture_transform": { "scale": [2.0, 2.0] } });
            material["extensions"]["KHR_materials_clearcoat"] = json!({ "clearcoatFactor": 1.0 });
            // An image that is none: the character is not refused for what it does not show.
            document["images"].as_array_mut().unwrap().push(json!({ "uri": "data:image/png;base64,AAAA" }));
            let image = document["images"].as_array().unwrap().len() - 1;
            document["textures"].as_array_mut().unwrap().push(json!({ "source": image, "sampler": 0 }));
            let texture = document["textures"].as_array().unwrap().len() - 1;
            document["materials"][TEXTURED]["emissiveTexture"]["index"] = json!(texture);
        }),
    );
    let left_out = [
        "material-reduced",
        "occlusionTexture: left out of exports: it reads TEXCOORD_1 and the material's first texture TEXCOORD_0",
        "normalTexture: left out of exports: its KHR_texture_transform",
        "KHR_materials_clearcoat: left out of exports",
        "emissiveTexture: left out of exports",
    ];
    bench.run(&["bake", "@lamp.glb", "-o", "@lamp.crowdpack"]).expect(0).says(&left_out);
    bench
        .run(&["bake", "@lamp.glb", "-o", "@strict.crowdpack", "--strict"])
        .expect(1)
        .says(&["4 warnings with --strict", "material-reduced"]);
    bench.run(&["export", "@lamp.crowdpack", "--ratio", "1", "-o", "@out.glb"]).expect(0).says(&left_out);
    let (out, _) = split(&bench.read("out.glb"));
    let material = out["materials"].as_array().unwrap().iter().find(|material| material["name"] == NAME).unwrap();
    for gone in ["occlusionTexture", "normalTexture", "emissiveTexture", "emissiveFactor"] {
        assert!(material[gone].is_null(), "{gone}: {material}");
    }
    assert_eq!(material["pbrMetallicRoughness"]["metallicFactor"], json!(0.75));
}
