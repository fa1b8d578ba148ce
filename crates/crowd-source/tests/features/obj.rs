//! OBJ and MTL.

use crowd_source::{RawCharacter, RawWrap};

use crate::builder::*;

fn load(text: &str) -> RawCharacter {
    load_bytes("a.obj", text.as_bytes()).unwrap_or_else(|e| panic!("{e}"))
}

fn refusal(text: &str) -> String {
    load_bytes("a.obj", text.as_bytes()).expect_err(text).to_string()
}

/// 3---2   two triangles that meet in a seam: positions 1 and 3 have two texture points each
/// | / |
/// 1---4
const SEAM: &str = "v 0 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\n\
    vt 0 0\nvt 1 0.25\nvt 0 1\nvt 0.5 0.5\nvt 0.75 0.75\n\
    f 1/1 2/2 3/3\nf 1/4 4/5 2/2\n";

#[test]
fn positions_and_texture_points_get_one_index_with_v_down() {
    let mesh = load(SEAM).mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 1]]);
    assert_eq!(mesh.positions, [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0., 0.], [1., 0., 0.]]);
    assert_eq!(mesh.uvs, [[0., 1.], [1., 0.75], [0., 0.], [0.5, 0.5], [0.75, 0.25]]);
}

#[test]
fn a_static_character_has_one_node_and_one_joint() {
    let character = load(SEAM);
    assert_eq!((character.nodes.len(), character.joints.len(), character.clips.len()), (1, 1, 0));
    assert!(character.mesh.weights.iter().all(|w| *w == [1., 0., 0., 0.]));
    assert!(!character.materials[0].flat_normals);
    assert!(character.mesh.normals.iter().all(|n| *n == [0., 0., 1.]));
}

#[test]
fn quads_and_concave_faces_keep_their_area() {
    //  4     2
    //  |\ 3 /|      an arrow head: corner 3 points inwards
    //  | \ / |
    //  0------1
    let area = |text: &str| -> f32 {
        let mesh = load(text).mesh;
        let at = |v: u32| glam::Vec3::from_array(mesh.positions[v as usize]);
        mesh.triangles.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a)).z / 2.0).sum()
    };
    let signed = |text: &str| -> Vec<f32> {
        let mesh = load(text).mesh;
        let at = |v: u32| glam::Vec3::from_array(mesh.positions[v as usize]);
        mesh.triangles.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a)).z).collect()
    };
    let quad = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n";
    assert_eq!(area(quad), 4.0);
    let arrow = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\n";
    for face in ["f 1 2 3 4 5", "f 2 3 4 5 1", "f 3 4 5 1 2", "f 4 5 1 2 3", "f 5 1 2 3 4"] {
        let text = format!("{arrow}{face}\n");
        assert_eq!(area(&text), 2.5, "{face}");
        assert!(signed(&text).iter().all(|a| *a > 0.0), "{face}: a triangle lies outside the face");
    }
    let dart = "v 0 0 0\nv 1 3 0\nv 0 1 0\nv -1 3 0\n";
    for face in ["f 1 2 3 4", "f 2 3 4 1", "f 3 4 1 2", "f 4 1 2 3"] {
        let text = format!("{dart}{face}\n");
        assert!(signed(&text).iter().all(|a| *a > 0.0), "{face}: a triangle lies outside the face");
    }
}

#[test]
fn negative_indices_count_back() {
    let mesh = load("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\n").mesh;
    assert_eq!(mesh.positions, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
}

#[test]
fn corners_without_texture_point_or_normal_do_not_shift_the_others() {
    let character = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.5\nvn 0 0 1\nf 1/1/1 2 3//1\n");
    assert_eq!(character.mesh.uvs, [[0.5, 0.5], [0., 0.], [0., 0.]]);
    assert_eq!(warning(&character, "uvs-missing").map(|w| w.count), Some(2));
    assert_eq!(warning(&character, "normals-missing").map(|w| w.count), Some(1));
}

#[test]
fn colours_on_all_vertices_are_read_and_on_some_left_out() {
    let all = load("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    assert_eq!(all.mesh.colors, [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]]);
    let some = load("v 0 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    assert_eq!(some.mesh.colors, [[255; 4]; 3]);
}

#[test]
fn wrong_lines_are_named() {
    for (text, words) in [
        ("v 0 0\n", "line 1: `v 0 0`: 2 numbers, expected 3"),
        ("v 0 nan 0\n", "line 1: `v 0 nan 0`: NaN is not finite"),
        ("v 0 0 0\nf 1 1\n", "line 2: a face of 2 corners"),
        ("v 0 0 0\nf 1 2 3\n", "line 2: face corner `2`: vertex 2, the file has 1"),
        ("v 0 0 0\nf 0 1 1\n", "line 2: face corner `0`: vertex 0, the file has 1"),
        ("v 0 0 0\nf 1/1 1 1\n", "line 2: face corner `1/1`: texture point 1, the file has 0"),
        ("v 0 0 0\nf 1 1 x\n", "line 2: face corner `x`: not an index"),
        ("v 0 0 0\nf 1 1 -9223372036854775808\n", "line 2: face corner"),
        ("v 0 0 0\n", "no faces"),
        ("", "no faces"),
    ] {
        let refusal = refusal(text);
        assert!(refusal.contains(words), "{words}: {refusal}");
    }
}

#[test]
fn utf16_texts_are_read() {
    let mut bytes = vec![0xff, 0xfe];
    bytes.extend(SEAM.encode_utf16().flat_map(u16::to_le_bytes));
    assert_eq!(load_bytes("a.obj", &bytes).expect("read").mesh.triangles.len(), 2);
}

#[test]
fn materials_and_textures_come_from_the_library() {
    let text = format!("mtllib my lib.mtl\nusemtl skin\n{SEAM}");
    let library = "Kd 9 9 9\nnewmtl skin\nKd 0.25 0.5 1\nKa 1\nKs 1 2\nmap_Kd -clamp on -s 1 1 tex tures\\face.png\n\
        newmtl broken\nKd 1 2\n";
    let character =
        load_files(&[("a.obj", text.as_bytes()), ("my lib.mtl", library.as_bytes()), ("tex tures/face.png", PNG)])
            .expect("read");
    let material = &character.materials[0];
    assert_eq!((material.name.as_str(), material.base_color), ("skin", [0.25, 0.5, 1., 1.]));
    assert_eq!(material.texture.map(|t| t.wrap_u), Some(RawWrap::Clamp));
    assert_eq!(character.images[0].name, "face.png");
    assert!(warning(&character, "texture-options-ignored").is_some());
    assert_eq!(warning(&character, "material-lines-ignored").map(|w| w.count), Some(2));
}

#[test]
fn a_missing_library_is_warned_about() {
    let character = load(&format!("mtllib gone.mtl\nusemtl skin\n{SEAM}"));
    assert!(warning(&character, "material-library-missing").is_some());
    assert_eq!(character.materials[0].base_color, [1.0; 4]);
}

#[test]
fn libraries_and_textures_may_not_leave_the_folder() {
    for library in ["../lib.mtl", "/etc/passwd", "C:\\lib.mtl"] {
        let refusal = refusal(&format!("mtllib {library}\n{SEAM}"));
        assert!(refusal.contains("leaves the asset's folder"), "{refusal}");
    }
    for texture in ["../face.png", "C:\\Users\\artist\\face.png", "/etc/passwd"] {
        let text = format!("mtllib lib.mtl\nusemtl skin\n{SEAM}");
        let library = format!("newmtl skin\nmap_Kd {texture}\n");
        let files = [("a/a.obj", text.as_bytes()), ("a/lib.mtl", library.as_bytes()), ("face.png", PNG)];
        let refusal = load_files(&files).expect_err(texture).to_string();
        assert!(refusal.contains("leaves the asset's folder"), "{refusal}");
    }
}

#[test]
fn faces_are_flat_where_the_file_turns_smoothing_off() {
    for (line, flat) in [("", false), ("s 1\n", false), ("s off\n", true), ("s 0\n", true)] {
        assert_eq!(load(&format!("{line}{SEAM}")).materials[0].flat_normals, flat, "{line}");
    }
}

#[test]
fn degenerate_faces_alone_and_far_away_vertices_are_refused() {
    let words = refusal("v 0 0 0\nv 1 0 0\nf 1 1 1\n");
    assert!(words.contains("degenerate"), "{words}");
    let words = refusal("o moon\nv 0 0 0\nv 1 0 0\nv 0 4e8 0\nf 1 2 3\n");
    assert!(words.contains("object `moon`: a vertex lies at") && words.contains("allowed up to 1000000 m"), "{words}");
}

#[test]
fn libraries_say_light_normals_metal_and_roughness() {
    let text = format!("mtllib a.mtl\nusemtl lamp\n{SEAM}");
    let read = |library: &str| {
        load_files(&[("a.obj", text.as_bytes()), ("a.mtl", library.as_bytes()), ("n.png", PNG)]).expect("read")
    };
    let character = read("newmtl lamp\nKd 1 1 1\nKe 2 0.5 x\nKe 0 0.5 1\nnorm -clamp on n.png\nPm 0.25\nPr 0.75\n");
    let finish = &character.materials[0].finish;
    assert_eq!((finish.emissive, finish.metallic, finish.roughness), ([0.0, 0.5, 1.0], 0.25, 0.75));
    assert_eq!(finish.normal.map(|(texture, scale)| (texture.wrap_u, scale)), Some((RawWrap::Clamp, 1.0)));
    assert_eq!((character.images.len(), character.finish_images[0].name.as_str()), (0, "n.png"));
    let lit = read("newmtl lamp\nKe 0 0 0\nmap_Ke n.png\n");
    assert_eq!(lit.materials[0].finish.emissive, [1.0; 3]);
    assert!(lit.materials[0].finish.emissive_texture.is_some());
    let reduced = read("newmtl lamp\nmap_Bump n.png\nmap_Ke gone.png\n");
    assert_eq!(reduced.materials[0].finish, crowd_source::RawFinish::default());
    let said: Vec<&str> =
        reduced.warnings.iter().filter(|w| w.code == "material-reduced").map(|w| w.place.as_str()).collect();
    assert_eq!(said, ["mtllib `a.mtl`: map_Bump", "material `lamp`: map_Ke"]);
}
