//! Malformed inputs, each named after the answer it must get, and the list of those answers.

use crate::Fixture;
use crate::glb::{Document, Primitive, pack_glb};
use crate::proofs::triangle;

/// A file that must be refused: its name, the error's kind, and words that the message must contain.
struct Refusal {
    name: &'static str,
    bytes: Vec<u8>,
    kind: &'static str,
    words: &'static [&'static str],
}

/// All malformed inputs and `expected.json`.
pub fn refusals() -> Vec<Fixture> {
    let mut list = containers();
    list.extend(meshes());
    list.extend(skeletons_and_clips());
    list.extend(references());
    list.extend(objects());
    list.sort_by_key(|r| r.name);
    let lines: Vec<String> = list
        .iter()
        .map(|r| {
            let words: Vec<String> = r.words.iter().map(|w| format!("\"{w}\"")).collect();
            format!("  {{ \"file\": \"{}\", \"kind\": \"{}\", \"words\": [{}] }}", r.name, r.kind, words.join(", "))
        })
        .collect();
    let expected = format!("[\n{}\n]\n", lines.join(",\n"));
    let mut out: Vec<Fixture> =
        list.into_iter().map(|r| Fixture { path: format!("bad/{}", r.name), bytes: r.bytes }).collect();
    out.push(Fixture { path: "bad/expected.json".into(), bytes: expected.into_bytes() });
    out
}

/// The smallest character with no picture, so that the files stay readable.
fn plain() -> Document {
    let mut d = triangle();
    d.images.clear();
    d.materials[0].image = None;
    d
}

fn edited(d: &Document, edit: impl Fn(&mut Primitive)) -> Vec<u8> {
    let mut d = d.clone();
    edit(&mut d.meshes[0].1[0]);
    d.to_glb()
}

/// The plain character as glTF text with its buffer inside, after replacing `from` by `to`.
fn text(from: &str, to: &str) -> Vec<u8> {
    text_of(&plain(), from, to)
}

fn text_of(d: &Document, from: &str, to: &str) -> Vec<u8> {
    let (_, bytes) = d.parts(None);
    let (json, _) = d.parts(Some(&format!("data:application/octet-stream;base64,{}", base64(&bytes))));
    assert!(json.contains(from), "the document has `{from}`");
    json.replacen(from, to, 1).into_bytes()
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let word = (0..3).fold(0_u32, |w, k| w << 8 | u32::from(*chunk.get(k).unwrap_or(&0)));
        for k in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * k) & 63) as usize] as char;
            out.push(if k <= chunk.len() { letter } else { '=' });
        }
    }
    out
}

fn containers() -> Vec<Refusal> {
    let glb = plain().to_glb();
    let mut wrong_magic = glb.clone();
    wrong_magic[0] = b'G';
    let mut wrong_version = glb.clone();
    wrong_version[4] = 7;
    let mut long_chunk = glb.clone();
    long_chunk[12..16].copy_from_slice(&0xffff_fff0_u32.to_le_bytes());
    let (json, bytes) = plain().parts(None);
    vec![
        Refusal { name: "truncated.glb", bytes: glb[..glb.len() / 2].to_vec(), kind: "format", words: &[] },
        Refusal { name: "not_a_glb.glb", bytes: wrong_magic, kind: "format", words: &[] },
        Refusal { name: "glb_version_7.glb", bytes: wrong_version, kind: "format", words: &[] },
        Refusal { name: "glb_chunk_beyond_file.glb", bytes: long_chunk, kind: "format", words: &[] },
        Refusal {
            name: "binary_chunk_too_short.glb",
            bytes: pack_glb(&json, &bytes[..16]),
            kind: "format",
            words: &[],
        },
        Refusal { name: "empty.gltf", bytes: Vec::new(), kind: "format", words: &[] },
        Refusal { name: "not_json.gltf", bytes: b"{ \"asset\": { \"version\": ".to_vec(), kind: "format", words: &[] },
        Refusal {
            name: "version_3.gltf",
            bytes: text("\"version\":\"2.0\"", "\"version\":\"3.0\",\"minVersion\":\"3.0\""),
            kind: "unsupported",
            words: &["3.0"],
        },
        Refusal {
            name: "draco_required.gltf",
            bytes: text(
                "\"scene\":0",
                "\"extensionsUsed\":[\"KHR_draco_mesh_compression\"],\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"scene\":0",
            ),
            kind: "unsupported",
            words: &["KHR_draco_mesh_compression"],
        },
        Refusal {
            name: "unknown_required_extension.gltf",
            bytes: text(
                "\"scene\":0",
                "\"extensionsUsed\":[\"EXT_tomorrow\"],\"extensionsRequired\":[\"EXT_tomorrow\"],\"scene\":0",
            ),
            kind: "unsupported",
            words: &["EXT_tomorrow"],
        },
    ]
}

fn meshes() -> Vec<Refusal> {
    let d = plain();
    let mut no_mesh = d.clone();
    no_mesh.meshes.clear();
    no_mesh.materials.clear();
    no_mesh.nodes[0].mesh = None;
    vec![
        Refusal {
            name: "index_out_of_range.glb",
            bytes: edited(&d, |p| p.indices[1] = 7),
            kind: "format",
            words: &["7"],
        },
        Refusal {
            name: "nan_position.glb",
            bytes: edited_json(&d, |p| p.positions[1][1] = f32::NAN),
            kind: "format",
            words: &["POSITION"],
        },
        Refusal {
            name: "infinite_position.glb",
            bytes: edited_json(&d, |p| p.positions[2][1] = f32::INFINITY),
            kind: "format",
            words: &["POSITION"],
        },
        Refusal {
            name: "nan_weight.glb",
            bytes: edited(&d, |p| p.weights[0][0] = f32::NAN),
            kind: "format",
            words: &["WEIGHTS_0"],
        },
        Refusal {
            name: "attribute_counts_differ.glb",
            bytes: edited(&d, |p| p.uvs.truncate(2)),
            kind: "format",
            words: &["TEXCOORD_0"],
        },
        Refusal {
            name: "zero_triangles.gltf",
            bytes: text("\"indices\":5,", "\"indices\":5,\"mode\":0,"),
            kind: "format",
            words: &["triangle"],
        },
        Refusal { name: "no_mesh.glb", bytes: no_mesh.to_glb(), kind: "format", words: &[] },
        Refusal { name: "no_positions.gltf", bytes: text("\"POSITION\":0,", ""), kind: "format", words: &["POSITION"] },
        Refusal {
            name: "accessor_count_huge.gltf",
            bytes: text("\"componentType\":5126,\"count\":3", "\"componentType\":5126,\"count\":4000000000"),
            kind: "format",
            words: &["4000000000"],
        },
        Refusal {
            name: "sparse_count_huge.gltf",
            bytes: text(
                "{\"bufferView\":0,\"componentType\":5126,\"count\":3",
                "{\"sparse\":{\"count\":3000000000,\"indices\":{\"bufferView\":5,\"componentType\":5123},\"values\":{\"bufferView\":0}},\"bufferView\":0,\"componentType\":5126,\"count\":3",
            ),
            kind: "format",
            words: &["sparse"],
        },
        Refusal {
            name: "buffer_view_beyond_buffer.gltf",
            bytes: text("\"byteLength\":36,", "\"byteLength\":36000,"),
            kind: "format",
            words: &["36000"],
        },
        Refusal {
            name: "buffer_view_offset_overflows.gltf",
            bytes: text("\"byteOffset\":0,", "\"byteOffset\":18446744073709551600,"),
            kind: "format",
            words: &[],
        },
        Refusal {
            name: "index_type_float.gltf",
            bytes: text("\"componentType\":5123", "\"componentType\":5126"),
            kind: "format",
            words: &["ind"],
        },
    ]
}

/// As [`edited`], with the bounds that JSON cannot write left out.
fn edited_json(d: &Document, edit: impl Fn(&mut Primitive)) -> Vec<u8> {
    let mut d = d.clone();
    edit(&mut d.meshes[0].1[0]);
    let (json, bytes) = d.parts(None);
    let json = json.replace("NaN", "0").replace("inf", "1");
    pack_glb(&json, &bytes)
}

fn skeletons_and_clips() -> Vec<Refusal> {
    let d = plain();
    let mut backwards = d.clone();
    backwards.clips[0].times = vec![0.0, 0.8, 0.5];
    let mut short = d.clone();
    short.clips[0].times.push(2.0);
    vec![
        Refusal {
            name: "joint_index_beyond_skeleton.glb",
            bytes: edited(&d, |p| p.joints[2][0] = 91),
            kind: "format",
            words: &["91", "2"],
        },
        Refusal {
            name: "node_cycle.gltf",
            bytes: text("{\"name\":\"top\"", "{\"name\":\"top\",\"children\":[1]"),
            kind: "format",
            words: &["node"],
        },
        Refusal {
            name: "node_child_missing.gltf",
            bytes: text("\"children\":[2]", "\"children\":[27]"),
            kind: "format",
            words: &["27"],
        },
        Refusal {
            name: "skin_joint_missing.gltf",
            bytes: text("\"joints\":[1,2]", "\"joints\":[1,88]"),
            kind: "format",
            words: &["88"],
        },
        Refusal { name: "times_not_increasing.glb", bytes: backwards.to_glb(), kind: "format", words: &["time"] },
        Refusal { name: "keys_fewer_than_times.glb", bytes: short.to_glb(), kind: "format", words: &["3", "4"] },
    ]
}

fn references() -> Vec<Refusal> {
    let (outside, _) = plain().parts(Some("../../good/mara.glb"));
    let (absolute, _) = plain().parts(Some("/etc/hostname"));
    let (encoded, _) = plain().parts(Some("%2e%2e/%2e%2e/Cargo.toml"));
    let (missing, _) = plain().parts(Some("there_is_no_such_buffer.bin"));
    let (remote, _) = plain().parts(Some("https://example.org/buffer.bin"));
    let (broken, _) = plain().parts(Some("data:application/octet-stream;base64,@@@@"));
    vec![
        Refusal {
            name: "uri_leaves_folder.gltf",
            bytes: outside.into(),
            kind: "format",
            words: &["../../good/mara.glb"],
        },
        Refusal { name: "uri_is_absolute.gltf", bytes: absolute.into(), kind: "format", words: &["/etc/hostname"] },
        Refusal { name: "uri_leaves_folder_percent_encoded.gltf", bytes: encoded.into(), kind: "format", words: &[] },
        Refusal {
            name: "missing_buffer.gltf",
            bytes: missing.into(),
            kind: "io",
            words: &["there_is_no_such_buffer.bin"],
        },
        Refusal {
            name: "uri_is_remote.gltf",
            bytes: remote.into(),
            kind: "unsupported",
            words: &["https://example.org/buffer.bin"],
        },
        Refusal { name: "data_uri_not_base64.gltf", bytes: broken.into(), kind: "format", words: &["base64"] },
    ]
}

fn objects() -> Vec<Refusal> {
    const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";
    let with = |face: &str| format!("{CORNERS}{face}\n").into_bytes();
    vec![
        Refusal { name: "face_index_zero.obj", bytes: with("f 0 1 2"), kind: "format", words: &["0"] },
        Refusal { name: "face_index_beyond.obj", bytes: with("f 1 2 9"), kind: "format", words: &["9"] },
        Refusal { name: "texture_index_beyond.obj", bytes: with("f 1/1 2/5 3/1"), kind: "format", words: &["5"] },
        Refusal { name: "face_before_vertices.obj", bytes: b"f 1 2 3\n".to_vec(), kind: "format", words: &[] },
        Refusal {
            name: "vertex_not_a_number.obj",
            bytes: b"v 0 zero 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(),
            kind: "format",
            words: &[],
        },
        Refusal { name: "no_faces.obj", bytes: CORNERS.as_bytes().to_vec(), kind: "format", words: &[] },
        Refusal { name: "empty.obj", bytes: Vec::new(), kind: "format", words: &[] },
        Refusal {
            name: "material_leaves_folder.obj",
            bytes: [b"mtllib ../../../secret.mtl\n", with("f 1 2 3").as_slice()].concat(),
            kind: "format",
            words: &["../../../secret.mtl"],
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_pads() {
        assert_eq!(base64(b"M"), "TQ==");
        assert_eq!(base64(b"Ma"), "TWE=");
        assert_eq!(base64(b"Man"), "TWFu");
    }
}
