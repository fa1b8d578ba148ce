//! Words as one would type them into a shell.

use std::path::Path;

/// A word in quotes where it has more than plain letters.
pub fn shell_word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+=:,@%".contains(c) || (cfg!(windows) && c == '\\');
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text.to_owned(),
        // No name has a double quote there.
        false if cfg!(windows) => format!("\"{text}\""),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

/// A path as such a word that is never taken for an option.
pub fn shell_path(path: &Path) -> String {
    let text = path.display().to_string();
    shell_word(&if text.starts_with('-') { format!("./{text}") } else { text })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn a_shell_takes_them_for_what_they_are() {
        for text in ["a/b-1.glb", "", "two words", "it's", "$(rm x)", "a\"b`c`", "--assert", "a/b <= 1", "\u{e9}*?"] {
            let said =
                std::process::Command::new("sh").args(["-c", &format!("printf %s {}", shell_word(text))]).output();
            assert_eq!(String::from_utf8(said.unwrap().stdout).unwrap(), text);
        }
        assert_eq!(["a/b-1.glb", "\u{e9}.glb"].map(shell_word), ["a/b-1.glb", "\u{e9}.glb"], "plain ones stay");
        assert_eq!(shell_path(Path::new("-x.glb")), "./-x.glb");
    }
}
