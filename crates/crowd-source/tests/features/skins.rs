//! Skins and rigid parts: the common bind space changes no pose.

use glam::{DMat4, DQuat, DVec3};
use proptest::prelude::*;
use serde_json::json;

use crate::builder::*;

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).length() <= 1e-4 * (1.0 + a.length())
}

/// Two joints; a strip of four vertices, each following some of them.
fn skinned(ibm: [DMat4; 2], weights: [[f32; 4]; 4]) -> Doc {
    let mut doc = Doc::empty();
    let positions = doc.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.]);
    let joints = doc.accessor(U8, "VEC4", 4, &[0u8, 1, 0, 0].repeat(4), false);
    let weights = doc.floats("VEC4", &weights.concat());
    let matrices: Vec<f32> = ibm.iter().flat_map(|m| m.as_mat4().to_cols_array()).collect();
    let matrices = doc.floats("MAT4", &matrices);
    let mesh = doc.mesh(json!({
        "attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights}, "mode": 5
    }));
    let tip = doc.node(json!({"name": "tip", "translation": [0, 1, 0]}));
    let hip = doc.scene_node(json!({"name": "hip", "children": [tip], "translation": [0.5, 0, 0]}));
    doc.push("skins", json!({"joints": [hip, tip], "inverseBindMatrices": matrices}));
    // The skinned node's own transform is ignored.
    doc.scene_node(json!({"mesh": mesh, "skin": 0, "translation": [100, 0, 0]}));
    doc
}

const HALVES: [[f32; 4]; 4] = [[1., 0., 0., 0.], [0.75, 0.25, 0., 0.], [0.25, 0.75, 0., 0.], [0., 1., 0., 0.]];

fn affine() -> impl Strategy<Value = DMat4> {
    let part = -3.0f64..3.0;
    let size = prop_oneof![0.1f64..3.0, -3.0f64..-0.1];
    (
        [part.clone(), part.clone(), part.clone()],
        [-1.0f64..1.0, -1.0f64..1.0, -1.0f64..1.0, 0.1f64..1.0],
        [size.clone(), size.clone(), size],
    )
        .prop_map(|(t, r, s)| {
            let rotation = DQuat::from_array(r).normalize();
            DMat4::from_scale_rotation_translation(DVec3::from_array(s), rotation, DVec3::from_array(t))
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// For any inverse bind matrices and any pose, ours equals the sum that glTF writes down.
    #[test]
    fn moving_the_bind_space_changes_no_pose(
        ibm in [affine(), affine()],
        pose_of in [affine(), affine()],
    ) {
        let doc = skinned(ibm, HALVES);
        let character = doc.load();
        let mut world = rest(&character);
        let node = |name: &str| character.nodes.iter().position(|n| n.name == name).expect("kept");
        world[node("hip")] = pose_of[0];
        world[node("tip")] = pose_of[1];
        let found = pose(&character, &world);
        let naive: Vec<DVec3> = (0..4).map(|v| {
            let position = DVec3::new((v % 2) as f64, (v / 2) as f64, 0.0);
            (0..2).map(|j| {
                let matrix = DMat4::from_cols_array(&ibm[j].as_mat4().to_cols_array().map(f64::from));
                (pose_of[j] * matrix).transform_point3(position) * f64::from(HALVES[v][j])
            }).sum()
        }).collect();
        for expected in naive {
            prop_assert!(found.iter().any(|f| (*f - expected).length() <= 1e-3 * (1.0 + expected.length())), "{expected} not in {found:?}");
        }
    }

    /// An unskinned mesh stands where its node stands, whatever stretches or mirrors it, and faces the same way.
    #[test]
    fn rigid_parts_stand_where_their_node_stands(transform in affine()) {
        let mut doc = Doc::triangle();
        let normals = doc.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
        doc.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
        let matrix = transform.as_mat4();
        doc.json["nodes"][0]["matrix"] = json!(matrix.to_cols_array());
        let character = doc.load();
        prop_assert!(character.mesh.parts[0].rigid);
        let mut found = pose(&character, &rest(&character));
        let world = DMat4::from_cols_array(&matrix.to_cols_array().map(f64::from));
        let mut expected = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| world.transform_point3(p)).to_vec();
        for list in [&mut found, &mut expected] {
            list.sort_by(|a, b| (a.x, a.y, a.z).partial_cmp(&(b.x, b.y, b.z)).expect("finite"));
        }
        for (f, e) in found.iter().zip(&expected) {
            prop_assert!(close(*f, *e), "{f} {e}");
        }
        // The triangle's own direction and its normals agree: winding was turned where the map mirrors.
        let mesh = &character.mesh;
        let [a, b, c] = mesh.triangles[0].map(|v| DVec3::from_array(mesh.positions[v as usize].map(f64::from)));
        let normal = DVec3::from_array(mesh.normals[0].map(f64::from));
        prop_assert!((b - a).cross(c - a).normalize().dot(normal) > 0.999);
    }
}

#[test]
fn two_skins_in_different_units_touch_at_rest() {
    // The second skin is the first one written down in centimetres, lying on its back.
    let metres = skinned([DMat4::IDENTITY, DMat4::from_translation(DVec3::new(0., -1., 0.))], HALVES);
    let mut doc = metres;
    let written = DMat4::from_scale(DVec3::splat(100.0)) * DMat4::from_rotation_x(1.0);
    let back = written.inverse();
    let corners = [[0., 1., 0.], [1., 1., 0.], [0., 2., 0.], [1., 2., 0.]];
    let positions: Vec<f32> =
        corners.iter().flat_map(|p| written.transform_point3(DVec3::from_array(*p)).as_vec3().to_array()).collect();
    let positions = doc.floats("VEC3", &positions);
    let matrices: Vec<f32> = [back, DMat4::from_translation(DVec3::new(0., -1., 0.)) * back]
        .iter()
        .flat_map(|m| m.as_mat4().to_cols_array())
        .collect();
    let matrices = doc.floats("MAT4", &matrices);
    let mut attributes = doc.json["meshes"][0]["primitives"][0]["attributes"].clone();
    attributes["POSITION"] = json!(positions);
    let mesh = doc.mesh(json!({"attributes": attributes, "mode": 5}));
    doc.push("skins", json!({"joints": doc.json["skins"][0]["joints"], "inverseBindMatrices": matrices}));
    doc.scene_node(json!({"mesh": mesh, "skin": 1}));

    let character = doc.load();
    assert_eq!(character.mesh.positions.len(), 8);
    // The upper edge of the first part is the lower edge of the second: in bind space and posed.
    for x in [0.5f32, 1.5] {
        let at = |p: &&[f32; 3]| (p[0] - x).abs() < 1e-3 && (p[1] - 1.0).abs() < 1e-3 && p[2].abs() < 1e-3;
        assert_eq!(character.mesh.positions.iter().filter(at).count(), 2, "{:?}", character.mesh.positions);
    }
    assert_eq!(character.joints.len(), 2, "equal matrices fall together");
}

#[test]
fn twelve_influences_keep_the_four_strongest() {
    let mut doc = Doc::triangle();
    let joints: Vec<u8> = [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]].concat();
    let weights = [[0.02, 0.04, 0.06, 0.08], [0.1, 0.2, 0.05, 0.05], [0.3, 0.05, 0.03, 0.02]];
    for set in 0..3 {
        let numbers = joints[set * 4..set * 4 + 4].repeat(3);
        let joints = doc.accessor(U8, "VEC4", 3, &numbers, false);
        let numbers: Vec<f32> = weights[set].repeat(3);
        let weights = doc.floats("VEC4", &numbers);
        let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
        attributes[format!("JOINTS_{set}")] = json!(joints);
        attributes[format!("WEIGHTS_{set}")] = json!(weights);
    }
    let nodes: Vec<usize> = (0..12).map(|n| doc.scene_node(json!({"name": format!("joint {n}")}))).collect();
    doc.push("skins", json!({"joints": nodes}));
    doc.json["nodes"][0]["skin"] = json!(0);
    let character = doc.load();
    let mesh = &character.mesh;
    let names: Vec<&str> = mesh.joints[0]
        .iter()
        .map(|j| character.nodes[character.joints[*j as usize].node as usize].name.as_str())
        .collect();
    assert_eq!(names, ["joint 8", "joint 5", "joint 4", "joint 3"]);
    for (found, expected) in mesh.weights[0].iter().zip([0.3, 0.2, 0.1, 0.08]) {
        assert!((found - expected / 0.68).abs() < 1e-6);
    }
    assert_eq!(character.joints.len(), 4, "joints that no vertex uses are dropped");
    let dropped = warning(&character, "weights-dropped").expect("a warning");
    assert_eq!(dropped.count, 3);
    assert!(dropped.message.contains("0.060"), "{}", dropped.message);
}

#[test]
fn weights_of_zero_and_below_are_repaired() {
    let mut weights = HALVES;
    weights[0] = [0.0; 4];
    weights[1] = [-1.0, 0.5, 0., 0.];
    let character = skinned([DMat4::IDENTITY; 2], weights).load();
    assert_eq!(warning(&character, "weights-missing").map(|w| w.count), Some(1));
    assert_eq!(warning(&character, "weights-negative").map(|w| w.count), Some(1));
    assert!(character.mesh.weights.iter().all(|w| (w.iter().sum::<f32>() - 1.0).abs() < 1e-6));
}

#[test]
fn weights_that_do_not_sum_to_one_are_scaled_and_counted() {
    let mut weights = HALVES;
    weights[0] = [0.75, 0.75, 0., 0.];
    weights[1] = [0.2, 0.2, 0., 0.];
    let character = skinned([DMat4::IDENTITY; 2], weights).load();
    let scaled = warning(&character, "weights-normalized").expect("a warning");
    assert_eq!(scaled.count, 2);
    assert!(scaled.message.contains("0.400"), "{}", scaled.message);
    assert!(character.mesh.weights.iter().all(|w| (w.iter().sum::<f32>() - 1.0).abs() < 1e-6));
    // What eight bits a weight round by is no repair.
    weights[0] = [0.502, 0.502, 0., 0.];
    weights[1] = HALVES[1];
    let character = skinned([DMat4::IDENTITY; 2], weights).load();
    assert_eq!(warning(&character, "weights-normalized"), None);
}

#[test]
fn a_joint_out_of_range_is_named() {
    let mut doc = skinned([DMat4::IDENTITY; 2], HALVES);
    let joints = doc.accessor(U8, "VEC4", 4, &[0u8, 91, 0, 0].repeat(4), false);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    assert!(
        doc.refusal()
            .ends_with("mesh 0 `torso` primitive 0: JOINTS_0: vertex 1: joint index 91, skeleton has 2 joints"),
        "{}",
        doc.refusal()
    );
}

#[test]
fn a_node_without_size_at_rest_keeps_its_own_space() {
    let mut doc = Doc::triangle();
    doc.json["nodes"][0]["scale"] = json!([0, 0, 0]);
    let character = doc.load();
    assert_eq!(character.mesh.positions, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
    assert_eq!(character.joints[0].inverse_bind, glam::Mat4::IDENTITY.to_cols_array());
}

#[test]
fn a_mesh_under_two_nodes_is_there_twice() {
    let mut doc = Doc::triangle();
    doc.scene_node(json!({"mesh": 0, "translation": [5, 0, 0]}));
    let character = doc.load();
    assert_eq!(character.mesh.triangles.len(), 2);
    assert_eq!(character.joints.len(), 2);
    assert!(character.mesh.positions.contains(&[6., 0., 0.]));
}

#[test]
fn joints_outside_the_scene_still_move_the_mesh() {
    let mut doc = skinned([DMat4::IDENTITY; 2], HALVES);
    doc.json["scenes"][0]["nodes"] = json!([2]);
    let character = doc.load();
    assert_eq!(character.joints.len(), 2);
    doc.json["scenes"][0]["nodes"] = json!([0]);
    assert!(doc.refusal().contains("no triangles"), "what the scene does not show is not read");
}

#[test]
fn loops_and_second_parents_are_refused() {
    let mut doc = Doc::triangle();
    doc.node(json!({"children": [2]}));
    doc.node(json!({"children": [1]}));
    assert!(doc.refusal().contains("node 1: its ancestors form a loop"), "{}", doc.refusal());
    doc.json["nodes"] = json!([{"mesh": 0}, {"children": [0]}, {"children": [0]}]);
    assert!(doc.refusal().contains("node 0: has two parents, nodes 1 and 2"), "{}", doc.refusal());
    doc.json["nodes"] = json!([{"mesh": 0, "children": [9]}]);
    assert!(doc.refusal().contains("node 0: child 9, the file has 1 nodes"), "{}", doc.refusal());
}

#[test]
fn a_matrix_with_shear_is_warned_about() {
    let mut doc = Doc::triangle();
    doc.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    let character = doc.load();
    assert!(warning(&character, "shear-dropped").is_some());
}

#[test]
fn joints_of_vertices_that_no_triangle_uses_are_dropped() {
    let mut doc =
        skinned([DMat4::IDENTITY; 2], [[1., 0., 0., 0.], [1., 0., 0., 0.], [1., 0., 0., 0.], [0., 1., 0., 0.]]);
    let indices = doc.indices(&[0, 1, 2]);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["mode"] = json!(4);
    primitive["indices"] = json!(indices);
    let character = doc.load();
    assert_eq!(character.joints.len(), 1);
    assert_eq!(character.nodes[character.joints[0].node as usize].name, "hip");
}

/// Two skins over one skeleton that does not rest where it was bound: their parts keep their places to each other, though
/// the heaviest joint of each is another one.
#[test]
fn skins_of_one_bind_space_stay_together() {
    let bind = [DMat4::from_rotation_z(0.5), DMat4::from_translation(DVec3::new(3., -1., 0.))];
    let mut doc = skinned(bind, [[1., 0., 0., 0.]; 4]);
    let mut attributes = doc.json["meshes"][0]["primitives"][0]["attributes"].clone();
    let weights = doc.floats("VEC4", &[[0f32, 1., 0., 0.]; 4].concat());
    attributes["WEIGHTS_0"] = json!(weights);
    let mesh = doc.mesh(json!({"attributes": attributes, "mode": 5}));
    let again = doc.json["skins"][0].clone();
    doc.push("skins", again);
    doc.scene_node(json!({"mesh": mesh, "skin": 1}));
    let character = doc.load();
    let (one, other) = character.mesh.positions.split_at(4);
    for (a, b) in one.iter().zip(other) {
        assert!(close(DVec3::from_array(a.map(f64::from)), DVec3::from_array(b.map(f64::from))), "{a:?} {b:?}");
    }
    assert_eq!(character.joints.len(), 2);
}

/// Two people in one file would move as one: that is said. A second skin over the same joints, or over joints that hang
/// from them (a head with a skin of its own), is one person.
#[test]
fn skeletons_that_share_nothing_are_named() {
    let warned = |second: &dyn Fn(&mut Doc) -> serde_json::Value| {
        let mut doc = skinned([DMat4::IDENTITY; 2], HALVES);
        let joints = second(&mut doc);
        doc.push("skins", json!({"name": "other", "joints": joints}));
        doc.scene_node(json!({"mesh": 0, "skin": 1}));
        let warning = doc.load().warnings.into_iter().find(|warning| warning.code == "several-skeletons");
        warning.map(|warning| (warning.count, warning.message.contains("`other`")))
    };
    let same = |doc: &mut Doc| doc.json["skins"][0]["joints"].clone();
    assert_eq!(warned(&same), None);
    let below = |doc: &mut Doc| {
        let (jaw, between) = (doc.node(json!({"name": "jaw"})), doc.node(json!({"name": "between"})));
        let tip = doc.json["skins"][0]["joints"][1].as_u64().unwrap() as usize;
        doc.json["nodes"][tip]["children"] = json!([between]);
        doc.json["nodes"][between]["children"] = json!([jaw]);
        json!([jaw, jaw])
    };
    assert_eq!(warned(&below), None);
    let apart = |doc: &mut Doc| {
        let tip = doc.node(json!({"name": "tip"}));
        json!([doc.scene_node(json!({"name": "hip", "children": [tip]})), tip])
    };
    assert_eq!(warned(&apart), Some((2, true)));
}

#[test]
fn the_rig_lists_all_joints_of_the_skin_in_its_order() {
    let binds = [DMat4::IDENTITY, DMat4::from_translation(DVec3::new(0., -1., 0.))];
    let rig_of = |weights: [[f32; 4]; 4]| {
        let character = skinned(binds, weights).load();
        let name = |joint: &crowd_source::RawJoint| character.nodes[joint.node as usize].name.clone();
        let (rig, joints) = (&character.rig, &character.joints);
        for (joint, &place) in joints.iter().zip(&rig.places) {
            assert_eq!(rig.joints[place as usize], *joint, "vertices keep their matrices");
        }
        (rig.joints.iter().map(name).collect::<Vec<_>>(), rig.places.clone())
    };
    let both = vec!["hip".to_owned(), "tip".to_owned()];
    assert_eq!(rig_of([[0., 1., 0., 0.]; 4]), (both.clone(), vec![1]), "one that nothing follows");
    let reversed = [[0., 1., 0., 0.], [1., 0., 0., 0.], [1., 0., 0., 0.], [1., 0., 0., 0.]];
    assert_eq!(rig_of(reversed), (both, vec![1, 0]), "another order");
    assert_eq!(rig_of(HALVES), (vec![], vec![]), "the list is the character's own");
}
