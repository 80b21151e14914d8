//! Words of a command that a person copies into a shell.

use std::path::Path;

/// A path as a shell takes it.
pub(crate) fn quoted(path: &Path) -> String {
    quoted_word(&path.display().to_string())
}

/// A word as a shell takes it.
pub(crate) fn quoted_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// The command line of this process.
pub(crate) fn typed() -> String {
    let words = std::env::args_os().skip(1);
    // Nothing is lost: arguments that are not UTF-8 were refused before.
    let words = words.map(|word| quoted_word(&word.to_string_lossy()));
    let words: Vec<String> = std::iter::once("robocell".to_owned())
        .chain(words)
        .collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted(Path::new("/a/b.urdf")), "/a/b.urdf");
        assert_eq!(quoted_word("my robot's"), "'my robot'\\''s'");
        assert_eq!(quoted_word("$(rm x)"), "'$(rm x)'");
        assert_eq!(quoted_word(""), "''");
    }
}
