//! Warnings, on stderr.

use std::io::Write;

/// One line on stderr. Where it cannot be written, nothing is left to say it with.
pub fn warn(text: impl std::fmt::Display) {
    writeln!(std::io::stderr().lock(), "robocell: {text}").ok();
}
