//! Releases the storage at the start of a file while another process appends to it. The offsets
//! of the rest do not change, so neither writer nor readers need to know.

use std::fs::File;
use std::io;
use std::os::fd::AsRawFd;

/// Releases the storage of the first `bytes` (a hole); they read as zeros afterwards.
///
/// # Errors
/// Where the file system cannot do it, or `file` was not opened for writing.
pub fn release(file: &File, bytes: u64) -> io::Result<()> {
    let mode = libc::FALLOC_FL_PUNCH_HOLE | libc::FALLOC_FL_KEEP_SIZE;
    let bytes = i64::try_from(bytes).map_err(io::Error::other)?;
    // SAFETY: numbers only; the descriptor is open for the whole call.
    match unsafe { libc::fallocate(file.as_raw_fd(), mode, 0, bytes) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// Offset of the first byte of data (bytes); the length of a file without data. Moves the
/// read position of the file.
///
/// # Errors
/// Of the operating system.
pub fn first_data(file: &File) -> io::Result<u64> {
    // SAFETY: numbers only; the descriptor is open for the whole call.
    let found = unsafe { libc::lseek(file.as_raw_fd(), 0, libc::SEEK_DATA) };
    if let Ok(place) = u64::try_from(found) {
        return Ok(place);
    }
    let error = io::Error::last_os_error();
    match error.raw_os_error() {
        // Only holes: all of it was released.
        Some(libc::ENXIO) => Ok(file.metadata()?.len()),
        // A file system without holes.
        Some(libc::EINVAL) => Ok(0),
        _ => Err(error),
    }
}
