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
