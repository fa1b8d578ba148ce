//! Same input, same bytes: for any number of threads, in any process, whatever stood in the pack before.

use crate::bench::{Bench, SPHERE, TUBE, TWO_MATERIALS};

#[test]
fn one_two_and_eight_threads_give_the_same_bytes() {
    let bench = Bench::with(&["zebra.glb", TUBE, SPHERE, TWO_MATERIALS]);
    for layout in ["3x4", "4x4"] {
        let bake = |jobs: &str| {
            let words = ["bake", "@.", "-o", "@out.crowdpack", "--jobs", jobs, "--animation-layout", layout];
            bench.run(&words).expect(0);
            bench.read("out.crowdpack")
        };
        let one = bake("1");
        assert!(bake("2") == one, "2 threads, {layout}");
        assert!(bake("8") == one, "8 threads, {layout}");
    }
    bench.run_program(&["bake", "@.", "-o", "@process.crowdpack", "--animation-layout", "4x4"]).expect(0);
    assert!(bench.read("process.crowdpack") == bench.read("out.crowdpack"), "another process");
    for threads in ["1", "2", "8"] {
        let mut program = bench.program(&["bake", "@.", "-o", "@threads.crowdpack", "--animation-layout", "4x4", "-q"]);
        let status = program.env("RAYON_NUM_THREADS", threads).status().expect("the program starts");
        assert!(status.success());
        assert!(bench.read("threads.crowdpack") == bench.read("out.crowdpack"), "RAYON_NUM_THREADS={threads}");
    }
}

#[test]
fn the_criteria_change_the_pack() {
    let bench = Bench::with(&["mara.glb"]);
    let coarsest = |criteria: &str| {
        bench.run(&["bake", "@mara.glb", "-o", "@out.crowdpack", "--criteria", criteria]).expect(0);
        let inspection = bench.run(&["inspect", "@out.crowdpack", "--json"]).expect(0).json();
        assert_eq!(inspection["characters"][0]["criteria"], criteria);
        inspection["characters"][0]["coarsest_triangles"].as_u64().unwrap()
    };
    let (wedge, peng) = (coarsest("wedge"), coarsest("peng2011"));
    // The paper's fixed vertices never move; tested one by one most of them may.
    assert!(wedge < peng, "wedge reaches {wedge}, peng2011 {peng}");
}
