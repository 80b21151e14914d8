//! What a run that crashed leaves behind, and its removal at the next start.

use std::fs;
use std::io;
use std::path::PathBuf;

use cell_rt::process::{SIGKILL, is_alive, kill, start_time};
use serde::{Deserialize, Serialize};

use crate::failure::{Context, Failure};
use crate::rundir::RunDir;

/// Where shared memory segments are files.
const SHM: &str = "/dev/shm";

/// One process of a run: the pid alone could be somebody else's by now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ChildId {
    pub(crate) pid: u32,
    /// Its start in clock ticks since boot.
    pub(crate) started: u64,
}

impl ChildId {
    /// The process that bears `pid` now.
    pub(crate) fn of(pid: u32) -> Option<Self> {
        Some(Self {
            pid,
            started: start_time(pid)?,
        })
    }

    /// Whether it still exists.
    pub(crate) fn exists(self) -> bool {
        is_alive(self.pid) && start_time(self.pid) == Some(self.started)
    }
}

/// What lies about of earlier runs of one run directory.
#[derive(Debug, Default)]
pub(crate) struct Leftovers {
    pub(crate) processes: Vec<ChildId>,
    pub(crate) segments: Vec<PathBuf>,
    pub(crate) files: Vec<PathBuf>,
}

impl Leftovers {
    /// Looks. Log files and the run file of a run that ended well are none.
    pub(crate) fn find(dir: &RunDir) -> Self {
        let ids = fs::read(dir.children()).ok();
        let ids: Vec<ChildId> = ids
            .and_then(|text| serde_json::from_slice(&text).ok())
            .unwrap_or_default();
        Self {
            processes: ids.into_iter().filter(|id| id.exists()).collect(),
            segments: segments(&dir.family()),
            files: [dir.children(), dir.control()]
                .into_iter()
                .filter(|path| path.exists())
                .collect(),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.processes.is_empty() && self.segments.is_empty() && self.files.is_empty()
    }
}

impl std::fmt::Display for Leftovers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} processes, {} shared memory segments",
            self.processes.len(),
            self.segments.len()
        )
    }
}

/// Shared memory segments whose names start with `prefix`.
pub(crate) fn segments(prefix: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(SHM).into_iter().flatten().flatten();
    let ours = |entry: &fs::DirEntry| {
        entry
            .file_name()
            .as_encoded_bytes()
            .starts_with(prefix.as_bytes())
    };
    entries.filter(ours).map(|entry| entry.path()).collect()
}

/// Removes everything of earlier runs; the lock is held. Says what a crash
/// left behind, if it did.
pub(crate) fn wipe(dir: &RunDir) -> Result<Option<String>, Failure> {
    let found = Leftovers::find(dir);
    for id in &found.processes {
        if id.exists() {
            // It may end by itself at this very moment.
            kill(id.pid, SIGKILL).ok();
        }
    }
    for _ in 0..400 {
        if !found.processes.iter().any(|id| id.exists()) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    if let Some(id) = found.processes.iter().find(|id| id.exists()) {
        let pid = id.pid;
        return Err(Failure::configuration(format!(
            "process {pid} of an earlier run does not end: kill -9 {pid}"
        )));
    }
    remove_segments(dir)?;
    for entry in fs::read_dir(dir.path())
        .cannot(format!("read {}", dir.path().display()))?
        .flatten()
    {
        if entry.file_name() != "lock" {
            remove(&entry.path()).cannot(format!("remove {}", entry.path().display()))?;
        }
    }
    if found.is_empty() {
        return Ok(None);
    }
    Ok(Some(format!(
        "removed what a run that crashed had left in {}: {found}",
        dir.path().display()
    )))
}

/// Removes what a run that ended needs no more; its logs stay for people.
pub(crate) fn tidy(dir: &RunDir, root: &std::path::Path) -> Result<(), Failure> {
    remove_segments(dir)?;
    for path in [root.to_owned(), dir.children(), dir.control()] {
        remove(&path).cannot(format!("remove {}", path.display()))?;
    }
    Ok(())
}

/// Removes what a process or a client of an earlier run of `dir` wrote after it
/// was wiped, in its last moment; nothing of the run with `prefix`.
pub(crate) fn sweep(dir: &RunDir, prefix: &str) {
    let late = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default();
        !name.as_encoded_bytes().starts_with(prefix.as_bytes())
    };
    for path in segments(&dir.family()).into_iter().filter(late) {
        // Its writer may take it away at this moment; the next start looks again.
        remove(&path).ok();
    }
}

fn remove_segments(dir: &RunDir) -> Result<(), Failure> {
    for path in segments(&dir.family()) {
        remove(&path).cannot(format!("remove {}", path.display()))?;
    }
    Ok(())
}

/// Removes a file or a directory; what is gone already is fine.
fn remove(path: &std::path::Path) -> io::Result<()> {
    let result = match fs::symlink_metadata(path) {
        Ok(meta) if meta.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(error) => Err(error),
    };
    match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pid_alone_is_not_an_identity() {
        let me = ChildId::of(std::process::id()).unwrap();
        assert!(me.exists());
        assert!(
            !ChildId {
                started: me.started + 1,
                ..me
            }
            .exists()
        );
    }

    #[test]
    fn a_crashed_run_is_removed_but_not_its_lock() {
        let dir =
            RunDir::at(std::env::temp_dir().join(format!("robocell-wipe-{}", std::process::id())));
        let _lock = dir.take("wipe").unwrap();
        assert_eq!(wipe(&dir).unwrap(), None);
        let segment = PathBuf::from(SHM).join(format!("{}beef_segment", dir.family()));
        fs::write(&segment, "x").unwrap();
        fs::create_dir_all(dir.path().join("bbeef/nodes")).unwrap();
        sweep(&dir, &format!("{}beef_", dir.family()));
        assert!(segment.exists(), "of this run");
        sweep(&dir, &format!("{}cafe_", dir.family()));
        assert!(!segment.exists(), "of an earlier one");
        fs::write(&segment, "x").unwrap();
        fs::write(dir.children(), "[]").unwrap();
        assert!(
            wipe(&dir)
                .unwrap()
                .unwrap()
                .contains("1 shared memory segments")
        );
        assert!(!segment.exists());
        let left: Vec<_> = fs::read_dir(dir.path())
            .unwrap()
            .flatten()
            .map(|e| e.file_name())
            .collect();
        assert_eq!(left, ["lock"]);
        fs::remove_dir_all(dir.path()).unwrap();
    }
}
