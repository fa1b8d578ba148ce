//! What names a character, and what happens to inputs that do not.

use crate::bench::{Bench, SPHERE, TRIANGLE, TUBE, TWO_MATERIALS};
use crowd_pack::Pack;

fn names(bench: &Bench, pack: &str) -> Vec<String> {
    let pack = Pack::open(&bench.path(pack)).expect("the pack is whole");
    pack.contents().manifest.characters.iter().map(|character| character.name.clone()).collect()
}

#[test]
fn a_bad_file_does_not_stop_the_batch() {
    let bench = Bench::with(&[TUBE]);
    bench.write("bad.glb", b"glTF but not really");
    let words = ["bake", "@bad.glb", "@gone.glb", &format!("@{TUBE}"), "-o", "@out.crowdpack", "--report", "@r.json"];
    bench.run(&words).expect(1).says(&["error: bad: load:", "bad.glb", "gone.glb: no such file", "1 character"]);
    assert_eq!(names(&bench, "out.crowdpack"), ["straight_tube_should_keep_its_elbow"]);
    let report: serde_json::Value = serde_json::from_slice(&bench.read("r.json")).unwrap();
    assert_eq!(report["exit_code"], 1);
    assert_eq!(report["characters"][0]["status"], "refused");
    assert!(report["characters"][0]["error"].as_str().unwrap().contains("bad.glb"));
    assert_eq!(report["characters"][1]["status"], "baked");
    assert_eq!(report["refused_inputs"].as_array().unwrap().len(), 1);
}

#[test]
fn with_nothing_good_no_pack_is_written_and_an_old_one_stays() {
    let bench = Bench::new();
    bench.write("bad.obj", b"v 1 2\nf 1 2 3\n");
    bench.run(&["bake", "@bad.obj", "-o", "@out.crowdpack"]).expect(1).says(&["no pack was written"]);
    assert_eq!(bench.listing(), ["bad.obj"]);
    bench.write("out.crowdpack", b"old");
    bench.run(&["bake", "@bad.obj", "-o", "@out.crowdpack"]).expect(1);
    assert_eq!(bench.read("out.crowdpack"), b"old");
}

#[test]
fn folders_and_patterns_give_characters_in_the_order_of_their_paths() {
    let bench = Bench::new();
    bench.copy(TRIANGLE, "cast/b/knight.glb");
    bench.copy(TRIANGLE, "cast/a.glb");
    bench.copy(TRIANGLE, "cast/c/knight.glb");
    bench.write("cast/readme.txt", b"not a character");
    bench.run(&["bake", "@cast", "-o", "@out.crowdpack"]).expect(0).says(&["`knight` is taken, baked as `knight-2`"]);
    assert_eq!(names(&bench, "out.crowdpack"), ["a", "knight", "knight-2"]);
    bench.run(&["bake", "@cast/**/k*.glb", "-o", "@out.crowdpack"]).expect(0);
    assert_eq!(names(&bench, "out.crowdpack"), ["knight", "knight-2"]);
    bench.run(&["bake", "@cast/*.gltf", "-o", "@none.crowdpack"]).expect(1).says(&["the pattern matches no"]);
    assert!(!bench.path("none.crowdpack").exists());
}

#[test]
fn a_manifest_names_characters_clips_and_options() {
    let bench = Bench::with(&[TUBE, SPHERE]);
    let manifest = format!(
        "[pack]\nanimation_layout = '4x4'\n[defaults]\nfps = 12\n[[characters]]\nsource = '{TUBE}'\nname = 'tube'\n\
         clips = ['bend*']\n[[characters]]\nsource = '{SPHERE}'\ncriteria = 'peng2011'\n"
    );
    bench.write("crowd.toml", manifest);
    bench.run(&["bake", "@crowd.toml", "-o", "@out.crowdpack"]).expect(0);
    let pack = Pack::open(&bench.path("out.crowdpack")).unwrap();
    let manifest = &pack.contents().manifest;
    assert_eq!(manifest.animation_layout, crowd_pack::AnimationLayout::Split4x4);
    assert_eq!(manifest.characters[0].name, "tube");
    assert_eq!(manifest.characters[0].fps, 12.0);
    assert_eq!(manifest.characters[1].criteria, "peng2011");
}

#[test]
fn a_wrong_manifest_is_refused_by_the_path_of_the_mistake() {
    let bench = Bench::with(&[TUBE]);
    let good = format!("[[characters]]\nsource = '{TUBE}'\n");
    bench.write("crowd.toml", format!("{good}name = 'a'\n{good}clips = 'bend'\n"));
    let done = bench.run(&["bake", "@crowd.toml", "-o", "@out.crowdpack"]).expect(1);
    done.says(&["crowd.toml: characters[1].clips: found string"]);
    bench.write("crowd.toml", good + "colour = 'red'\n");
    let done = bench.run(&["bake", "@crowd.toml", "-o", "@out.crowdpack"]).expect(1);
    done.says(&["characters[0].colour: unknown key, allowed source, name, fps, criteria, clips, frames, clip_weights"]);
    assert!(!bench.path("out.crowdpack").exists());
}

#[test]
fn an_unknown_clip_is_answered_with_the_clips_there_are() {
    let bench = Bench::with(&[TUBE]);
    let words = ["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack", "--clips", "Swim"];
    bench.run(&words).expect(1).says(&["select-clips: clip `Swim`: no clip of that name; the character has bend"]);
    assert!(!bench.path("out.crowdpack").exists());
}

#[test]
fn print_config_gives_a_manifest_that_bakes_the_same_bytes() {
    let bench = Bench::with(&[TUBE, TWO_MATERIALS]);
    let options = ["--fps", "20", "--criteria", "peng2011"];
    let printed =
        bench.run(&[&["print-config", &format!("@{TUBE}"), &format!("@{TWO_MATERIALS}")], &options[..]].concat());
    bench.write("crowd.toml", printed.expect(0).out);
    bench.run(&["bake", "@crowd.toml", "-o", "@a.crowdpack"]).expect(0);
    let inputs = [format!("@{TUBE}"), format!("@{TWO_MATERIALS}")];
    let words = [&["bake", &inputs[0], &inputs[1], "-o", "@b.crowdpack"], &options[..]].concat();
    bench.run(&words).expect(0);
    assert!(bench.read("a.crowdpack") == bench.read("b.crowdpack"));
    assert!(bench.run(&["print-config"]).expect(0).out.contains("[defaults]"));
}

#[test]
fn print_config_names_sources_from_the_folder_of_its_file() {
    let bench = Bench::with(&[TUBE]);
    bench.run(&["print-config", &format!("@{TUBE}"), "-o", "@plans/deep/crowd.toml"]).expect(0);
    let text = String::from_utf8(bench.read("plans/deep/crowd.toml")).unwrap();
    assert!(text.contains(&format!("source = \"../../{TUBE}\"")), "{text}");
    bench.run(&["bake", "@plans/deep/crowd.toml", "-o", "@a.crowdpack"]).expect(0);
    bench.run(&["print-config", &format!("@{TUBE}"), "-o", &format!("@{TUBE}")]).expect(2);
    // What cannot be planned leaves the old one alone.
    bench.run(&["print-config", "@gone.glb", "-o", "@plans/deep/crowd.toml"]).expect(1);
    assert_eq!(bench.read("plans/deep/crowd.toml"), text.as_bytes());
}

/// What an asset names lies beside its link.
#[cfg(unix)]
#[test]
fn print_config_keeps_links() {
    let bench = Bench::with(&[TUBE]);
    std::fs::create_dir(bench.path("shown")).unwrap();
    std::os::unix::fs::symlink(bench.path(TUBE), bench.path("shown/link.glb")).unwrap();
    bench.run(&["print-config", "@shown/link.glb", "-o", "@crowd.toml"]).expect(0);
    let text = String::from_utf8(bench.read("crowd.toml")).unwrap();
    assert!(text.contains("source = \"shown/link.glb\""), "{text}");
}

#[test]
fn strict_refuses_what_the_import_warns_about() {
    let bench = Bench::new();
    // The crate's material file stays behind: a warning.
    bench.copy("painted_crate.obj", "crate.obj");
    bench.run(&["bake", "@crate.obj", "-o", "@out.crowdpack"]).expect(0).says(&["warning: crate:"]);
    std::fs::remove_file(bench.path("out.crowdpack")).unwrap();
    let done = bench.run(&["bake", "@crate.obj", "-o", "@out.crowdpack", "--strict"]).expect(1);
    done.says(&["crate: load: 1 warning with --strict", "crate.mtl"]);
    assert!(!bench.path("out.crowdpack").exists());
}

#[test]
fn every_bad_fixture_is_refused_and_named() {
    let bench = Bench::new();
    let folder = crowd_tests::folders::fixtures().join("bad");
    let words = ["bake", &folder.to_string_lossy(), "-o", "@out.crowdpack", "--report", "@r.json"];
    bench.run(&words).expect(1);
    let report: serde_json::Value = serde_json::from_slice(&bench.read("r.json")).unwrap();
    let characters = report["characters"].as_array().unwrap();
    assert!(characters.len() > 20, "{}", characters.len());
    for character in characters {
        let source = character["source"].as_str().unwrap();
        assert_eq!(character["status"], "refused", "{source}");
        let file = source.rsplit(['/', '\\']).next().unwrap();
        let words = character["error"].as_str().unwrap();
        let named = words.contains(file) || words.contains("there_is_no_such_buffer.bin");
        assert!(named, "{source}: {words}");
    }
    assert!(!bench.path("out.crowdpack").exists());
}

#[test]
fn a_character_of_degenerate_triangles_alone_is_refused_and_the_batch_goes_on() {
    let bench = Bench::with(&[TUBE]);
    // Corners at one place, told apart by their texture points.
    bench.write("flat.obj", "v 0 0 0\nv 1 0 0\nvt 0 0\nvt 1 0\nf 1/1 1/2 2/1\nf 2/1 2/2 1/1\n");
    bench.write("folded.obj", "v 0 0 0\nv 1 0 0\nf 1 1 1\n");
    let words = ["all 2 triangles are degenerate: two corners at one place", "all 1 triangles are degenerate"];
    bench.run(&["bake", "@.", "-o", "@out.crowdpack"]).expect(1).says(&words);
    assert_eq!(names(&bench, "out.crowdpack"), ["straight_tube_should_keep_its_elbow"]);
    bench.run(&["inspect", "@flat.obj"]).expect(1).says(&words[..1]);
    bench.run(&["inspect", "@folded.obj"]).expect(1).says(&words[1..]);
}

#[test]
fn a_folder_is_not_inspected() {
    let bench = Bench::new();
    bench.run(&["inspect", "@."]).expect(1).says(&["error: read: ", "is a folder, a pack or an asset is needed"]);
}

#[test]
fn a_pattern_that_finds_nothing_anywhere_is_warned_of_and_one_that_finds_something_somewhere_is_not() {
    let bench = Bench::with(&[TUBE, SPHERE]);
    bench.copy("zebra.glb", "zebra.glb");
    let words = ["bake", &format!("@{TUBE}"), "@zebra.glb", "-o", "@out.crowdpack", "--fps", "5", "--clips"];
    let with = |clips: &'static str| bench.run(&[&words[..], &[clips]].concat()).expect(0);
    with("bend*,walk*,*fly*").says(&["warning: clips: `*fly*` finds no clip in any character"]);
    assert!(!with("bend*,walk*").err.contains("finds no clip"));
}

#[test]
fn a_character_of_another_unit_is_warned_of_and_scaled_when_asked() {
    let bench = Bench::with(&[SPHERE]);
    let bake = |more: &[&str]| {
        let words = ["bake", &format!("@{SPHERE}"), "-o", "@out.crowdpack"];
        bench.run(&[&words[..], more].concat())
    };
    let height = || {
        let json = bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json();
        json["characters"][0]["height_m"].as_f64().unwrap()
    };
    assert!(!bake(&[]).expect(0).err.contains("unlikely-size"));
    let plain = height();
    let giant = bake(&["--scale", "100"]).expect(0);
    assert!(!giant.err.contains("unlikely-size"), "who says a size knows it");
    assert!((height() / plain - 100.0).abs() < 1e-3);
    bake(&["--height", "1.8"]).expect(0);
    assert!((height() - 1.8).abs() < 1e-4);
    bench.write("crowd.toml", format!("[defaults]\nheight = 3\n[[characters]]\nsource = '{SPHERE}'\n"));
    bench.run(&["bake", "@crowd.toml", "-o", "@out.crowdpack"]).expect(0);
    assert!((height() - 3.0).abs() < 1e-4);
    bake(&["--scale", "1e6"]).expect(1).says(&["load: --scale or --height: 1000000 times", "allowed"]);
    bake(&["--scale", "0"]).expect(2);
    bake(&["--scale", "-1"]).expect(2).says(&["--scale", "found -1, allowed"]);
    bake(&["--scale", "2", "--height", "2"]).expect(2);
    bench.write("giant.obj", "v 0 0 0\nv 1 0 0\nv 0 180 0\nf 1 2 3\n");
    let giant = bench.run(&["bake", "@giant.obj", "-o", "@out.crowdpack"]).expect(0);
    giant.says(&["unlikely-size", "--scale 0.01 bakes it 1.80 m", "--height METRES"]);
    bench.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n");
    bench.run(&["bake", "@flat.obj", "-o", "@o.crowdpack", "--height", "2"]).expect(1).says(&["no height", "--scale"]);
}
