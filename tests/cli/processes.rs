//! What only a real process can show: kills, races, pipes, terminals.

use crate::bench::{Bench, TRIANGLE, TUBE};
use crowd_pack::Pack;
use std::io::Read;
use std::process::Stdio;
use std::time::Duration;

#[test]
fn exit_codes_and_streams_are_those_of_the_library() {
    let bench = Bench::with(&[TRIANGLE]);
    let done = bench.run_program(&["bake", &format!("@{TRIANGLE}"), "-o", "@out.crowdpack", "--json"]).expect(0);
    assert_eq!(done.json()["exit_code"], 0);
    // Not a terminal: no bar, no colours.
    assert!(!done.err.contains('\u{1b}') && !done.err.contains('\r'), "{:?}", done.err);
    bench.run_program(&["bake", "@gone.glb", "-o", "@none.crowdpack"]).expect(1).says(&["no such file"]);
    bench.run_program(&["bake", "--nonsense"]).expect(2);
    bench.run_program(&["verify", "@out.crowdpack"]).expect(0);
}

#[test]
fn a_killed_bake_leaves_the_old_pack_or_the_new_one() {
    let bench = Bench::with(&["mara.glb"]);
    let words = ["bake", "@mara.glb", "-o", "@out.crowdpack"];
    bench.run_program(&words).expect(0);
    let whole = bench.read("out.crowdpack");
    for wait_ms in [0, 20, 60, 120, 240, 360, 480] {
        bench.write("out.crowdpack", b"old");
        let mut bake = bench.program(&words).stderr(Stdio::null()).spawn().expect("the program starts");
        std::thread::sleep(Duration::from_millis(wait_ms));
        bake.kill().expect("the child is ours");
        bake.wait().expect("the child is ours");
        let left = bench.read("out.crowdpack");
        assert!(left == b"old" || left == whole, "killed after {wait_ms} ms: {} bytes", left.len());
    }
}

#[test]
fn two_bakes_at_once_leave_one_whole_pack() {
    let bench = Bench::with(&[TUBE]);
    let words = ["bake", &format!("@{TUBE}"), "-o", "@out.crowdpack"];
    let start = || bench.program(&words).stderr(Stdio::null()).spawn().expect("the program starts");
    let mut bakes: Vec<_> = (0..4).map(|_| start()).collect();
    for bake in &mut bakes {
        assert!(bake.wait().expect("the child is ours").success());
    }
    Pack::open(&bench.path("out.crowdpack")).expect("the pack is whole");
    assert_eq!(bench.listing(), ["out.crowdpack", TUBE], "temporary files are gone");
}

#[test]
fn a_closed_pipe_is_success() {
    let bench = Bench::new();
    let mut command = bench.program(&["completions", "bash"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    drop(child.stdout.take());
    let mut err = String::new();
    child.stderr.take().expect("it was piped").read_to_string(&mut err).expect("the program speaks UTF-8");
    assert_eq!(child.wait().expect("the child is ours").code(), Some(0), "{err}");
    assert!(err.is_empty(), "{err}");
}
