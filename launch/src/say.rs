//! What commands write: results on stdout by [`cell_rt::stdout`], the rest on stderr.

use std::io::Write;

pub(crate) use cell_rt::stdout::{line, raw};

/// One line on stderr. Where it cannot be written, nothing is left to say it with.
pub(crate) fn warn(text: impl std::fmt::Display) {
    writeln!(std::io::stderr().lock(), "robocell: {text}").ok();
}
