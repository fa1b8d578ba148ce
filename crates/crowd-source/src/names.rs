//! Names and other words out of files, made fit for messages, reports and terminals.

/// Longest name that is kept, in characters.
const NAME_CHARS: usize = 200;

/// At most 80 characters of a stranger's text, for a message. What could steer a terminal or turn the
/// direction of its text becomes `?`.
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
        text[..end.unwrap_or(text.len())].chars().map(|c| if steers_text(c) { '?' } else { c }).collect();
    if end.is_some() { kept + "..." } else { kept }
}

/// Control characters, line separators, and the marks that turn the direction of text.
fn steers_text(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
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
        assert_eq!(shorten("glb.\u{202e}gnp"), "glb.?gnp");
    }

    #[test]
    fn missing_and_empty_names_fall_back() {
        assert_eq!(name_or(None, || "node 3".into()), "node 3");
        assert_eq!(name_or(Some(""), || "node 3".into()), "node 3");
    }
}
