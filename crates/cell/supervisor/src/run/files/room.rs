//! Whether there is room for a process to start, or for a command to join a cell.

use std::path::{Path, PathBuf};

use cell_rt::memory::free_bytes;

/// Where shared memory segments are files.
const SHM: &str = "/dev/shm";
/// Part of the shared memory of a whole cell that one process needs at most: what the
/// process before it had is free again.
const SHARE: u64 = 4;
/// A successor writes its log and its files (bytes).
const RUN_DIR: u64 = 1 << 20;
/// A command that joins a cell (bytes): `top` uses 64 KiB of shared memory, and a request
/// ended by SIGBUS with 64 KiB free and not with 128.
const COMMAND: u64 = 256 << 10;

/// Looks at the file systems a process writes to.
#[derive(Debug)]
pub struct Room {
    needs: [(PathBuf, u64); 2],
    /// Whose needs they are, in words.
    of: &'static str,
}

impl Room {
    /// For processes of a cell of `arms` arms with its run directory at `run_dir`.
    pub(crate) fn new(run_dir: &Path, arms: u8) -> Self {
        let shm = cell_bus::needed_bytes(arms) / SHARE;
        Self {
            needs: [(SHM.into(), shm), (run_dir.to_owned(), RUN_DIR)],
            of: "a start",
        }
    }

    /// For a command that joins the cell with its run directory at `run_dir`.
    pub fn of_command(run_dir: &Path) -> Self {
        Self {
            needs: [(SHM.into(), COMMAND), (run_dir.to_owned(), COMMAND)],
            of: "a command",
        }
    }

    /// What lacks, in words; `None` where there is room.
    pub fn lack(&self) -> Option<String> {
        let lack = |(path, needed): &(PathBuf, u64)| {
            // What cannot be looked at is no reason to wait.
            let free = free_bytes(path).ok()?;
            let (path, free, needed) = (path.display(), free >> 10, needed >> 10);
            let of = self.of;
            (free < needed).then(|| format!("{path} has {free} KiB free, {of} needs {needed} KiB"))
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
            of: "a start",
        };
        assert_eq!(needs(0).lack(), None);
        let said = needs(1 << 20).lack().unwrap();
        assert_eq!(said, "/proc has 0 KiB free, a start needs 1024 KiB");
    }
}
