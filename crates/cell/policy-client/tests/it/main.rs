//! Policies behind a socket, against servers of these tests.

mod answers;
mod codec;
mod episodes;
mod server;
