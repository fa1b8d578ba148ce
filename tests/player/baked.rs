//! The whole way, from a character's file to the picture: baked here, drawn on CPU and GPU.

use crate::compare::{BOUND, Difference};
use crate::{Scene, crowdplay};
use std::path::PathBuf;

fn fixture(name: &str) -> PathBuf {
    crowd_tests::folders::fixtures().join("good").join(name)
}

fn asset(name: &str) -> PathBuf {
    crowd_tests::folders::assets().join(name)
}

/// Bakes into the scene's folder; the pack's path.
fn bake(scene: &Scene, inputs: &[PathBuf]) -> String {
    let pack = scene.path("baked.crowdpack");
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    let inputs = inputs.iter().map(|path| path.to_str().expect("assets have plain names"));
    let words: Vec<&str> = ["crowdbake", "bake", "-o", &pack].into_iter().chain(inputs).collect();
    let code = crowdbake::run(words, &mut stdout, &mut stderr);
    assert_eq!(code, 0, "{}", String::from_utf8_lossy(&stderr));
    pack
}

/// Impostors take two triangles each and look more like whom they stand for than the coarsest meshes; a pack without has none.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn impostors_look_like_whom_they_stand_for() {
    let scene = Scene::new();
    let plain = bake(&scene, &[fixture("zebra.glb")]);
    let pack = scene.path("impostors.crowdpack");
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    let input = fixture("zebra.glb");
    let words =
        ["crowdbake", "bake", "-o", &pack, "--impostors", "32", "--clips", "walk", input.to_str().expect("plain")];
    assert_eq!(crowdbake::run(words, &mut stdout, &mut stderr), 0, "{}", String::from_utf8_lossy(&stderr));
    let far = |pack: &str, words: &[&str]| {
        let usual =
            [pack, "--headless", "--size", "480x270", "--count", "40", "--msaa", "4", "--out", "-", "--backend"];
        let camera = ["gpu", "--eye", "0,4,40", "--target", "0,1,0", "--dots", "0", "--clips", "walk"];
        let ran = crowdplay(&[&usual[..], &camera, words].concat());
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        (image::load_from_memory(&ran.stdout).expect("standard output is a PNG").to_rgb8(), ran.stderr)
    };
    let (full, _) = far(&pack, &["--impostors", "0", "--budget", "9000000"]);
    let (impostors, said) = far(&pack, &["--impostors", "64", "--budget", "9000000"]);
    let (coarsest, _) = far(&pack, &["--impostors", "0", "--budget", "1"]);
    assert!(said.contains("40 visible; 80 of"), "two triangles each: {said}");
    let bytes = |pack: &str, words: &[&str]| {
        let words =
            [&[pack, "--headless", "--size", "32x18", "--count", "4", "--backend", "gpu", "--report", "-"], words]
                .concat();
        let ran = crowdplay(&words);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let report: serde_json::Value = serde_json::from_slice(&ran.stdout).expect("standard output is the report");
        (report["gpu_memory"]["impostors"].as_u64().expect("it has a line of its own"), ran.stderr)
    };
    // Their pictures come to the GPU only where somebody may be one.
    let [none, reformed, there] =
        [&["--impostors", "0"][..], &["--technique", "reform"], &[]].map(|words| bytes(&pack, words).0);
    assert!(none == 0 && reformed == 0 && there > 10_000, "{none}, {reformed}, {there}");
    let (none, said) = bytes(&plain, &["--impostors", "9"]);
    assert!(none == 0 && said.contains("this pack has no impostors"), "{said}");
    let off = |picture| Difference::between(picture, &full).mean;
    println!("impostors {}, coarsest meshes {}", off(&impostors), off(&coarsest));
    assert!(off(&impostors) < 0.95 * off(&coarsest), "{} and {}", off(&impostors), off(&coarsest));
    assert!(off(&impostors) > 0.0, "the comparison can tell");
    let (_, said) = far(&plain, &["--impostors", "64", "--budget", "9000000"]);
    assert!(said.contains("42560 of 42560 triangles"), "who has no impostors is drawn as ever: {said}");
}

/// A small crowd's picture, one sample a pixel.
fn picture(pack: &str, words: &[&str]) -> image::RgbImage {
    let usual = [pack, "--headless", "--size", "480x270", "--count", "40", "--msaa", "1", "--out", "-"];
    let ran = crowdplay(&usual.iter().copied().chain(words.iter().copied()).collect::<Vec<_>>());
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    image::load_from_memory(&ran.stdout).expect("standard output is a PNG").to_rgb8()
}

fn cpu_and_gpu_agree(inputs: &[PathBuf]) {
    let scene = Scene::new();
    let pack = bake(&scene, inputs);
    for budget in ["1000000", "30000"] {
        let words = ["--start", "0.7", "--budget", budget, "--backend"];
        let cpu = picture(&pack, &[&words[..], &["cpu"]].concat());
        let gpu = picture(&pack, &[&words[..], &["gpu"]].concat());
        let difference = Difference::between(&cpu, &gpu);
        assert!(difference.is_within(&BOUND), "budget {budget}: {difference:?}, allowed {BOUND:?}");
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn cpu_and_gpu_draw_one_picture_of_the_shipped_characters() {
    cpu_and_gpu_agree(&[fixture("mara.glb"), fixture("zebra.glb")]);
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn cpu_and_gpu_draw_one_picture_of_characters_as_found() {
    cpu_and_gpu_agree(&[asset("kaykit-skeleton-minion/skeleton_minion.glb"), asset("khronos-fox/Fox.glb")]);
}

#[test]
#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
fn a_fox_in_centimetres_is_shown_at_its_size_and_as_baked_on_request() {
    let scene = Scene::new();
    let pack = bake(&scene, &[asset("khronos-fox/Fox.glb")]);
    let spacing = |words: &[&str]| {
        let usual =
            [pack.as_str(), "--headless", "--backend", "cpu", "--count", "4", "--size", "32x18", "--report", "-"];
        let ran = crowdplay(&usual.iter().copied().chain(words.iter().copied()).collect::<Vec<_>>());
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let report: serde_json::Value = serde_json::from_slice(&ran.stdout).expect("a report");
        (report["crowd"]["spacing_m"].as_f64().expect("metres"), ran.stderr)
    };
    let (usual, said) = spacing(&[]);
    let (as_baked, _) = spacing(&["--height", "source"]);
    let (small, _) = spacing(&["--height", "Fox=0.4"]);
    assert!(said.contains("centimetres"), "{said}");
    assert!((as_baked / usual - 100.0).abs() < 0.1, "{as_baked} m to {usual} m");
    assert!((small / usual - 0.4 / 0.79).abs() < 0.01, "{small} m to {usual} m");
}
