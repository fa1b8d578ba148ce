//! Primitives: modes, indices, component types, sparse and interleaved data, normals, colours.

use proptest::prelude::*;
use serde_json::json;

use crate::builder::*;

/// 0 1     the square in the xy plane
/// 2 3
const SQUARE: [f32; 12] = [0., 1., 0., 1., 1., 0., 0., 0., 0., 1., 0., 0.];

fn triangle_positions(doc: &Doc) -> Vec<[[f32; 3]; 3]> {
    let character = doc.load();
    let mesh = &character.mesh;
    mesh.triangles.iter().map(|t| t.map(|v| mesh.positions[v as usize])).collect()
}

#[test]
fn strips_fans_lists_and_plain_vertices_give_the_same_square() {
    let corners =
        |order: &[usize]| -> Vec<f32> { order.iter().flat_map(|v| SQUARE[v * 3..v * 3 + 3].to_vec()).collect() };
    let square = [[[0., 1., 0.], [0., 0., 0.], [1., 1., 0.]], [[1., 1., 0.], [0., 0., 0.], [1., 0., 0.]]];
    let with = |mode: u32, positions: Vec<f32>, indices: Option<&[u16]>| {
        let mut doc = Doc::empty();
        let positions = doc.floats("VEC3", &positions);
        let mut primitive = json!({"attributes": {"POSITION": positions}, "mode": mode});
        if let Some(indices) = indices {
            primitive["indices"] = json!(doc.indices(indices));
        }
        let mesh = doc.mesh(primitive);
        doc.scene_node(json!({"mesh": mesh}));
        let mut found = triangle_positions(&doc);
        // Rotated so that the smallest corner comes first: where a triangle begins means nothing.
        let turn = |t: &mut [[f32; 3]; 3]| {
            while !(t[0] <= t[1] && t[0] <= t[2]) {
                t.rotate_left(1)
            }
        };
        found.iter_mut().for_each(turn);
        let mut expected = square.to_vec();
        expected.iter_mut().for_each(turn);
        found.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
        expected.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
        assert_eq!(found, expected, "mode {mode}");
    };
    with(4, SQUARE.to_vec(), Some(&[0, 2, 1, 1, 2, 3]));
    with(4, corners(&[0, 2, 1, 1, 2, 3]), None);
    with(5, SQUARE.to_vec(), Some(&[0, 2, 1, 3]));
    with(5, corners(&[0, 2, 1, 3]), None);
    with(6, SQUARE.to_vec(), Some(&[1, 0, 2, 3]));
    with(6, corners(&[1, 0, 2, 3]), None);
}

#[test]
fn points_and_lines_are_left_out_with_a_warning_and_alone_refused() {
    let mut doc = Doc::triangle();
    let positions = doc.floats("VEC3", &SQUARE);
    let lines = json!({"attributes": {"POSITION": positions}, "mode": 1});
    doc.json["meshes"][0]["primitives"].as_array_mut().expect("a list").push(lines.clone());
    let character = doc.load();
    assert_eq!(character.mesh.triangles.len(), 1);
    assert_eq!(warning(&character, "points-and-lines-skipped").map(|w| w.count), Some(1));

    doc.json["meshes"][0]["primitives"] = json!([lines]);
    assert!(doc.refusal().contains("1 primitives are points or lines"), "{}", doc.refusal());
}

#[test]
fn an_index_out_of_range_is_named() {
    let mut doc = Doc::triangle();
    doc.json["meshes"][0]["primitives"][0]["indices"] = json!(doc.json["accessors"].as_array().map(Vec::len));
    doc.indices(&[0, 1, 7]);
    assert!(
        doc.refusal()
            .ends_with("mesh 0 `torso` primitive 0: indices: index 2 is vertex 7, the primitive has 3 vertices"),
        "{}",
        doc.refusal()
    );
}

#[test]
fn positions_that_are_no_numbers_name_their_vertex() {
    let mut doc = Doc::empty();
    let positions = doc.floats("VEC3", &[0., 0., 0., 1., f32::NAN, 0., 0., 1., 0.]);
    let mesh = doc.mesh(json!({"attributes": {"POSITION": positions}}));
    doc.scene_node(json!({"mesh": mesh}));
    assert!(doc.refusal().contains("POSITION: vertex 1 is [1.0, NaN, 0.0]"), "{}", doc.refusal());
}

#[test]
fn sparse_accessors_change_their_base_and_start_from_zero_without_one() {
    for with_base in [true, false] {
        let mut doc = Doc::triangle();
        let indices = doc.view(&[1u8, 2]);
        let values = doc.view(bytemuck::cast_slice(&[3f32, 0., 0., 0., 5., 0.]));
        doc.json["accessors"][0]["sparse"] = json!({
            "count": 2, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}
        });
        if !with_base {
            doc.json["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
        }
        assert_eq!(doc.load().mesh.positions, [[0., 0., 0.], [3., 0., 0.], [0., 5., 0.]]);
    }
    let mut doc = Doc::triangle();
    let indices = doc.view(&[1u8, 3]);
    let values = doc.view(bytemuck::cast_slice(&[0f32; 6]));
    doc.json["accessors"][0]["sparse"] = json!({
        "count": 2, "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}
    });
    assert!(doc.refusal().contains("sparse: index 3, the accessor has 3 elements"), "{}", doc.refusal());
}

#[test]
fn missing_normals_mean_flat_shading_and_split_a_shared_material() {
    let mut doc = Doc::triangle();
    let normals = doc.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    doc.push("materials", json!({"name": "skin"}));
    doc.json["meshes"][0]["primitives"] = json!([
        {"attributes": {"POSITION": 0}, "material": 0},
        {"attributes": {"POSITION": 0, "NORMAL": normals}, "material": 0},
        {"attributes": {"POSITION": 0}, "material": 0},
    ]);
    let character = doc.load();
    let flats: Vec<bool> = character.materials.iter().map(|m| m.flat_normals).collect();
    assert_eq!(flats, [true, false]);
    let used: Vec<u32> = character.mesh.parts.iter().map(|p| p.material).collect();
    assert_eq!(used, [0, 1, 0]);
    assert!(character.mesh.normals.iter().all(|n| *n == [0., 0., 1.]));
}

#[test]
fn a_normal_without_direction_is_computed_with_a_warning() {
    let mut doc = Doc::triangle();
    let normals = doc.floats("VEC3", &[0., 0., 2., 0., 0., 0., f32::NAN, 0., 1.]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let character = doc.load();
    assert!(character.mesh.normals.iter().all(|n| *n == [0., 0., 1.]));
    assert_eq!(warning(&character, "normals-repaired").map(|w| w.count), Some(2));
}

#[test]
fn colours_of_every_type_become_linear_rgba8() {
    let mut doc = Doc::triangle();
    let colors = doc.floats("VEC3", &[1., 0.5, 0., 0., 0., 0., 2., -1., f32::NAN]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    assert_eq!(doc.load().mesh.colors, [[255, 128, 0, 255], [0, 0, 0, 255], [255, 0, 0, 255]]);

    let bytes: [u8; 12] = [255, 128, 0, 7, 1, 2, 3, 4, 0, 0, 0, 0];
    let colors = doc.accessor(U8, "VEC4", 3, &bytes, true);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    assert_eq!(doc.load().mesh.colors, [[255, 128, 0, 7], [1, 2, 3, 4], [0, 0, 0, 0]]);

    let words: [u16; 12] = [65535, 32896, 0, 65535, 0, 0, 0, 0, 257, 257, 257, 257];
    let colors = doc.accessor(U16, "VEC4", 3, bytemuck::cast_slice(&words), true);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    assert_eq!(doc.load().mesh.colors, [[255, 128, 0, 255], [0; 4], [1; 4]]);
}

#[test]
fn equal_vertices_are_merged_and_unused_ones_dropped() {
    let mut doc = Doc::empty();
    let six: Vec<f32> = [0usize, 2, 1, 1, 2, 3, 0].iter().flat_map(|v| SQUARE[v * 3..v * 3 + 3].to_vec()).collect();
    let positions = doc.floats("VEC3", &six);
    let indices = doc.indices(&[0, 1, 2, 3, 4, 5]);
    let mesh = doc.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices}));
    doc.scene_node(json!({"mesh": mesh}));
    let mesh = doc.load().mesh;
    assert_eq!(mesh.positions.len(), 4);
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
}

#[test]
fn triangles_that_use_a_vertex_twice_are_left_out() {
    let mut doc = Doc::triangle();
    let indices = doc.indices(&[0, 1, 2, 1, 1, 2]);
    doc.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let character = doc.load();
    assert_eq!(character.mesh.triangles.len(), 1);
    assert_eq!(warning(&character, "degenerate-triangles-dropped").map(|w| w.count), Some(1));
}

#[test]
fn a_mesh_of_degenerate_triangles_alone_is_refused_by_that_name() {
    let mut doc = Doc::triangle();
    let indices = doc.indices(&[1, 1, 1, 2, 2, 0]);
    doc.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let refusal = doc.refusal();
    assert!(refusal.contains("all 2 triangles are degenerate: two corners at one place"), "{refusal}");
}

#[test]
fn positions_beyond_a_thousand_kilometres_name_their_vertex_and_the_remedy() {
    let mut doc = Doc::triangle();
    let far = doc.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.5e6, 0.0]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(far);
    let refusal = doc.refusal();
    for part in ["mesh 0", "vertex 2", "-1500000.0", "allowed up to 1000000 m", "scale the model down"] {
        assert!(refusal.contains(part), "no {part:?} in {refusal}");
    }
}

#[test]
fn attributes_of_different_length_are_refused() {
    let mut doc = Doc::triangle();
    let normals = doc.floats("VEC3", &[0.; 6]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    assert!(doc.refusal().contains("NORMAL has 2 elements, POSITION has 3"), "{}", doc.refusal());
}

#[test]
fn morph_targets_are_counted_and_named() {
    let mut doc = Doc::triangle();
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 0}, {"POSITION": 0}]);
    let character = doc.load();
    let warning = warning(&character, "morph-targets-ignored").expect("a warning");
    assert_eq!((warning.count, warning.place.as_str()), (2, "mesh 0 `torso` primitive 0"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Any component type, stride, offset and normalisation reads back what was written.
    #[test]
    fn accessors_read_what_was_written(
        numbers in prop::collection::vec(0u8..=255, 6),
        kind in prop::sample::select(vec![I8, U8, I16, U16, F32]),
        normalized in any::<bool>(),
        gap in 0usize..4,
        lead in 0usize..3,
    ) {
        let size = match kind { I8 | U8 => 1, I16 | U16 => 2, _ => 4 };
        let stride = size * 2 + gap * 4;
        let mut bytes = vec![0xeeu8; lead * 4];
        let mut expected = Vec::new();
        for pair in numbers.chunks(2) {
            let mut element = Vec::new();
            for n in pair {
                let n = *n;
                // Wide types get a wide number: the byte in both halves.
                let wide = u16::from(n) * 257;
                let (raw, value, max): (Vec<u8>, f32, f32) = match kind {
                    I8 => (vec![n], f32::from(n as i8), 127.0),
                    U8 => (vec![n], f32::from(n), 255.0),
                    I16 => (wide.to_le_bytes().to_vec(), f32::from(wide as i16), 32767.0),
                    U16 => (wide.to_le_bytes().to_vec(), f32::from(wide), 65535.0),
                    _ => (f32::from(n).to_le_bytes().to_vec(), f32::from(n), 1.0),
                };
                element.extend(raw);
                expected.push(if normalized && kind != F32 { (value / max).max(-1.0) } else { value });
            }
            element.resize(stride, 0xee);
            bytes.extend(element);
        }
        let mut doc = Doc::triangle();
        let view = doc.view(&bytes);
        if stride >= 4 {
            doc.json["bufferViews"][view]["byteStride"] = json!(stride);
        }
        let accessor = doc.push("accessors", json!({
            "bufferView": view, "byteOffset": lead * 4, "componentType": kind, "type": "VEC2", "count": 3,
            "normalized": normalized,
        }));
        doc.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(accessor);
        let found: Vec<f32> = doc.load().mesh.uvs.concat();
        prop_assert_eq!(found, expected);
    }
}
