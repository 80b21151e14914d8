//! Writes the container: MCAP, <https://mcap.dev/spec>, as far as recordings need
//! it. It takes what is already packed, a thousand times a second and more, and
//! must not be noticed: one copy into the open chunk, blocks compressed without a
//! second checksum as soon as they are full, one write for each chunk.

mod chunk;
mod file;
mod header;
mod lz4;
mod record;
mod summary;

pub(crate) use file::Container;
pub(crate) use header::MessageHeader;
