//! What is on the pictures: the same on CPU and GPU, the same twice, different where it must be.

use crate::Scene;
use crate::compare::{BOUND, Difference};

const SMALL: [&str; 4] = ["--size", "320x180", "--count", "60"];

fn with<'a>(words: &[&'a str]) -> Vec<&'a str> {
    SMALL.iter().copied().chain(words.iter().copied()).collect()
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn cpu_and_gpu_draw_one_picture() {
    let scene = Scene::new();
    let details: [&[&str]; 4] = [
        &["--start", "0.3"],
        &["--budget", "4000", "--layout", "disc"],
        &["--weight", "area-distance"],
        &["--fog", "30"],
    ];
    for detail in details {
        let cpu = scene.picture(&with(&[&["--backend", "cpu"], detail].concat()));
        let gpu = scene.picture(&with(&[&["--backend", "gpu"], detail].concat()));
        let difference = Difference::between(&cpu, &gpu);
        assert!(difference.is_within(&BOUND), "{detail:?}: {difference:?}, allowed {BOUND:?}");
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn cpu_and_gpu_count_the_same() {
    let scene = Scene::new();
    for technique in ["reform", "pseudo-instancing"] {
        let words = ["--budget", "6000", "--frames", "3", "--technique", technique];
        let cpu = scene.report(&with(&[&words[..], &["--backend", "cpu"]].concat()));
        let gpu = scene.report(&with(&[&words[..], &["--backend", "gpu"]].concat()));
        for frame in 0..3 {
            for key in ["visible", "triangles", "vertices", "min_vertices", "overflow"] {
                assert_eq!(cpu["frames"][frame][key], gpu["frames"][frame][key], "{technique}, frame {frame}, {key}");
            }
        }
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn wherever_vertices_are_skinned_the_picture_is_the_same_and_the_report_says_where() {
    let scene = Scene::new();
    let words = |way: &'static str| with(&["--backend", "gpu", "--budget", "4000", "--skinning", way]);
    let picture = scene.picture(&words("vertex"));
    for way in ["palettes", "compute"] {
        assert_eq!(scene.picture(&words(way)), picture, "{way}");
        let report = scene.report(&[&words(way)[..], &["--frames", "2"]].concat());
        assert_eq!(report["skinning"], way);
        assert!(report["frames"][1]["stages_ms"]["blend_palettes"].is_number(), "{way}");
    }
    // One frame is no trial; many are, and they say what came out.
    let report = scene.report(&[&words("auto")[..], &["--frames", "20"]].concat());
    assert_eq!(report["skinning_ms"].as_array().map(Vec::len), Some(3), "{}", report["skinning"]);
    assert!(scene.report(&words("auto"))["skinning_ms"].is_null());
}

#[test]
fn fog_swallows_what_is_far() {
    let scene = Scene::new();
    let words = |fog: &'static str| with(&["--backend", "cpu", "--fog", fog]);
    let [clear, haze, soup] = ["off", "30", "1"].map(|fog| scene.picture(&words(fog)));
    assert_eq!(clear, scene.picture(&with(&["--backend", "cpu"])));
    assert!(!Difference::between(&clear, &haze).is_within(&BOUND));
    let horizon = soup.get_pixel(0, soup.height() / 2);
    let is_fog = |pixel: &image::Rgb<u8>| pixel.0.iter().zip(horizon.0).all(|(a, b)| a.abs_diff(b) <= 8);
    assert!(soup.pixels().all(is_fog) && !clear.pixels().all(is_fog), "next to nothing is seen through metres of it");
}

/// The comparator must see what it is there to see.
#[test]
fn a_shift_by_one_pixel_exceeds_the_bound() {
    let picture = Scene::new().picture(&with(&["--backend", "cpu"]));
    let (width, height) = picture.dimensions();
    let shifted = image::RgbImage::from_fn(width, height, |x, y| *picture.get_pixel((x + 1).min(width - 1), y));
    let difference = Difference::between(&picture, &shifted);
    assert!(!difference.is_within(&BOUND), "{difference:?} would pass for the same picture");
    assert!(Difference::between(&picture, &picture).is_within(&BOUND));
}

/// A missing individual, too.
#[test]
fn one_instance_less_exceeds_the_bound() {
    let scene = Scene::new();
    let people: Vec<String> =
        (0..12).map(|i| format!("{} 0 {} 0 1 {} 1 0.{i}", (i % 4) * 2 - 3, -(i / 4) * 2, i % 2)).collect();
    let layout = |people: &[String]| format!("# crowd layout v1\n{}\n", people.join("\n"));
    std::fs::write(scene.file("all.txt"), layout(&people)).unwrap();
    std::fs::write(scene.file("less.txt"), layout(&people[1..])).unwrap();
    let view = ["--size", "320x180", "--eye", "0,2,9", "--target", "0,0.5,0", "--backend", "cpu", "--layout"];
    let all = scene.picture(&[&view[..], &[&scene.path("all.txt")]].concat());
    let less = scene.picture(&[&view[..], &[&scene.path("less.txt")]].concat());
    let difference = Difference::between(&all, &less);
    assert!(!difference.is_within(&BOUND), "{difference:?} would pass for the same picture");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn with_enough_budget_reform_draws_what_pseudo_instancing_draws_on_the_gpu() {
    let scene = Scene::new();
    let words = with(&["--backend", "gpu", "--budget", "1000000", "--technique"]);
    let reform = scene.picture(&[&words[..], &["reform"]].concat());
    let baseline = scene.picture(&[&words[..], &["pseudo-instancing"]].concat());
    let difference = Difference::between(&reform, &baseline);
    assert!(difference.is_within(&BOUND), "{difference:?}, allowed {BOUND:?}");
}

#[test]
fn with_enough_budget_reform_draws_what_pseudo_instancing_draws_on_the_cpu() {
    let scene = Scene::new();
    let words = with(&["--backend", "cpu", "--budget", "1000000", "--technique"]);
    let reform = scene.picture(&[&words[..], &["reform"]].concat());
    assert_eq!(reform, scene.picture(&[&words[..], &["pseudo-instancing"]].concat()));
}

fn two_runs_agree(backend: &str) {
    let scene = Scene::new();
    let run = || {
        let out = scene.path("frame-%d.png");
        let words = ["--backend", backend, "--frames", "3", "--budget", "5000", "--out", &out];
        let mut report = scene.report(&with(&words));
        let pictures: Vec<Vec<u8>> =
            (0..3).map(|i| std::fs::read(scene.file(&format!("frame-{i}.png"))).unwrap()).collect();
        for frame in report["frames"].as_array_mut().expect("frames are a list") {
            for time in ["frame_ms", "stages_ms"] {
                frame.as_object_mut().expect("a frame is an object").remove(time).expect("every frame is timed");
            }
        }
        (report["frames"].clone(), pictures)
    };
    let (first, second) = (run(), run());
    assert_eq!(first, second);
    assert!(first.1[0] != first.1[1] && first.1[1] != first.1[2], "the crowd moves");
}

#[test]
fn two_runs_agree_to_the_byte_on_the_cpu() {
    two_runs_agree("cpu");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn two_runs_agree_to_the_byte_on_the_gpu() {
    two_runs_agree("gpu");
}

#[test]
fn four_samples_soften_edges_and_change_nothing_else() {
    let scene = Scene::new();
    let one = scene.picture(&with(&["--backend", "cpu"]));
    let png = scene.render(&with(&["--backend", "cpu", "--msaa", "4", "--out", "-"])).stdout;
    let four = image::load_from_memory(&png).unwrap().to_rgb8();
    let difference = Difference::between(&one, &four);
    assert!(difference.mean > 0.0 && difference.mean < 6.0, "{difference:?}");
}

#[test]
fn a_smaller_budget_draws_less_and_says_when_it_is_too_small() {
    let scene = Scene::new();
    let of = |budget: &str| scene.report(&with(&["--backend", "cpu", "--budget", budget]))["frames"][0].clone();
    let (large, small, tiny) = (of("100000"), of("6000"), of("100"));
    let count = |frame: &serde_json::Value, key: &str| frame[key].as_u64().expect("a count");
    assert!(count(&small, "triangles") < count(&large, "triangles"));
    assert!(count(&small, "vertices") <= 6000 && count(&small, "visible") > 20);
    assert_eq!(tiny["overflow"], serde_json::json!(["budget"]));
    assert_eq!(count(&tiny, "vertices"), count(&tiny, "min_vertices"));
}

#[test]
fn a_camera_path_moves_the_camera() {
    let scene = Scene::new();
    let path = "# crowd camera path v1\n0  0 2 9  0 1 0  45\n1  9 2 0  0 1 0  45\n";
    std::fs::write(scene.file("path.txt"), path).unwrap();
    let (file, out) = (scene.path("path.txt"), scene.path("f-%d.png"));
    let words = ["--backend", "cpu", "--camera-path", &file, "--frames", "2", "--dt", "1", "--clips", "idle"];
    scene.render(&with(&[&words[..], &["--out", &out]].concat()));
    let frame = |i: u32| image::open(scene.file(&format!("f-{i}.png"))).unwrap().to_rgb8();
    assert!(!Difference::between(&frame(0), &frame(1)).is_within(&BOUND));
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn one_person_is_drawn_by_every_technique() {
    let scene = Scene::new();
    let words = |more: &[&'static str]| [&["--size", "64x64", "--count", "1", "--backend", "gpu"], more].concat();
    for technique in ["pseudo-instancing", "instanced", "discrete", "reform", "static-floor", "points", "bucketed"] {
        let frame = &scene.report(&words(&["--technique", technique]))["frames"][0];
        assert!(frame["visible"] == 1 && frame["triangles"].as_u64() > Some(0), "{technique}: {frame}");
    }
    let all = words(&["--skinning", "compute", "--shadows", "2", "--occlusion", "on"]);
    assert_eq!(scene.report(&all)["frames"][0]["visible"], 1);
}
