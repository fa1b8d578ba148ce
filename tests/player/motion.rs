//! People on their places who change what they do: graphs made and given, shown by the GPU as by the CPU, refused by line.

use crate::{Scene, crowdplay};
use crowd_tests::folders::fixtures;

const SMALL: [&str; 6] = ["--size", "160x90", "--layout", "ranks", "--count", "12"];

fn graph(scene: &Scene, name: &str, lines: &str) -> String {
    let path = scene.path(name);
    std::fs::write(&path, format!("# crowd motion graph v1\n{lines}")).expect("our folder");
    path
}

const TO_AND_FRO: &str = "state rest idle seconds 0.5 1\nstate sway SWAY seconds 0.5 1\n\
                          way rest sway 0.4\nway sway rest 0.4 in-step\n";

#[test]
fn any_time_looks_the_same_however_it_was_reached() {
    let scene = Scene::new();
    let file = graph(&scene, "graph.txt", TO_AND_FRO);
    let words = [&SMALL[..], &["--backend", "cpu", "--motion-graph", &file]].concat();
    let at = |more: &[&str]| scene.picture(&[&words[..], more].concat());
    let at_once = at(&["--time", "9"]);
    assert!(at_once == at(&["--time", "3", "--frames", "3", "--dt", "3"]));
    assert!(at_once != at(&["--time", "9", "--seed", "5"]));
    let off = [&SMALL[..], &["--backend", "cpu", "--time", "9"]].concat();
    assert!(at_once != scene.picture(&off));
    assert!(scene.picture(&[&off[..], &["--motion-graph", "off"]].concat()) == scene.picture(&off));
}

#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1")]
#[test]
fn the_gpu_shows_what_the_cpu_shows_and_says_what_it_took() {
    let scene = Scene::new();
    let file = graph(&scene, "graph.txt", TO_AND_FRO);
    for graph in ["auto", &file] {
        let words = [&SMALL[..], &["--motion-graph", graph, "--time", "7.3", "--dots", "0", "--no-morph"]].concat();
        let of = |backend| scene.picture(&[&words[..], &["--backend", backend]].concat());
        let (gpu, cpu) = (of("gpu"), of("cpu"));
        let apart = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 24);
        let share = gpu.pixels().zip(cpu.pixels()).filter(|pair| apart(*pair)).count() as f32 / (160.0 * 90.0);
        assert!(share < 0.02, "{graph}: {share} of the pixels differ");
        // The static floor is placed by the CPU.
        let floor = scene.picture(&[&words[..], &["--backend", "gpu", "--technique", "static-floor"]].concat());
        let share = gpu.pixels().zip(floor.pixels()).filter(|pair| apart(*pair)).count() as f32 / (160.0 * 90.0);
        assert!(share < 0.02, "{graph}: {share} of the pixels differ from the floor's");
    }
    let report = scene.report(&[&SMALL[..], &["--motion-graph", "auto", "--backend", "gpu"]].concat());
    let stages = report["frames"][0]["stages_ms"].as_object().expect("stages");
    assert!(stages.is_empty() || stages.contains_key("play_motion"), "{stages:?}");
}

#[test]
fn graphs_are_refused_by_line_and_clips_that_lack_are_named() {
    let scene = Scene::new();
    let refused = |lines: &str, code: u8, words: &[&str]| {
        let file = graph(&scene, "dance.txt", lines);
        let pack = scene.pack();
        let ran =
            crowdplay(&[&[&pack, "--headless", "--backend", "cpu", "--motion-graph", &file][..], &SMALL].concat());
        assert_eq!(ran.code, code, "{lines}: {}", ran.stderr);
        for word in words {
            assert!(ran.stderr.contains(word), "{lines}: {}", ran.stderr);
        }
    };
    refused("state a idle seconds 1 nan\n", 1, &["dance.txt: line 2: found `nan`"]);
    refused("state a idle seconds 1 2\nstate b sway seconds 1 2\nway a b 0.1\n", 1, &["line 3: found `b`"]);
    refused("state a waltz seconds 1 2\n", 1, &["found a clip of it in no character"]);
    let lacks = "state a idle seconds 1 2\nstate b waltz seconds 1 2\nway a b 0.1\nway b a 0.1\n";
    refused(lacks, 0, &["no clip called waltz of the motion graph"]);
    let pack = scene.pack();
    let feed = crowdplay(&[pack.as_str(), "--headless", "--walk", "--motion-graph", "auto"]);
    assert_eq!(feed.code, 2, "{}", feed.stderr);
}

#[test]
fn the_fixture_is_read() {
    let text = std::fs::read_to_string(fixtures().join("scenes/motion.txt")).expect("a fixture");
    let graph = crowd_scene::MotionGraph::parse(&text).expect("a good one");
    assert_eq!((graph.states().len(), graph.ways().len()), (3, 4));
}
