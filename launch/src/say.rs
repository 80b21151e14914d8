//! Words for the person in front: a closed pipe is no reason to die.

use std::io::Write;

/// One line on stdout.
pub(crate) fn line(text: impl std::fmt::Display) {
    writeln!(std::io::stdout().lock(), "{text}").ok();
}

/// A whole text on stdout, as it is.
pub(crate) fn raw(text: &[u8]) {
    std::io::stdout().lock().write_all(text).ok();
}

/// One line on stderr.
pub(crate) fn warn(text: impl std::fmt::Display) {
    writeln!(std::io::stderr().lock(), "robocell: {text}").ok();
}
