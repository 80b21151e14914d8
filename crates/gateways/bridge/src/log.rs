//! The log of the bridge: lines on standard error.

use std::io::Write as _;

/// Writes a line to the log. If the log cannot be written, it is lost: `eprintln!` would panic
/// and end the process.
pub fn line(text: impl std::fmt::Display) {
    writeln!(std::io::stderr().lock(), "bridge-proc: {text}").ok();
}
