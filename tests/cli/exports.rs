//! Exported levels are read back and must be the level: same triangles, same places in motion, same textures.

use crate::bench::{Bench, SPHERE, TUBE, TWO_MATERIALS};
use crate::materials::{join, split};
use crowd_pack::{LodRecord, Pack};
use crowd_source::{Limits, RawCharacter, load_character};
use crowdbake::pose::pose_positions;
use crowdbake::unpack::Unpacked;
use serde_json::json;

/// Corners of every triangle, by the material's name: place, texture coordinate.
type Corners = Vec<(String, [[f32; 3]; 3], [[f32; 2]; 3])>;

fn corners_of_level(character: &Unpacked<'_>, level: LodRecord) -> Corners {
    let palette = character.rest_palette();
    let posed = pose_positions(&character.positions, &character.joints, &character.weights, &palette);
    let corners = character.level_triangles(level).into_iter().map(|triangle| {
        let first = &character.vertices[triangle[0] as usize];
        let material = character.manifest.materials[first.material() as usize].clone();
        let at = |corner: u32| corner as usize;
        (material, triangle.map(|c| posed[at(c)]), triangle.map(|c| character.vertices[at(c)].uv))
    });
    corners.collect()
}

fn corners_of_file(raw: &RawCharacter) -> Corners {
    let baked = crowdbake::unpack::rest_palette_of(raw);
    let posed = pose_positions(&raw.mesh.positions, &raw.mesh.joints, &raw.mesh.weights, &baked);
    let mut corners = Corners::new();
    for part in &raw.mesh.parts {
        let range = part.first_triangle as usize..(part.first_triangle + part.triangle_count) as usize;
        for triangle in &raw.mesh.triangles[range] {
            let at = |corner: u32| corner as usize;
            let name = raw.materials[part.material as usize].name.clone();
            corners.push((name, triangle.map(|c| posed[at(c)]), triangle.map(|c| raw.mesh.uvs[at(c)])));
        }
    }
    corners
}

fn sorted(mut corners: Corners) -> Corners {
    let key = |corner: &(String, [[f32; 3]; 3], [[f32; 2]; 3])| {
        let rounded: Vec<i64> = corner
            .1
            .iter()
            .flatten()
            .chain(corner.2.iter().flatten())
            .map(|&x| (f64::from(x) * 1e4).round() as i64)
            .collect();
        (corner.0.clone(), rounded)
    };
    corners.sort_by_key(key);
    corners
}

/// Bakes, exports a share, reads the file back; both sides' corners must agree.
fn expect_same_level(fixture: &str, ratio: f64, textured: bool) -> RawCharacter {
    let bench = Bench::with(&[fixture]);
    bench.run(&["bake", &format!("@{fixture}"), "-o", "@out.crowdpack"]).expect(0);
    bench.run(&["export", "@out.crowdpack", "--ratio", &ratio.to_string(), "-o", "@low.glb"]).expect(0);
    let pack = Pack::open(&bench.path("out.crowdpack")).unwrap();
    let character = Unpacked::new(pack.contents(), 0);
    let (level, reached) = character.level_of_ratio(ratio);
    assert!(reached);
    let raw = load_character(&bench.path("low.glb"), &Limits::default()).expect("the export reads back");
    let (level, file) = (sorted(corners_of_level(&character, level)), sorted(corners_of_file(&raw)));
    assert_eq!(level.len(), file.len());
    let size = character.record.sphere[3];
    for (a, b) in level.iter().zip(&file) {
        assert_eq!(a.0, b.0);
        for (p, q) in a.1.iter().zip(&b.1) {
            assert!((0..3).all(|axis| (p[axis] - q[axis]).abs() < 1e-4 * size), "{p:?} became {q:?}");
        }
        if textured {
            assert_eq!(a.2, b.2);
        }
    }
    raw
}

#[test]
fn a_level_of_a_skinned_character_reads_back_as_it_was() {
    let raw = expect_same_level(TUBE, 0.25, true);
    assert_eq!(raw.clips.len(), 1);
    assert!(raw.warnings.is_empty(), "{:?}", raw.warnings);
}

#[test]
fn a_level_of_two_materials_keeps_them_apart() {
    let raw = expect_same_level(TWO_MATERIALS, 0.5, false);
    assert_eq!(raw.materials.len(), 2);
}

#[test]
fn a_static_mesh_needs_no_skin() {
    expect_same_level(SPHERE, 0.1, true);
}

#[test]
fn a_zebra_keeps_its_clips_and_curves() {
    let raw = expect_same_level("zebra.glb", 0.3, true);
    let source = load_character(&crowd_tests::folders::fixtures().join("good/zebra.glb"), &Limits::default()).unwrap();
    let names = |raw: &RawCharacter| raw.clips.iter().map(|clip| clip.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&raw), names(&source));
    // Curves of joints that move nothing in this level are left out on reading, no others.
    let moves = |name: &str| {
        let mut corners = raw.mesh.triangles.iter().flatten().map(|&v| v as usize);
        let is_joint = |joint: u16| raw.nodes[raw.joints[usize::from(joint)].node as usize].name == name;
        corners.any(|v| (0..4).any(|i| raw.mesh.weights[v][i] > 0.0 && is_joint(raw.mesh.joints[v][i])))
    };
    for (ours, theirs) in raw.clips.iter().zip(&source.clips) {
        let mut left = ours.tracks.iter();
        for b in &theirs.tracks {
            let name = &source.nodes[b.node as usize].name;
            let Some(a) = left.as_slice().first().filter(|a| raw.nodes[a.node as usize].name == *name) else {
                assert!(!moves(name), "{name} moves and has no curve");
                continue;
            };
            left.next();
            assert_eq!((a.property, &a.times), (b.property, &b.times));
            assert!(a.values.iter().zip(&b.values).all(|(x, y)| (x - y).abs() < 1e-6));
        }
        assert_eq!(left.len(), 0, "curves of nobody");
    }
    assert_eq!(raw.images[0].bytes, source.images[0].bytes, "textures go through untouched");
}

#[test]
fn several_lods_are_one_file_each() {
    let bench = Bench::with(&[TUBE]);
    let input = format!("@{TUBE}");
    bench.run(&["export", &input, "--lods", "1,0.5,0.1", "-o", "@tube.glb"]).expect(0);
    assert_eq!(bench.listing(), [TUBE, "tube.lod0.glb", "tube.lod1.glb", "tube.lod2.glb"]);
    let triangles = |file: &str| load_character(&bench.path(file), &Limits::default()).unwrap().mesh.triangles.len();
    let full = triangles("tube.lod0.glb");
    assert_eq!(full, triangles(TUBE));
    assert!(triangles("tube.lod1.glb") <= full / 2 && triangles("tube.lod2.glb") <= full / 10);
    bench.run(&["export", &input, "--lods", "1", "-o", "@folder/"]).expect(0);
    assert!(bench.path("folder/straight_tube_should_keep_its_elbow.lod0.glb").is_file());
}

#[test]
fn a_target_that_no_level_reaches_is_said_and_refused_when_strict() {
    let bench = Bench::with(&[TUBE]);
    let input = format!("@{TUBE}");
    let words = ["export", &input, "--triangles", "1", "-o", "@low.glb"];
    bench.run(&words).expect(0).says(&["warning", "target missed: asked for 1 triangles, the coarsest level has"]);
    std::fs::remove_file(bench.path("low.glb")).unwrap();
    bench.run(&[&words[..], &["--strict"]].concat()).expect(5).says(&["target missed"]);
    assert!(!bench.path("low.glb").exists());
}

#[test]
fn a_character_is_named_when_there_are_several() {
    let bench = Bench::with(&[TUBE, SPHERE]);
    bench.run(&["bake", "@.", "-o", "@out.crowdpack"]).expect(0);
    let export = ["export", "@out.crowdpack", "--vertices", "40", "-o", "@low.glb"];
    bench.run(&export).expect(1).says(&["holds 2 characters", "--character"]);
    bench.run(&[&export[..], &["--character", "nobody"]].concat()).expect(1).says(&["the pack has sphere"]);
    bench.run(&[&export[..], &["--character", "sphere_with_seam_and_poles"]].concat()).expect(0);
    assert!(load_character(&bench.path("low.glb"), &Limits::default()).unwrap().mesh.positions.len() <= 40);
}

/// The JSON of a `.glb`.
fn document(glb: &[u8]) -> serde_json::Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).expect("the first chunk is JSON")
}

#[test]
fn the_skin_lists_the_joints_of_the_source_in_their_order() {
    // Of the zebra's joints two move nothing; the levels of all characters meet their joints in another order.
    let bench = Bench::with(&["zebra.glb", "mara.glb"]);
    for name in ["zebra", "mara"] {
        bench.run(&["bake", &format!("@{name}.glb"), "-o", "@out.crowdpack", "--scale", "2"]).expect(0);
        bench.run(&["export", "@out.crowdpack", "--ratio", "0.1", "-o", "@low.glb"]).expect(0);
        let (source, low) = (document(&bench.read(&format!("{name}.glb"))), document(&bench.read("low.glb")));
        let joints = |document: &serde_json::Value| -> Vec<String> {
            let joints = document["skins"][0]["joints"].as_array().unwrap();
            let name = |joint: &serde_json::Value| document["nodes"][joint.as_u64().unwrap() as usize]["name"].clone();
            joints.iter().map(|joint| name(joint).as_str().unwrap().to_owned()).collect()
        };
        assert_eq!(joints(&low), joints(&source), "{name}");
        let channels = |document: &serde_json::Value| -> Vec<usize> {
            let clips = document["animations"].as_array().unwrap();
            clips.iter().map(|clip| clip["channels"].as_array().unwrap().len()).collect()
        };
        assert_eq!(channels(&low), channels(&source), "{name}");
    }
}

#[test]
fn the_count_of_vertices_is_that_of_the_file() {
    let bench = Bench::with(&["mara.glb"]);
    bench.run(&["bake", "@mara.glb", "-o", "@out.crowdpack", "--lod-ratio", "20%"]).expect(0);
    for words in [["--ratio", "0.5"], ["--lod", "lod1"]] {
        let done = bench.run(&[&["export", "@out.crowdpack", "-o", "@low.glb"][..], &words].concat());
        let document = document(&bench.read("low.glb"));
        let count = |primitive: &serde_json::Value| {
            let position = primitive["attributes"]["POSITION"].as_u64().unwrap() as usize;
            document["accessors"][position]["count"].as_u64().unwrap()
        };
        let found: u64 = document["meshes"][0]["primitives"].as_array().unwrap().iter().map(count).sum();
        done.expect(0).says(&[&format!(", {found} vertices")]);
        assert_eq!(document["asset"]["extras"]["crowdbake"]["vertices"].as_u64(), Some(found));
    }
}

#[test]
fn credits_of_the_file_come_through() {
    let (mut document, bin) = split(&std::fs::read(crowd_tests::folders::fixtures().join("good").join(TUBE)).unwrap());
    document["asset"]["copyright"] = json!("CC-BY 4.0\nAda");
    document["asset"]["extras"] = json!({ "author": "Ada", "license": "CC-BY-4.0" });
    let bench = Bench::new();
    bench.write("tube.glb", join(&document, bin));
    bench.run(&["bake", "@tube.glb", "-o", "@out.crowdpack"]).expect(0);
    assert_eq!(Pack::open(&bench.path("out.crowdpack")).unwrap().contents().finishes.credits.len(), 1);
    for input in ["@tube.glb", "@out.crowdpack"] {
        let shown = bench.run(&["inspect", input]).expect(0).out;
        assert!(shown.contains("copyright     CC-BY 4.0 Ada\n"), "{shown}");
    }
    bench.run(&["export", "@out.crowdpack", "--ratio", "0.5", "-o", "@low.glb"]).expect(0);
    // An export of an export says of itself what it is.
    bench.run(&["export", "@low.glb", "--ratio", "0.5", "-o", "@lower.glb"]).expect(0);
    let asset = |file: &str| split(&bench.read(file)).0["asset"].clone();
    let (low, lower) = (asset("low.glb"), asset("lower.glb"));
    for asset in [&low, &lower] {
        assert_eq!(asset["copyright"], "CC-BY 4.0\nAda");
        assert_eq!((&asset["extras"]["author"], &asset["extras"]["license"]), (&json!("Ada"), &json!("CC-BY-4.0")));
    }
    let triangles = |asset: &serde_json::Value| asset["extras"]["crowdbake"]["triangles"].as_u64().unwrap();
    assert!(triangles(&lower) < triangles(&low));
}
