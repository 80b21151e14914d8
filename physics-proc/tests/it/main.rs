//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

mod determinism;
mod equipment;
mod grasp;
mod operator;
mod plc;
mod sanity;
mod scene;
mod stops;
mod support;
mod two_arms;
