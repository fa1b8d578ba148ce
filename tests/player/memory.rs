//! Budgets: of memory, of triangles, and with something left over so that levels keep still.

use crate::{Ran, Scene, crowdplay};
use serde_json::Value;

fn run(scene: &Scene, words: &[&str]) -> Ran {
    let pack = scene.pack();
    let mut all = vec![pack.as_str(), "--headless", "--size", "64x36", "--report", "-"];
    all.extend(words);
    crowdplay(&all)
}

fn report(ran: &Ran) -> Value {
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    serde_json::from_slice(&ran.stdout).expect("the report is JSON")
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn memory_sets_the_budget_and_what_cannot_fit_is_refused_with_the_numbers() {
    let scene = Scene::new();
    let words = ["--count", "3000", "--skinning", "compute", "--vram"];
    let with = |more: &[&'static str]| run(&scene, &[&words[..], more].concat());
    let fitted = report(&with(&["12"]));
    let number = |value: &Value| value.as_u64().unwrap_or_else(|| panic!("{value} is no number"));
    let (least, full) = (number(&fitted["crowd"]["vertices_least"]), number(&fitted["crowd"]["vertices_full"]));
    let budget = number(&fitted["budget"]);
    assert!((least + 1..full).contains(&budget), "{budget}, {least} to {full}");
    let (taken, limit) = (number(&fitted["gpu_bytes"]), 12 << 20);
    assert_eq!(number(&fitted["vram_bytes"]), limit);
    // As much as fits: one more vertex is 24 bytes.
    assert!(taken <= limit && taken + 100 > limit, "{taken} of {limit}");
    let parts = fitted["gpu_memory"].as_object().expect("parts by name");
    assert_eq!(parts.values().map(number).sum::<u64>(), taken);
    assert!(number(&parts["skinning"]) > 24 * budget);

    let refused = with(&["1"]);
    assert_eq!((refused.code, refused.stdout.len()), (5, 0), "{}", refused.stderr);
    for word in ["--vram", "1.0 MB", "skinning", "in all", "--count"] {
        assert!(refused.stderr.contains(word), "{word} in {}", refused.stderr);
    }
    let refused = with(&["12", "--budget", "660000"]);
    assert!(refused.code == 5 && refused.stderr.contains("660000 vertices"), "{}", refused.stderr);
    assert_eq!(number(&report(&with(&["12", "--budget", "90000"]))["budget"]), 90_000);
}

/// Pictures of a second camera are as large as the frame's, and no budget may have their room.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn what_the_reference_camera_needs_is_counted() {
    let scene = Scene::new();
    let words = ["--count", "3000", "--skinning", "compute", "--size", "640x360", "--msaa", "1", "--vram", "15"];
    let pack = scene.pack();
    let fitted = |more: &[&str]| {
        let words = [&[pack.as_str(), "--headless", "--report", "-"], &words[..], more].concat();
        let report = report(&crowdplay(&words));
        let number = |value: &Value| value.as_u64().unwrap_or_else(|| panic!("{value} is no number"));
        let taken = number(&report["gpu_bytes"]);
        assert!(taken <= 15 << 20 && taken + 100 > 15 << 20, "{taken}");
        (number(&report["budget"]), number(&report["gpu_memory"]["picture"]))
    };
    let out = scene.path("seen.png");
    let (alone, seen) = (fitted(&["--out", &out]), fitted(&["--out", &out, "--reference-camera"]));
    // Each with the buffer that its rows of 2,560 bytes are read back through.
    assert_eq!([alone.1, seen.1], [2 * 2560 * 360, 2 * 2 * 2560 * 360]);
    // A vertex takes 24 bytes, skinned beforehand; a little more goes to the marks that the second camera shows.
    let (freed, asked) = ((alone.0 - seen.0) * 24, seen.1 - alone.1);
    assert!((asked..asked + 1000).contains(&freed), "{alone:?} {seen:?}");
}

/// People lie in one binding.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn more_people_than_an_adapter_binds_are_refused_with_how_many_it_can_take() {
    let (device, _) = crowd_tests::gpu::device();
    let allowed = crowd_stages::gpu::most_instances(&device.limits(), &crowd_stages::Technique::Bucketed.into());
    if allowed >= 4_000_000 {
        println!("this adapter takes {allowed}, more than --count allows");
        return;
    }
    let scene = Scene::new();
    let ran = run(&scene, &["--count", &(allowed + 1).to_string()]);
    assert_eq!((ran.code, ran.stdout.len()), (5, 0), "{}", ran.stderr);
    for word in ["people", &format!("needs {}", allowed + 1), &format!("allows {allowed}"), "--count"] {
        assert!(ran.stderr.contains(word), "{word} in {}", ran.stderr);
    }
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn a_budget_of_triangles_is_kept_and_used() {
    let scene = Scene::new();
    let words = ["--count", "600", "--technique", "reform", "--budget", "60000"];
    let drawn = |more: &[&'static str]| report(&run(&scene, &[&words[..], more].concat()));
    let count = |report: &Value, what: &str| report["frames"][0][what].as_u64().expect("a count");
    let by_triangles = drawn(&["--budget-in", "triangles"]);
    assert_eq!(by_triangles["budget_in"], "triangles");
    let triangles = count(&by_triangles, "triangles");
    assert!((59_400..=60_000).contains(&triangles), "{triangles}");
    let by_vertices = drawn(&[]);
    assert_ne!(count(&by_vertices, "triangles"), triangles, "and vertices are another budget");
    let on_cpu = drawn(&["--budget-in", "triangles", "--backend", "cpu"]);
    let other = count(&on_cpu, "triangles");
    assert!(other.abs_diff(triangles) <= 600, "{other} on the CPU, {triangles} on the GPU");
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn levels_keep_still_while_the_camera_goes() {
    let scene = Scene::new();
    let words = ["--count", "600", "--budget", "40000", "--frames", "6", "--camera-path", "line", "--dt", "0.1"];
    let used = |more: &[&'static str]| -> Vec<u64> {
        let report = report(&run(&scene, &[&words[..], &["--technique", "reform"], more].concat()));
        let frames = report["frames"].as_array().expect("frames");
        frames.iter().map(|frame| frame["vertices"].as_u64().expect("a count")).collect()
    };
    let steady = used(&["--steady", "5"]);
    assert!(steady.iter().all(|used| (38_000 - 221..=40_000).contains(used)), "{steady:?}");
    assert!(steady[0] > 39_500, "the first frame uses all it can: {steady:?}");
    let eager = used(&["--steady", "0"]);
    assert!(eager.iter().all(|used| (39_500..=40_000).contains(used)), "{eager:?}");
    assert_ne!(steady, eager);
}

#[test]
fn contradictions_are_usage_errors() {
    let scene = Scene::new();
    let pack = scene.pack();
    let table: &[&[&str]] = &[
        &["--vram", "64", "--backend", "cpu"],
        &["--vram", "0"],
        &["--budget-in", "triangles", "--fit", "eq1"],
        &["--steady", "2", "--fit", "eq1"],
        &["--steady", "60"],
    ];
    for words in table {
        let ran = crowdplay(&[&[pack.as_str(), "--headless"][..], words].concat());
        assert!(ran.code == 2 && ran.stderr.contains(words[0]), "{words:?}: {}", ran.stderr);
    }
}
