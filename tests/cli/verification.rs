//! `verify` believes nothing: each of its checks has a pack that must fail it.

use crate::bench::{Bench, Done, TUBE};
use crowd_pack::{CharacterRecord, Pack, PackContents};

/// Bakes the tube, breaks one promise in a way that still opens, verifies.
fn break_and_verify(break_it: impl FnOnce(&mut PackContents)) -> Done {
    let bench = Bench::with(&[TUBE]);
    bench.run(&["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack"]).expect(0);
    let mut contents = Pack::open(&bench.path("out.crowdpack")).unwrap().contents().clone();
    break_it(&mut contents);
    contents.write(&bench.path("out.crowdpack")).expect("the broken pack still opens");
    bench.run(&["verify", "@out.crowdpack"])
}

#[track_caller]
fn fails(done: Done, check: &str) {
    fails_all(done, &[check]);
}

#[track_caller]
fn fails_all(done: Done, checks: &[&str]) {
    let done = done.expect(4).says(&["checks failed"]);
    let failed: Vec<&str> = done.out.lines().filter(|line| line.starts_with("FAILED")).collect();
    for check in checks {
        assert!(failed.iter().any(|line| line.contains(check)), "{check} is not among {failed:#?}");
    }
}

#[test]
fn a_pack_as_baked_keeps_its_promises_in_both_layouts() {
    let bench = Bench::with(&[TUBE, "zebra.glb"]);
    for layout in ["3x4", "4x4"] {
        bench.run(&["bake", "@.", "-o", "@out.crowdpack", "--animation-layout", layout]).expect(0);
        let verification = bench.run(&["verify", "@out.crowdpack", "--json"]).expect(0).json();
        assert_eq!(verification["schema_version"], 2);
        assert_eq!(verification["passed"], true);
        assert_eq!(verification["checks"].as_array().unwrap().len(), 2 + 2 * 6);
    }
}

#[test]
fn impostors_are_baked_alike_on_any_number_of_threads_and_shown_and_checked() {
    let bench = Bench::with(&[TUBE]);
    let asset = format!("@{TUBE}");
    let bake = |words: &[&str]| {
        bench.run(&[&["bake", &asset, "-o", "@out.crowdpack"], words].concat()).expect(0);
        bench.read("out.crowdpack")
    };
    // The fixture's roughness makes it a pack of version 5 whatever it holds; without that the impostors alone decide.
    let version = |name: &str| {
        let mut contents = Pack::open(&bench.path(name)).unwrap().contents().clone();
        (contents.finishes, contents.finish_images, contents.finish_bytes) = Default::default();
        contents.to_bytes().unwrap()[8]
    };
    let plain = bake(&[]);
    assert_eq!(
        (version("out.crowdpack"), bake(&["--impostors", "0"]) == plain),
        (3, true),
        "a pack without stays as it was"
    );
    let one = bake(&["--impostors", "8", "--jobs", "1"]);
    assert!(version("out.crowdpack") == 4 && bake(&["--impostors", "8", "--jobs", "4"]) == one);
    let inspection = bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json();
    assert_eq!(inspection["characters"][0]["impostors"]["tile_px"], 8);
    assert!(
        bench.run(&["inspect", "@out.crowdpack"]).expect(0).out.contains("  impostors     8 texels, 16 directions")
    );
    bench.run(&["verify", "@out.crowdpack"]).expect(0);
    bench.write("crowd.toml", format!("[pack]\nimpostors = 8\n[[characters]]\nsource = \"{TUBE}\"\n").as_bytes());
    bench.run(&["bake", "@crowd.toml", "-o", "@toml.crowdpack"]).expect(0);
    assert_eq!(version("toml.crowdpack"), 4);
    bench.write("crowd.toml", format!("[pack]\nimpostors = 9\n[[characters]]\nsource = \"{TUBE}\"\n").as_bytes());
    bench.run(&["bake", "@crowd.toml", "-o", "@toml.crowdpack"]).expect(1).says(&["pack.impostors", "found 9"]);
    bench.run(&["bake", &asset, "-o", "@out.crowdpack", "--impostors", "12"]).expect(2).says(&["found 12, allowed 8"]);
}

#[test]
fn impostors_of_another_size_are_found() {
    let bench = Bench::with(&[TUBE]);
    bench.run(&["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack", "--impostors", "8"]).expect(0);
    let mut contents = Pack::open(&bench.path("out.crowdpack")).unwrap().contents().clone();
    contents.impostors[0].azimuth_count = 4;
    contents.write(&bench.path("out.crowdpack")).expect("the broken pack still opens");
    fails(bench.run(&["verify", "@out.crowdpack"]), "impostors-decode");
}

#[test]
fn more_levels_than_there_are_mean_all_of_them() {
    let bench = Bench::with(&[TUBE]);
    bench.run(&["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack"]).expect(0);
    let all = bench.run(&["verify", "@out.crowdpack", "--levels", "100000"]).expect(0).out;
    let more = bench.run(&["verify", "@out.crowdpack", "--levels", "4294967295"]).expect(0).out;
    assert_eq!(all, more);
}

#[test]
fn an_untouched_copy_passes() {
    break_and_verify(|_| {}).expect(0);
}

#[test]
fn a_flipped_byte_is_found() {
    let bench = Bench::with(&[TUBE]);
    bench.run(&["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack"]).expect(0);
    let mut bytes = bench.read("out.crowdpack");
    // The first byte of the vertices, the third section of the table.
    let entry = 64 + 2 * 40 + 16;
    let vertices = u64::from_le_bytes(bytes[entry..entry + 8].try_into().unwrap()) as usize;
    bytes[vertices] ^= 1;
    bench.write("out.crowdpack", bytes);
    fails(bench.run(&["verify", "@out.crowdpack"]), "file-is-whole");
    bench.run(&["inspect", "@out.crowdpack"]).expect(1).says(&["damaged"]);
    bench.run(&["verify", "@gone.crowdpack"]).expect(1).says(&["gone.crowdpack"]);
}

#[test]
fn a_sphere_that_is_too_small_is_found() {
    fails(break_and_verify(|pack| pack.clips[0].sphere[3] *= 0.99), "bounds-hold-every-frame");
    fails(break_and_verify(|pack| pack.characters[0].box_max[1] -= 0.01), "bounds-hold-every-frame");
}

/// What is drawn of a level must be inside, too, where it has vertices of its own: refitting moves them out of full detail's surface.
#[test]
fn a_refitted_level_that_sticks_out_is_found() {
    let bench = Bench::with(&["mara.glb"]);
    let words = ["bake", "@mara.glb", "-o", "@out.crowdpack", "--lod-ratio", "5%,2%", "--refit", "--clips", "run"];
    bench.run(&words).expect(0);
    bench.run(&["verify", "@out.crowdpack"]).expect(0);
    let contents = Pack::open(&bench.path("out.crowdpack")).unwrap().contents().clone();
    // Of full detail alone the box is smaller.
    bench.run(&["bake", "@mara.glb", "-o", "@plain.crowdpack", "--clips", "run"]).expect(0);
    let plain = Pack::open(&bench.path("plain.crowdpack")).unwrap().contents().clone();
    let mut broken = contents;
    broken.characters[0] = CharacterRecord {
        box_min: plain.characters[0].box_min,
        box_max: plain.characters[0].box_max,
        ..broken.characters[0]
    };
    broken.write(&bench.path("broken.crowdpack")).expect("the broken pack still opens");
    let said = bench.run(&["verify", "@broken.crowdpack"]);
    assert!(said.out.contains("(of a refitted level)"), "{}", said.out);
    fails(said, "bounds-hold-every-frame");
}

#[test]
fn an_error_that_was_made_smaller_is_found() {
    let fake = |pack: &mut PackContents| pack.manifest.characters[0].measured[0].max_m *= 0.8;
    fails(break_and_verify(fake), "errors-measure-again");
}

/// Distances between such places are no numbers any more, and a search among them would look at everything.
#[test]
fn a_pose_too_far_off_to_be_measured_is_refused() {
    let far = |pack: &mut PackContents| pack.vertices.iter_mut().for_each(|v| v.position[0] *= 1.0e30);
    fails(break_and_verify(far), "errors-measure-again");
}

#[test]
fn an_error_of_a_refitted_level_that_was_made_smaller_or_larger_is_found() {
    let bench = Bench::with(&[TUBE]);
    bench.run(&["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack", "--lod-ratio", "30%", "--refit"]).expect(0);
    bench.run(&["verify", "@out.crowdpack"]).expect(0);
    let contents = Pack::open(&bench.path("out.crowdpack")).unwrap().contents().clone();
    for factor in [0.8, 1.2] {
        let mut broken = contents.clone();
        let level = &mut broken.manifest.characters[0].discrete[0].measured;
        level.max_m *= factor;
        level.max_frame = 0;
        broken.write(&bench.path("broken.crowdpack")).expect("the broken pack still opens");
        fails(bench.run(&["verify", "@broken.crowdpack"]), "errors-measure-again");
    }
}

#[test]
fn bounds_made_smaller_are_found() {
    let fake = |pack: &mut PackContents| {
        pack.levels.iter_mut().for_each(|level| level.bound_m *= 0.5);
        pack.manifest.characters[0].measured.iter_mut().for_each(|level| level.bound_m *= 0.5);
    };
    fails(break_and_verify(fake), "errors-measure-again");
}

#[test]
fn a_table_with_other_triangles_is_found() {
    // Turned over.
    fails(break_and_verify(|pack| pack.indices_16.swap(0, 1)), "tables-hold-the-levels");
    // Twice the same.
    let repeat = |pack: &mut PackContents| pack.indices_16.copy_within(0..3, 3);
    fails(break_and_verify(repeat), "tables-hold-the-levels");
    // Turned around and moved to the end of its level is no other triangle.
    let count = |pack: &PackContents| pack.levels[0].triangle_count as usize * 3;
    let turn = |pack: &mut PackContents| {
        let end = count(pack);
        pack.indices_16[..end].rotate_left(4);
        pack.indices_16[..end].rotate_left(2);
    };
    break_and_verify(turn).expect(0);
}

#[test]
fn a_collapse_to_the_wrong_place_is_found() {
    // All that collapsed goes to vertex 0: triangles fold up, companions part.
    let fold = |pack: &mut PackContents| {
        let kept = pack.characters[0].min_vertex_count as usize;
        pack.collapse_map[kept..].fill(0);
    };
    fails(break_and_verify(fold), "levels-are-meshes");
}

#[test]
fn companions_that_part_tear_the_seam_open_and_are_found() {
    let part = |pack: &mut PackContents| {
        // The last companion goes where its partner does not.
        let last = pack.vertices.iter().rposition(|vertex| vertex.class() == 1).expect("the tube has a seam");
        let target = pack.collapse_map[last];
        pack.collapse_map[last] = if target == 0 { 1 } else { 0 };
    };
    fails_all(break_and_verify(part), &["companions-stay-together", "no-new-open-edges"]);
}

#[test]
fn an_image_that_does_not_decode_is_found() {
    let spoil = |pack: &mut PackContents| {
        let image = pack.images[0];
        let start = image.byte_offset as usize;
        pack.image_bytes[start..start + image.byte_count as usize].fill(7);
    };
    fails(break_and_verify(spoil), "images-decode");
}
