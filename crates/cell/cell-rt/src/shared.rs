//! A file mapped into the memory of several processes, as words.

use std::fs::OpenOptions;
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// Shared memory as 64-bit words. Reading a word is always defined, regardless of other
/// processes that write to it: all access is atomic.
#[derive(Debug)]
pub struct SharedWords {
    start: NonNull<AtomicU64>,
    words: usize,
    /// Keeps the memory of [`Self::of`]; `None` for a mapped file.
    // Beside the address and not in its place: reading a word stays the same for both.
    owner: Option<Arc<[AtomicU64]>>,
}

// SAFETY: the memory is only reached as atomics, which any thread may use; the
// mapping, or the owner, stays until the value is dropped.
unsafe impl Send for SharedWords {}
// SAFETY: as above.
unsafe impl Sync for SharedWords {}

impl SharedWords {
    /// Maps the file at `path` with room for `words` words, creating it (mode 0600, zeros) or
    /// extending it as needed; existing content stays. Keep the file on tmpfs, or writes may
    /// wait for a disk.
    ///
    /// # Errors
    /// Of the file system, and for anything but a regular file: a symbolic link in its place
    /// would let its author choose the file that is written to.
    pub fn open(path: &Path, words: usize) -> io::Result<Self> {
        let bytes = words.checked_mul(8).filter(|bytes| *bytes > 0);
        let bytes = bytes.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            // A device or a pipe must not delay or change anything by being opened.
            .custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK | libc::O_NOCTTY)
            .open(path)
            .map_err(|error| refusal(path, error))?;
        let meta = file.metadata()?;
        // Checked on the open file, not of its path, which could change in between.
        if !meta.is_file() {
            return Err(not_a_file("not a regular file"));
        }
        // Extended before it is mapped: access beyond the end of a file is a SIGBUS.
        if meta.len() < bytes as u64 {
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
        Ok(Self {
            start,
            words,
            owner: None,
        })
    }

    /// The same in the memory of this process: its other owners have the part of other
    /// processes, in a model of them.
    pub fn of(words: Arc<[AtomicU64]>) -> Self {
        Self {
            start: NonNull::from(&*words).cast(),
            words: words.len(),
            owner: Some(words),
        }
    }

    /// The words.
    #[inline]
    pub fn words(&self) -> &[AtomicU64] {
        // SAFETY: the mapping is `words` words long, page-aligned, initialised by the kernel,
        // lives as long as `self`, and is only used as atomics; so is the slice of an owner.
        unsafe { core::slice::from_raw_parts(self.start.as_ptr(), self.words) }
    }
}

/// The error of opening `path`, with a clear text if something else has its place.
fn refusal(path: &Path, error: io::Error) -> io::Error {
    match error.raw_os_error() {
        // ELOOP is also the error for a loop of links further up the path.
        Some(libc::ELOOP) if path.is_symlink() => not_a_file("a symbolic link"),
        Some(libc::EISDIR) => not_a_file("a directory"),
        _ => error,
    }
}

fn not_a_file(kind: &str) -> io::Error {
    let text = format!("it is {kind}, and only a regular file is used here; remove it");
    io::Error::new(io::ErrorKind::InvalidInput, text)
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
        if self.owner.is_some() {
            return;
        }
        // SAFETY: exactly the mapping that `open` made; no caller can hold a
        // reference into it any more. Unmapping it cannot fail.
        unsafe { libc::munmap(self.start.as_ptr().cast(), self.words * 8) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::Ordering;

    #[test]
    fn a_link_or_a_directory_in_the_place_of_the_file_is_refused_by_name() {
        let dir = std::env::temp_dir().join(format!("cell-rt-shared-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let (theirs, link) = (dir.join("theirs"), dir.join("link"));
        std::fs::write(&theirs, "not ours").unwrap();
        std::os::unix::fs::symlink(&theirs, &link).unwrap();
        let said = |path: &Path| SharedWords::open(path, 8).unwrap_err().to_string();
        assert!(said(&link).contains("symbolic link"), "{}", said(&link));
        assert!(said(&dir).contains("directory"), "{}", said(&dir));
        assert_eq!(std::fs::read(&theirs).unwrap(), b"not ours");
        // One that leads nowhere must not create a file there.
        std::fs::remove_file(&theirs).unwrap();
        assert!(said(&link).contains("symbolic link"));
        assert!(!theirs.exists());
        let device = Path::new("/dev/zero");
        assert!(said(device).contains("regular file"), "{}", said(device));
        let words = SharedWords::open(&theirs, 8).unwrap();
        assert_eq!(words.words()[7].load(Ordering::Relaxed), 0);
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
