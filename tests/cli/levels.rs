//! Levels that a pack stores beside the continuous order: asked for, measured, exported, missed.

use crate::bench::{Bench, SPHERE, TUBE};
use crowd_source::{Limits, load_character};
use serde_json::Value;

/// Under Peng's criteria nothing of it can go.
const CUBE: &str = "cube_with_cuts_should_keep_8_fixed.glb";

/// Bakes the tube with some discrete levels.
fn baked(more: &[&str]) -> (Bench, String) {
    baked_of(TUBE, more)
}

/// Bakes a fixture with some discrete levels.
fn baked_of(fixture: &str, more: &[&str]) -> (Bench, String) {
    let bench = Bench::with(&[fixture]);
    let input = format!("@{fixture}");
    let words = ["bake", &input, "-o", "@out.crowdpack", "--lod-ratio", "50%,0.25", "--error", "0.5%", "--px", "1@120"];
    let said = bench.run(&[&words[..], more].concat()).expect(0).err;
    (bench, said)
}

fn number(level: &Value, key: &str) -> f64 {
    level[key].as_f64().unwrap_or_else(|| panic!("no {key} in {level}"))
}

#[test]
fn discrete_levels_are_named_finest_first_and_measured() {
    let (bench, said) = baked(&[]);
    for word in
        ["lod1 (", "50% of the triangles", "within 0.5% of the height", "within 1 px RMS at 120 px", ": reached"]
    {
        assert!(said.contains(word), "no {word} in:\n{said}");
    }
    let character = &bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json()["characters"][0];
    let discrete = character["discrete"].as_array().unwrap();
    assert_eq!(discrete.len(), 4);
    for (index, level) in discrete.iter().enumerate() {
        assert_eq!(level["name"], format!("lod{}", index + 1));
        assert_eq!(level["reached"], true);
        assert!(number(level, "rms_m") <= number(level, "max_m") && number(level, "max_m") <= number(level, "bound_m"));
    }
    assert!(discrete.windows(2).all(|pair| number(&pair[0], "triangles") >= number(&pair[1], "triangles")));
    let height = number(character, "height_m");
    for level in discrete {
        let target = level["target"].as_str().unwrap();
        let (bound, pixels) = (number(level, "bound_m"), number(level, "bound_px"));
        assert!(!target.contains("of the height") || bound <= 0.005 * height, "{level}");
        assert!(!target.contains("px RMS at 120") || number(level, "rms_m") <= height / 120.0, "{level}");
        assert!((pixels - bound / height * 720.0).abs() < 1e-3 * pixels + 1e-6, "{level}");
    }
    let table = bench.run(&["inspect", "@out.crowdpack"]).expect(0).out;
    assert!(table.contains("lod2") && table.contains("4 discrete"), "{table}");
}

#[test]
fn the_coarsest_level_within_a_distance_lies_between_quantised_ones() {
    let bench = Bench::with(&["mara.glb"]);
    let asked = ["--error", "1mm,3mm,9mm,3mm:rms", "--px", "1@300,1@300:max"];
    bench.run(&[&["bake", "@mara.glb", "-o", "@out.crowdpack"], &asked[..]].concat()).expect(0);
    let character = &bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json()["characters"][0];
    let height = number(character, "height_m");
    let limits = [
        ("every point within 1mm", "bound_m", 0.001),
        ("every point within 3mm", "bound_m", 0.003),
        ("every point within 9mm", "bound_m", 0.009),
        ("within 3mm RMS", "rms_m", 0.003),
        ("within 1 px RMS at 300 px", "rms_m", height / 300.0),
        ("every point within 1 px at 300 px", "bound_m", height / 300.0),
    ];
    let quantised = character["measured"].as_array().unwrap();
    let discrete = character["discrete"].as_array().unwrap();
    assert!(discrete.len() >= 5, "{discrete:?}");
    let is_between = |level: &serde_json::Value| quantised.iter().all(|other| other["triangles"] != level["triangles"]);
    assert!(discrete.iter().any(is_between), "{discrete:?}");
    for level in discrete {
        let (_, figure, most) = limits.iter().find(|(words, ..)| level["target"] == *words).unwrap();
        assert!(number(level, figure) <= *most, "{level}");
        // The next coarser quantised level but those that measure better than a finer one exceeds it.
        let finest =
            quantised.iter().filter(|other| number(other, figure) > *most).map(|other| number(other, "triangles"));
        let exceeding = finest.fold(0.0, f64::max);
        let kept = quantised.iter().map(|other| number(other, "triangles")).filter(|&triangles| triangles > exceeding);
        let coarsest_kept = kept.fold(f64::INFINITY, f64::min);
        let triangles = number(level, "triangles");
        assert!(exceeding < triangles && triangles <= coarsest_kept, "{level}: {exceeding}, {coarsest_kept}");
    }
    bench.run(&["verify", "@out.crowdpack"]).expect(0);
}

#[test]
fn levels_that_come_out_equal_are_stored_once_and_named() {
    let bench = Bench::with(&[TUBE]);
    let input = format!("@{TUBE}");
    let words = ["bake", &input, "-o", "@out.crowdpack", "--lod-ratio", "50%,0.5", "--error", "0.00001mm,100%"];
    bench.run(&[&words[..], &["--report", "@bake.json"]].concat()).expect(0).says(&[
        "level-repeated: 50%: the level `50% of the triangles` comes out as lod1 (50% of the triangles)",
        "no level of the order is `every point within 0.00001mm` but full detail",
    ]);
    let character = &bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json()["characters"][0];
    assert_eq!(character["discrete"].as_array().unwrap().len(), 2);
    let report: Value = serde_json::from_slice(&bench.read("bake.json")).unwrap();
    let warnings = report["characters"][0]["warnings"].as_array().unwrap();
    assert_eq!(warnings.iter().filter(|warning| warning["code"] == "level-repeated").count(), 2);
    let strict = [&words[..3], &["@strict.crowdpack", "--lod-ratio", "50%,0.5", "--strict"]].concat();
    bench.run(&strict).expect(1).says(&["1 warning with --strict", "level-repeated"]);
    assert!(!bench.path("strict.crowdpack").exists());
}

/// A level says the same of itself in the bake's report, in `inspect` and, for a share, in `explain`.
#[test]
fn a_level_has_one_record_everywhere() {
    let bench = Bench::with(&["mara.glb"]);
    let words = ["bake", "@mara.glb", "-o", "@out.crowdpack", "--lod-ratio", "30%", "--report", "@bake.json"];
    bench.run(&words).expect(0);
    let report: Value = serde_json::from_slice(&bench.read("bake.json")).unwrap();
    let report = &report["characters"][0];
    let inspected = &bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json()["characters"][0];
    assert_eq!(report["measured"], inspected["measured"]);
    assert_eq!(report["discrete"], inspected["discrete"]);
    let explain = ["explain", "@out.crowdpack", "--ratio", "30%,17%", "--json"];
    let explained = bench.run(&explain).expect(0).json();
    let targets = explained["characters"][0]["targets"].as_array().unwrap();
    for (key, value) in targets[0]["measured"].as_object().unwrap() {
        assert_eq!(*value, inspected["discrete"][0][key], "{key}");
    }
    assert_eq!(explained["characters"][0]["stored"], inspected["discrete"]);
    let text = bench.run(&["explain", "@out.crowdpack", "--ratio", "5%"]).expect(0).out;
    assert!(text.contains("stored        lod1 (30% of the triangles)"), "{text}");
    // Fingers of mara lie further off at rest than in any frame.
    assert!(text.contains("mm (at rest)"), "{text}");
    // One that the pack does not store is measured: as a bake that stores it does.
    let again = ["bake", "@mara.glb", "-o", "@again.crowdpack", "--lod-ratio", "17%"];
    bench.run(&again).expect(0);
    let stored =
        &bench.run(&["inspect", "@again.crowdpack", "--json"]).expect(0).json()["characters"][0]["discrete"][0];
    for (key, value) in targets[1]["measured"].as_object().unwrap() {
        assert_eq!(*value, stored[key], "{key}");
    }
}

#[test]
fn quantised_levels_lie_between_the_coarsest_and_full_detail() {
    let (bench, _) = baked(&[]);
    let character = &bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json()["characters"][0];
    let levels = character["measured"].as_array().unwrap();
    assert!((40..=64).contains(&levels.len()), "{}", levels.len());
    let (first, last) = (&levels[0], &levels[levels.len() - 1]);
    assert_eq!(first["triangles"], character["coarsest_triangles"]);
    assert_eq!(last["triangles"], character["triangles"]);
    assert_eq!(number(last, "bound_m"), 0.0);
    for pair in levels.windows(2) {
        assert!(number(&pair[0], "triangles") < number(&pair[1], "triangles"));
        assert!(
            number(&pair[0], "bound_m") >= number(&pair[1], "bound_m"),
            "a bound of a finer level holds for it alone"
        );
    }
}

#[test]
fn stored_levels_are_exported_by_name() {
    let (bench, _) = baked(&[]);
    bench.run(&["export", "@out.crowdpack", "--lod", "all", "-o", "@t.glb"]).expect(0);
    bench.run(&["export", "@out.crowdpack", "--lod", "lod2", "-o", "@two.glb"]).expect(0);
    let character = &bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json()["characters"][0];
    for (index, level) in character["discrete"].as_array().unwrap().iter().enumerate() {
        let raw = load_character(&bench.path(&format!("t.lod{}.glb", index + 1)), &Limits::default()).unwrap();
        assert_eq!(raw.mesh.triangles.len() as f64, number(level, "triangles"));
    }
    assert_eq!(bench.read("two.glb"), bench.read("t.lod2.glb"));
    let words = ["export", "@out.crowdpack", "--lod", "near", "-o", "@no.glb"];
    bench.run(&words).expect(1).says(&["level `near`", "lod1, lod2, lod3, lod4"]);
    assert!(!bench.path("no.glb").exists());
}

#[test]
fn refitted_levels_are_stored_verified_and_exported() {
    let (bench, said) = baked_of("mara.glb", &["--refit"]);
    assert!(said.contains(", refitted"), "{said}");
    bench.run(&["verify", "@out.crowdpack"]).expect(0);
    let (plain, _) = baked_of("mara.glb", &[]);
    let of =
        |bench: &Bench| bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json()["characters"][0].clone();
    let (refitted, plain_levels) = (of(&bench), of(&plain));
    let height = number(&refitted, "height_m");
    for moved in refitted["discrete"].as_array().unwrap() {
        let target = moved["target"].as_str().unwrap();
        let kept = plain_levels["discrete"].as_array().unwrap().iter().find(|kept| kept["target"] == target).unwrap();
        if target.contains("of the triangles") {
            assert_eq!(moved["triangles"], kept["triangles"]);
            assert!(number(moved, "rms_m") <= number(kept, "rms_m"), "{moved} {kept}");
        } else {
            // By distance: coarser where the refit allows, and never over the limit.
            assert!(number(moved, "triangles") <= number(kept, "triangles"), "{moved} {kept}");
            let (figure, most) =
                if target.contains("px RMS") { ("rms_m", height / 120.0) } else { ("bound_m", 0.005 * height) };
            assert!(number(moved, figure) <= most, "{moved}");
        }
    }
    let pixels = |levels: &Value| {
        let of = |level: &&Value| level["target"] == "within 1 px RMS at 120 px";
        number(levels["discrete"].as_array().unwrap().iter().find(of).unwrap(), "triangles")
    };
    assert!(pixels(&refitted) < 0.95 * pixels(&plain_levels), "{} {}", pixels(&refitted), pixels(&plain_levels));
    // From a pack without refitted levels, on the way out: the same places, for the textures weigh alike from asset and pack.
    let quarter =
        refitted["discrete"].as_array().unwrap().iter().find(|level| level["target"] == "25% of the triangles");
    let stored = quarter.unwrap()["name"].as_str().unwrap();
    bench.run(&["export", "@out.crowdpack", "--lod", stored, "-o", "@stored.glb"]).expect(0);
    plain.run(&["export", "@out.crowdpack", "--ratio", "0.25", "--refit", "-o", "@moved.glb"]).expect(0);
    plain.run(&["export", "@out.crowdpack", "--ratio", "0.25", "-o", "@kept.glb"]).expect(0);
    let places = |bench: &Bench, file: &str| {
        let mesh = load_character(&bench.path(file), &Limits::default()).unwrap().mesh;
        let mut places: Vec<_> = mesh.positions.iter().map(|place| place.map(f32::to_bits)).collect();
        places.sort_unstable();
        places
    };
    let (stored, moved) = (places(&bench, "stored.glb"), places(&plain, "moved.glb"));
    assert_ne!(moved, places(&plain, "kept.glb"));
    assert!(
        stored == moved,
        "{} places of {} differ",
        stored.iter().zip(&moved).filter(|(a, b)| a != b).count(),
        stored.len()
    );
}

/// A wavy cloth of small patches in nine plain colours.
fn patchwork(bench: &Bench) {
    let (side, colors) = (41, 9);
    let mut text = "mtllib patchwork.mtl\n".to_owned();
    for (row, column) in (0..side * side).map(|i| (i / side, i % side)) {
        let (x, y) = (column as f32 / side as f32, row as f32 / side as f32);
        text += &format!("v {x} {y} {}\n", 0.1 * libm::sinf(9.0 * x) * libm::cosf(7.0 * y));
    }
    for (row, column) in (0..(side - 1) * (side - 1)).map(|i| (i / (side - 1), i % (side - 1))) {
        let a = row * side + column + 1;
        let color = (row / 3 * 5 + column / 4 * 7) % colors;
        text += &format!("usemtl plain{color}\ns 1\nf {a} {} {} {}\n", a + 1, a + 1 + side, a + side);
    }
    bench.write("patchwork.obj", text);
    let tone = |i: usize| ["0.05", "0.5", "1"][i % 3];
    let color = |i: usize| format!("newmtl plain{i}\nKd {} {} {}\n", tone(i), tone(i / 3), tone(i * 5 / 3));
    bench.write("patchwork.mtl", (0..colors).map(color).collect::<String>());
}

#[test]
fn repainted_levels_are_stored_verified_and_exported() {
    let (bench, plain) = (Bench::new(), Bench::new());
    let words = ["bake", "@patchwork.obj", "-o", "@out.crowdpack", "--lod-ratio", "95%,8%,3%"];
    for (bench, more) in [(&bench, &["--refit"][..]), (&plain, &[])] {
        patchwork(bench);
        bench.run(&[&words[..], more].concat()).expect(0);
        bench.run(&["verify", "@out.crowdpack"]).expect(0);
        bench.run(&["export", "@out.crowdpack", "--lod", "all", "-o", "@t.glb"]).expect(0);
    }
    // How many triangles have each material.
    let counts = |bench: &Bench, file: &str| {
        let mut counts = std::collections::BTreeMap::new();
        let raw = load_character(&bench.path(file), &Limits::default()).unwrap();
        for part in &raw.mesh.parts {
            *counts.entry(raw.materials[part.material as usize].name.clone()).or_insert(0) += part.triangle_count;
        }
        counts
    };
    let (painted, kept) = (counts(&bench, "t.lod3.glb"), counts(&plain, "t.lod3.glb"));
    assert_eq!(painted.values().sum::<u32>(), kept.values().sum::<u32>());
    assert_ne!(painted, kept, "some triangle got another color");
    bench.run(&["report", "@out.crowdpack", "-o", "@page.html"]).expect(0);
}

#[test]
fn a_share_that_is_not_reached_is_said_and_refused_when_strict() {
    let bench = Bench::with(&[CUBE, SPHERE]);
    let words = ["bake", &format!("@{CUBE}"), "-o", "@out.crowdpack", "--criteria", "peng2011", "--lod-ratio", "0.05"];
    bench.run(&words).expect(0).says(&[
        "lod1 (5% of the triangles)",
        "not reached",
        "positions that cannot move",
        "they are: ",
        " at joint ",
    ]);
    bench.run(&["export", "@out.crowdpack", "--lod", "lod1", "-o", "@a.glb"]).expect(0).says(&["target missed"]);
    bench.run(&["export", "@out.crowdpack", "--lod", "lod1", "--strict", "-o", "@b.glb"]).expect(5);
    assert!(!bench.path("b.glb").exists());
    let strict =
        [&words[..3], &["@strict.crowdpack", "--criteria", "peng2011", "--lod-ratio", "0.05", "--strict"]].concat();
    bench.run(&strict).expect(5).says(&["levels: target missed", "the coarsest level has 12", "they are: "]);
    assert!(!bench.path("strict.crowdpack").exists());
    // The others of a batch are written all the same.
    let both = [
        "bake",
        &format!("@{SPHERE}"),
        &format!("@{CUBE}"),
        "-o",
        "@both.crowdpack",
        "--criteria",
        "peng2011",
        "--lod-ratio",
        "0.05",
        "--strict",
    ];
    bench.run(&both).expect(5);
    let names = bench.run(&["inspect", "@both.crowdpack", "--json"]).expect(0).json();
    assert_eq!(names["characters"].as_array().unwrap().len(), 1);
}

#[test]
fn manifests_ask_for_levels_too_and_too_many_are_refused() {
    let bench = Bench::with(&[SPHERE]);
    let text = format!("[defaults]\nlod_ratio = [0.5, '10%']\nrefit = true\n[[characters]]\nsource = '{SPHERE}'\n");
    bench.write("crowd.toml", text.into_bytes());
    bench.run(&["bake", "@crowd.toml", "-o", "@out.crowdpack"]).expect(0).says(&["lod2 (10% of the triangles)"]);
    let config = bench.run(&["print-config", "@crowd.toml"]).expect(0).out;
    assert!(config.contains("lod_ratio = [\"50%\", \"10%\"]") && config.contains("refit = true"), "{config}");
    let many = vec!["50%"; 33].join(",");
    let words = ["bake", "@crowd.toml", "-o", "@many.crowdpack", "--lod-ratio", &many];
    bench.run(&words).expect(1).says(&["discrete levels: found 33, allowed 32"]);
    bench.run(&["bake", "@crowd.toml", "-o", "@x.crowdpack", "--error", "5 feet"]).expect(2).says(&["as in 0.5%"]);
}
