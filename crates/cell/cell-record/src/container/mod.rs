//! Writes the container: MCAP, <https://mcap.dev/spec>, as far as recordings need
//! it. It takes packed messages, a thousand times a second and more, and has to be
//! cheap: one copy into the open chunk, blocks compressed without a second checksum
//! as soon as they are full, one write for each chunk.

mod chunk;
mod file;
mod header;
mod lz4;
mod record;
mod summary;

pub(crate) use file::Container;
pub(crate) use header::MessageHeader;
