//! The folder rule.

use serde_json::json;

use crate::builder::*;

/// A triangle in a `.gltf` whose buffer has a given URI, in a folder with other files.
fn with_uri(uri: &str, files: &[(&str, &[u8])]) -> Result<crowd_source::RawCharacter, crowd_source::Error> {
    let mut doc = Doc::triangle();
    doc.json["buffers"][0]["uri"] = json!(uri);
    let text = doc.json.to_string();
    let mut all = vec![("asset/a.gltf", text.as_bytes())];
    all.extend(files);
    load_files(&all)
}

#[test]
fn names_with_blanks_percent_signs_and_folders_are_found() {
    let bin = Doc::triangle().bin;
    for (uri, name) in [
        ("data.bin", "asset/data.bin"),
        ("./data.bin", "asset/data.bin"),
        ("two%20words.bin", "asset/two words.bin"),
        ("two words.bin", "asset/two words.bin"),
        ("%C3%A4.bin", "asset/ä.bin"),
        ("100%.bin", "asset/100%.bin"),
        ("parts/data.bin", "asset/parts/data.bin"),
        ("parts\\data.bin", "asset/parts/data.bin"),
    ] {
        with_uri(uri, &[(name, &bin)]).unwrap_or_else(|e| panic!("{uri}: {e}"));
    }
    with_uri("parts/../data.bin", &[("asset/data.bin", &bin), ("asset/parts/x", b"")]).expect("stays inside");
}

#[test]
fn data_uris_are_read() {
    use base64::Engine;
    let bin = Doc::triangle().bin;
    let text = base64::engine::general_purpose::STANDARD.encode(&bin);
    let percent: String = bin.iter().map(|b| format!("%{b:02x}")).collect();
    for uri in [
        format!("data:application/octet-stream;base64,{text}"),
        format!("data:application/gltf-buffer;base64,{}", text.trim_end_matches('=')),
        format!("DATA:;base64,{text}"),
        format!("data:,{percent}"),
    ] {
        with_uri(&uri, &[]).unwrap_or_else(|e| panic!("{uri}: {e}"));
    }
    for uri in ["data:;base64,!!!", "data:no comma"] {
        assert!(with_uri(uri, &[]).is_err());
    }
}

#[test]
fn names_that_leave_the_folder_are_refused() {
    let bin = Doc::triangle().bin;
    for uri in [
        "../data.bin",
        "parts/../../data.bin",
        "..%2Fdata.bin",
        "..\\data.bin",
        "/etc/passwd",
        "\\\\server\\share\\data.bin",
        "C:\\data.bin",
        "c:data.bin",
    ] {
        let refusal = with_uri(uri, &[("data.bin", &bin), ("asset/parts/x", b"")]).expect_err(uri).to_string();
        assert!(refusal.contains("leaves the asset's folder"), "{uri}: {refusal}");
    }
}

#[test]
fn other_schemes_are_refused_by_name() {
    for uri in ["https://example.org/data.bin", "file:///etc/passwd", "ftp:x"] {
        let refusal = with_uri(uri, &[]).expect_err(uri).to_string();
        let scheme = uri.split(':').next().expect("a scheme");
        assert!(refusal.contains(&format!("a `{scheme}:` URI (`{uri}`) is not supported")), "{refusal}");
    }
}

#[test]
fn missing_files_and_folders_are_named() {
    let refusal = with_uri("gone.bin", &[]).expect_err("missing").to_string();
    assert!(refusal.contains("gone.bin"), "{refusal}");
    let refusal = with_uri("parts", &[("asset/parts/x", b"")]).expect_err("a folder").to_string();
    assert!(refusal.contains("not a plain file"), "{refusal}");
    let refusal = with_uri("short.bin", &[("asset/short.bin", b"abc")]).expect_err("short").to_string();
    assert!(refusal.contains("buffer 0: says 36 bytes, 3 are there"), "{refusal}");
}

#[cfg(unix)]
#[test]
fn links_that_lead_out_are_refused_and_those_that_stay_are_not() {
    let mut doc = Doc::triangle();
    doc.json["buffers"][0]["uri"] = json!("link.bin");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let inside = folder.path().join("asset");
    std::fs::create_dir(&inside).expect("a folder");
    std::fs::write(inside.join("a.gltf"), doc.json.to_string()).expect("a file");
    for (target, allowed) in [(folder.path().join("out.bin"), false), (inside.join("in.bin"), true)] {
        std::fs::write(&target, &doc.bin).expect("a file");
        let _ = std::fs::remove_file(inside.join("link.bin"));
        std::os::unix::fs::symlink(&target, inside.join("link.bin")).expect("a link");
        let loaded = crowd_source::load_character(&inside.join("a.gltf"), &crowd_source::Limits::default());
        assert_eq!(loaded.is_ok(), allowed, "{loaded:?}");
    }
}

#[test]
fn missing_files_are_named_with_the_asset_and_the_place() {
    let refusal = with_uri("gone.bin", &[]).expect_err("nothing there").to_string();
    assert!(refusal.contains("a.gltf: buffer 0: `gone.bin`: "), "{refusal}");
    let long = format!("a\u{202e}{}.bin", "x".repeat(500));
    let refusal = with_uri(&long, &[]).expect_err("nothing there").to_string();
    assert!(refusal.contains("buffer 0: `a?xxx") && !refusal.contains(&"x".repeat(100)), "{refusal}");
    assert!(!refusal.contains('\u{202e}'), "{refusal:?}");
}

#[test]
fn the_files_that_an_asset_names_are_listed_where_they_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path().canonicalize().expect("it is there");
    let write = |name: &str, bytes: &[u8]| std::fs::write(root.join(name), bytes).expect("the folder is ours");
    let mut doc = Doc::triangle();
    doc.json["buffers"][0]["uri"] = json!("a%20b.bin");
    doc.json["images"] = json!([{"uri": "skin.png"}, {"uri": "gone.png"}, {"uri": "data:,x"}, {"uri": "../up.png"}]);
    write("a.gltf", doc.json.to_string().as_bytes());
    write("b.obj", b"mtllib my paint.mtl\nv 0 0 0\n");
    write("my paint.mtl", b"newmtl m\nmap_Kd -clamp on skin.png\n");
    ["a b.bin", "skin.png", "other.bin"].iter().for_each(|name| write(name, b"?"));
    let listed = |asset: &str| crowd_source::named_files(&root.join(asset));
    assert_eq!(listed("a.gltf"), ["a b.bin", "skin.png"].map(|name| root.join(name)));
    assert_eq!(listed("b.obj"), ["my paint.mtl", "skin.png"].map(|name| root.join(name)));
    assert!(listed("other.bin").is_empty() && listed("gone.gltf").is_empty());
}
