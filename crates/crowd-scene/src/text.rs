//! The lines of our text files: a heading, comments from `#` to the line's end, words between blanks, or between quotes (`"clip 0"`).

use crate::{Error, Result};

/// Coordinates beyond this are refused, metres: f32 keeps 6 cm there.
pub(crate) const FARTHEST_M: f32 = 1.0e6;

/// A line with something in it, and its number from 1.
pub(crate) struct Line<'a> {
    pub(crate) number: usize,
    words: Vec<&'a str>,
}

/// Lines after the heading that are not empty, split into at most 32 words.
///
/// # Errors
/// [`Error::Format`] when the first line is not `heading`.
pub(crate) fn lines_after<'a>(text: &'a str, heading: &str) -> Result<impl Iterator<Item = Line<'a>> + use<'a>> {
    let first = text.lines().next().unwrap_or("").trim_start_matches('\u{feff}').trim_end();
    if first != heading {
        return Err(wrong(1, first, &format!("`{heading}`")));
    }
    Ok(text.lines().enumerate().skip(1).filter_map(|(index, line)| {
        let words = words_of(line);
        (!words.is_empty()).then_some(Line { number: index + 1, words })
    }))
}

/// The first 32 words of a line. What stands in quotes is one word, blanks and `#` with it; a quote that is not closed goes to the line's end and
/// stays with its word, so that whoever refuses the line can say so.
fn words_of(line: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let mut rest = line.trim_start();
    while !rest.is_empty() && !rest.starts_with('#') && words.len() < 32 {
        let quoted = rest.strip_prefix('"').and_then(|inner| inner.split_once('"'));
        let word = match quoted {
            Some((word, after)) => {
                rest = after;
                word
            }
            None if rest.starts_with('"') => std::mem::take(&mut rest).trim_end(),
            None => {
                let end = rest.find(|c: char| c.is_whitespace() || c == '#').unwrap_or(rest.len());
                let (word, after) = rest.split_at(end);
                rest = after;
                word
            }
        };
        words.push(word);
        rest = rest.trim_start();
    }
    words
}

impl Line<'_> {
    /// True where that word stands there.
    pub(crate) fn is_word(&self, word: usize, expected: &str) -> bool {
        self.words.get(word).is_some_and(|found| *found == expected)
    }

    /// The word there, or nothing.
    pub(crate) fn word(&self, word: usize) -> &str {
        self.words.get(word).copied().unwrap_or("")
    }

    /// How many there are.
    pub(crate) fn word_count(&self) -> usize {
        self.words.len()
    }

    /// Refuses fewer and more words.
    pub(crate) fn must_have_between(&self, least: usize, most: usize, names: &str) -> Result<()> {
        if (least..=most).contains(&self.words.len()) {
            return Ok(());
        }
        Err(self.wrong_words(&format!("{least} to {most}: {names}")))
    }

    /// One of `names`, or its number, a whole number below `end`.
    pub(crate) fn index_or_name(&self, word: usize, what: &str, names: &[String], end: usize) -> Result<u32> {
        let found = self.word(word);
        let is = |name: &&String| name.as_str() == found;
        let is_alike = |name: &&String| name.eq_ignore_ascii_case(found);
        let named = names.iter().take(end).find(is).or_else(|| names.iter().take(end).find(is_alike));
        if let Some(name) = named {
            return Ok(names.iter().position(|other| other == name).unwrap_or(0) as u32);
        }
        self.index_below(word, what, end).map_err(|_| {
            let known: Vec<&str> = names.iter().take(end.min(12)).map(String::as_str).collect();
            let more = if end.min(names.len()) > 12 { ", ..." } else { "" };
            let or = if known.is_empty() { String::new() } else { format!(", or one of {}{more}", known.join(", ")) };
            wrong(self.number, found, &format!("{what}, a whole number below {end}{or}"))
        })
    }

    /// Refuses any other number of words.
    pub(crate) fn must_have(&self, count: usize, names: &str) -> Result<()> {
        if self.words.len() == count {
            return Ok(());
        }
        Err(self.wrong_words(&format!("{count}: {names}")))
    }

    fn wrong_words(&self, expected: &str) -> Error {
        match self.words.last() {
            Some(word) if word.starts_with('"') => wrong_in_words(self.number, OPEN_QUOTE, expected),
            _ => wrong_count(self.number, self.words.len(), expected),
        }
    }

    /// A finite number within `low..=high`.
    pub(crate) fn number_in(&self, word: usize, name: &str, low: f32, high: f32) -> Result<f32> {
        let found = self.words.get(word).copied().unwrap_or("");
        match found.parse::<f32>() {
            Ok(value) if value >= low && value <= high => Ok(value),
            _ => Err(wrong(self.number, found, &format!("{name}, a number from {low} to {high}"))),
        }
    }

    /// A whole number below `end`.
    pub(crate) fn index_below(&self, word: usize, name: &str, end: usize) -> Result<u32> {
        let found = self.words.get(word).copied().unwrap_or("");
        match found.parse::<u32>() {
            Ok(value) if (value as usize) < end => Ok(value),
            _ => Err(wrong(self.number, found, &format!("{name}, a whole number below {end}"))),
        }
    }
}

/// Words in the place of a count, where a quote swallowed the others.
const OPEN_QUOTE: &str = "a quote that is not closed";

/// A refusal of a line with too few or too many words.
pub(crate) fn wrong_count(line: usize, count: usize, expected: &str) -> Error {
    wrong_in_words(line, &if count == 1 { "1 word".to_owned() } else { format!("{count} words") }, expected)
}

/// A refusal that says what was found in words of ours, not in the file's.
pub(crate) fn wrong_in_words(line: usize, found: &str, expected: &str) -> Error {
    Error::Format { line, found: found.to_owned(), expected: expected.to_owned() }
}

/// A refusal that quotes at most the first 60 characters.
pub(crate) fn wrong(line: usize, found: &str, expected: &str) -> Error {
    let quoted: String = found.chars().take(60).collect();
    let found = if quoted.is_empty() { "nothing".to_owned() } else { format!("`{}`", quoted.escape_debug()) };
    Error::Format { line, found, expected: expected.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::words_of;

    #[test]
    fn words_stand_between_blanks_or_quotes() {
        for (line, words) in [
            ("", &[][..]),
            ("  # 1 2", &[]),
            (" 1  2\t3# 4", &["1", "2", "3"]),
            ("CesiumMan \"clip 0\" 0.5", &["CesiumMan", "clip 0", "0.5"]),
            ("\"a # b\" c # d", &["a # b", "c"]),
            ("\"\" \"Armature|Walk\"2", &["", "Armature|Walk", "2"]),
            ("1 \"not closed # 3 ", &["1", "\"not closed # 3"]),
            ("it\"s one", &["it\"s", "one"]),
        ] {
            assert_eq!(words_of(line), words, "{line:?}");
        }
        assert_eq!(words_of(&"1 ".repeat(100)).len(), 32);
    }
}
