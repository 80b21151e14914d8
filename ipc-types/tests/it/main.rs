//! The integration tests of this package, in one program: it links once.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot continue has failed"
)]

mod codes;
mod damage;
mod layout;
mod pieces;
mod refused;
