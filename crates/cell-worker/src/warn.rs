//! The log of a process.

use std::io::Write;

/// A warning in the log. Where the log cannot be written, as its file system is full, it
/// is lost: `eprintln!` would end the process.
pub fn warn(text: impl std::fmt::Display) {
    line(format_args!("warning: {text}"));
}

/// A line in the log, as [`warn`].
pub(crate) fn line(text: impl std::fmt::Display) {
    writeln!(std::io::stderr().lock(), "{text}").ok();
}
