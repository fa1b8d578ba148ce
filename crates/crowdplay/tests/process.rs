//! The program as a process: what only a process has, such as an environment without a display.

#[cfg(target_os = "linux")]
use crowd_pack::*;
use std::process::Command;
#[cfg(target_os = "linux")]
use std::process::Output;

fn crowdplay() -> Command {
    Command::new(env!("CARGO_BIN_EXE_crowdplay"))
}

#[test]
#[cfg(all(unix, not(target_os = "macos")))]
fn without_a_display_the_error_names_the_way_out() {
    let mut command = crowdplay();
    command.arg("any.crowdpack");
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    let output = command.output().expect("the program was built beside this test");
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{talk}");
    assert!(talk.contains("no display") && talk.contains("--headless"), "{talk}");
    assert!(output.stdout.is_empty());
}

#[test]
fn exit_codes_reach_the_shell() {
    let code = |words: &[&str]| crowdplay().args(words).output().expect("the program was built").status.code();
    assert_eq!(code(&["--help"]), Some(0));
    assert_eq!(code(&["--count", "0", "x.crowdpack"]), Some(2));
    assert_eq!(code(&["no-such-file.crowdpack", "--headless"]), Some(1));
}

/// Runs on one triangle, with a choice of backends that this system does not have.
#[cfg(target_os = "linux")]
fn without_adapter(words: &[&str]) -> (Output, Vec<String>) {
    let folder = tempfile::tempdir().expect("there is a temporary folder");
    let pack = folder.path().join("triangle.crowdpack");
    let mut contents = one_triangle();
    contents.store_end_levels();
    contents.write(&pack).expect("the triangle is valid");
    let output = crowdplay()
        .current_dir(folder.path())
        .env("WGPU_BACKEND", "dx12")
        .args(["triangle.crowdpack", "--headless", "--size", "32x18", "--count", "3", "--out", "a.png"])
        .args(words)
        .output()
        .expect("the program was built beside this test");
    let entries = std::fs::read_dir(folder.path()).expect("the folder is there");
    let mut names: Vec<String> = entries.map(|e| e.expect("readable").file_name().to_string_lossy().into()).collect();
    names.sort();
    (output, names)
}

#[test]
#[cfg(target_os = "linux")]
fn without_an_adapter_the_cpu_draws_and_it_is_said() {
    let (output, files) = without_adapter(&[]);
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{talk}");
    assert!(talk.contains("drawing on the CPU instead"), "{talk}");
    assert_eq!(files, ["a.png", "triangle.crowdpack"]);
}

#[test]
#[cfg(target_os = "linux")]
fn without_an_adapter_a_gpu_asked_for_is_code_5() {
    let (output, files) = without_adapter(&["--backend", "gpu"]);
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{talk}");
    assert!(talk.contains("no adapter") && talk.contains("--backend cpu"), "{talk}");
    assert_eq!(files, ["triangle.crowdpack"]);
}

/// The smallest pack: a triangle that does not move.
#[cfg(target_os = "linux")]
fn one_triangle() -> PackContents {
    let corner = |x: f32, y: f32| {
        VertexRecord::new([x, y, 0.0], [0.0, 0.0, 1.0], [x, y], [1.0; 4], 0, 2, [0; 4], [1.0, 0.0, 0.0, 0.0])
    };
    let level = LodRecord { vertex_count: 3, triangle_count: 1 };
    let sphere = [0.0, 1.0, 0.0, 2.0];
    PackContents {
        manifest: Manifest {
            characters: vec![ManifestCharacter {
                name: "triangle".into(),
                nodes: vec![ManifestNode { rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3], ..Default::default() }],
                joints: vec![ManifestJoint::default()],
                clips: vec![ManifestClip { name: "rest".into(), ..Default::default() }],
                materials: vec!["only".into()],
                ..Default::default()
            }],
            ..Default::default()
        },
        characters: vec![CharacterRecord {
            vertex_count: 3,
            triangle_count: 1,
            min_vertex_count: 3,
            min_triangle_count: 1,
            joint_count: 1,
            clip_count: 1,
            material_count: 1,
            sphere,
            box_max: [1.0, 2.0, 0.0],
            height_m: 2.0,
            ..Default::default()
        }],
        vertices: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 2.0)],
        triangles: vec![[0, 1, 2]],
        collapse_map: vec![0, 1, 2],
        lods: vec![level; 4],
        clips: vec![ClipRecord { frame_count: 1, sphere, ..Default::default() }],
        animation: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0_f32]]
            .map(|r| r.map(f32::to_bits))
            .to_vec(),
        materials: vec![MaterialRecord { base_color: [1.0; 4], image: NONE, ..Default::default() }],
        ..Default::default()
    }
}
