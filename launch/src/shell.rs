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
