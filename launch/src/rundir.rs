//! The run directory: where it is, who holds it, what lies in it.
//!
//! `BASE/CELL/` with `lock`, `run.json`, `page.json`, `children.json`,
//! `control.sock`, `record.sock`, `logs/`, `data/` and the bus's root. BASE is `ROBOCELL_RUN_DIR`, or
//! `XDG_RUNTIME_DIR/robocell` where that is in memory, or
//! `/dev/shm/robocell-UID`. Mode 0700.

use std::fs::{self, DirBuilder};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use cell_rt::memory::is_tmpfs;
use cell_rt::process::user_id;

use crate::failure::{Context, Failure};
use crate::lock::{Holder, Lock};

/// Names the base directory of all cells.
pub const ENV_RUN_DIR: &str = "ROBOCELL_RUN_DIR";

/// Start of every prefix of ours in shared memory.
const FAMILY: &str = "rc";

/// The directory the run directories of all cells lie in.
pub fn base() -> PathBuf {
    if let Some(dir) = std::env::var_os(ENV_RUN_DIR).filter(|d| !d.is_empty()) {
        let dir = PathBuf::from(dir);
        return std::path::absolute(&dir).unwrap_or(dir);
    }
    if let Some(dir) = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from)
        && dir.is_absolute()
        && is_tmpfs(&dir).unwrap_or(false)
    {
        return dir.join("robocell");
    }
    PathBuf::from(format!("/dev/shm/robocell-{}", user_id()))
}

/// The run directory of one cell; it need not exist.
#[derive(Clone, Debug)]
pub struct RunDir {
    path: PathBuf,
}

impl RunDir {
    /// The run directory of `cell`.
    pub fn of(cell: &str) -> Self {
        Self {
            path: base().join(cell),
        }
    }

    /// The directory at `path`.
    pub fn at(path: PathBuf) -> Self {
        Self { path }
    }

    /// All that exist, by name.
    pub fn all() -> Vec<(String, Self)> {
        let entries = fs::read_dir(base()).into_iter().flatten().flatten();
        let mut all: Vec<_> = entries
            .filter(|entry| entry.path().join("lock").is_file())
            .filter_map(|entry| {
                Some((
                    entry.file_name().into_string().ok()?,
                    Self::at(entry.path()),
                ))
            })
            .collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file every process reads at its start.
    pub fn spec(&self) -> PathBuf {
        self.path.join(cell_model::runs::spec::RunSpec::FILE)
    }

    /// The built-in cells and robots, for the processes.
    pub fn data(&self) -> PathBuf {
        self.path.join("data")
    }

    /// Where the processes write their words to.
    pub fn logs(&self) -> PathBuf {
        self.path.join("logs")
    }

    /// The log of one process.
    pub fn log(&self, process: &str) -> PathBuf {
        self.logs().join(format!("{process}.log"))
    }

    /// Socket between the launcher and the commands that talk to it.
    pub fn control(&self) -> PathBuf {
        self.path.join("control.sock")
    }

    /// What opens the page.
    pub fn page(&self) -> PathBuf {
        self.path.join("page.json")
    }

    /// Socket between the recorder and the commands that talk to it.
    pub fn record(&self) -> PathBuf {
        self.path.join("record.sock")
    }

    /// Pids of the processes, for the next start after a crash of the launcher.
    pub fn children(&self) -> PathBuf {
        self.path.join("children.json")
    }

    /// Who runs the cell now, if anybody.
    pub fn holder(&self) -> Option<Holder> {
        Lock::holder(&self.path.join("lock"))
    }

    /// Makes the directory, readable by nobody else, and takes its lock.
    pub fn take(&self, cell: &str) -> Result<Lock, Failure> {
        let show = self.path.display();
        let make = |dir: &Path| DirBuilder::new().recursive(true).mode(0o700).create(dir);
        make(&self.path).cannot(format!("make the run directory {show}"))?;
        let meta = fs::metadata(&self.path).cannot(format!("look at the run directory {show}"))?;
        if meta.uid() != user_id() || meta.mode() & 0o077 != 0 {
            return Err(Failure::configuration(format!(
                "the run directory {show} belongs to user {} with mode {:o}; it has to be yours with mode 700: \
                 remove it, or set {ENV_RUN_DIR} to another directory",
                meta.uid(),
                meta.mode() & 0o777
            )));
        }
        match Lock::take(&self.path.join("lock")).cannot(format!("lock {show}"))? {
            Ok(lock) => Ok(lock),
            Err(holder) => Err(Failure::configuration(format!(
                "cell `{cell}` is running already: pid {}, since {}; `robocell down --cell {cell}` stops it, \
                 `robocell top --cell {cell}` shows it, and `--cell OTHER` runs another beside it",
                holder.pid, holder.since
            ))),
        }
    }

    /// Start of the prefix of every run in this directory.
    pub fn family(&self) -> String {
        format!(
            "{FAMILY}{:06x}",
            fold(self.path.as_os_str().as_encoded_bytes(), 24)
        )
    }

    /// The bus's root and prefix of run `run`: fresh for every run, so that a
    /// process of a dead run can neither meet the new one nor delete its files.
    pub fn site(&self, run: u64) -> (PathBuf, String) {
        let tag = fold(&run.to_le_bytes(), 16);
        (
            self.path.join(format!("b{tag:04x}")),
            format!("{}{tag:04x}_", self.family()),
        )
    }
}

/// FNV-1a folded to `bits` bits.
fn fold(bytes: &[u8], bits: u32) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325, step);
    (hash ^ (hash >> 32)) & ((1 << bits) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_and_prefix_leave_room_for_the_socket_names() {
        let dir = RunDir::at(PathBuf::from("/dev/shm/robocell-10000/franka-stack"));
        let (root, prefix) = dir.site(0x1234_5678);
        assert!(
            root.as_os_str().len() + prefix.len() <= 61,
            "{root:?} {prefix}"
        );
        assert!(prefix.starts_with(&dir.family()));
    }

    #[test]
    fn two_runs_of_a_cell_meet_nowhere() {
        let dir = RunDir::at(PathBuf::from("/dev/shm/robocell-0/cell"));
        assert_ne!(dir.site(1), dir.site(2));
        assert_ne!(
            dir.family(),
            RunDir::at(PathBuf::from("/dev/shm/robocell-0/cell2")).family()
        );
    }
}
