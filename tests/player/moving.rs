//! People who move: trajectories shown over time, in every format, refused by name.

use crate::{Scene, crowdplay};
use crowd_tests::folders::fixtures;
use std::path::Path;

const SMALL: [&str; 6] = ["--size", "96x54", "--backend", "cpu", "--msaa", "1"];

fn fixture(name: &str) -> String {
    fixtures().join("scenes").join(name).to_str().expect("plain names").to_owned()
}

/// Visible instances frame by frame.
fn visible(report: &serde_json::Value) -> Vec<u64> {
    let frames = report["frames"].as_array().expect("frames");
    frames.iter().map(|frame| frame["visible"].as_u64().expect("a count")).collect()
}

#[test]
fn every_format_shows_the_same_people() {
    let scene = Scene::new();
    for (name, stays) in
        [("crossing.sqlite", 13), ("crossing_juelich.txt", 13), ("crossing.csv", 13), ("crossing_vadere.traj", 12)]
    {
        let file = fixture(name);
        let words = [&["--trajectories", &file, "--frames", "3", "--dt", "3"][..], &SMALL].concat();
        let report = scene.report(&words);
        assert_eq!(report["crowd"]["instances"], stays, "{name}");
        let visible = visible(&report);
        assert_eq!(visible[0], 1, "{name}");
        assert!(visible[1] >= 6 && visible[2] >= 8, "{name}: {visible:?}");
    }
}

#[test]
fn a_moment_looks_the_same_however_it_was_reached() {
    let scene = Scene::new();
    let file = fixture("crossing.sqlite");
    let at_once = scene.picture(&[&["--trajectories", &file, "--time", "6"][..], &SMALL[..4]].concat());
    let later = scene
        .picture(&[&["--trajectories", &file, "--time", "2", "--frames", "3", "--dt", "2"][..], &SMALL[..4]].concat());
    assert!(at_once == later);
    let other = scene.picture(&[&["--trajectories", &file, "--time", "7"][..], &SMALL[..4]].concat());
    assert!(at_once != other);
}

#[test]
fn the_scene_begins_anew_and_may_be_empty() {
    let scene = Scene::new();
    let file = scene.path("gap.csv");
    std::fs::write(&file, "id,time,x,y\n1,0,0,0\n1,1,1,0\n2,9,0,0\n2,10,1,0\n").expect("our folder");
    let words = ["--trajectories", &file, "--frames", "4", "--dt", "5", "--time", "0.5"];
    let report = scene.report(&[&words[..], &SMALL].concat());
    assert_eq!(visible(&report), [1, 0, 1, 0]);
    // Who has not come or has left counts for nothing.
    let of = |key: &str| -> Vec<u64> {
        report["frames"].as_array().expect("frames").iter().map(|frame| frame[key].as_u64().expect("a count")).collect()
    };
    assert_eq!((of("present"), report["crowd"]["instances"].as_u64()), (vec![1, 0, 1, 0], Some(2)));
    let full = report["crowd"]["triangles_full"].as_u64().expect("a count");
    let there = of("present_triangles");
    assert!(there[0] > 0 && there[1] == 0 && there[0] + there[2] == full, "{there:?} of {full}");
    let said = scene.render(&[&words[..], &SMALL].concat()).stderr;
    assert!(said.contains("0 of 2 instances present, 0 visible; 0 of 0 triangles"), "{said}");
}

#[test]
fn whoever_is_much_wider_than_a_person_does_not_walk_unless_named() {
    let scene = Scene::new();
    let file = fixture("crossing.csv");
    let wide = ["--height", "Bruno=60"];
    for feed in [&["--trajectories", &file][..], &["--walk", "--count", "9"]] {
        let words = [feed, &wide, &SMALL].concat();
        let said = scene.render(&words).stderr;
        assert!(said.contains("Bruno (") && said.contains("not among those who walk"), "{said}");
        assert_eq!(scene.report(&words)["crowd"]["characters"], serde_json::json!(["Ada"]), "{feed:?}");
        let words = [&words[..], &["--characters", "Ada,Bruno"]].concat();
        assert_eq!(scene.report(&words)["crowd"]["characters"], serde_json::json!(["Ada", "Bruno"]), "{feed:?}");
        assert!(scene.render(&words).stderr.contains("may walk through others"));
    }
    let flock = scene.report(&[&["--flock", "9"][..], &wide, &SMALL].concat());
    assert_eq!(flock["crowd"]["characters"], serde_json::json!(["Ada", "Bruno"]), "a flock keeps apart by itself");
}

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1")]
#[test]
fn seats_stand_on_steps_and_all_of_them_are_in_the_picture() {
    let scene = Scene::new();
    let words = |layout, backend| ["--layout", layout, "--count", "200", "--size", "192x108", "--backend", backend];
    let (gpu, cpu) = (scene.picture(&words("seats", "gpu")), scene.picture(&words("seats", "cpu")));
    // Steps are of a warmer grey than the endless plane and the sky.
    let warm = |picture: &image::RgbImage| picture.pixels().filter(|p| p.0[0] > p.0[2].saturating_add(14)).count();
    assert!(warm(&gpu) > 192 * 108 / 5 && warm(&cpu) > 192 * 108 / 5, "{} and {}", warm(&gpu), warm(&cpu));
    let level = scene.picture(&words("disc", "gpu"));
    // As many people on level ground, whose clothes are warm, too.
    assert!(
        warm(&gpu) > warm(&level) + 192 * 108 / 30,
        "people on level ground are not it: {} and {}",
        warm(&gpu),
        warm(&level)
    );
    assert_eq!(scene.report(&words("seats", "cpu"))["frames"][0]["visible"], 200);
}

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1")]
#[test]
fn the_gpu_follows_who_comes_and_who_leaves() {
    let scene = Scene::new();
    let file = scene.path("gap.csv");
    std::fs::write(&file, "id,time,x,y\n1,0,0,0\n1,1,1,0\n2,9,0,0\n2,10,1,0\n3,9,2,0\n3,10,2,0\n").expect("our folder");
    let words = ["--trajectories", &file, "--frames", "3", "--dt", "4.5", "--time", "0.5", "--size", "64x36"];
    assert_eq!(visible(&scene.report(&[&words[..], &["--backend", "gpu"]].concat())), [1, 0, 2]);
    let baseline = [&words[..], &["--backend", "gpu", "--technique", "pseudo-instancing"]].concat();
    assert_eq!(visible(&scene.report(&baseline)), [1, 0, 2]);
}

#[test]
fn refusals_name_the_file_the_line_and_the_way_out() {
    let scene = Scene::new();
    for (text, words) in [
        ("id,time,x,y\n1,0,0,NaN\n", &["people.txt", "line 2", "`NaN`", "finite"][..]),
        ("id,time,x,y\n", &["found nobody", "at least one row"]),
        ("", &["heading"]),
        ("id,frame,x,y\n1,0,0,0\n", &["no frame rate", "--trajectory-rate"]),
    ] {
        let file = scene.path("people.txt");
        std::fs::write(&file, text).expect("our folder");
        let ran = crowdplay(&[&[&scene.pack(), "--headless", "--trajectories", &file][..], &SMALL].concat());
        assert_eq!(ran.code, 1, "{}", ran.stderr);
        assert!(words.iter().all(|word| ran.stderr.contains(word)), "{words:?}: {}", ran.stderr);
    }
    let ran = crowdplay(&[&scene.pack(), "--headless", "--trajectories", "x.csv", "--count", "3"]);
    assert_eq!(ran.code, 2, "a file's people are all the crowd: {}", ran.stderr);
    let out = scene.path("people.txt");
    let ran = crowdplay(&[&[&scene.pack(), "--headless", "--trajectories", &out, "--out", &out][..], &SMALL].concat());
    assert_eq!(ran.code, 2, "{}", ran.stderr);
}

#[test]
fn a_database_with_a_journal_beside_it_is_refused() {
    let scene = Scene::new();
    std::fs::copy(fixture("crossing.sqlite"), scene.file("a.sqlite")).expect("our folder");
    std::fs::write(scene.file("a.sqlite-wal"), "rows").expect("our folder");
    let ran =
        crowdplay(&[&[&scene.pack(), "--headless", "--trajectories", &scene.path("a.sqlite")][..], &SMALL].concat());
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("a.sqlite-wal") && ran.stderr.contains("wal_checkpoint"), "{}", ran.stderr);
}

#[test]
fn a_flock_and_a_walk_move_and_are_repeatable() {
    let scene = Scene::new();
    let ways = fixture("waypoints.txt");
    for feed in [
        &["--flock", "40"][..],
        &["--flock", "--count", "40"],
        &["--walk", &ways, "--count", "40"],
        &["--walk", "--count", "40"],
    ] {
        let words = [feed, &SMALL[..4]].concat();
        let report = scene.report(&[&words[..], &["--frames", "2", "--dt", "1"]].concat());
        assert_eq!(report["crowd"]["instances"], 40);
        let picture = |time: &str| scene.picture(&[&words[..], &["--time", time]].concat());
        assert!(picture("2") == picture("2"), "{feed:?}");
        assert!(picture("2") != picture("3"), "{feed:?}");
        assert!(picture("2") != scene.picture(&[&words[..], &["--time", "2", "--seed", "9"]].concat()), "{feed:?}");
    }
}

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1")]
#[test]
fn a_flock_on_the_gpu_shows_what_one_on_the_cpu_shows() {
    let scene = Scene::new();
    let words = |time, simulator| {
        ["--flock", "60", "--time", time, "--size", "192x108", "--backend", "gpu", "--simulate", simulator]
    };
    let report = scene.report(&words("2", "gpu"));
    assert_eq!((&report["simulator"], &report["crowd"]["instances"]), (&"gpu".into(), &60.into()));
    assert!(report["frames"][0]["simulate_ms"].as_f64().is_some_and(|ms| ms > 0.0));
    assert_eq!(scene.report(&words("2", "cpu"))["simulator"], "cpu");
    let (gpu, cpu) = (scene.picture(&words("2", "gpu")), scene.picture(&words("2", "cpu")));
    let far = |a: &image::Rgb<u8>, b: &image::Rgb<u8>| a.0.iter().zip(b.0).any(|(&x, y)| x.abs_diff(y) > 6);
    let differ =
        |a: &image::RgbImage, b: &image::RgbImage| a.pixels().zip(b.pixels()).filter(|(a, b)| far(a, b)).count();
    assert!(differ(&gpu, &cpu) < 30, "{} pixels differ", differ(&gpu, &cpu));
    assert!(gpu == scene.picture(&words("2", "gpu")), "the same every time");
    let later = scene.picture(&words("3", "gpu"));
    assert!(differ(&gpu, &later) > 100, "a second later everyone is elsewhere: {}", differ(&gpu, &later));
}

#[test]
fn waypoints_and_layouts_are_refused_by_line() {
    let scene = Scene::new();
    let file = scene.path("way.txt");
    std::fs::write(&file, "# crowd waypoints v1\nroute 2\n0 0\n0 nan\n").expect("our folder");
    let ran = crowdplay(&[&[&scene.pack(), "--headless", "--walk", &file][..], &SMALL].concat());
    assert_eq!(ran.code, 1);
    assert!(ran.stderr.contains("way.txt: line 4: found `nan`"), "{}", ran.stderr);
    for (line, words) in [
        ("0 0 0 0 1 Carla Sway 0", "found `Carla`, expected character, a whole number below 2, or one of Ada, Bruno"),
        ("0 0 NaN 0 1 Ada Sway 0", "found `NaN`, expected z"),
        ("place grid 0 0 0 0 1 1", "found nobody"),
    ] {
        std::fs::write(&file, format!("# crowd layout v1\n{line}\n")).expect("our folder");
        let ran = crowdplay(&[&[&scene.pack(), "--headless", "--layout", &file][..], &SMALL].concat());
        assert_eq!(ran.code, 1);
        assert!(ran.stderr.contains(words), "{}", ran.stderr);
    }
    std::fs::write(&file, "# crowd layout v1\n0 0 0 0 1 ada Sway 0\nplace seats 30 0 0 0 1 1\n").expect("our folder");
    assert_eq!(scene.report(&[&["--layout", &file][..], &SMALL].concat())["crowd"]["instances"], 31);
}

#[test]
fn a_moving_camera_is_recorded_and_played_again() {
    let scene = Scene::new();
    let words = ["--count", "30", "--size", "64x36", "--backend", "cpu", "--time", "1", "--frames", "3", "--dt", "2"];
    for name in ["orbit", "line", "walkthrough"] {
        let record = scene.path("flown.txt");
        let made = scene.picture(&[&words[..], &["--camera-path", name, "--record-camera", &record]].concat());
        assert!(made == scene.picture(&[&words[..], &["--camera-path", &record]].concat()), "{name}");
        assert!(made != scene.picture(&words), "{name}");
    }
    let out = scene.path("a.png");
    let ran = crowdplay(&[&scene.pack(), "--headless", "--out", &out, "--record-camera", &out]);
    assert_eq!(ran.code, 2, "{}", ran.stderr);
}

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1")]
#[test]
fn the_walkable_area_is_ground_and_walls_on_gpu_and_cpu() {
    let scene = Scene::new();
    let file = fixture("crossing.sqlite");
    // Before anybody but one has come, so that the picture is the area's.
    let words = |backend| ["--trajectories", &file, "--size", "192x108", "--time", "0", "--backend", backend];
    let (gpu, cpu) = (scene.picture(&words("gpu")), scene.picture(&words("cpu")));
    let far = |a: &image::Rgb<u8>, b: &image::Rgb<u8>| a.0.iter().zip(b.0).any(|(&x, y)| x.abs_diff(y) > 6);
    let differ = gpu.pixels().zip(cpu.pixels()).filter(|(a, b)| far(a, b)).count();
    assert!(differ < 192 * 108 / 50, "{differ} pixels differ");
    let bare = scene.path("bare.csv");
    std::fs::write(&bare, "id,time,x,y\n1,0,0,0\n1,1,1,0\n2,0,16,16\n").expect("our folder");
    // Ground and walls are of a warmer grey than the endless plane and the sky.
    let warm = |picture: &image::RgbImage| picture.pixels().filter(|p| p.0[0] > p.0[2].saturating_add(14)).count();
    let plain = scene.picture(&["--trajectories", &bare, "--size", "192x108", "--backend", "cpu"]);
    assert!(warm(&cpu) > 192 * 108 / 20, "{}", warm(&cpu));
    assert!(warm(&plain) < 192 * 108 / 50, "{}", warm(&plain));
}

fn sample(name: &str) -> Vec<u8> {
    let path = crowd_tests::folders::assets().join("trajectories").join(name);
    std::fs::read(Path::new(&path)).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
#[test]
fn what_jupedsim_wrote_is_read_row_by_row() {
    let ways = crowd_scene::Trajectories::read(&sample("jupedsim-crossing.sqlite"), None).expect("JuPedSim's own");
    assert_eq!((ways.person_count(), ways.stay_count()), (160, 160));
    assert!((ways.end_s() - 39.9).abs() < 1e-3);
    assert_eq!(ways.origin(), [15.0, 15.0]);
    let area = ways.area().expect("it has one");
    assert!((area.square_metres() - 324.0).abs() < 1e-6);
    let mut walkers = Vec::new();
    // Counted with SQLite itself.
    for (frame, count) in [(0, 160), (100, 158), (250, 99), (399, 20)] {
        ways.people_at(frame as f32 / 10.0, &mut walkers);
        assert_eq!(walkers.len(), count, "frame {frame}");
    }
    ways.people_at(12.0, &mut walkers);
    let one = walkers.iter().find(|walker| walker.id == 402).expect("present");
    assert!((one.position.x - (11.016_134 - 15.0)).abs() < 1e-4 && (one.position.z - (15.0 - 15.448_673)).abs() < 1e-4);
    let walking = walkers.iter().filter(|walker| walker.gait == crowd_scene::Gait::Walk).count();
    assert!(walking > 100, "{walking}");
    assert!(walkers.iter().all(|walker| walker.speed_m_s < 2.5));
}

#[cfg_attr(not(crowd_assets), ignore = "needs ../shared/assets or CROWD_ASSETS")]
#[test]
fn what_the_archive_has_is_read_row_by_row() {
    let ways = crowd_scene::Trajectories::read(&sample("juelich-bottleneck.txt"), None).expect("the archive's form");
    assert_eq!(ways.person_count(), 400);
    let mut walkers = Vec::new();
    for (frame, count) in [(0, 400), (50, 400), (100, 385), (199, 348)] {
        ways.people_at(frame as f32 / 5.0, &mut walkers);
        assert_eq!(walkers.len(), count, "frame {frame}");
    }
    assert!(ways.remarks().is_empty(), "{:?}", ways.remarks());
}
