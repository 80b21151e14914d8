//! The ground a run stands on: room before it, nothing left after it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::error::BusError;
use crate::qos::needed_bytes;
use crate::site::RunSite;

/// Where the transport's segments lie on Linux.
const SHARED_MEMORY: &str = "/dev/shm";

/// Whether shared memory has room for a cell of `arms` arms. Without it the
/// first write to a page that is not there ends a process by SIGBUS.
pub fn preflight(arms: u8) -> Result<(), BusError> {
    let path = Path::new(SHARED_MEMORY);
    let free = cell_rt::memory::free_bytes(path).map_err(|source| io_error(path, source))?;
    let needed = needed_bytes(arms);
    if free >= needed {
        return Ok(());
    }
    Err(BusError::NoRoom {
        path: path.to_owned(),
        free,
        needed,
        arms,
    })
}

/// The run's segments in shared memory, sorted.
pub fn segments(site: &RunSite) -> Result<Vec<PathBuf>, BusError> {
    site.check()?;
    let path = Path::new(SHARED_MEMORY);
    let mut found = Vec::new();
    for entry in fs::read_dir(path).map_err(|source| io_error(path, source))? {
        let entry = entry.map_err(|source| io_error(path, source))?;
        if entry
            .file_name()
            .as_encoded_bytes()
            .starts_with(site.prefix.as_bytes())
        {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

/// Deletes all there is of a run: the root with everything in it, and the
/// segments under its prefix. Only when no process of the run is alive.
pub fn wipe(site: &RunSite) -> Result<(), BusError> {
    for segment in segments(site)? {
        gone(fs::remove_file(&segment)).map_err(|source| io_error(&segment, source))?;
    }
    gone(fs::remove_dir_all(&site.root)).map_err(|source| io_error(&site.root, source))
}

/// What is not there need not be deleted.
fn gone(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

fn io_error(path: &Path, source: io::Error) -> BusError {
    BusError::Io {
        path: path.to_owned(),
        source,
    }
}
