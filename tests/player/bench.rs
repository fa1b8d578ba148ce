//! `crowdplay bench`: techniques in turn, tables, conditions.

use crate::{Scene, crowdplay};
use serde_json::Value;

fn bench(scene: &Scene, words: &[&str]) -> crate::Ran {
    let pack = scene.pack();
    let all = ["bench", &pack, "--size", "64x36", "--msaa", "1", "--backend", "gpu", "--warm-up", "1", "--rounds", "3"];
    crowdplay(&all.iter().chain(words).copied().collect::<Vec<_>>())
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn techniques_are_measured_in_turn_at_every_count() {
    let scene = Scene::new();
    let ran = bench(&scene, &["--ab", "b0,b3,bucketed", "--counts", "9,25", "--json", "-"]);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let report: Value = serde_json::from_slice(&ran.stdout).expect("standard output is the report and nothing else");
    assert_eq!(report["schema_version"], 1);
    assert!(!report["adapter"]["name"].as_str().unwrap().is_empty());
    let rows = report["rows"].as_array().unwrap();
    let names: Vec<(u64, &str)> =
        rows.iter().map(|row| (row["count"].as_u64().unwrap(), row["technique"].as_str().unwrap())).collect();
    let three = ["pseudo-instancing", "reform", "bucketed"];
    assert_eq!(names, [9, 25].into_iter().flat_map(|n| three.map(|t| (n, t))).collect::<Vec<_>>());
    for row in rows {
        assert_eq!(row["frames"], 3);
        let of = |key: &str| row[key].as_f64().unwrap();
        assert!(row["frame_ms"]["median"].as_f64().unwrap() > 0.0 && of("frame_ratio") > 0.0, "{row}");
        assert!(of("triangles") > 0.0 && of("visible") > 0.0, "{row}");
        if let Some(share) = row["lod_share"].as_f64() {
            assert!((0.0..=1.0).contains(&share), "{row}");
        }
        assert!(of("cpu_ms") > 0.0 && of("cpu_share") > 0.0 && of("cpu_share") < 1.0, "{row}");
    }
    assert_eq!(rows[0]["frame_ratio"], 1.0);
    assert_eq!(rows[0]["image_rmse"], 0.0, "full detail is full detail");
    assert_eq!(rows[0]["draws"], 9, "a draw per instance");
    assert!(rows[5]["draws"].as_u64() < Some(25));
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn conditions_decide_the_exit_code() {
    let scene = Scene::new();
    let csv = scene.path("out.csv");
    let held = ["--ab", "b0,bucketed", "--count", "9", "--csv", &csv, "--assert", "draws:bucketed/b0 < 1"];
    let ran = bench(&scene, &held);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(ran.stderr.contains("draws:bucketed/b0 < 1") && ran.stderr.contains("holds"), "{}", ran.stderr);
    assert!(ran.stdout.is_empty());
    let table = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(table.lines().count(), 3, "{table}");
    // One that fails fails the run, after everything is written.
    std::fs::remove_file(&csv).unwrap();
    let ran = bench(&scene, &[&held[..], &["--assert", "bucketed/b0 < 0"]].concat());
    assert_eq!(ran.code, 4, "{}", ran.stderr);
    assert!(ran.stderr.contains("DOES NOT HOLD") && ran.stderr.contains("1 of 2"), "{}", ran.stderr);
    assert!(std::fs::read_to_string(&csv).is_ok());
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn a_path_is_measured_from_end_to_end() {
    let scene = Scene::new();
    let pack = scene.pack();
    let words =
        ["bench", &pack, "--size", "64x36", "--msaa", "1", "--backend", "gpu", "--ab", "b2,bucketed", "--count", "25"];
    let path = ["--camera-path", "walkthrough", "--path", "5", "--warm-up", "1", "--budget", "100000", "--json", "-"];
    let equal = ["--assert", "triangles_at_equal_image:bucketed/b2 <= 100"];
    let ran = crowdplay(&[&words[..], &path, &equal].concat());
    assert!(matches!(ran.code, 0 | 4), "{}", ran.stderr);
    let report: Value = serde_json::from_slice(&ran.stdout).expect("standard output is the report and nothing else");
    let rows = report["rows"].as_array().unwrap();
    for row in rows {
        assert_eq!(row["frames"], 5);
        if let Some(most) = row["most_runs_per_triangle"].as_f64() {
            assert!(most >= row["mean_runs_per_triangle"].as_f64().unwrap(), "{row}");
        }
    }
    let [discrete, ours] = &rows[..] else { panic!("two techniques") };
    let equal = &ours["as_good_as"]["discrete"];
    assert_eq!(equal.is_object(), ran.code == 0, "{equal}");
    if equal.is_object() {
        assert!(equal["image_rmse"].as_f64() <= discrete["image_rmse"].as_f64(), "{equal}");
    }
}

#[test]
fn words_that_make_no_sense_are_usage_errors() {
    let scene = Scene::new();
    for (words, said) in [
        (&["--ab", "b0,b9"][..], "b9"),
        (&["--ab", "b0", "--assert", "b3/b0 < 1"], "techniques of --ab"),
        (&["--ab", "b0", "--headless"], "not of bench"),
        (&["--ab", "b0", "--csv", &scene.pack()], "the same file"),
    ] {
        let ran = bench(&scene, words);
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(said), "{words:?}: {}", ran.stderr);
    }
    let said = crowdplay(&["-q", "bench", "--help"]).stdout;
    assert!(said == crowdplay(&["bench", "-q", "--help"]).stdout && String::from_utf8_lossy(&said).contains("--ab"));
    let ran = crowdplay(&["bench", "--help"]);
    assert_eq!(ran.code, 0);
    let help = String::from_utf8(ran.stdout).unwrap();
    assert!(help.contains("--assert") && help.contains("lod_share") && !help.contains("--headless"), "{help}");
}

/// Its own, also where those drawn after it fade or are skinned elsewhere.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn what_is_said_of_a_contenders_skinning_is_what_its_row_says() {
    let scene = Scene::new();
    for ab in ["bucketed,bucketed+vertex+fades", "bucketed+fades,bucketed+vertex"] {
        let ran = bench(&scene, &["--ab", ab, "--count", "9", "--json", "-"]);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let report: Value = serde_json::from_slice(&ran.stdout).expect("standard output is the report");
        let row = &report["rows"][0];
        let (name, way) = (row["technique"].as_str().unwrap(), row["skinning"].as_str().unwrap());
        let said = ran.stderr.lines().find_map(|line| line.split_once(&format!("{name}: skinning: ")));
        let (_, words) = said.unwrap_or_else(|| panic!("nothing is said of {name}: {}", ran.stderr));
        assert!(words.starts_with(way), "{way}: {words}");
    }
}
