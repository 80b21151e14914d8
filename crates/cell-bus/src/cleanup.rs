//! The ground a run stands on: room before it, nothing left after it.

use std::fs;
use std::io;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
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

/// What [`remove_half_made`] found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HalfMade {
    /// Removed.
    pub removed: usize,
    /// Left, because a process has it open: it may be finishing it.
    pub in_use: usize,
}

/// Removes segments of the run whose maker was killed before it finished them.
/// A process that opens one waits for its maker: 1 s where it is unreadable, without limit where
/// its size is 0 (iceoryx2-cal 0.10.0, `posix_shared_memory`: the arm
/// `MappingSizeIsZero` does not look at the time).
pub fn remove_half_made(site: &RunSite) -> Result<HalfMade, BusError> {
    let mut found = segments(site)?;
    found.retain(|path| is_half_made(path));
    if found.is_empty() {
        return Ok(HalfMade::default());
    }
    let count = found.len();
    let mut removed = 0;
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

/// The transport gives a segment its size after it is created, and the right to be
/// read when it is filled.
fn is_half_made(path: &Path) -> bool {
    const OWNER_READ: u32 = 0o400;
    fs::symlink_metadata(path).is_ok_and(|meta| meta.len() == 0 || meta.mode() & OWNER_READ == 0)
}

/// Takes the run's segments away from other users: the transport gives one of 16 bytes
/// to all.
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
