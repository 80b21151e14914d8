//! Log of a process.

use std::io::Write;

/// Writes a warning to the log. If the log cannot be written because its file system is full,
/// the warning is lost: `eprintln!` would panic and end the process.
pub fn warn(text: impl std::fmt::Display) {
    line(format_args!("warning: {text}"));
}

/// Writes a line to the log, as [`warn`].
pub(crate) fn line(text: impl std::fmt::Display) {
    writeln!(std::io::stderr().lock(), "{text}").ok();
}
