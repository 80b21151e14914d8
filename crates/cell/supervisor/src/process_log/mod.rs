//! The logs of the processes: bounded by the launcher, read while they are written.
//!
//! A process writes to its log through its own descriptor, opened to append, which the launcher
//! cannot redirect. So the storage of the oldest lines is released in place: the file gets a
//! hole at its start, and its length still counts all bytes ever written. The process never
//! waits, and no newer line is lost.

mod bounds;
mod follower;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use cell_rt::hole;

pub(crate) use bounds::LogBounds;
pub use follower::Follower;

/// Most bytes that a log occupies. A task that prints megabytes must not fill the memory
/// that the cell works in.
const LIMIT: u64 = 10_000_000;
/// A log that occupies more loses its older half. The rest up to the limit is for lines
/// that are written until that is done.
const FULL: u64 = 8_000_000;

/// The last `bytes` of the log at `path`; nothing where there is none.
pub fn tail(path: &Path, bytes: u64) -> String {
    let end = end_of(path, bytes).unwrap_or_default();
    String::from_utf8_lossy(&end).into_owned()
}

fn end_of(path: &Path, bytes: u64) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let from = file.metadata()?.len().saturating_sub(bytes);
    let mut end = Vec::new();
    read_from(&mut file, from, &mut end)?;
    Ok(end)
}

/// Appends the bytes of the log from `position` on to `out`. Returns the number of bytes
/// after `position` that are no longer kept.
fn read_from(file: &mut File, position: u64, out: &mut Vec<u8>) -> io::Result<u64> {
    // Not the zeros of a large hole.
    let from = position.max(hole::first_data(file)?);
    file.seek(SeekFrom::Start(from))?;
    let begin = out.len();
    let read = file.read_to_end(out)? as u64;
    // Bytes released during the read may have been read as zeros.
    let first = hole::first_data(file)?.clamp(from, from + read);
    let unread = usize::try_from(first - from).map_err(io::Error::other)?;
    out.drain(begin..begin + unread);
    Ok(first - position)
}
