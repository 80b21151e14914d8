//! Waiting for input with a limit.

use std::io;
use std::os::fd::{AsFd, AsRawFd};
use std::time::Duration;

/// Whether `source` has something to read, or to accept, within `time`.
///
/// # Errors
/// Of poll(2); a signal counts as nothing to read.
pub fn is_readable(source: impl AsFd, time: Duration) -> io::Result<bool> {
    let mut asked = libc::pollfd {
        fd: source.as_fd().as_raw_fd(),
        events: libc::POLLIN,
        revents: 0,
    };
    let ms = libc::c_int::try_from(time.as_millis()).unwrap_or(libc::c_int::MAX);
    // SAFETY: one entry, which lives for the whole call, as does its descriptor.
    let count = unsafe { libc::poll(&raw mut asked, 1, ms) };
    if count >= 0 {
        return Ok(count > 0);
    }
    match io::Error::last_os_error() {
        error if error.kind() == io::ErrorKind::Interrupted => Ok(false),
        error => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::os::unix::net::UnixStream;

    #[test]
    fn what_was_written_is_readable_and_nothing_is_not() {
        let (mut one, other) = UnixStream::pair().unwrap();
        assert!(!is_readable(&other, Duration::ZERO).unwrap());
        one.write_all(b"x").unwrap();
        assert!(is_readable(&other, Duration::from_secs(5)).unwrap());
    }
}
