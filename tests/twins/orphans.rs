//! One stage, one name, four places: shader, CPU twin, GPU dispatch, twin test.

use crowd_stages::gpu::STAGES;
use crowd_tests::folders::repository;
use std::collections::BTreeSet;

/// File names without their ending, less those that are no stage.
fn names(folder: &str, ending: &str, others: &[&str]) -> BTreeSet<String> {
    let entries = std::fs::read_dir(repository().join(folder)).expect("a folder of the repository");
    let files = entries.map(|entry| entry.expect("readable").file_name().into_string().expect("plain names"));
    let mut names: BTreeSet<String> = files.filter_map(|name| name.strip_suffix(ending).map(str::to_owned)).collect();
    for other in others {
        assert!(names.remove(*other), "{folder}/{other}{ending} is gone: take it off this list");
    }
    names
}

#[test]
fn every_stage_has_a_shader_a_twin_a_dispatch_and_a_test() {
    let stages: BTreeSet<String> = STAGES.iter().map(|&name| name.to_owned()).collect();
    let not_stages_cpu = ["mod", "pose_instance", "pose_points"];
    let not_stages_gpu = [
        "mod",
        "allocate",
        "bucket_draws",
        "draw_crowd",
        "draw_marks",
        "draw_scenery",
        "feed",
        "flock",
        "impostor_textures",
        "kernel",
        "lending",
        "lit",
        "memory_use",
        "occlusion",
        "open_device",
        "poll_device",
        "pose_sharing",
        "pre_skinning",
        "read_back",
        "renderer",
        "selection",
        "shadows",
        "skinning_trial",
        "stage_recorder",
        "targets",
        "upload",
        "vertex_inputs",
    ];
    let not_stages_tests = [
        "main",
        "cases",
        "crowded_joints",
        "embedding",
        "feeds",
        "flocks",
        "memory",
        "occlusion",
        "orphans",
        "shadows",
        "small_bindings",
        "stage_times",
        "techniques",
        "whole_chain",
    ];
    assert_eq!(names("shaders/stages", ".wgsl", &[]), stages);
    assert_eq!(names("crates/crowd-stages/src/cpu", ".rs", &not_stages_cpu), stages);
    assert_eq!(names("crates/crowd-stages/src/gpu", ".rs", &not_stages_gpu), stages);
    assert_eq!(names("tests/twins", ".rs", &not_stages_tests), stages);
}

#[test]
fn an_orphan_is_seen() {
    let shaders = names("shaders/stages", ".wgsl", &[]);
    let without_exceptions = names("crates/crowd-stages/src/cpu", ".rs", &[]);
    assert_ne!(shaders, without_exceptions, "pose_instance has no shader of its own");
}
