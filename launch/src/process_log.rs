//! The logs of the processes: bounded by the launcher, read over a rotation.
//!
//! A process writes to its log by a descriptor of its own, opened to append, that nobody
//! else can redirect. So a log that is full is copied to its older part and truncated in
//! place; the process writes on at its beginning and never waits for anybody. What is
//! written between the last look and the truncation, some microseconds, is lost.

mod follower;
mod rotation;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

pub(crate) use follower::Follower;
pub(crate) use rotation::LogRotation;

/// Most bytes of a log. A task that prints megabytes must not fill the memory that the
/// cell works in.
const LIMIT: u64 = 10_000_000;
/// A log is copied to its older part when it has so many bytes: two parts, and what is
/// written until the copy is made, are within the limit.
const PART: u64 = 4_000_000;

/// The older part of the log at `path`.
fn older(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".1");
    name.into()
}

/// The last `bytes` of the log at `path`, both parts of it; nothing where there is none.
pub(crate) fn tail(path: &Path, bytes: u64) -> String {
    let mut end = end_of(path, bytes).unwrap_or_default();
    let missing = bytes.saturating_sub(end.len() as u64);
    if missing > 0 {
        let mut before = end_of(&older(path), missing).unwrap_or_default();
        before.append(&mut end);
        end = before;
    }
    String::from_utf8_lossy(&end).into_owned()
}

fn end_of(path: &Path, bytes: u64) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(bytes)))?;
    let mut end = Vec::new();
    file.read_to_end(&mut end)?;
    Ok(end)
}
