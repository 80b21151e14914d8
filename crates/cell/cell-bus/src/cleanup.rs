//! Space for a run before it starts, and removal of its files after it.
//!
//! Dead nodes are not cleaned up one by one: a process killed in its first milliseconds leaves
//! files that the transport cannot reclaim, and 57 of them made creating a node 5 times as
//! slow. Each run has a root directory and a prefix of its own instead, and both are deleted
//! whole once no process of the run is alive.

use std::fs;
use std::io;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use crate::error::BusError;
use crate::qos::needed_bytes;
use crate::site::RunSite;

/// Directory of the transport's segments on Linux.
const SHARED_MEMORY: &str = "/dev/shm";

/// Whether shared memory has room for a cell of `arms` arms. Without it the
/// first write to a page that is not there ends a process by SIGBUS.
pub fn preflight(arms: u8) -> Result<(), BusError> {
    // Creating services and ports succeeds on a full mount; only the first write fails. So the
    // space has to be checked before.
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
    // An empty prefix would match the segments of every program of the machine.
    site.check()?;
    let path = Path::new(SHARED_MEMORY);
    let mut found = Vec::new();
    for entry in fs::read_dir(path).map_err(|source| io_error(path, source))? {
        let entry = entry.map_err(|source| io_error(path, source))?;
        if entry
            // Segments of all runs are in one directory; the prefix ends with `_`, so none
            // contains another.
            .file_name()
            .as_encoded_bytes()
            .starts_with(site.prefix.as_bytes())
        {
            found.push(entry.path());
        }
    }
    // Sorted, so that tests and messages do not depend on the order of a directory.
    found.sort();
    Ok(found)
}

/// Result of [`remove_half_made`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HalfMade {
    /// Removed.
    pub removed: usize,
    /// Left, because a process has it open: it may be finishing it.
    pub in_use: usize,
}

/// Removes segments of the run whose maker was killed before it finished them. A process that
/// opens one waits for its maker: 1 s where it is unreadable, without limit where its size is 0
/// (iceoryx2-cal 0.10.0, `posix_shared_memory`: the arm `MappingSizeIsZero` does not check the
/// time).
// Called before a start that follows a kill: without it, one file of length 0 hung every later
// start without limit.
pub fn remove_half_made(site: &RunSite) -> Result<HalfMade, BusError> {
    let mut found = segments(site)?;
    found.retain(|path| is_half_made(path));
    if found.is_empty() {
        return Ok(HalfMade::default());
    }
    let count = found.len();
    let mut removed = 0;
    // A file that is open may be completed any moment; removing it would split two processes
    // onto two segments of one name.
    for path in cell_rt::process::unused(found) {
        // Its maker may have finished it, and closed it, since the first look.
        if is_half_made(&path) {
            gone(fs::remove_file(&path)).map_err(|source| io_error(&path, source))?;
        }
        removed += 1;
    }
    Ok(HalfMade {
        removed,
        in_use: count - removed,
    })
}

/// The transport sets the size of a segment after it creates it, and makes it readable after it
/// has filled it.
fn is_half_made(path: &Path) -> bool {
    const OWNER_READ: u32 = 0o400;
    fs::symlink_metadata(path).is_ok_and(|meta| meta.len() == 0 || meta.mode() & OWNER_READ == 0)
}

/// Removes the access of other users to the run's segments: the transport grants it for one of
/// 16 bytes.
pub(crate) fn make_private(site: &RunSite) -> Result<(), BusError> {
    for path in segments(site)? {
        let mode = fs::metadata(&path).map(|meta| meta.mode());
        if mode.is_ok_and(|mode| mode & 0o077 != 0) {
            fs::set_permissions(&path, fs::Permissions::from_mode(0o600))
                .map_err(|source| io_error(&path, source))?;
        }
    }
    Ok(())
}

/// Deletes all files of a run: its root directory and the segments under its prefix. Only when
/// no process of the run is alive: a live one would continue on files without a name.
pub fn wipe(site: &RunSite) -> Result<(), BusError> {
    // Segments first: if the process dies here, the root is
    // still there and names the run to wipe.
    for segment in segments(site)? {
        gone(fs::remove_file(&segment)).map_err(|source| io_error(&segment, source))?;
    }
    gone(fs::remove_dir_all(&site.root)).map_err(|source| io_error(&site.root, source))
}

/// A missing file is as good as a deleted one.
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
