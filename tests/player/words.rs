//! Words, exit codes, files left behind, and the report's shape.

use crate::{Scene, crowdplay, figures, player};
use crowd_tests::taught::{commands, documented};

pub(crate) const TINY: [&str; 6] = ["--size", "32x18", "--count", "4", "--backend", "cpu"];

#[test]
fn help_version_and_completions_are_data() {
    for words in [&["--help"][..], &["--version"], &["--completions", "bash"], &["--completions", "fish"]] {
        let ran = crowdplay(words);
        assert_eq!((ran.code, ran.stderr.as_str()), (0, ""), "{words:?}");
        assert!(String::from_utf8_lossy(&ran.stdout).contains("crowdplay"), "{words:?}");
    }
    let help = String::from_utf8(crowdplay(&["--help"]).stdout).unwrap();
    for taught in ["Examples:", "Exit codes:", "--headless", "--list-adapters"] {
        assert!(help.contains(taught), "{taught}");
    }
}

/// Nothing that they name is there, not even a display: words that make sense end with 1 or 5.
#[test]
fn commands_that_help_and_documents_teach_are_understood() {
    let scene = Scene::new();
    let mut taught = documented("crowdplay");
    for words in [&["--help"][..], &["bench", "--help"]] {
        taught.extend(commands("crowdplay", &String::from_utf8(crowdplay(words).stdout).unwrap()));
    }
    assert!(taught.len() > 50, "{}", taught.len());
    for words in &taught {
        let mut program = player();
        program.args(words).current_dir(scene.folder());
        let ran = program.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").output();
        let ran = ran.expect("the program starts");
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(matches!(ran.status.code(), Some(0 | 1 | 5)), "{words:?}: {said}");
    }
    assert_eq!(scene.files(), ["posts.crowdpack"]);
}

#[test]
fn wrong_words_are_usage_errors() {
    let scene = Scene::new();
    let pack = scene.pack();
    let table: &[&[&str]] = &[
        &[],
        &[&pack, "--count", "0"],
        &[&pack, "--headless", "--frames", "0"],
        &[&pack, "--headless", "--size", "0x0"],
        &[&pack, "--headless", "--characters", "Nobody"],
        &[&pack, "--headless", "--clips", "fly"],
        &[&pack, "--headless", "--layout", "circle"],
        &[&pack, "--headless", "--flock", "0"],
        &[&pack, "--headless", "--flock", "9", "--count", "9"],
        &[&pack, "--headless", "--walk", "--layout", "grid"],
        &[&pack, "--headless", "--out", "-", "--report", "-"],
        &[&pack, "--headless", "--backend", "cpu", "--size", "16384x16384"],
        &[&pack, "--headless", "--backend", "cpu", "--msaa", "1", "--size", "16384x8193"],
        &[&pack, "--unknown"],
    ];
    for words in table {
        let ran = crowdplay(words);
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.stderr);
        assert!(ran.stdout.is_empty() && !ran.stderr.is_empty(), "{words:?}");
    }
    assert_eq!(scene.files(), ["posts.crowdpack"]);
}

#[test]
fn words_that_nothing_would_heed_are_refused_with_those_that_would() {
    let scene = Scene::new();
    let table: &[(&[&str], &str)] = &[
        (&["--max-px", "2"], "--lod-metric error"),
        (&["--technique", "discrete", "--target-ms", "9"], "reform, static-floor, bucketed"),
        (&["--technique", "instanced", "--fit", "eq1"], "reform, static-floor, bucketed"),
        (&["--technique", "points", "--steady", "1"], "reform, static-floor, bucketed"),
        (&["--technique", "discrete", "--reference-camera"], "instanced, reform, static-floor, points or bucketed"),
    ];
    for (words, allowed) in table {
        let ran = crowdplay(&[&[scene.pack().as_str(), "--headless"][..], words].concat());
        assert_eq!(ran.code, 2, "{words:?}: {}", ran.stderr);
        assert!(ran.stderr.contains("found") && ran.stderr.contains(allowed), "{words:?}: {}", ran.stderr);
        assert!(words.iter().any(|word| ran.stderr.contains(&format!("error: {word}: "))), "{}", ran.stderr);
    }
}

#[test]
fn a_result_names_a_budget_where_there_is_one_and_errors_come_before_remarks() {
    let scene = Scene::new();
    let small = ["--backend", "cpu", "--count", "4", "--size", "32x18"];
    let said = scene.render(&small).stderr;
    assert!(said.contains(", budget ") && said.contains(" vertices\n"), "{said}");
    let said = scene.render(&[&small[..], &["--technique", "b0"]].concat()).stderr;
    assert!(said.contains(" visible; ") && !said.contains("budget"), "{said}");
    let lost = crowdplay(&[&scene.pack(), "--headless", "--camera-path", &scene.path("none.txt")]);
    assert_eq!((lost.code, lost.stderr.lines().count()), (1, 1), "{}", lost.stderr);
}

#[test]
fn unknown_names_are_answered_with_the_known_ones() {
    let scene = Scene::new();
    let ran = crowdplay(&[&scene.pack(), "--headless", "--characters", "Nobody"]);
    assert!(ran.stderr.contains("Nobody") && ran.stderr.contains("Ada, Bruno"), "{}", ran.stderr);
    let ran = crowdplay(&[&scene.pack(), "--headless", "--clips", "fly"]);
    assert!(ran.stderr.contains("fly") && ran.stderr.contains("Sway"), "{}", ran.stderr);
}

#[test]
fn a_missing_or_damaged_pack_is_refused() {
    let scene = Scene::new();
    let good = std::fs::read(scene.pack()).unwrap();
    let mut flipped = good.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 0x10;
    std::fs::write(scene.file("flipped.crowdpack"), flipped).unwrap();
    std::fs::write(scene.file("short.crowdpack"), &good[..good.len() / 2]).unwrap();
    std::fs::write(scene.file("text.crowdpack"), "not a pack").unwrap();
    for name in ["missing.crowdpack", "flipped.crowdpack", "short.crowdpack", "text.crowdpack"] {
        let out = scene.path("never.png");
        let ran = crowdplay(&[&scene.path(name), "--headless", "--backend", "cpu", "--out", &out]);
        assert_eq!(ran.code, 1, "{name}: {}", ran.stderr);
        assert_eq!(ran.stderr.matches(name).count(), 1, "{}", ran.stderr);
        assert!(!scene.file("never.png").exists());
    }
}

#[test]
fn an_asset_in_the_place_of_a_pack_is_answered_with_the_command_that_bakes_it() {
    let scene = Scene::new();
    for name in ["mara.glb", "two words.gltf", "CAST.OBJ", "crowd.toml"] {
        std::fs::write(scene.file(name), "not a pack, and long enough to have a header of some kind").unwrap();
        let asset = scene.path(name);
        for words in [&[asset.as_str(), "--headless", "--backend", "cpu"][..], &["bench", &asset, "--ab", "b0,b1"]] {
            let ran = crowdplay(words);
            assert_eq!((ran.code, ran.stdout.len()), (1, 0), "{words:?}: {}", ran.stderr);
            let stem = name.split('.').next().expect("it has one");
            assert!(ran.stderr.contains("crowdbake bake") && ran.stderr.contains(&format!("{stem}.crowdpack")));
            assert_eq!(ran.stderr.contains(&format!("'{asset}'")), name.contains(' '), "{}", ran.stderr);
        }
    }
    // A pack with an asset's name is a pack; an asset that is not there is a missing file.
    std::fs::copy(scene.pack(), scene.file("pack.glb")).unwrap();
    let ran = crowdplay(&[&[scene.path("pack.glb").as_str(), "--headless"][..], &TINY].concat());
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let ran = crowdplay(&[&scene.path("gone.glb"), "--headless"]);
    assert!(ran.code == 1 && !ran.stderr.contains("crowdbake"), "{}", ran.stderr);
}

#[test]
fn a_pack_whose_image_does_not_decode_is_refused() {
    let scene = Scene::new();
    let mut contents = figures::contents(&figures::TWO_POSTS);
    contents.image_bytes[20..40].fill(0);
    contents.write(&scene.file("image.crowdpack")).expect("the pack itself is well formed");
    let ran = crowdplay(&[&scene.path("image.crowdpack"), "--headless", "--backend", "cpu"]);
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    assert!(ran.stderr.contains("image 0"), "{}", ran.stderr);
}

#[test]
fn wrong_layouts_and_camera_paths_are_refused_with_their_line() {
    let scene = Scene::new();
    std::fs::write(scene.file("wrong.txt"), "# crowd layout v1\n0 0 0 0 1 9 0 0\n").unwrap();
    std::fs::write(scene.file("empty.txt"), "# crowd layout v1\n").unwrap();
    std::fs::write(scene.file("latin1.txt"), b"# crowd layout v1\n# caf\xe9\n").unwrap();
    let (wrong, empty, missing) = (scene.path("wrong.txt"), scene.path("empty.txt"), scene.path("missing.txt"));
    let latin1 = scene.path("latin1.txt");
    let table = [
        (["--layout", wrong.as_str()], "line 2"),
        (["--layout", empty.as_str()], "nobody"),
        (["--layout", missing.as_str()], "missing.txt"),
        (["--layout", latin1.as_str()], "latin1.txt: is not UTF-8 text"),
        (["--camera-path", latin1.as_str()], "latin1.txt: is not UTF-8 text"),
        (["--camera-path", wrong.as_str()], "line 1"),
        (["--camera-path", missing.as_str()], "missing.txt"),
    ];
    for (words, evidence) in table {
        let ran = crowdplay(&[&scene.pack(), "--headless", "--backend", "cpu", words[0], words[1]]);
        assert_eq!(ran.code, 1, "{words:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(evidence), "{words:?}: {}", ran.stderr);
    }
}

#[test]
fn a_gpu_that_is_not_there_is_code_5() {
    let scene = Scene::new();
    let ran = crowdplay(&[&scene.pack(), "--headless", "--adapter", "no such graphics card"]);
    assert_eq!(ran.code, 5, "{}", ran.stderr);
    assert!(ran.stderr.contains("no such graphics card") && ran.stderr.contains("--backend cpu"), "{}", ran.stderr);
}

/// Four samples of each take eight gigabytes before the first triangle.
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn an_enormous_picture_is_a_usage_error_on_the_gpu_too() {
    let scene = Scene::new();
    let ran = crowdplay(&[&scene.pack(), "--headless", "--backend", "gpu", "--count", "1", "--size", "16384x16384"]);
    assert_eq!(ran.code, 2, "{}", ran.stderr);
    assert!(ran.stderr.contains("--size: found 16384x16384"), "{}", ran.stderr);
}

#[test]
fn the_report_has_its_shape() {
    let scene = Scene::new();
    let out = scene.path("last.png");
    let words = ["--frames", "4", "--dt", "0.25", "--start", "1", "--out", &out, "--seed", "9"];
    let report = scene.report(&[&words[..], &TINY].concat());
    assert_eq!(report["schema_version"], 1);
    assert_eq!(report["backend"], "cpu");
    assert_eq!(report["pack"], "posts.crowdpack");
    assert_eq!(report["size"], serde_json::json!([32, 18]));
    assert_eq!(report["technique"], "bucketed");
    assert_eq!(report["levels"], "quantized");
    assert_eq!(report["weight"], "area");
    assert_eq!(report["alpha"], 3.0);
    assert_eq!(report["budget"], 300_000 + 4 * 26, "the coarsest levels and the software default");
    assert_eq!(report["crowd"]["instances"], 4);
    assert_eq!(report["crowd"]["seed"], 9);
    assert_eq!(report["crowd"]["vertices_full"], 4 * 17 * 13);
    assert_eq!(report["crowd"]["clips"], serde_json::json!(["Ada/Idle", "Ada/Sway", "Bruno/Idle", "Bruno/Sway"]));
    assert_eq!(report["pictures"], serde_json::json!([out]));
    assert_eq!(report["adapter"]["name"], "crowd-raster");
    let frames = report["frames"].as_array().expect("a list");
    let times: Vec<f64> = frames.iter().map(|f| f["time_s"].as_f64().expect("seconds")).collect();
    assert_eq!(times, [1.0, 1.25, 1.5, 1.75]);
    for frame in frames {
        assert_eq!(frame["visible"], 4);
        assert!(frame["triangles"].as_u64().expect("a count") > 0);
        assert!(frame["frame_ms"].as_f64().expect("a time") > 0.0);
    }
    assert_eq!(report["timings"]["frames"], 3);
    let spread = &report["timings"]["frame_ms"];
    assert!(spread["median"].as_f64() <= spread["p95"].as_f64());
    assert!(report["timings"]["stages_ms"]["pose_and_draw"]["median"].is_number());
    assert_eq!(scene.files(), ["last.png", "posts.crowdpack"]);
}

#[test]
fn quiet_is_quiet() {
    let scene = Scene::new();
    assert_eq!(scene.render(&[&["--quiet"][..], &TINY].concat()).stderr, "");
    assert!(scene.render(&TINY).stderr.contains("4 instances"));
}

#[test]
fn a_spacing_below_the_bodies_is_raised_aloud_and_reported() {
    let scene = Scene::new();
    let asked = [&["--spacing", "0.01"][..], &TINY].concat();
    let said = scene.render(&asked).stderr;
    assert!(said.contains("--spacing 0.01: raised to") && said.contains("m across"), "{said}");
    let used = |words: &[&str]| scene.report(words)["crowd"]["spacing_m"].as_f64().expect("metres");
    assert!(used(&asked) > 0.05 && used(&asked) <= used(&TINY), "{} and {}", used(&asked), used(&TINY));
    let wide = [&["--spacing", "7"][..], &TINY].concat();
    assert_eq!(used(&wide), 7.0);
    assert!(!scene.render(&wide).stderr.contains("raised"));
}

#[test]
fn one_frame_is_said_to_be_the_first() {
    let scene = Scene::new();
    assert!(scene.render(&TINY).stderr.contains("1 frame: "));
    let said = scene.render(&[&["--frames", "3"][..], &TINY].concat()).stderr;
    assert!(said.contains("3 frames, median ") && said.contains("(of 2, without the first)"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn without_vulkan_it_is_said_what_would_take_opengl() {
    let scene = Scene::new();
    let run = |words: &[&str]| {
        let mut player = crate::player();
        player.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent").args(words);
        player.output().expect("the player is built")
    };
    let listed = String::from_utf8(run(&["--list-adapters"]).stdout).expect("text");
    let auto = run(&[&[scene.pack().as_str(), "--headless"][..], &TINY[..4]].concat());
    let said = String::from_utf8_lossy(&auto.stderr);
    // Where OpenGL is played by a processor, or not there at all, the CPU draws.
    if listed.trim().is_empty() || listed.lines().all(|line| line.contains("Cpu")) {
        assert!(auto.status.success() && said.contains("drawing on the CPU instead"), "{said}");
        assert_eq!(said.contains("OpenGL with --backend gpu"), !listed.trim().is_empty(), "{listed}: {said}");
    } else {
        assert!(auto.status.success() && !said.contains("drawing on the CPU instead"), "{listed}: {said}");
    }
}

#[test]
fn characters_and_clips_are_chosen_by_name() {
    let scene = Scene::new();
    let report = scene.report(&[&["--characters", "bruno", "--clips", "SWAY"][..], &TINY].concat());
    assert_eq!(report["crowd"]["characters"], serde_json::json!(["Bruno"]));
    assert_eq!(report["crowd"]["clips"], serde_json::json!(["Bruno/Sway"]));
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: needs an adapter")]
fn adapters_are_listed_one_a_line_and_named_in_the_report() {
    let ran = crowdplay(&["--list-adapters"]);
    let list = String::from_utf8(ran.stdout).unwrap();
    let first = list.lines().next().expect("there is an adapter, or this test is opted out of");
    let fields: Vec<&str> = first.split('\t').collect();
    assert_eq!((ran.code, fields.len()), (0, 4), "{list}");
    let scene = Scene::new();
    let words = ["--size", "32x18", "--count", "4", "--backend", "gpu", "--adapter", fields[0]];
    assert_eq!(scene.report(&words)["adapter"]["name"], fields[0]);
}
