//! Policies behind a socket, against servers of these tests.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

mod answers;
mod codec;
mod episodes;
mod server;
