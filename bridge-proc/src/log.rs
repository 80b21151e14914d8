//! The log of the bridge: lines on standard error.

use std::io::Write as _;

/// A line in the log. Where it cannot be written it is lost: `eprintln!` would end the
/// process.
pub fn line(text: impl std::fmt::Display) {
    writeln!(std::io::stderr().lock(), "bridge-proc: {text}").ok();
}
