//! Commands that help texts and documents teach, to be tried.

use crate::folders::repository;

/// The commands of a program in a text: of every line that begins with one, its words up to a comment, a pipe, or two blanks.
pub fn commands(program: &str, text: &str) -> Vec<Vec<String>> {
    // `cargo run ... -p PROGRAM -- WORDS` is the program, too.
    let by_cargo = format!("-p {program} -- ");
    let of_line = |line: &str| {
        let starts = line.starts_with("cargo run").then(|| line.match_indices(&by_cargo)).into_iter().flatten();
        let mut found: Vec<Vec<String>> = starts.map(|(at, cut)| words(&line[at + cut.len()..])).collect();
        found.extend(line.strip_prefix(program).and_then(|rest| rest.strip_prefix(' ')).map(words));
        found
    };
    let text = text.split("\\\n").map(|part| part.trim_matches(' ')).collect::<Vec<_>>().join(" ");
    // Lines of a usage have <PLACES> to fill.
    let is_whole = |words: &Vec<String>| !words.iter().any(|word| word.starts_with(['<', '[']));
    text.lines().map(str::trim).flat_map(of_line).filter(is_whole).collect()
}

/// The commands in the README and in the recipes of the justfile.
pub fn documented(program: &str) -> Vec<Vec<String>> {
    let read = |page| std::fs::read_to_string(repository().join(page)).expect("both are there, and are text");
    ["README.md", "justfile"].iter().flat_map(|page| commands(program, &read(page))).collect()
}

/// As a shell would have them, up to what is no more of this command.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote, mut blanks) = (Vec::new(), None::<String>, None, 0);
    for c in line.chars().chain([' ']) {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (Some(_), c) => word.get_or_insert_default().push(c),
            (None, '\'' | '"') => {
                (quote, blanks) = (Some(c), 0);
                word.get_or_insert_default();
            }
            (None, ' ') => {
                blanks += 1;
                words.extend(word.take());
            }
            (None, c) => {
                let ends = word.is_none() && ("#|>&".contains(c) || blanks > 1);
                if ends {
                    return words;
                }
                word.get_or_insert_default().push(c);
                blanks = 0;
            }
        }
    }
    assert!(quote.is_none(), "a quote stays open in: {line}");
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_end_where_the_command_does() {
        let text = "See:\n  tool make 'a b' --if \"x <= 1\"   a remark\n  tool do \\\n    it | jq .\ncargo run --release -p tool -- x > y && cargo run -p tool -- z # why\ntools no\ntool <FILE>";
        let expected = [&["make", "a b", "--if", "x <= 1"][..], &["do", "it"], &["x"], &["z"]];
        assert_eq!(commands("tool", text), expected);
        assert!(documented("crowdplay").len() > 20 && documented("crowdbake").len() > 20);
    }
}
