//! `survey`: one row an asset, a message for what was refused, a picture each.

use crate::bench::{Bench, TRIANGLE, TUBE};

#[test]
fn a_survey_has_a_row_for_each_asset_good_or_bad() {
    let bench = Bench::new();
    bench.copy(TUBE, "in/tube.glb");
    bench.copy(TRIANGLE, "in/triangle.glb");
    bench.copy(TRIANGLE, "in/a/b.glb");
    bench.copy(TRIANGLE, "in/a-b.glb");
    bench.write("in/bad.glb", b"no");
    bench.run(&["survey", "@in", "-o", "@S.md", "--pictures", "@p"]).expect(1).says(&["bad.glb: refused"]);
    let table = String::from_utf8(bench.read("S.md")).unwrap();
    for part in ["| tube.glb |", "| triangle.glb |", "## Refused", "| bad.glb |"] {
        assert!(table.contains(part), "no {part} in:\n{table}");
    }
    assert!(!table.contains(&bench.path("").to_string_lossy().into_owned()), "machine paths stay out:\n{table}");
    assert_eq!(
        crate::bench::listing(&bench.path("p")),
        ["a-b.glb-2.png", "a-b.glb.png", "triangle.glb.png", "tube.glb.png"]
    );
}
