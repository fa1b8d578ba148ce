//! Damaged bytes: whatever they are, the reader answers, and soon. A panic or a hang fails the test by itself.

use serde_json::json;

use crate::builder::*;

/// One of everything, small: skin, clip, texture, sparse and compressed accessors.
fn rich() -> Doc {
    let mut doc = Doc::triangle();
    let normals = doc.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let joints = doc.accessor(U8, "VEC4", 3, &[0u8, 1, 0, 0].repeat(3), false);
    let weights = doc.accessor(U8, "VEC4", 3, &[200u8, 55, 0, 0].repeat(3), true);
    let uvs = doc.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    let indices = doc.indices(&[0, 1, 2]);
    doc.json["meshes"][0]["primitives"][0] = json!({
        "attributes": {"POSITION": 0, "NORMAL": normals, "JOINTS_0": joints, "WEIGHTS_0": weights, "TEXCOORD_0": uvs},
        "indices": indices, "material": 0,
    });
    let changed = doc.view(&[1u8]);
    let values = doc.view(bytemuck::cast_slice(&[3f32, 0., 0.]));
    doc.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": changed, "componentType": U8}, "values": {"bufferView": values}
    });
    let image = doc.view(PNG);
    doc.push("images", json!({"bufferView": image, "mimeType": "image/png"}));
    doc.push("textures", json!({"source": 0}));
    doc.push("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    let tip = doc.node(json!({"translation": [0, 1, 0]}));
    let hip = doc.scene_node(json!({"children": [tip]}));
    let matrices = doc.floats("MAT4", &[glam::Mat4::IDENTITY.to_cols_array(); 2].concat());
    doc.push("skins", json!({"joints": [hip, tip], "inverseBindMatrices": matrices}));
    doc.json["nodes"][0]["skin"] = json!(0);
    let times = doc.floats("SCALAR", &[0., 1.]);
    let turns =
        meshopt::encode_vertex_buffer(&meshopt::encode_filter_quat(&[[0f32, 0., 0., 1.]; 2], 12)).expect("encodes");
    let turns_view = doc.view(&turns);
    let offset = doc.json["bufferViews"][turns_view]["byteOffset"].clone();
    doc.json["bufferViews"][turns_view] = json!({"buffer": 0, "byteLength": 16, "extensions": {"EXT_meshopt_compression": {
        "buffer": 0, "byteOffset": offset, "byteLength": turns.len(), "byteStride": 8, "count": 2, "mode": "ATTRIBUTES",
        "filter": "QUATERNION",
    }}});
    let output = doc.push(
        "accessors",
        json!({
            "bufferView": turns_view, "componentType": I16, "type": "VEC4", "count": 2, "normalized": true
        }),
    );
    doc.push(
        "animations",
        json!({
            "samplers": [{"input": times, "output": output}],
            "channels": [{"sampler": 0, "target": {"node": tip, "path": "rotation"}}],
        }),
    );
    doc
}

/// Reads many versions of one file as if from one path.
struct Bench {
    folder: tempfile::TempDir,
    name: &'static str,
}

impl Bench {
    fn new(name: &'static str) -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder"), name }
    }

    fn load(&self, bytes: &[u8]) -> bool {
        let path = self.folder.path().join(self.name);
        crowd_source::read_character(&path, bytes, &crowd_source::Limits::default()).is_ok()
    }

    /// Every byte with one bit turned, with its top bit turned, and at its ends.
    fn load_with_each_byte_changed(&self, bytes: &[u8]) {
        let mut changed = bytes.to_vec();
        for at in 0..bytes.len() {
            for other in [bytes[at] ^ 1, bytes[at] ^ 0x80, bytes[at] ^ 0x10, 0, 0xff] {
                changed[at] = other;
                self.load(&changed);
            }
            changed[at] = bytes[at];
        }
    }
}

#[test]
fn the_whole_file_is_read() {
    let character = rich().load();
    assert_eq!((character.joints.len(), character.clips.len(), character.images.len()), (2, 1, 1));
}

#[test]
fn every_shorter_glb_is_refused() {
    let bench = Bench::new("a.glb");
    let bytes = rich().glb();
    assert!(bench.load(&bytes));
    for length in 0..bytes.len() {
        assert!(!bench.load(&bytes[..length]), "{length} of {} bytes were accepted", bytes.len());
    }
}

#[test]
fn a_glb_with_any_byte_changed_is_answered() {
    Bench::new("a.glb").load_with_each_byte_changed(&rich().glb());
}

#[test]
fn a_json_with_any_number_changed_is_answered() {
    let bench = Bench::new("a.glb");
    let doc = rich();
    let text = doc.json.to_string();
    let numbers: Vec<(usize, usize)> = {
        let bytes = text.as_bytes();
        let starts = (1..bytes.len()).filter(|i| {
            bytes[*i].is_ascii_digit()
                && !bytes[i - 1].is_ascii_alphanumeric()
                && bytes[i - 1] != b'.'
                && bytes[i - 1] != b'_'
        });
        starts.map(|s| (s, s + bytes[s..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count())).collect()
    };
    for (start, end) in numbers {
        for other in [
            "-1",
            "0",
            "1",
            "2",
            "3",
            "65536",
            "4294967295",
            "4294967296",
            "18446744073709551615",
            "1e300",
            "null",
            "[]",
            "\"x\"",
        ] {
            let changed = format!("{}{other}{}", &text[..start], &text[end..]);
            let Ok(json) = serde_json::from_str(&changed) else { continue };
            bench.load(&Doc { json, bin: doc.bin.clone() }.glb());
        }
    }
}

#[test]
fn damaged_obj_texts_are_answered() {
    let bench = Bench::new("a.obj");
    let library = "newmtl skin\nKd 1 1 1\nd 0.5\nmap_Kd -o 1 2 face.png\n";
    std::fs::write(bench.folder.path().join("a.mtl"), library).expect("a file");
    std::fs::write(bench.folder.path().join("face.png"), PNG).expect("a file");
    let text = "mtllib a.mtl\no one\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1\nvt 0 0\nvt 1 1 1\nvn 0 0 1\n\
        g two\nf 1/1/1 2/2/1 3/1/1 -1/-1/-1\ns off\nf 1 2 3\n";
    assert!(bench.load(text.as_bytes()));
    for length in 0..text.len() {
        bench.load(&text.as_bytes()[..length]);
    }
    bench.load_with_each_byte_changed(text.as_bytes());

    let bench_library = Bench::new("a.mtl");
    std::fs::write(bench_library.folder.path().join("face.png"), PNG).expect("a file");
    let obj = bench_library.folder.path().join("a.obj");
    std::fs::write(&obj, text).expect("a file");
    let mut changed = library.as_bytes().to_vec();
    for at in 0..changed.len() {
        let kept = changed[at];
        for other in [kept ^ 1, kept ^ 0x80, b'\n', b' ', 0] {
            changed[at] = other;
            std::fs::write(bench_library.folder.path().join("a.mtl"), &changed).expect("a file");
            let _ = crowd_source::load_character(&obj, &crowd_source::Limits::default());
        }
        changed[at] = kept;
    }
}
