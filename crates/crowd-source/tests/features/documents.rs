//! Versions, extensions, containers and limits.

use crowd_source::{Limits, RawCredits, load_character};
use serde_json::json;

use crate::builder::*;

#[test]
fn a_character_is_named_after_its_file() {
    let character = Doc::triangle().load();
    assert_eq!(character.name, "character");
    assert_eq!(character.nodes[0].name, "node 0");
    assert!(character.warnings.is_empty(), "{:?}", character.warnings);
}

#[test]
fn versions_that_we_cannot_honour_are_refused_by_name() {
    for (asset, words) in [
        (json!({"version": "1.0"}), "glTF version `1.0` is not supported"),
        (json!({"version": "2.0", "minVersion": "2.1"}), "glTF minVersion \"2.1\" is not supported"),
        (json!({"generator": "x"}), "no `version`"),
    ] {
        let mut doc = Doc::triangle();
        doc.json["asset"] = asset;
        assert!(doc.refusal().contains(words), "{}", doc.refusal());
    }
    let mut doc = Doc::triangle();
    doc.json["asset"] = json!({"version": "2.1", "minVersion": "2.0"});
    doc.load();
}

#[test]
fn credits_come_along() {
    let mut doc = Doc::triangle();
    assert_eq!(doc.load().credits, RawCredits::default());
    let extras = json!({"license": "CC-BY-4.0", "author": "Ada", "crowdbake": {"triangles": 3}});
    doc.json["asset"] = json!({"version": "2.0", "copyright": "2026 Ada", "extras": extras});
    let character = doc.load();
    assert_eq!(character.credits.copyright, "2026 Ada");
    assert_eq!(
        character.credits.extras, r#"{"author":"Ada","license":"CC-BY-4.0"}"#,
        "less what an export says of itself"
    );
    assert!(character.warnings.is_empty());
    // No object, or too long.
    doc.json["asset"] = json!({"version": "2.0", "copyright": "x".repeat((64 << 10) + 1), "extras": [1, 2]});
    let character = doc.load();
    assert_eq!(character.credits, RawCredits::default());
    let codes: Vec<(&str, &str)> = character.warnings.iter().map(|w| (w.code, w.place.as_str())).collect();
    assert_eq!(codes, [("credits-left-out", "asset.copyright")]);
}

#[test]
fn required_extensions_are_refused_by_name_with_a_remedy() {
    for (name, remedy) in [
        ("KHR_draco_mesh_compression", "decompress"),
        ("KHR_texture_basisu", "PNG, JPEG or WebP"),
        ("ACME_hair", "export the file without it"),
    ] {
        let mut doc = Doc::triangle();
        doc.json["extensionsRequired"] = json!([name]);
        let refusal = doc.refusal();
        assert!(refusal.contains(name) && refusal.contains(remedy), "{refusal}");
    }
    let mut doc = Doc::triangle();
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit"]);
    doc.load();
}

#[test]
fn used_extensions_that_change_the_picture_are_warned_about() {
    let mut doc = Doc::triangle();
    doc.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_materials_sheen"]);
    let character = doc.load();
    let codes: Vec<(&str, &str)> = character.warnings.iter().map(|w| (w.code, w.place.as_str())).collect();
    assert_eq!(codes, [("extension-ignored", "EXT_mesh_gpu_instancing")]);
}

#[test]
fn draco_without_plain_data_is_refused_even_where_it_is_not_required() {
    let mut doc = Doc::triangle();
    doc.json["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
    doc.json["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
    assert!(doc.refusal().contains("KHR_draco_mesh_compression"), "{}", doc.refusal());
}

#[test]
fn a_gltf_with_a_byte_order_mark_and_a_glb_called_gltf_are_read() {
    let mut doc = Doc::triangle();
    assert!(load_bytes("a.gltf", &doc.glb()).is_ok());
    doc.json["buffers"][0]["uri"] = json!("data.bin");
    let text = format!("\u{feff}{}", doc.json);
    assert!(load_files(&[("a.gltf", text.as_bytes()), ("data.bin", &doc.bin)]).is_ok());
}

#[test]
fn unknown_kinds_of_file_are_refused() {
    let refusal = load_bytes("a.fbx", b"Kaydara").expect_err("must be refused").to_string();
    assert!(refusal.contains("the extension `.fbx` is not supported; give a .glb, .gltf or .obj"), "{refusal}");
    let refusal = load_bytes("a.glb", b"").expect_err("must be refused").to_string();
    assert!(refusal.contains("empty"), "{refusal}");
}

#[test]
fn limits_are_checked_before_anything_is_made() {
    let check = |change: &dyn Fn(&mut Doc, &mut Limits), words: &str| {
        let mut doc = Doc::triangle();
        let mut limits = Limits::default();
        change(&mut doc, &mut limits);
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.glb");
        std::fs::write(&path, doc.glb()).expect("a file");
        let refusal = load_character(&path, &limits).expect_err(words).to_string();
        assert!(refusal.contains(words), "{refusal}");
    };
    check(&|_, limits| limits.file_bytes = 100, "bytes, allowed 100");
    check(&|_, limits| limits.vertices = 2, "found 3 vertices, allowed 2");
    check(&|_, limits| limits.triangles = 0, "found 1 triangles, allowed 0");
    check(&|_, limits| limits.nodes = 0, "found 1 nodes, allowed 0");
    check(&|_, limits| limits.joints = 0, "found 1 joints, allowed 0");
    // More elements than the view has bytes, and a sparse accessor that is nothing but zeros.
    check(&|doc, _| doc.json["accessors"][0]["count"] = json!(3_000_000), "3000000 elements of 12 bytes");
    check(&|doc, _| doc.json["accessors"][0]["count"] = json!(u64::MAX), "elements of 12 bytes");
    check(
        &|doc, _| {
            doc.json["accessors"][0] = json!({"componentType": F32, "type": "VEC3", "count": 1_000_000_000u64});
        },
        "found 1000000000 vertices",
    );
    check(&|doc, _| doc.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX), "buffer 0 has");
    check(&|doc, _| doc.json["accessors"][0]["byteOffset"] = json!(u64::MAX), "3 elements of 12 bytes");
}
