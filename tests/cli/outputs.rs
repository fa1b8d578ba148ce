//! Files left behind: whole or not at all, and never over an input.

use crate::bench::{Bench, TRIANGLE};

#[test]
fn an_output_that_is_an_input_is_refused_and_the_input_stays() {
    let bench = Bench::with(&[TRIANGLE]);
    let before = bench.read(TRIANGLE);
    let input = format!("@{TRIANGLE}");
    bench.run(&["bake", &input, "-o", &input]).expect(2).says(&["is an input too"]);
    let same = format!("@./{TRIANGLE}");
    bench.run(&["bake", &input, "-o", "@out.crowdpack", "--report", &same]).expect(2);
    bench.run(&["export", &input, "--ratio", "1", "-o", &input]).expect(2);
    bench.run(&["picture", &input, "-o", &input]).expect(2);
    bench.run(&["survey", &input, "-o", &input]).expect(2);
    assert!(bench.read(TRIANGLE) == before);
    assert_eq!(bench.listing(), [TRIANGLE]);
}

#[test]
fn a_pack_that_cannot_be_written_ends_with_3_before_any_work() {
    let bench = Bench::with(&[TRIANGLE]);
    let input = format!("@{TRIANGLE}");
    // A file where a folder is needed: no user may write below it, not even root.
    let below_a_file = format!("@{TRIANGLE}/out.crowdpack");
    let done = bench.run(&["bake", &input, "-o", &below_a_file]).expect(3);
    assert!(!done.err.contains("triangles down to"), "{}", done.err);
    done.says(&["is a file, a folder is needed"]);
    std::fs::create_dir(bench.path("folder")).unwrap();
    bench.run(&["bake", &input, "-o", "@folder"]).expect(3).says(&["is a folder"]);
    assert_eq!(bench.listing(), ["folder", TRIANGLE]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_files_ends_with_3() {
    let bench = Bench::with(&[TRIANGLE]);
    bench.run(&["bake", &format!("@{TRIANGLE}"), "-o", "/proc/out.crowdpack"]).expect(3).says(&["/proc/out.crowdpack"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_pack_larger_than_the_shell_allows_ends_with_3_and_leaves_nothing() {
    let bench = Bench::with(&[TRIANGLE]);
    let bake = bench.program(&["bake", &format!("@{TRIANGLE}"), "-o", "@out.crowdpack"]);
    // Two blocks of 512 bytes, or of 1,024: no pack is so small.
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", "ulimit -f 2; exec \"$0\" \"$@\""]).arg(bake.get_program()).args(bake.get_args());
    let output = shell.output().expect("a shell is there");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("ulimit -f"), "{said}");
    assert_eq!(bench.listing(), [TRIANGLE]);
}

#[test]
fn missing_folders_are_made_and_nothing_else_is_left() {
    let bench = Bench::with(&[TRIANGLE]);
    bench.run(&["bake", &format!("@{TRIANGLE}"), "-o", "@new/deep/out.crowdpack"]).expect(0);
    assert_eq!(bench.listing(), ["new", TRIANGLE]);
    assert_eq!(crate::bench::listing(&bench.path("new/deep")), ["out.crowdpack"]);
}

#[test]
fn quiet_says_nothing_and_the_pack_is_the_same() {
    let bench = Bench::with(&[TRIANGLE]);
    let input = format!("@{TRIANGLE}");
    let quiet = bench.run(&["-q", "bake", &input, "-o", "@a.crowdpack"]).expect(0);
    assert!(quiet.err.is_empty() && quiet.out.is_empty());
    let loud = bench.run(&["bake", "-v", &input, "-o", "@b.crowdpack"]).expect(0);
    loud.says(&["simplify", "1 triangles down to 1"]);
    assert!(bench.read("a.crowdpack") == bench.read("b.crowdpack"));
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_stay_links() {
    let bench = Bench::with(&[TRIANGLE]);
    let input = format!("@{TRIANGLE}");
    for (link, real) in [("l.crowdpack", "r.crowdpack"), ("l.json", "r.json"), ("l.glb", "r.glb"), ("l.png", "r.png")] {
        bench.write(real, b"old");
        std::os::unix::fs::symlink(bench.path(real), bench.path(link)).unwrap();
    }
    bench.run(&["bake", &input, "-o", "@l.crowdpack", "--report", "@l.json"]).expect(0);
    bench.run(&["export", &input, "--ratio", "1", "-o", "@l.glb"]).expect(0);
    bench.run(&["picture", &input, "--size", "32x32", "-o", "@l.png"]).expect(0);
    for (link, real) in [("l.crowdpack", "r.crowdpack"), ("l.json", "r.json"), ("l.glb", "r.glb"), ("l.png", "r.png")] {
        assert!(bench.path(link).is_symlink(), "{link} was replaced");
        assert!(bench.read(real) != b"old", "{real} was not written");
    }
    assert_eq!(bench.listing().len(), 9, "nothing else is left: {:?}", bench.listing());
}

#[cfg(unix)]
#[test]
fn pipes_are_written_to_and_stay_pipes() {
    use std::os::unix::fs::FileTypeExt;
    let bench = Bench::with(&[TRIANGLE]);
    let input = format!("@{TRIANGLE}");
    let words: [&[&str]; 4] = [
        &["bake", &input, "-o", "@pipe"],
        &["bake", &input, "-o", "@out.crowdpack", "--report", "@pipe"],
        &["export", &input, "--ratio", "1", "-o", "@pipe"],
        &["picture", &input, "--size", "32x32", "-o", "@pipe"],
    ];
    let made = std::process::Command::new("mkfifo").arg(bench.path("pipe")).status().expect("coreutils are there");
    assert!(made.success());
    for (words, begins) in words.iter().zip([&crowd_pack::MAGIC[..], b"{", b"glTF", b"\x89PNG"]) {
        // Opened for reading and writing, a pipe waits for nobody; what is written fits into it.
        let mut pipe = std::fs::File::options().read(true).write(true).open(bench.path("pipe")).unwrap();
        bench.run(words).expect(0);
        let is_pipe = std::fs::symlink_metadata(bench.path("pipe")).unwrap().file_type().is_fifo();
        assert!(is_pipe, "{words:?} replaced the pipe");
        let mut start = vec![0; begins.len()];
        std::io::Read::read_exact(&mut pipe, &mut start).unwrap();
        assert_eq!(start, begins, "{words:?}");
    }
}

#[test]
fn two_outputs_may_not_be_one_file() {
    let bench = Bench::with(&[TRIANGLE]);
    let input = format!("@{TRIANGLE}");
    std::fs::create_dir(bench.path("deep")).unwrap();
    for report in ["@a.crowdpack", "@./a.crowdpack", "@deep/../a.crowdpack"] {
        let done = bench.run(&["bake", &input, "-o", "@a.crowdpack", "--report", report]).expect(2);
        done.says(&["two outputs are this file"]);
        bench.write("a.crowdpack", b"old");
    }
    assert!(bench.read("a.crowdpack") == b"old");
    bench.run(&["bake", &input, "-o", "@a.crowdpack", "--report", "@deep/a.crowdpack"]).expect(0);
}

#[test]
fn files_that_an_asset_reads_are_inputs_too() {
    let bench = Bench::new();
    let glb = std::fs::read(crowd_tests::folders::fixtures().join("good").join(TRIANGLE)).unwrap();
    // The fixture again, its buffer in a file of its own.
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let mut document: serde_json::Value = serde_json::from_slice(&glb[20..20 + word(12)]).unwrap();
    document["buffers"][0]["uri"] = "own.bin".into();
    let buffer = glb[28 + word(12)..].to_vec();
    std::fs::create_dir(bench.path("g")).unwrap();
    bench.write("g/t.gltf", document.to_string());
    bench.write("g/own.bin", &buffer);
    bench.write("g/o.obj", "mtllib o.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.write("g/o.mtl", "newmtl m\n");
    let refused: [&[&str]; 7] = [
        &["bake", "@g/t.gltf", "-o", "@g/own.bin"],
        &["bake", "@g", "-o", "@g/../g/own.bin"],
        &["bake", "@g/t.gltf", "-o", "@out.crowdpack", "--report", "@g/own.bin"],
        &["export", "@g/t.gltf", "--ratio", "1", "-o", "@g/own.bin"],
        &["picture", "@g/t.gltf", "-o", "@g/own.bin"],
        &["survey", "@g", "-o", "@g/own.bin"],
        &["bake", "@g/o.obj", "-o", "@g/o.mtl"],
    ];
    for words in refused {
        bench.run(words).expect(2).says(&["reads this file; inputs are never overwritten"]);
    }
    assert!(bench.read("g/own.bin") == buffer && bench.read("g/o.mtl") == b"newmtl m\n");
    assert_eq!(bench.listing(), ["g"], "nothing was written");
    bench.run(&["bake", "@g/t.gltf", "-o", "@g/other.bin"]).expect(0);
}

#[test]
fn standard_output_is_refused_by_name_and_so_is_another_format() {
    let bench = Bench::with(&[TRIANGLE]);
    let input = format!("@{TRIANGLE}");
    for words in [&["bake"][..], &["export", "--ratio", "1"], &["picture"], &["survey"]] {
        let done = bench.run(&[words, &[&input, "-o", "-"]].concat()).expect(2);
        done.says(&["standard output is not written to"]);
    }
    bench.run(&["bake", &input, "-o", "@a.crowdpack", "--report", "-"]).expect(2);
    let done = bench.run(&["export", &input, "--ratio", "1", "-o", "@low.gltf"]).expect(2);
    done.says(&["found .gltf, allowed .glb"]);
    assert_eq!(bench.listing(), [TRIANGLE]);
}

/// Nothing that could be read is there: had it been looked for first, these would end with 1, and folders would be left.
#[test]
fn outputs_are_tried_before_inputs_are_read_and_refused_inputs_leave_nothing() {
    let bench = Bench::new();
    bench.write("file", b"");
    bench.run(&["export", "@gone.glb", "--ratio", "1", "-o", "@file/a.glb"]).expect(3).says(&["file", "a folder"]);
    bench.run(&["export", "@gone.glb", "--lods", "1,0.5", "-o", "@file/new/"]).expect(3).says(&["file", "a folder"]);
    bench.run(&["export", "@gone.glb", "--lod", "all", "-o", "@file/a.glb"]).expect(3).says(&["file", "a folder"]);
    let long = format!("@new/{}/a.crowdpack", "n".repeat(300));
    bench.run(&["bake", "@gone.glb", "-o", &long]).expect(3).says(&["nnn"]);
    bench.run(&["bake", "@gone.glb", "-o", "@new/deep/a.crowdpack"]).expect(1);
    bench.run(&["report", "@gone.glb", "-o", "@new/a.html"]).expect(1);
    bench.run(&["export", "@gone.glb", "--ratio", "1", "-o", "@new/"]).expect(1);
    assert_eq!(bench.listing(), ["file"]);
}

/// What is tried is what will be written: `--lods` to a file write beside it.
#[test]
fn exports_try_the_names_that_they_write() {
    let bench = Bench::new();
    bench.copy(TRIANGLE, "t.glb");
    std::fs::create_dir_all(bench.path("folder/level.glb")).unwrap();
    std::fs::create_dir(bench.path("b.lod1.glb")).unwrap();
    bench.run(&["export", "@t.glb", "--ratio", "1", "-o", "@folder"]).expect(0);
    bench.run(&["export", "@gone.glb", "--lods", "1,0.5", "-o", "@b.glb"]).expect(3).says(&["b.lod1.glb", "a folder"]);
    // Were it read first, it would be refused for what is in it.
    bench.write("bad.lod0.glb", b"no");
    for words in [["--lods", "1", "-o", "@bad.glb"], ["--ratio", "1", "-o", "@bad.lod0.glb"]] {
        bench.run(&[&["export", "@bad.lod0.glb"][..], &words].concat()).expect(2).says(&["is an input too"]);
    }
    // One of several is the pack: none is written.
    bench.run(&["bake", "@t.glb", "--lod-ratio", "1,0.5", "-o", "@p.lod1.glb"]).expect(0);
    bench.run(&["export", "@p.lod1.glb", "--lod", "all", "-o", "@p.glb"]).expect(2).says(&["is an input too"]);
    assert_eq!(bench.listing(), ["b.lod1.glb", "bad.lod0.glb", "folder", "p.lod1.glb", "t.glb"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("gone/a.glb", bench.path("a.glb")).unwrap();
        bench.run(&["export", "@t.glb", "--lods", "1", "-o", "@a.glb"]).expect(0);
        assert!(bench.path("a.lod0.glb").is_file() && bench.path("a.glb").is_symlink());
        bench.run(&["bake", "@gone.glb", "-o", "@a.glb/a.crowdpack"]).expect(3).says(&["a.glb", "leads nowhere"]);
    }
}

#[test]
fn a_folder_that_is_to_be_made_gets_one_level_as_it_gets_several() {
    let bench = Bench::new();
    bench.copy(TRIANGLE, TRIANGLE);
    let input = format!("@{TRIANGLE}");
    bench.run(&["export", &input, "--ratio", "1", "-o", "@one/"]).expect(0);
    bench.run(&["export", &input, "--lods", "1", "-o", "@more/"]).expect(0);
    let stem = TRIANGLE.trim_end_matches(".glb");
    assert_eq!(crate::bench::listing(&bench.path("one")), [format!("{stem}.glb")]);
    assert_eq!(crate::bench::listing(&bench.path("more")), [format!("{stem}.lod0.glb")]);
}
