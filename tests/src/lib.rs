//! Black-box tests on the built programs: every cell in its own run directory,
//! every wait for a condition, never for a time.
//!
//! The programs are taken from the target folder this test was built into;
//! `cargo build --workspace --bins` builds them.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on has failed"
)]
#![forbid(unsafe_code)]

pub mod assert;
pub mod cell;
pub mod fault;
pub mod http;
pub mod program;
pub mod recording;
