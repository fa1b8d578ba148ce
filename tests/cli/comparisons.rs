//! `compare`: our levels and other tools' side by side, as tables, JSON and a document.

use crate::bench::{Bench, TUBE};
use serde_json::Value;

const PAIR: [&str; 6] = ["--quick", "--ratios", "25%", "--ours", "wedge", "--peers"];

fn compare<'a>(extra: &[&'a str]) -> Vec<&'a str> {
    let mut words = vec!["compare", "@tube.glb"];
    words.extend(PAIR);
    words.push("meshopt-global");
    words.extend(extra);
    words
}

#[test]
fn every_contender_is_judged_at_every_ratio() {
    let bench = Bench::new();
    bench.copy(TUBE, "tube.glb");
    let run = bench.run(&compare(&["--json"])).expect(0);
    let json = run.json();
    assert_eq!(json["command"], "compare");
    let scores = json["characters"][0]["scores"].as_array().expect("a list of scores");
    let names: Vec<&str> = scores.iter().filter_map(|score| score["contender"].as_str()).collect();
    assert_eq!(names, ["wedge", "meshopt-global"]);
    for score in scores {
        let (count, target) = (score["triangles"].as_u64().unwrap(), score["target"].as_u64().unwrap());
        assert_eq!(score["reached"], count * 100 <= target * 101, "{score}");
        assert!(score["verdict"]["animated_rms_percent"].as_f64().unwrap() > 0.0, "{score}");
        assert!(score["verdict"]["image_rmse"].is_null(), "--quick draws no pictures: {score}");
    }
    assert!(json["bars"].as_array().unwrap().iter().any(|bar| bar["than"] == "meshopt-global"), "{}", json["bars"]);
}

#[test]
fn the_same_figures_come_out_on_any_number_of_threads() {
    let bench = Bench::new();
    bench.copy(TUBE, "tube.glb");
    let verdicts = |threads: &str| {
        let output = bench.program(&compare(&["--json"])).env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert!(output.status.success());
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        let scores = json["characters"][0]["scores"].as_array().unwrap().clone();
        scores.into_iter().map(|score| score["verdict"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(verdicts("1"), verdicts("4"));
}

#[test]
fn the_document_is_written_whole_and_nothing_is_printed() {
    let bench = Bench::new();
    bench.copy(TUBE, "tube.glb");
    let run = bench.run(&compare(&["-o", "@deep/B.md"])).expect(0);
    assert_eq!(run.out, "");
    let page = String::from_utf8(bench.read("deep/B.md")).unwrap();
    for part in ["# Benchmarks", "## All characters together", "## Bars", "## tube", "| 25 % | wedge |"] {
        assert!(page.contains(part), "no {part} in:\n{page}");
    }
    assert!(!page.contains(&bench.path("").to_string_lossy().into_owned()), "machine paths stay out:\n{page}");
}

#[test]
fn what_cannot_be_compared_is_said() {
    let bench = Bench::new();
    bench.copy(TUBE, "tube.glb");
    bench.write("bad.glb", b"no");
    bench.run(&compare(&["@bad.glb"])).expect(1).says(&["bad.glb"]);
    bench.run(&compare(&["--ours", "simplygon"])).expect(2).says(&["wedge"]);
    bench
        .run(&["compare", "@tube.glb", "--ratios", "25"])
        .expect(2)
        .says(&["found 25, allowed above 0 and up to 1, or up to 100%"]);
    bench.run(&compare(&["-o", "@tube.glb"])).expect(2).says(&["inputs are never overwritten"]);
    // Without PATH there is no gltfpack: it is left out aloud, the others are compared.
    let words = ["compare", "@tube.glb", "--quick", "--ratios", "50%", "--ours", "wedge", "--peers", "gltfpack-se1"];
    let output = bench.program(&words).env("PATH", "").output().unwrap();
    let talk = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && talk.contains("gltfpack is left out"), "{talk}");
}

/// Sizes of a manifest are those of a bake: distances are of the size asked for, shares of it stay what they are.
#[test]
fn characters_are_compared_in_the_size_that_a_manifest_asks_for() {
    let bench = Bench::new();
    bench.copy(TUBE, "tube.glb");
    let numbers = |words: &[&str]| {
        let json = bench.run(words).expect(0).json();
        let scores = json["characters"][0]["scores"].as_array().expect("a list of scores").clone();
        let rms = |score: &Value| score["verdict"]["animated_rms_percent"].as_f64().expect("a number");
        (json["characters"][0]["diagonal_m"].as_f64().unwrap(), scores.iter().map(rms).collect::<Vec<_>>())
    };
    let (diagonal_m, shares) = numbers(&compare(&["--json"]));
    bench.write("crowd.toml", b"[[characters]]\nsource = 'tube.glb'\nscale = 0.01\n");
    let words = [&["compare", "@crowd.toml", "--json"], &PAIR[..], &["meshopt-global"]].concat();
    let (small_m, of_small) = numbers(&words);
    assert!((small_m - 0.01 * diagonal_m).abs() < 1e-5 * diagonal_m, "{small_m} of {diagonal_m}");
    assert!(!shares.is_empty() && of_small.len() == shares.len(), "{of_small:?} and {shares:?}");
    for (a, b) in of_small.iter().zip(&shares) {
        assert!((a - b).abs() < 0.05 * b, "{of_small:?} and {shares:?}");
    }
    bench.write("crowd.toml", b"[[characters]]\nsource = 'tube.glb'\nheight = 1e30\n");
    bench.run(&words).expect(1).says(&["crowd.toml", "height"]);
    bench.run(&compare(&["--scale", "2"])).expect(2).says(&["--scale"]);
}

/// Another program works on the file as it is; what it wrote is judged in the size asked for. This one leaves everything where it was.
#[test]
#[cfg(unix)]
fn levels_of_another_program_take_on_the_size_too() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new();
    bench.copy(TUBE, "tube.glb");
    bench.write("crowd.toml", b"[[characters]]\nsource = 'tube.glb'\nscale = 0.01\n");
    std::fs::create_dir(bench.path("bin")).unwrap();
    bench.write("bin/gltfpack", b"#!/bin/sh\n[ \"$1\" = -v ] || exec /bin/cp \"$2\" \"$4\"\n");
    let program = bench.path("bin/gltfpack");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let words = ["compare", "@crowd.toml", "--json", "--quick", "--ratios", "50%", "--ours", "wedge", "--peers"];
    let words = [&words[..], &["gltfpack-se1"]].concat();
    let output = bench.program(&words).env("PATH", bench.path("bin")).output().unwrap();
    let json: Value = serde_json::from_slice(&output.stdout).expect("standard output is JSON and nothing else");
    let theirs = &json["characters"][0]["scores"][1];
    assert_eq!(theirs["contender"], "gltfpack-se1");
    let off = theirs["verdict"]["animated_rms_percent"].as_f64().expect("a number");
    assert!(off < 0.01, "{off}");
}
