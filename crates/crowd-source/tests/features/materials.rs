//! Materials, textures, images.

use crowd_source::{ImageEncoding, RawFilters, RawMinFilter, RawWrap};
use serde_json::{Value, json};

use crate::builder::*;

fn surfaced(material: Value) -> Doc {
    let mut doc = Doc::triangle();
    let uvs = doc.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    let other = doc.floats("VEC2", &[0.5; 6]);
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_0"] = json!(uvs);
    attributes["TEXCOORD_1"] = json!(other);
    doc.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    doc.push("materials", material);
    let view = doc.view(PNG);
    doc.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    doc.push("samplers", json!({"wrapS": 33071, "wrapT": 33648}));
    doc.push("textures", json!({"source": 0, "sampler": 0}));
    doc
}

fn textured(info: Value) -> Doc {
    surfaced(json!({"pbrMetallicRoughness": {"baseColorTexture": info}}))
}

#[test]
fn factors_sides_and_unlit_come_through() {
    let character = surfaced(json!({
        "name": "skin", "doubleSided": true, "extensions": {"KHR_materials_unlit": {}},
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4]},
    }))
    .load();
    let material = &character.materials[0];
    assert_eq!((material.name.as_str(), material.base_color), ("skin", [0.1, 0.2, 0.3, 0.4]));
    assert!(material.double_sided && material.unlit && material.texture.is_none() && material.alpha_cutoff.is_none());
    assert!(character.images.is_empty(), "images that no material uses are left out");
}

#[test]
fn alpha_modes_become_cutoffs() {
    for (material, cutoff, warned) in [
        (json!({"alphaMode": "OPAQUE"}), None, false),
        (json!({"alphaMode": "MASK"}), Some(0.5), false),
        (json!({"alphaMode": "MASK", "alphaCutoff": 0.25}), Some(0.25), false),
        (json!({"alphaMode": "BLEND"}), Some(0.5), true),
        (
            json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25]}}),
            Some(0.125),
            true,
        ),
        (json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0]}}), Some(0.5), true),
    ] {
        let character = surfaced(material).load();
        assert_eq!(character.materials[0].alpha_cutoff, cutoff);
        assert_eq!(warning(&character, "alpha-blend-as-mask").is_some(), warned);
    }
}

#[test]
fn textures_bring_their_image_and_wrapping() {
    let character = textured(json!({"index": 0})).load();
    let texture = character.materials[0].texture.expect("a texture");
    assert_eq!((texture.wrap_u, texture.wrap_v), (RawWrap::Clamp, RawWrap::Mirror));
    let image = &character.images[texture.image as usize];
    assert_eq!((image.encoding, image.width, image.height), (ImageEncoding::Png, 1, 1));
    assert_eq!(image.bytes, PNG);
}

#[test]
fn texture_coordinates_follow_the_material() {
    assert_eq!(textured(json!({"index": 0, "texCoord": 1})).load().mesh.uvs, [[0.5; 2]; 3]);
    let transform = |transform: Value| {
        let info = json!({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": transform}});
        textured(info).load().mesh.uvs
    };
    assert_eq!(transform(json!({"offset": [0.25, 0.5], "scale": [2, 4]})), [[0.25, 0.5], [2.25, 0.5], [0.25, 4.5]]);
    assert_eq!(transform(json!({"texCoord": 1})), [[0.5; 2]; 3]);
    // A quarter turn counter-clockwise as seen with v down: u goes to -v.
    let turned = transform(json!({"rotation": std::f32::consts::FRAC_PI_2}));
    for (found, expected) in turned.iter().zip([[0., 0.], [0., -1.], [1., 0.]]) {
        assert!((found[0] - expected[0]).abs() < 1e-6 && (found[1] - expected[1]).abs() < 1e-6, "{turned:?}");
    }
}

#[test]
fn a_texture_without_coordinates_is_warned_about() {
    let mut doc = textured(json!({"index": 0, "texCoord": 2}));
    let character = doc.load();
    assert_eq!(character.mesh.uvs, [[0.0; 2]; 3]);
    assert!(warning(&character, "uvs-missing").is_some());
    doc.json["materials"][0]["pbrMetallicRoughness"] = json!({});
    assert!(warning(&doc.load(), "uvs-missing").is_none());
}

#[test]
fn webp_is_preferred_and_ktx2_alone_refused() {
    let mut webp = std::io::Cursor::new(Vec::new());
    image::RgbaImage::new(3, 2).write_to(&mut webp, image::ImageFormat::WebP).expect("encodes");
    let mut doc = textured(json!({"index": 0}));
    let view = doc.view(webp.get_ref());
    doc.push("images", json!({"bufferView": view, "name": "face"}));
    doc.json["textures"][0]["extensions"] = json!({"EXT_texture_webp": {"source": 1}});
    let character = doc.load();
    let image = &character.images[0];
    assert_eq!((image.name.as_str(), image.encoding, image.width, image.height), ("face", ImageEncoding::WebP, 3, 2));

    doc.json["textures"][0] = json!({"extensions": {"KHR_texture_basisu": {"source": 1}}});
    assert!(doc.refusal().contains("KTX2"), "{}", doc.refusal());
    doc.json["textures"][0] = json!({"source": 0, "extensions": {"KHR_texture_basisu": {"source": 1}}});
    assert_eq!(doc.load().images[0].encoding, ImageEncoding::Png);
}

#[test]
fn images_that_are_none_are_refused() {
    for (bytes, words) in [
        (&b"\xabKTX 20\xbb"[..], "a KTX2 image is not supported; convert it"),
        (&b"GIF89a"[..], "neither PNG, JPEG nor WebP"),
        (&PNG[..20], "header does not decode"),
    ] {
        let mut doc = textured(json!({"index": 0}));
        let view = doc.view(bytes);
        doc.json["images"][0]["bufferView"] = json!(view);
        assert!(doc.refusal().contains(words), "{}", doc.refusal());
    }
    // A header that promises 100,000 x 100,000 pixels.
    let mut huge = PNG.to_vec();
    huge[16..24].copy_from_slice(&[0, 1, 0x86, 0xa0, 0, 1, 0x86, 0xa0]);
    let mut doc = textured(json!({"index": 0}));
    let view = doc.view(&huge);
    doc.json["images"][0]["bufferView"] = json!(view);
    assert!(doc.refusal().contains("image 0"), "{}", doc.refusal());
}

#[test]
fn images_are_decoded_to_their_end_and_no_side_is_longer_than_packs_hold() {
    let png = |width, height| {
        let mut png = std::io::Cursor::new(Vec::new());
        image::GrayImage::new(width, height).write_to(&mut png, image::ImageFormat::Png).expect("encodes");
        png.into_inner()
    };
    let whole = png(64, 64);
    let mut broken = whole.clone();
    let middle = broken.len() - 24;
    broken[middle] ^= 0x55;
    let cut = whole[..whole.len() - 20].to_vec();
    for (bytes, words) in [
        (broken, Some("does not decode")),
        (cut, Some("does not decode")),
        (png(16_385, 1), Some("found 16385 pixels a side, allowed 16384")),
        (png(1, 16_385), Some("found 16385 pixels a side, allowed 16384")),
        (png(16_384, 1), None),
        (whole, None),
    ] {
        let mut doc = textured(json!({"index": 0}));
        let view = doc.view(&bytes);
        doc.json["images"][0]["bufferView"] = json!(view);
        match words {
            Some(words) => assert!(doc.refusal().contains(words), "{}", doc.refusal()),
            None => assert_eq!(doc.load().images[0].bytes, bytes),
        }
    }
}

#[test]
fn the_old_glossiness_materials_keep_their_diffuse_colour() {
    let character = surfaced(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.25, 1, 1], "diffuseTexture": {"index": 0},
    }}}))
    .load();
    assert_eq!(character.materials[0].base_color, [0.5, 0.25, 1., 1.]);
    assert!(character.materials[0].texture.is_some());
}

#[test]
fn references_out_of_range_are_refused() {
    for (path, words) in [
        ("/meshes/0/primitives/0/material", "material 7, the file has 1"),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", "texture 7, the file has 1"),
        ("/textures/0/source", "image 7, the file has 1"),
        ("/textures/0/sampler", "sampler 7, the file has 1"),
        ("/images/0/bufferView", "buffer view 7, the file has"),
        ("/bufferViews/0/buffer", "buffer 7, the file has 1"),
        ("/accessors/0/bufferView", "buffer view 7, the file has"),
        ("/meshes/0/primitives/0/attributes/POSITION", "accessor 7, the file has 3"),
        ("/nodes/0/mesh", "mesh 7, the file has 1"),
        ("/scene", "scene 7, the file has 1"),
        ("/scenes/0/nodes/0", "node 7, the file has 1"),
    ] {
        let mut doc = textured(json!({"index": 0}));
        *doc.json.pointer_mut(path).expect("there") = json!(7);
        assert!(doc.refusal().contains(words), "{path}: {}", doc.refusal());
    }
}

#[test]
fn what_a_material_has_beside_its_base_colour_is_kept() {
    let info = json!({"index": 0, "texCoord": 1});
    let doc = surfaced(json!({
        "pbrMetallicRoughness": {"metallicFactor": 0.25, "roughnessFactor": 0.5, "metallicRoughnessTexture": info},
        "normalTexture": {"index": 0, "texCoord": 1, "scale": -2.0},
        "occlusionTexture": {"index": 0, "texCoord": 1, "strength": 0.75},
        "emissiveFactor": [1.0, 0.5, 0.0],
        "emissiveTexture": info,
        "alphaMode": "BLEND",
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 4.0},
            "KHR_materials_ior": {},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": info},
        },
    }));
    let character = doc.load();
    let finish = &character.materials[0].finish;
    assert_eq!((finish.metallic, finish.roughness, finish.blend), (0.25, 0.5, true));
    assert_eq!((finish.normal.map(|n| n.1), finish.occlusion.map(|o| o.1)), (Some(-2.0), Some(0.75)));
    assert_eq!((finish.emissive, finish.emissive_strength), ([1.0, 0.5, 0.0], 4.0));
    assert_eq!((finish.ior, finish.specular), (Some(1.5), Some((0.5, [1.0; 3]))));
    let textures = [finish.metallic_roughness, finish.emissive_texture, finish.specular_texture];
    assert!(textures.iter().all(|t| t.is_some_and(|t| t.wrap_u == RawWrap::Clamp && t.wrap_v == RawWrap::Mirror)));
    assert_eq!((character.images.len(), character.finish_images.len()), (0, 1), "one image, and none is shown");
    assert_eq!(character.mesh.uvs, [[0.5; 2]; 3], "without a base colour the first texture's coordinates are kept");
    assert!(warning(&character, "material-reduced").is_none());
    // What glTF says where a file says nothing.
    let bare = surfaced(json!({})).load().materials[0].finish.clone();
    assert_eq!((bare.metallic, bare.roughness, bare.emissive), (1.0, 1.0, [0.0; 3]));
}

#[test]
fn strangers_numbers_are_kept_within_their_ranges() {
    let finish = surfaced(json!({
        "pbrMetallicRoughness": {"metallicFactor": 7, "roughnessFactor": -1},
        "emissiveFactor": [1e30, -1, 0.5],
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 1e300},
            "KHR_materials_ior": {"ior": 0.5},
            "KHR_materials_specular": {"specularFactor": "x", "specularColorFactor": [-1, 1e300]},
        },
    }))
    .load()
    .materials[0]
        .finish
        .clone();
    assert_eq!((finish.metallic, finish.roughness, finish.emissive), (1.0, 0.0, [1.0, 0.0, 0.5]));
    assert_eq!((finish.emissive_strength, finish.ior), (1.0, Some(1.0)));
    assert_eq!(finish.specular, Some((1.0, [0.0, 1.0, 1.0])));
}

#[test]
fn textures_that_cannot_be_kept_are_named_and_take_their_factors_along() {
    let transformed = json!({"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}});
    let mut doc = surfaced(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0, "texCoord": 1},
        },
        "emissiveFactor": [1, 1, 1],
        "emissiveTexture": {"index": 1},
        "normalTexture": transformed,
        "occlusionTexture": {"index": 9},
        "extensions": {"KHR_materials_sheen": {}},
    }));
    doc.push("textures", json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}));
    let character = doc.load();
    let finish = &character.materials[0].finish;
    assert_eq!(*finish, crowd_source::RawFinish::default());
    // The second set of coordinates is read by nothing then, which is said, too.
    let (reduced, others): (Vec<_>, Vec<_>) = character.warnings.iter().partition(|w| w.code == "material-reduced");
    let said: Vec<&str> = reduced.iter().map(|w| w.place.rsplit(": ").next().unwrap()).collect();
    let places =
        ["emissiveTexture", "normalTexture", "metallicRoughnessTexture", "occlusionTexture", "KHR_materials_sheen"];
    assert_eq!(said, places);
    assert_eq!(others.iter().map(|w| w.code).collect::<Vec<_>>(), ["attributes-ignored"]);
    // With the same transform on both it is the mesh's.
    let same =
        surfaced(json!({"pbrMetallicRoughness": {"baseColorTexture": transformed}, "normalTexture": transformed}));
    assert!(same.load().materials[0].finish.normal.is_some());
}

#[test]
fn filters_come_through_and_unknown_ones_are_named() {
    let mut doc = textured(json!({"index": 0}));
    let of = |doc: &Doc| doc.load().materials[0].texture.unwrap().filters;
    assert_eq!(of(&doc), RawFilters::default());
    doc.json["samplers"][0] = json!({"magFilter": 9728, "minFilter": 9985});
    assert_eq!(of(&doc), RawFilters { mag_nearest: true, min: RawMinFilter::LinearMipmapNearest });
    doc.json["samplers"][0] = json!({"magFilter": 7, "minFilter": 8});
    assert_eq!(of(&doc), RawFilters::default());
    assert_eq!(warning(&doc.load(), "filter-unknown").map(|w| w.count), Some(2));
}

#[test]
fn what_nothing_reads_is_named() {
    let mut doc = textured(json!({"index": 0}));
    let other = doc.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"].clone();
    doc.json["meshes"][0]["primitives"][0]["attributes"]["_WIND"] = other;
    let character = doc.load();
    let ignored = warning(&character, "attributes-ignored").unwrap();
    assert_eq!(ignored.count, 2);
    assert!(ignored.message.contains("TEXCOORD_1") && ignored.message.contains("_WIND"), "{}", ignored.message);
    let material = &mut doc.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    material["texCoord"] = json!(1);
    assert!(warning(&doc.load(), "attributes-ignored").unwrap().message.contains("TEXCOORD_0"));
}
