//! Meshopt compression: modes, filters, and claims that cannot be true.

use serde_json::json;

use crate::builder::*;

/// Puts compressed bytes in place of a plain view.
fn compress(doc: &mut Doc, view: usize, bytes: &[u8], count: usize, stride: usize, mode: &str, filter: &str) {
    let source = doc.view(bytes);
    let offset = doc.json["bufferViews"][source]["byteOffset"].clone();
    doc.json["bufferViews"].as_array_mut().expect("a list").pop();
    // The plain bytes are a fallback buffer that is not there.
    let fallback =
        doc.push("buffers", json!({"byteLength": 1000, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}));
    doc.json["bufferViews"][view] = json!({
        "buffer": fallback, "byteLength": count * stride,
        "extensions": {"EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "byteStride": stride, "count": count,
            "mode": mode, "filter": filter,
        }},
    });
}

#[test]
fn compressed_positions_and_indices_read_like_plain_ones() {
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let mut doc = Doc::triangle();
        let positions = [[0f32, 0., 0.], [2., 0., 0.], [0., 3., 0.]];
        let bytes = meshopt::encode_vertex_buffer(&positions).expect("encodes");
        compress(&mut doc, 0, &bytes, 3, 12, "ATTRIBUTES", "NONE");
        for (mode, bytes) in [
            ("TRIANGLES", meshopt::encode_index_buffer(&[0, 1, 2], 3).expect("encodes")),
            ("INDICES", meshopt::encode_index_sequence(&[0, 1, 2], 3).expect("encodes")),
        ] {
            let mut doc = Doc { json: doc.json.clone(), bin: doc.bin.clone() };
            let indices = doc.indices(&[9, 9, 9]);
            let view = doc.json["bufferViews"].as_array().expect("a list").len() - 1;
            compress(&mut doc, view, &bytes, 3, 2, mode, "NONE");
            doc.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
            doc.json["extensionsRequired"] = json!([name]);
            let text = doc.json.to_string().replace("EXT_meshopt_compression", name);
            doc.json = serde_json::from_str(&text).expect("JSON");
            let mesh = doc.load().mesh;
            assert_eq!(mesh.positions, positions);
            assert_eq!(mesh.triangles, [[0, 1, 2]]);
        }
    }
}

#[test]
fn filters_are_undone() {
    // Exponential: positions.
    let mut doc = Doc::triangle();
    let positions = [[0f32, 0., 0.], [2.5, 0., 0.], [0., -3.0, 0.25]];
    let filtered: Vec<[u32; 3]> = meshopt::encode_filter_exp(&positions, 20, meshopt::EncodeExpMode::Separate);
    let bytes = meshopt::encode_vertex_buffer(&filtered).expect("encodes");
    compress(&mut doc, 0, &bytes, 3, 12, "ATTRIBUTES", "EXPONENTIAL");
    assert_eq!(doc.load().mesh.positions, positions);

    // Octahedral: normals in 8 and 16 bits.
    for wide in [false, true] {
        let mut doc = Doc::triangle();
        let normals = [[0f32, 0.6, 0.8, 0.0]; 3];
        let (bytes, stride, kind) = if wide {
            let filtered: Vec<[i16; 4]> = meshopt::encode_filter_oct(&normals, 12);
            (meshopt::encode_vertex_buffer(&filtered).expect("encodes"), 8, I16)
        } else {
            let filtered: Vec<[i8; 4]> = meshopt::encode_filter_oct(&normals, 8);
            (meshopt::encode_vertex_buffer(&filtered).expect("encodes"), 4, I8)
        };
        let accessor = doc.accessor(kind, "VEC3", 3, &[], true);
        let view = doc.json["bufferViews"].as_array().expect("a list").len() - 1;
        compress(&mut doc, view, &bytes, 3, stride, "ATTRIBUTES", "OCTAHEDRAL");
        doc.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(accessor);
        for normal in doc.load().mesh.normals {
            assert!((normal[1] - 0.6).abs() < 0.02 && (normal[2] - 0.8).abs() < 0.02, "{normal:?}");
        }
    }

    // Quaternion: rotation keys.
    let mut doc = Doc::triangle();
    let rotation = [0.5f32, -0.5, 0.5, 0.5];
    let filtered = meshopt::encode_filter_quat(&[rotation], 12);
    let bytes = meshopt::encode_vertex_buffer(&filtered).expect("encodes");
    let times = doc.floats("SCALAR", &[0.]);
    let output = doc.accessor(I16, "VEC4", 1, &[], true);
    let view = doc.json["bufferViews"].as_array().expect("a list").len() - 1;
    compress(&mut doc, view, &bytes, 1, 8, "ATTRIBUTES", "QUATERNION");
    doc.push(
        "animations",
        json!({
            "samplers": [{"input": times, "output": output}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}],
        }),
    );
    let values = doc.load().clips[0].tracks[0].values.clone();
    let dot: f32 = values.iter().zip(rotation).map(|(a, b)| a * b).sum();
    assert!(dot.abs() > 0.9999, "{values:?}");
}

#[test]
fn impossible_claims_are_refused_before_anything_is_made() {
    let plain = meshopt::encode_vertex_buffer(&[[0f32; 3]; 3]).expect("encodes");
    for (count, stride, mode, words) in [
        (1_000_000_000, 12, "ATTRIBUTES", "cannot come out of"),
        (3, 0, "ATTRIBUTES", "do not fit"),
        (3, 6, "ATTRIBUTES", "do not fit"),
        (4, 2, "TRIANGLES", "do not fit"),
        (3, 12, "WHAT", "mode `WHAT` is not known"),
        (4, 12, "ATTRIBUTES", "do not decode"),
    ] {
        let mut doc = Doc::triangle();
        compress(&mut doc, 0, &plain[..plain.len() - 1], count, stride, mode, "NONE");
        assert!(doc.refusal().contains(words), "{words}: {}", doc.refusal());
    }
}
