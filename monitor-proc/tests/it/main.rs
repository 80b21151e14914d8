//! The integration tests of this package, in one program: it links once.

mod server;
mod server_bench;
mod server_feed;
