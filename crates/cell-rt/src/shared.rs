//! A file mapped into memory that several processes see, as words.

use std::fs::OpenOptions;
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::AtomicU64;

/// Shared memory as 64-bit words. Whatever other process writes to it, reading a word is
/// always defined: all access is atomic.
#[derive(Debug)]
pub struct SharedWords {
    start: NonNull<AtomicU64>,
    words: usize,
}

// SAFETY: the memory is only reached as atomics, which any thread may use; the
// mapping stays until the value is dropped.
unsafe impl Send for SharedWords {}
// SAFETY: as above.
unsafe impl Sync for SharedWords {}

impl SharedWords {
    /// Maps the file at `path` with room for `words` words, creating it (mode
    /// 0600, zeros) or extending it as needed; content that is there stays.
    /// Keep the file on tmpfs, or writes may wait for a disk.
    pub fn open(path: &Path, words: usize) -> io::Result<Self> {
        let bytes = words.checked_mul(8).filter(|bytes| *bytes > 0);
        let bytes = bytes.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(path)?;
        if file.metadata()?.len() < bytes as u64 {
            reserve(&file, bytes)?;
        }
        // SAFETY: a new mapping at an address of the kernel's choice, of a file
        // that is at least `bytes` long.
        let address = unsafe {
            libc::mmap(
                core::ptr::null_mut(),
                bytes,
                libc::PROT_READ | libc::PROT_WRITE,
                libc::MAP_SHARED,
                file.as_raw_fd(),
                0,
            )
        };
        if address == libc::MAP_FAILED {
            return Err(io::Error::last_os_error());
        }
        let start = NonNull::new(address.cast::<AtomicU64>()).ok_or(io::ErrorKind::OutOfMemory)?;
        Ok(Self { start, words })
    }

    /// The words.
    #[inline]
    pub fn words(&self) -> &[AtomicU64] {
        // SAFETY: the mapping is `words` words long, page-aligned, initialised
        // by the kernel, lives as long as `self`, and is only used as atomics.
        unsafe { core::slice::from_raw_parts(self.start.as_ptr(), self.words) }
    }
}

/// Reserves the space now: a write to a page that a full tmpfs cannot supply
/// would end the process by SIGBUS.
fn reserve(file: &std::fs::File, bytes: usize) -> io::Result<()> {
    let length = libc::off_t::try_from(bytes).map_err(|_| io::ErrorKind::InvalidInput)?;
    // SAFETY: the descriptor is open for the whole call.
    match unsafe { libc::posix_fallocate(file.as_raw_fd(), 0, length) } {
        0 => Ok(()),
        code => Err(io::Error::from_raw_os_error(code)),
    }
}

impl Drop for SharedWords {
    fn drop(&mut self) {
        // SAFETY: exactly the mapping that `open` made; no caller can hold a
        // reference into it any more. Unmapping it cannot fail.
        unsafe { libc::munmap(self.start.as_ptr().cast(), self.words * 8) };
    }
}
