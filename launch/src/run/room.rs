//! Whether there is room for a process to start.

use std::path::{Path, PathBuf};

use cell_rt::memory::free_bytes;

/// Where shared memory segments are files.
const SHM: &str = "/dev/shm";
/// Part of the shared memory of a whole cell that one process needs at most: what the
/// process before it had is free again.
const SHARE: u64 = 4;
/// A successor writes its log and its files (bytes).
const RUN_DIR: u64 = 1 << 20;

/// Looks at the file systems a process writes to.
#[derive(Debug)]
pub(super) struct Room {
    needs: [(PathBuf, u64); 2],
}

impl Room {
    /// For processes of a cell of `arms` arms with its run directory at `run_dir`.
    pub(super) fn new(run_dir: &Path, arms: u8) -> Self {
        let shm = cell_bus::needed_bytes(arms) / SHARE;
        Self {
            needs: [(SHM.into(), shm), (run_dir.to_owned(), RUN_DIR)],
        }
    }

    /// What lacks, in words; `None` where a process can start.
    pub(super) fn lack(&self) -> Option<String> {
        let lack = |(path, needed): &(PathBuf, u64)| {
            // What cannot be looked at is no reason to wait.
            let free = free_bytes(path).ok()?;
            let (path, free, needed) = (path.display(), free >> 10, needed >> 10);
            (free < needed)
                .then(|| format!("{path} has {free} KiB free, a start needs {needed} KiB"))
        };
        self.needs.iter().find_map(lack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lacks_is_named() {
        let needs = |needed| Room {
            needs: [(SHM.into(), 0), ("/proc".into(), needed)],
        };
        assert_eq!(needs(0).lack(), None);
        let said = needs(1 << 20).lack().unwrap();
        assert_eq!(said, "/proc has 0 KiB free, a start needs 1024 KiB");
    }
}
