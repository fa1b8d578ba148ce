//! Help, usage errors, completions: before anything is read.

use crate::bench::Bench;
use crowd_tests::taught::{commands, documented};

const VERBS: [&str; 8] = ["bake", "inspect", "verify", "export", "picture", "survey", "print-config", "completions"];

#[test]
fn help_goes_to_stdout_and_every_verb_teaches_by_example() {
    let bench = Bench::new();
    let help = bench.run(&["--help"]).expect(0);
    assert!(help.err.is_empty());
    for verb in VERBS {
        assert!(help.out.contains(verb), "{verb} is missing in:\n{}", help.out);
        let help = bench.run(&[verb, "--help"]).expect(0);
        assert!(help.out.contains(&format!("crowdbake {verb}")), "{}", help.out);
        assert!(help.out.contains("Example"), "{verb} --help shows no example:\n{}", help.out);
    }
    assert!(help.out.contains("Exit codes: 0"));
    assert!(bench.run(&["--version"]).expect(0).out.starts_with("crowdbake "));
}

#[test]
fn wrong_words_end_with_2_and_nothing_on_stdout() {
    let bench = Bench::new();
    for words in [
        &[][..],
        &["bake"],
        &["bake", "a.glb"],
        &["bake", "a.glb", "-o", "x", "--fps", "0"],
        &["bake", "a.glb", "-o", "x", "--criteria", "best"],
        &["bake", "a.glb", "-o", "x", "-q", "-v"],
        &["export", "a.crowdpack", "-o", "x.glb"],
        &["export", "a.crowdpack", "-o", "x.glb", "--ratio", "2"],
        &["export", "a.crowdpack", "-o", "x.glb", "--ratio", "0.5", "--triangles", "3"],
        &["picture", "a.crowdpack", "-o", "x.png", "--size", "0x0"],
        &["picture", "a.crowdpack", "-o", "x.png", "--turn", "NaN"],
        &["picture", "a.crowdpack", "-o", "x.png", "--turn", "1e30"],
        &["picture", "a.crowdpack", "-o", "x.png", "--time", "NaN"],
        &["bake", "a.glb", "-o", "x", "--jobs", "100000"],
        &["frobnicate"],
    ] {
        let done = bench.run(words).expect(2);
        assert!(done.out.is_empty() && !done.err.is_empty(), "{words:?}");
    }
    assert!(bench.listing().is_empty());
}

/// Nothing that they name is there: words that make sense end with 1.
#[test]
fn commands_that_help_and_documents_teach_are_understood() {
    let bench = Bench::new();
    let mut taught = documented("crowdbake");
    for verb in VERBS.iter().copied().chain(["report", "explain", "compare", ""]) {
        let words = [verb, "--help"];
        let help = bench.run(if verb.is_empty() { &words[1..] } else { &words }).expect(0);
        taught.extend(commands("crowdbake", &help.out));
    }
    assert!(taught.len() > 50, "{}", taught.len());
    for words in taught.iter().filter(|words| !words.is_empty() && words[0] != "help") {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let done = bench.run_program(&words);
        assert!(done.code < 2, "{words:?}: {}", done.err);
    }
}

#[test]
fn completions_are_made_for_each_shell() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = bench.run(&["completions", shell]).expect(0).out;
        assert!(script.contains("animation-layout"), "{shell}");
    }
}
