//! A file lock that ends with its holder, including by `kill -9`.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// An exclusive lock. The kernel releases it when the process dies; children
/// do not inherit it.
#[derive(Debug)]
pub struct Lock {
    file: File,
}

impl Lock {
    /// Takes the lock at `path`, creating the file (mode 0600) if needed. The
    /// content of the file is left as it is. `Ok(None)`: another process has it.
    // No link is followed: its target would be created, and would not be the lock of others.
    // Not truncated: the holder's name is in the file, and a second start has to report it.
    pub fn try_new(path: &Path) -> io::Result<Option<Self>> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .custom_flags(libc::O_NOFOLLOW)
            .open(path)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self { file })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(error)) => Err(error),
        }
    }

    /// The locked file, for the holder's name in it.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_not_followed() {
        let own = std::process::id();
        let link = std::env::temp_dir().join(format!("cell-rt-lock-link-{own}"));
        let target = link.with_extension("target");
        std::os::unix::fs::symlink(&target, &link).unwrap();
        let refused = Lock::try_new(&link);
        std::fs::remove_file(&link).unwrap();
        assert!(refused.is_err() && !target.exists());
    }

    #[test]
    fn the_second_taker_is_told_and_gets_it_after_the_first() {
        let path = std::env::temp_dir().join(format!("cell-rt-lock-{}", std::process::id()));
        let first = Lock::try_new(&path).unwrap();
        assert!(first.is_some());
        assert!(Lock::try_new(&path).unwrap().is_none());
        drop(first);
        assert!(Lock::try_new(&path).unwrap().is_some());
        std::fs::remove_file(path).unwrap();
    }
}
