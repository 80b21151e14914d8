//! The run directory: its place, the process that holds it, and its files.
//!
//! `BASE/CELL/` with `.robocell` (says that it is ours), `lock`, `run.json`, `record.json`, `page.json`,
//! `children.json`, `control.sock`, `record.sock`, `logs/`,
//! `blackbox/`, `data/` and the bus's root. BASE is `ROBOCELL_RUN_DIR`, or
//! `XDG_RUNTIME_DIR/robocell` where that is in memory, or
//! `/dev/shm/robocell-UID`. Mode 0700. BASE and `BASE/CELL` are checked before anything in them
//! is read or connected to: files in them say which programs are started.

mod base;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use cell_run::children::ChildId;
use cell_run::record::RecordReport;
use cell_run::spec::PageSecrets;

use crate::failure::{Context, Failure};
use crate::lock::{Holder, Lock};

pub use base::{checked_base, shared_locks};

/// Names the base directory of all cells.
pub const ENV_RUN_DIR: &str = "ROBOCELL_RUN_DIR";

/// Name of a cell when nothing else is said.
pub const DEFAULT_CELL: &str = "cell";

/// The file that marks a run directory: everything beside it may be deleted.
const MARKER: &str = ".robocell";
/// Content of the marker.
// An interface: a run directory of another build has the same text, and one with any other
// text is refused.
const MARKED: &str =
    "A run directory of robocell; the next run of this cell deletes what is in it.\n";
/// What a run directory holds before it is marked, and keeps when it is emptied.
pub(crate) const KEPT: [&str; 2] = [MARKER, "lock"];

/// A link to the recording that is replayed.
const RECORDING: &str = "recording";

/// Start of every prefix of ours in shared memory.
const FAMILY: &str = "rc";

/// The run directory of one cell; it need not exist.
#[derive(Clone, Debug)]
pub struct RunDir {
    path: PathBuf,
}

impl RunDir {
    /// The run directory of `cell`.
    ///
    /// # Errors
    /// Where another user can change it, or the directory above it.
    pub fn of(cell: &str) -> Result<Self, Failure> {
        let path = checked_base()?.join(cell);
        base::check_run_dir(&path)?;
        Ok(Self { path })
    }

    /// The directory at `path`.
    pub fn at(path: PathBuf) -> Self {
        Self { path }
    }

    /// All that exist, by name.
    ///
    /// # Errors
    /// Where another user can change the directory above them.
    pub fn all() -> Result<Vec<(String, Self)>, Failure> {
        let entries = fs::read_dir(checked_base()?)
            .into_iter()
            .flatten()
            .flatten();
        let mut all: Vec<_> = entries
            .filter(|entry| base::check_run_dir(&entry.path()).is_ok())
            .filter(|entry| entry.path().join("lock").is_file())
            .filter_map(|entry| {
                Some((
                    entry.file_name().into_string().ok()?,
                    Self::at(entry.path()),
                ))
            })
            .collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(all)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file every process reads at its start.
    pub fn spec(&self) -> PathBuf {
        self.path.join(cell_run::spec::RunSpec::FILE)
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

    /// The rings of the last cycles of each process.
    pub fn black_boxes(&self) -> PathBuf {
        self.path.join("blackbox")
    }

    /// The recording that is replayed; none in a cell.
    pub fn recording(&self) -> Option<PathBuf> {
        fs::read_link(self.path.join(RECORDING)).ok()
    }

    /// Notes that `file` is replayed.
    pub fn set_recording(&self, file: &Path) -> io::Result<()> {
        std::os::unix::fs::symlink(file, self.path.join(RECORDING))
    }

    /// Socket between the launcher and the commands that talk to it.
    pub fn control(&self) -> PathBuf {
        self.path.join("control.sock")
    }

    /// What opens the page.
    pub fn page(&self) -> PathBuf {
        self.path.join("page.json")
    }

    /// Writes down what opens the page, in the directory, which is there now.
    pub fn save_page(&self, secrets: &PageSecrets) -> Result<(), Failure> {
        let path = self.page();
        let written = secrets.save(&path);
        written.cannot(format_args!("write {}", path.display()))
    }

    /// Socket between the recorder and the commands that talk to it.
    pub fn record(&self) -> PathBuf {
        self.path.join("record.sock")
    }

    /// The report of the recorder.
    pub fn record_report(&self) -> Option<RecordReport> {
        RecordReport::load(&self.path)
    }

    /// Pids of the processes, for the next start after a crash of the launcher.
    pub fn children(&self) -> PathBuf {
        ChildId::path(&self.path)
    }

    /// The launcher that runs the cell now, if one does.
    pub fn holder(&self) -> Option<Holder> {
        Lock::holder(&self.path.join("lock")).ok().flatten()
    }

    /// The launcher that runs `cell`, whose directory this is.
    ///
    /// # Errors
    /// Where no launcher does, or the directory may not be read.
    pub fn running(&self, cell: &str) -> Result<Holder, Failure> {
        let holder = Lock::holder(&self.path.join("lock"));
        let what = format!("tell whether cell `{cell}` runs: {}", self.path.display());
        holder
            .cannot(what)?
            .ok_or_else(|| Failure::not_running(cell))
    }

    /// Makes the directory, readable by this user alone; whether it was not there before.
    ///
    /// # Errors
    /// Where it cannot be made, or another user can change it or the directory above it.
    pub fn make(&self) -> Result<bool, Failure> {
        base::make_base(self.path.parent().unwrap_or(Path::new("/")))?;
        let made = base::make_private(&self.path, false);
        let made = made.cannot(format!("make the run directory {}", self.path.display()))?;
        base::check_run_dir(&self.path)?;
        Ok(made)
    }

    /// Makes the directory and takes its lock. A directory of that name that is not ours is
    /// refused, as it would be emptied.
    pub fn take(&self, cell: &str) -> Result<Lock, Failure> {
        let show = self.path.display();
        if !self.make()? {
            self.check_ours()?;
        }
        match Lock::take(&self.path.join("lock")).cannot(format!("lock {show}"))? {
            Ok(lock) => {
                // A second start may be reading a marker that is there: it is never rewritten.
                if !self.is_marked() {
                    fs::write(self.path.join(MARKER), MARKED).cannot(format!("write to {show}"))?;
                }
                Ok(lock)
            }
            Err(holder) => Err(Failure::configuration(format!(
                "cell `{cell}` is running already: pid {}, since {}; `robocell down --cell {cell}` stops it, \
                 `robocell top --cell {cell}` shows it, and `--cell OTHER` runs another beside it",
                holder.pid, holder.since
            ))),
        }
    }

    /// Whether a directory that exists was made for us.
    fn check_ours(&self) -> Result<(), Failure> {
        let show = self.path.display();
        // The marker is read again last: a start that won meanwhile has written it before
        // anything else.
        if self.is_marked() || self.is_unused().cannot(format!("read {show}"))? || self.is_marked()
        {
            return Ok(());
        }
        Err(Failure::configuration(format!(
            "{show} is not a run directory of robocell: it has no file `{MARKER}` of ours; a run would delete \
             its content: remove it, choose another name with `--cell`, or set {ENV_RUN_DIR} to another \
             directory"
        )))
    }

    fn is_marked(&self) -> bool {
        let marker = self.path.join(MARKER);
        let is_file = fs::symlink_metadata(&marker).is_ok_and(|meta| meta.is_file());
        is_file && fs::read(marker).is_ok_and(|text| text == MARKED.as_bytes())
    }

    /// Whether a run that was killed can have left it before it marked it.
    fn is_unused(&self) -> io::Result<bool> {
        for entry in fs::read_dir(&self.path)? {
            if !KEPT
                .iter()
                .any(|name| entry.as_ref().is_ok_and(|e| e.file_name() == *name))
            {
                return Ok(false);
            }
        }
        Ok(true)
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
// Not `DefaultHasher`, which may change: another build finds the leftovers of this one by the
// same prefix.
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
    fn a_directory_that_is_not_ours_is_refused_and_stays_as_it_is() {
        let base = tempfile::tempdir().unwrap();
        let base = base.path();
        let dir = RunDir::at(base.join("cell"));
        drop(dir.take("cell").unwrap());
        drop(dir.take("cell").unwrap());
        fs::remove_file(dir.path().join(MARKER)).unwrap();
        drop(dir.take("cell").unwrap());
        // Ours, but without a marker and with something in it: not ours any more.
        fs::remove_file(dir.path().join(MARKER)).unwrap();
        fs::write(dir.path().join("thesis.tex"), "x").unwrap();
        let said = dir.take("cell").unwrap_err().message;
        assert!(
            said.contains(".robocell") && said.contains("--cell"),
            "{said}"
        );
        let of_another_build =
            "A run directory of robocell; the next run of this cell deletes what is in it.\n";
        let elsewhere = RunDir::at(base.join("elsewhere"));
        drop(elsewhere.take("elsewhere").unwrap());
        fs::write(elsewhere.path().join(MARKER), of_another_build).unwrap();
        fs::write(elsewhere.path().join("run.json"), "x").unwrap();
        drop(elsewhere.take("elsewhere").unwrap());
        fs::write(dir.path().join(MARKER), "something else").unwrap();
        dir.take("cell").unwrap_err();
        assert!(dir.path().join("thesis.tex").exists());
        let link = RunDir::at(base.join("link"));
        std::os::unix::fs::symlink(dir.path(), link.path()).unwrap();
        let said = link.take("link").unwrap_err().message;
        assert!(said.contains("symbolic link"), "{said}");
    }

    #[test]
    fn starts_beside_a_running_cell_are_told_that_it_runs() {
        let base = tempfile::tempdir().unwrap();
        let dir = RunDir::at(base.path().join("cell"));
        let held = dir.take("cell").unwrap();
        fs::write(dir.path().join("run.json"), "{}").unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..500 {
                        let said = dir.take("cell").unwrap_err().message;
                        assert!(said.contains("is running already"), "{said}");
                    }
                });
            }
        });
        drop(held);
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
