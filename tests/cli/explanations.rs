//! `explain`: the counts are the bake's, the causes and places those that the fixtures were made to have.

use crate::bench::{Bench, SPHERE, TRIANGLE, TUBE};
use serde_json::Value;

const CUBE: &str = "cube_with_cuts_should_keep_8_fixed.glb";
const HAT: &str = "rigid_hat_should_follow_the_head_joint.glb";

/// Causes with their counts, as listed.
fn causes(character: &Value) -> Vec<(String, u64)> {
    let causes = character["causes"].as_array().expect("causes");
    let pair = |cause: &Value| (cause["cause"].as_str().unwrap().to_owned(), cause["count"].as_u64().unwrap());
    causes.iter().map(pair).collect()
}

fn explained(words: &[&str], fixture: &str) -> Value {
    let bench = Bench::with(&[fixture]);
    let input = format!("@{fixture}");
    let words: Vec<&str> = ["explain", &input, "--json"].iter().chain(words).copied().collect();
    bench.run(&words).expect(0).json()["characters"][0].clone()
}

#[test]
fn corners_of_a_cube_are_held_by_the_rules_of_the_paper_and_a_flag_lifts_them() {
    let cube = explained(&["--criteria", "peng2011"], CUBE);
    assert_eq!(cube["coarsest"]["triangles"], 12);
    assert_eq!(cube["stuck_positions"], 8);
    assert_eq!(causes(&cube), [("fixed-class".to_owned(), 8)]);
    assert_eq!(cube["causes"][0]["flag"], "--criteria wedge");
    let free = explained(&[], CUBE);
    assert_eq!(causes(&free), [("last-piece".to_owned(), 3)]);
    assert!(free["causes"][0]["flag"].is_null());
}

#[test]
fn a_piece_of_four_triangles_is_named_with_its_joint_and_material() {
    let hat = explained(&["--criteria", "peng2011"], HAT);
    let places = hat["places"].as_array().unwrap();
    let felt = places.iter().find(|place| place["material"] == "felt").expect("the hat is of felt");
    assert_eq!((felt["joint"].as_str(), felt["count"].as_u64()), (Some("hat"), Some(4)));
    assert_eq!(felt["parts"], serde_json::json!(["hat"]));
    assert_eq!(felt["causes"], serde_json::json!([["smallest-piece", 4]]));
}

#[test]
fn an_open_triangle_says_that_it_is_open() {
    assert_eq!(causes(&explained(&["--criteria", "peng2011"], TRIANGLE)), [("open-border".to_owned(), 3)]);
}

#[test]
fn what_is_counted_by_cause_by_place_and_by_obstacle_is_the_same() {
    for criteria in ["wedge", "peng2011"] {
        let tube = explained(&["--criteria", criteria, "--coarsest", "last"], TUBE);
        let stuck = tube["stuck_positions"].as_u64().unwrap();
        let sum = |list: &str| tube[list].as_array().unwrap().iter().map(|e| e["count"].as_u64().unwrap()).sum::<u64>();
        let obstacles = tube["obstacles"].as_object().unwrap().values().map(|v| v.as_u64().unwrap()).sum::<u64>();
        assert!(stuck > 0);
        assert_eq!([sum("causes"), sum("places"), obstacles], [stuck; 3], "{criteria}");
    }
}

#[test]
fn targets_say_whether_they_are_reached_and_what_they_cost() {
    let bench = Bench::with(&[CUBE, TUBE]);
    bench.run(&["bake", &format!("@{TUBE}"), "-o", "@tube.crowdpack"]).expect(0);
    let text = bench.run(&["explain", "@tube.crowdpack", "--ratio", "10%,0.05"]).expect(0).out;
    assert!(text.contains("10 % (50 triangles): reached") && text.contains("5 % (25 triangles): reached"), "{text}");
    assert!(text.contains("RMS") && text.contains("clip bend") && text.contains("furthest off at joints"), "{text}");
    let cube = explained(&["--criteria", "peng2011", "--ratio", "5%,50%"], CUBE);
    assert_eq!(
        (cube["targets"][0]["reached"].as_bool(), cube["targets"][1]["reached"].as_bool()),
        (Some(false), Some(true))
    );
    assert_eq!(cube["targets"][0]["level"]["triangles"], 12);
}

#[test]
fn an_ended_order_says_that_nothing_holds_it() {
    let sphere = explained(&[], SPHERE);
    assert_eq!(sphere["stuck_positions"], 0);
    assert!(sphere["free_positions"].as_u64().unwrap() > 0);
    let tube = explained(&[], TUBE);
    assert_eq!(tube["coarsest"]["triangles"], 10, "2 % of 504");
    let bench = Bench::with(&[TUBE]);
    let words = |more: &[&str]| {
        let path = format!("@{TUBE}");
        let words: Vec<&str> = ["explain", &path].iter().chain(more).copied().collect();
        bench.run(&words).expect(0).out
    };
    assert!(words(&[]).contains("could still move: the bake ended the detail here"));
    let last = words(&["--coarsest", "last"]);
    assert!(
        last.contains("the coarsest level has 2 of 504") && last.contains("nothing of the character would be left"),
        "{last}"
    );
    assert!(words(&["--coarsest", "100"]).contains("the coarsest level has 98 of 504"));
    bench.run(&["explain", &format!("@{TUBE}"), "--coarsest", "0"]).expect(2).says(&["found 0, allowed triangles"]);
}

#[test]
fn one_character_of_many_can_be_asked_for_and_an_unknown_one_is_refused() {
    let bench = Bench::with(&[CUBE, TUBE]);
    bench.run(&["bake", &format!("@{CUBE}"), &format!("@{TUBE}"), "-o", "@two.crowdpack"]).expect(0);
    let name = TUBE.trim_end_matches(".glb");
    let both = bench.run(&["explain", "@two.crowdpack"]).expect(0).out;
    let one = bench.run(&["explain", "@two.crowdpack", "--character", name]).expect(0).out;
    assert!(both.contains(CUBE) && both.ends_with(&one) && !one.contains(CUBE), "{both}");
    bench.run(&["explain", "@two.crowdpack", "--character", "nobody"]).expect(1).says(&["character `nobody`"]);
    bench.run(&["explain", "@two.crowdpack", "--ratio", "300%"]).expect(2).says(&["found 300%"]);
    bench.run(&["explain", "@gone.crowdpack"]).expect(1);
}
