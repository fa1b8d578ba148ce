//! Which frames count: `--frames`, `--clip-weight`, and what they are worth.

use crate::bench::{Bench, TUBE};
use crowd_lod::{FrameChoice, LodPoses, MeasuredError, measure_level, reform};
use crowd_tests::folders::fixtures;
use crowdbake::{BakedCharacter, bake_character, plan::PlanEntry};

const FLAT_SIDED: &str = "flat_sided_tube_should_lose_its_elbow_in_bind_pose_only.glb";

fn baked(fixture: &str, frames: FrameChoice) -> BakedCharacter {
    let entry = PlanEntry { frames, ..PlanEntry::of_file(&fixtures().join("good").join(fixture)) };
    bake_character(&entry, false, &|_, _| {}).expect("the fixture bakes")
}

/// Measures the largest level within `share` of the triangles over all frames of all clips.
fn error_at(baked: &BakedCharacter, share: f64) -> MeasuredError {
    let order = &baked.order;
    let full = f64::from(order.levels.last().expect("full detail").triangle_count);
    let within = |level: &&crowd_lod::Level| f64::from(level.triangle_count) <= share * full;
    let level = order.levels.iter().rfind(within).expect("the level is reached");
    let triangles = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
    let source = |i: &u32| *i as usize;
    let mesh = &baked.mesh;
    let positions: Vec<_> = order.vertex_source.iter().map(source).map(|v| mesh.positions[v]).collect();
    let joints: Vec<_> = order.vertex_source.iter().map(source).map(|v| mesh.joints[v]).collect();
    let weights: Vec<_> = order.vertex_source.iter().map(source).map(|v| mesh.weights[v]).collect();
    let palettes: Vec<_> = baked.animation.clips.iter().flat_map(|clip| clip.palettes.iter().copied()).collect();
    let frame_count = palettes.len() / baked.raw.joints.len();
    let frame_weights = vec![1.0 / frame_count as f32; frame_count];
    let poses = LodPoses { palettes: &palettes, joint_count: baked.raw.joints.len(), frame_weights: &frame_weights };
    measure_level(&positions, &joints, &weights, &order.triangles, &triangles, &poses, 2000)
}

/// Flat in bind pose, bent in its clip: whoever looks at the bind pose alone takes the elbow's rings away for nothing.
#[test]
fn a_straight_elbow_costs_a_bind_pose_bake_three_times_the_error() {
    let (ours, bind) = (baked(FLAT_SIDED, FrameChoice::Auto), baked(FLAT_SIDED, FrameChoice::Bind));
    for share in [0.5, 0.25] {
        let (ours, bind) = (error_at(&ours, share), error_at(&bind, share));
        assert!(ours.max_m <= 0.3 * bind.max_m, "at {share}: {ours:?} against {bind:?} from the bind pose");
        assert!(ours.rms_m <= 0.3 * bind.rms_m, "at {share}: {ours:?} against {bind:?} from the bind pose");
    }
}

#[test]
fn frames_are_chosen_checked_and_said() {
    let bench = Bench::with(&["zebra.glb"]);
    let run = |words: &[&str]| bench.run(&[&["bake", "@zebra.glb", "-o", "@out.crowdpack", "--json"], words].concat());
    let done = run(&[]).expect(0).says(&["frames stand for all: their mean error lies", "% off that of all frames"]);
    let frames = &done.json()["characters"][0]["frames"];
    let all = done.json()["characters"][0]["animation"]["frames"].as_u64().unwrap();
    assert_eq!(frames["choice"], "auto");
    assert!(frames["used"].as_u64().unwrap() < all, "{frames}");
    assert!(frames["holds"] == true && frames["deviation"].as_f64().unwrap() <= 0.03, "{frames}");
    let exact = run(&["--frames", "all"]).expect(0).json();
    assert_eq!(exact["characters"][0]["frames"]["used"], all);
    assert!(exact["characters"][0]["frames"]["holds"].is_null());
    let bind = run(&["--frames", "bind"]).expect(0).json();
    assert_eq!(
        (&bind["characters"][0]["frames"]["choice"], &bind["characters"][0]["frames"]["used"]),
        (&"bind".into(), &0.into())
    );
}

#[test]
fn clip_weights_change_the_order_and_a_weight_for_no_clip_is_refused() {
    let bench = Bench::with(&["mara.glb", TUBE]);
    let order = |words: &[&str]| {
        bench.run(&[&["bake", "@mara.glb", "-o", "@out.crowdpack"], words].concat()).expect(0);
        bench.read("out.crowdpack")
    };
    let even = order(&[]);
    assert!(order(&["--clip-weight", "*=2"]) == even, "twice as much for all is no change");
    assert!(order(&["--clip-weight", "run=50", "--clip-weight", "w*=0"]) != even);
    let words = ["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack", "--clip-weight"];
    bench.run(&[&words[..], &["Swim=2"]].concat()).expect(1).says(&["no clip of that name; the character has bend"]);
    bench.run(&[&words[..], &["bend=0"]].concat()).expect(1).says(&["all clips have the weight 0", "--clip-weight"]);
    bench.run(&[&words[..], &["bend=-1"]].concat()).expect(2).says(&["allowed a clip and a number from 0 to 1000"]);
    bench.run(&[&words[..], &["bend"]].concat()).expect(2).says(&["allowed CLIP=W"]);
}

#[test]
fn attribute_weights_change_the_order_and_an_unknown_attribute_is_refused() {
    let bench = Bench::with(&["mara.glb"]);
    let order = |words: &[&str]| {
        bench.run(&[&["bake", "@mara.glb", "-o", "@out.crowdpack"], words].concat()).expect(0);
        bench.read("out.crowdpack")
    };
    let even = order(&[]);
    assert!(order(&["--attribute-weight", "uv=1"]) == even, "the default said aloud is no change");
    for attribute in ["uv=20", "normal=0", "color=0", "layers=0"] {
        assert!(order(&["--attribute-weight", attribute]) != even, "{attribute}");
    }
    let words = ["bake", "@mara.glb", "-o", "@out.crowdpack", "--attribute-weight"];
    for wrong in ["weight=1", "uv", "uv=-1"] {
        bench.run(&[&words[..], &[wrong]].concat()).expect(2).says(&["allowed uv, normal, color or layers"]);
    }
}

#[test]
fn a_manifest_says_which_frames_count() {
    let bench = Bench::with(&["mara.glb"]);
    let words = [
        ["@mara.glb", "--frames", "bind"].as_slice(),
        &["--clip-weight", "run=3", "--clip-weight", "walk=0.5", "--attribute-weight", "normal=3"],
    ];
    let words = words.concat();
    let printed = bench.run(&[&["print-config"], &words[..]].concat()).expect(0).out;
    assert!(printed.contains("frames = \"bind\"") && printed.contains("\"run\" = 3.0"), "{printed}");
    bench.write("crowd.toml", printed);
    bench.run(&["bake", "@crowd.toml", "-o", "@a.crowdpack"]).expect(0);
    bench.run(&[&["bake", "-o", "@b.crowdpack"], &words[..]].concat()).expect(0);
    assert!(bench.read("a.crowdpack") == bench.read("b.crowdpack"));
}

#[test]
fn a_bake_and_inspect_say_the_same_of_how_animation_is_stored() {
    for layout in ["3x4", "4x4"] {
        let bench = Bench::with(&["zebra.glb"]);
        let words = ["bake", "@zebra.glb", "-o", "@out.crowdpack", "--json", "--animation-layout", layout];
        let said = bench.run(&[&words[..], &["--animation-error", "0.2"]].concat()).expect(0);
        let is_told = said.err.contains("animation_error says nothing");
        assert_eq!(is_told, layout == "4x4", "{}", said.err);
        let baked = said.json()["characters"][0]["animation"].clone();
        let seen = bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json();
        let seen = seen["characters"][0]["animation"].clone();
        for field in ["storage", "frames", "sampled_frames", "bytes", "papers_bytes", "vertex_texture_bytes", "error_m"]
        {
            assert!(!seen[field].is_null());
            assert_eq!(baked[field], seen[field], "{layout}: {field}");
        }
        assert_eq!(seen["storage"] == "4x4", layout == "4x4");
    }
}

#[test]
fn clips_are_sampled_at_the_rate_of_their_keys() {
    // Keyed every quarter of a second, 1.5 seconds long: of the rates that have frames there, 28 is next to 30.
    const HAT: &str = "rigid_hat_should_follow_the_head_joint.glb";
    let bench = Bench::with(&[HAT]);
    bench.write("crowd.toml", format!("[[characters]]\nsource = '{HAT}'\nfps = 'auto'\n"));
    for (words, frames, fps) in [
        (vec![format!("@{HAT}")], 43, None),
        (vec!["@crowd.toml".to_owned()], 43, None),
        (vec![format!("@{HAT}"), "--fps".to_owned(), "30".to_owned()], 46, Some(30.0)),
        (vec!["@crowd.toml".to_owned(), "--fps".to_owned(), "8".to_owned()], 13, Some(8.0)),
    ] {
        let words: Vec<&str> =
            ["bake", "-o", "@out.crowdpack", "--json"].into_iter().chain(words.iter().map(String::as_str)).collect();
        let report = bench.run(&words).expect(0).json()["characters"][0].clone();
        assert_eq!((report["animation"]["sampled_frames"].as_u64(), report["fps"].as_f64()), (Some(frames), fps));
        let between = report["animation"]["between_frames_m"].as_f64().unwrap();
        assert_eq!(between > 1e-3, fps.is_some(), "the corners of the curves lie on frames: {between}");
    }
    let text = bench.run(&["print-config", &format!("@{HAT}")]).expect(0).out;
    assert!(text.contains("fps = \"auto\""), "{text}");
}
