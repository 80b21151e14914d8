//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

mod ability;
mod bench;
mod conditions;
mod files;
mod guarded;
mod jobs;
mod own_leaf;
mod several;
mod skills;
mod way;
