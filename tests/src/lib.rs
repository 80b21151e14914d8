//! Black-box tests on the built programs: every cell in its own run directory,
//! every wait for a condition, never for a time.
//!
//! The programs lie in the target folder this test was built into. The first
//! test that needs one has cargo build them, so that none is of yesterday.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]
#![forbid(unsafe_code)]

pub mod assert;
pub mod cell;
pub mod fault;
pub mod http;
pub mod page_socket;
pub mod program;
pub mod recording;
pub mod schema;

/// A number from 0 to 1. Small, repeatable, good enough to choose instants with.
pub fn random(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as f64 / f64::from(1_u32 << 31)
}
