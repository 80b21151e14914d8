//! What a run that crashed leaves behind, and its removal at the next start.

use std::fs;
use std::io;
use std::path::PathBuf;

use cell_rt::process::{SIGKILL, is_same, kill};
use cell_run::children::ChildId;

use crate::failure::{Context, Failure};
use crate::rundir::{KEPT, RunDir};

/// Where shared memory segments are files.
const SHM: &str = "/dev/shm";

/// Leftovers of earlier runs of one run directory.
#[derive(Debug, Default)]
pub struct Leftovers {
    /// Processes that still run.
    pub processes: Vec<ChildId>,
    /// Segments of shared memory.
    pub segments: Vec<PathBuf>,
    /// Files of a run that did not end.
    pub files: Vec<PathBuf>,
}

impl Leftovers {
    /// Looks. Log files and the run file of a run that ended well are none.
    pub fn find(dir: &RunDir) -> Self {
        let mut processes = ChildId::all(dir.path());
        processes.retain(exists);
        Self {
            processes,
            segments: segments(&dir.family()),
            files: [dir.children(), dir.control()]
                .into_iter()
                .filter(|path| path.exists())
                .collect(),
        }
    }

    /// How many things there are.
    pub fn count(&self) -> usize {
        self.processes.len() + self.segments.len() + self.files.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count() == 0
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

fn exists(id: &ChildId) -> bool {
    // Since that run, the kernel may have given the pid to another program.
    is_same(id.pid, id.started)
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
        if exists(id) {
            // It may end by itself at this very moment.
            kill(id.pid, SIGKILL).ok();
        }
    }
    // 2 s: the kernel may keep a killed process for as long as a device does not answer.
    for _ in 0..400 {
        if !found.processes.iter().any(exists) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    if let Some(id) = found.processes.iter().find(|id| exists(id)) {
        let pid = id.pid;
        return Err(Failure::configuration(format!(
            "process {pid} of an earlier run does not end: kill -9 {pid}"
        )));
    }
    // After the processes, which could create new ones until their end.
    remove_segments(dir)?;
    for entry in fs::read_dir(dir.path())
        .cannot(format!("read {}", dir.path().display()))?
        .flatten()
    {
        if !KEPT.iter().any(|name| entry.file_name() == *name) {
            remove(&entry.path()).cannot(format!("remove {}", entry.path().display()))?;
        }
    }
    if found.is_empty() {
        return Ok(None);
    }
    Ok(Some(format!(
        "removed leftovers of a crashed run in {}: {found}",
        dir.path().display()
    )))
}

/// Removes what a run that ended needs no more; its logs stay for people.
pub(crate) fn tidy(dir: &RunDir, root: &std::path::Path) -> Result<(), Failure> {
    remove_segments(dir)?;
    // Links to its page open nothing any more.
    let files = [
        dir.children(),
        dir.control(),
        dir.record(),
        dir.page(),
        dir.black_boxes(),
    ];
    for path in files.into_iter().chain([root.to_owned()]) {
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

/// Removes a file or a directory; one that does not exist is not an error.
pub(crate) fn remove(path: &std::path::Path) -> io::Result<()> {
    // Not `metadata`: it would take a link without a target for a file that is gone.
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
    fn a_crashed_run_is_removed_but_not_its_lock() {
        let base = tempfile::tempdir().unwrap();
        let dir = RunDir::at(base.path().join("wipe"));
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
        let mut left: Vec<_> = fs::read_dir(dir.path())
            .unwrap()
            .flatten()
            .map(|e| e.file_name())
            .collect();
        left.sort();
        assert_eq!(left, KEPT);
        fs::remove_dir_all(dir.path()).unwrap();
    }
}
