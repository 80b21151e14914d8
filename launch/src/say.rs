//! What commands write: results on stdout by [`cell_rt::stdout`], the rest on stderr.

pub(crate) use cell_rt::stdout::{line, raw};
pub(crate) use supervisor::say::warn;
