//! JSON documents: what a pipeline may rely on.

use crate::bench::{Bench, SPHERE, TUBE};
use serde_json::Value;

#[test]
fn the_report_has_steps_counts_and_the_sections_of_the_pack() {
    let bench = Bench::with(&[TUBE]);
    let words = ["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack", "--json", "--report", "@r.json"];
    let done = bench.run(&words).expect(0);
    let report = done.json();
    assert_eq!(done.out.into_bytes(), bench.read("r.json"), "file and stdout hold the same document");
    assert_eq!(report["schema_version"], 2);
    assert_eq!(report["command"], "bake");
    let character = &report["characters"][0];
    let steps: Vec<&str> =
        character["steps"].as_array().unwrap().iter().map(|step| step["step"].as_str().unwrap()).collect();
    assert_eq!(steps, ["load", "select-clips", "sample", "quantize", "simplify", "bound", "levels"]);
    assert!(character["steps"][4]["seconds"].as_f64().unwrap() > 0.0);
    let triangles = |which: &str| character[which]["triangles"].as_u64().unwrap();
    assert_eq!(triangles("before"), triangles("full_detail"));
    assert!(triangles("after") < triangles("before") / 4);
    assert!(!character["measured"].as_array().unwrap().is_empty());
    let sections = report["pack"]["sections"].as_array().unwrap();
    let bytes: u64 = sections.iter().map(|section| section["bytes"].as_u64().unwrap()).sum();
    let whole = report["pack"]["bytes"].as_u64().unwrap();
    assert_eq!(whole, bench.read("out.crowdpack").len() as u64);
    assert!(bytes < whole && whole < bytes + 4096, "{bytes} of {whole}");
}

#[test]
fn pack_and_asset_are_inspected_under_one_schema() {
    let bench = Bench::with(&[SPHERE]);
    let input = format!("@{SPHERE}");
    bench.run(&["bake", &input, "-o", "@out.crowdpack"]).expect(0);
    let asset = bench.run(&["inspect", &input, "--json"]).expect(0).json();
    let pack = bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json();
    assert_eq!((&asset["kind"], &pack["kind"]), (&Value::from("asset"), &Value::from("pack")));
    for inspection in [&asset, &pack] {
        assert_eq!(inspection["schema_version"], 2);
    }
    let (before, after) = (&asset["characters"][0], &pack["characters"][0]);
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(before), keys(after));
    // A pack has the vertices too that only its coarser levels use.
    assert!(before["vertices"].as_u64() <= after["vertices"].as_u64());
    for same in ["triangles", "seams", "joints", "materials", "parts"] {
        assert_eq!(before[same], after[same], "{same}");
    }
    assert!(before["measured"].as_array().unwrap().is_empty());
    assert!(after["measured"].as_array().unwrap().len() > 8);
}

#[test]
fn the_table_for_people_names_seams_classes_and_errors() {
    let bench = Bench::with(&[TUBE]);
    bench.run(&["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack"]).expect(0);
    let table = bench.run(&["inspect", "@out.crowdpack"]).expect(0).out;
    for word in ["full detail", "coarsest", "seams", "companion", "blocked", "clip", "rms mm", "bound mm", "quantised"]
    {
        assert!(table.contains(word), "no {word} in:\n{table}");
    }
    assert!(!table.contains('\u{1b}'));
}
