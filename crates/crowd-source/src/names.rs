//! Names and other words out of files, made fit for messages, reports and terminals.

/// Longest name that is kept, in characters.
const NAME_CHARS: usize = 200;

/// At most 80 characters of a stranger's text, for a message. Control characters, which could steer a terminal, become `?`.
pub(crate) fn shorten(text: &str) -> String {
    cut(text, 80)
}

/// A name out of a file, or `fallback` where it has none.
pub(crate) fn name_or(name: Option<&str>, fallback: impl FnOnce() -> String) -> String {
    match name.map(|name| cut(name, NAME_CHARS)) {
        Some(name) if !name.is_empty() => name,
        _ => fallback(),
    }
}

fn cut(text: &str, chars: usize) -> String {
    let end = text.char_indices().nth(chars).map(|(end, _)| end);
    let kept: String =
        text[..end.unwrap_or(text.len())].chars().map(|c| if c.is_control() { '?' } else { c }).collect();
    if end.is_some() { kept + "..." } else { kept }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_words_are_cut_between_characters() {
        assert_eq!(shorten(&"ä".repeat(80)), "ä".repeat(80));
        assert_eq!(shorten(&"ä".repeat(81)), "ä".repeat(80) + "...");
    }

    #[test]
    fn words_cannot_steer_a_terminal() {
        assert_eq!(name_or(Some("a\u{1b}[2Jb\n"), || unreachable!("there is a name")), "a?[2Jb?");
    }

    #[test]
    fn missing_and_empty_names_fall_back() {
        assert_eq!(name_or(None, || "node 3".into()), "node 3");
        assert_eq!(name_or(Some(""), || "node 3".into()), "node 3");
    }
}
