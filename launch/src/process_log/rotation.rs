//! Keeps the logs of a run bounded, on a thread of its own: the copy may wait for a disk.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use cell_rt::priority::{set_fifo, set_other};

use super::{LIMIT, PART, older};
use crate::say;

/// Time between two looks. A program that does nothing but print writes 1 MB in it.
const LOOK: Duration = Duration::from_millis(5);
/// Below every process of a cell, so that a copy delays none, and above other programs:
/// on a busy machine a thread without it came 100 ms late, and a log had 9 MB by then.
const PRIORITY: i32 = 1;
/// A process that writes while its log is copied is waited for so often.
const COPIES: usize = 8;

/// Bounds every `*.log` of a directory until it is dropped.
#[derive(Debug)]
pub(crate) struct LogRotation {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl LogRotation {
    /// Of the logs in `dir`, which exists.
    pub(crate) fn start(dir: PathBuf) -> Self {
        let (end, ended) = channel();
        let work = move || {
            if set_fifo(PRIORITY).is_err() {
                set_other().ok();
            }
            let mut reported = Vec::new();
            while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                for path in logs(&dir) {
                    look(&path, &mut reported);
                }
            }
        };
        let thread = std::thread::Builder::new().name("logs".to_owned());
        let thread = thread.spawn(work);
        if let Err(error) = &thread {
            say::warn(format_args!("the logs are not bounded: {error}"));
        }
        Self {
            end: Some(end),
            thread: thread.ok(),
        }
    }
}

impl Drop for LogRotation {
    fn drop(&mut self) {
        self.end = None;
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

fn logs(dir: &Path) -> impl Iterator<Item = PathBuf> {
    let entries = fs::read_dir(dir).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    paths.filter(|path| path.extension().is_some_and(|end| end == "log"))
}

/// Rotates a log that is full, and reports the first time.
fn look(path: &Path, reported: &mut Vec<PathBuf>) {
    let done = rotate(path, PART);
    if matches!(done, Ok(false)) || reported.iter().any(|known| known == path) {
        return;
    }
    reported.push(path.to_owned());
    let name = path.file_stem().unwrap_or_default().display();
    let (old, limit) = (older(path), LIMIT / 1_000_000);
    match done {
        Ok(_) => say::warn(format_args!(
            "the log of {name} is long: of at most {limit} MB the newest lines are kept, the older \
             of them in {}",
            old.display()
        )),
        Err(error) => say::warn(format_args!(
            "the log of {name} is long, and its older lines cannot be kept: {}: {error}",
            old.display()
        )),
    }
}

/// Moves what is in the log at `path` to its older part where it is longer than `part`;
/// whether it did.
///
/// # Errors
/// Of the file system. The log keeps its lines then, until it is twice as long.
fn rotate(path: &Path, part: u64) -> io::Result<bool> {
    let mut options = OpenOptions::new();
    let options = options.read(true).write(true);
    let mut log = options.custom_flags(libc::O_NOFOLLOW).open(path)?;
    if log.metadata()?.len() <= part {
        return Ok(false);
    }
    let kept = keep(&mut log, path);
    if kept.is_ok() || log.metadata()?.len() > 2 * part {
        log.set_len(0)?;
    }
    kept.map(|()| true)
}

fn keep(log: &mut File, path: &Path) -> io::Result<()> {
    let old = older(path);
    let mut draft_name = old.clone().into_os_string();
    draft_name.push(".draft");
    let draft_path = PathBuf::from(draft_name);
    // First, so that there are never three parts.
    fs::remove_file(&old).ok();
    fs::remove_file(&draft_path).ok();
    let mut copied = || -> io::Result<()> {
        let mut options = OpenOptions::new();
        let mut draft = options
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(&draft_path)?;
        let mut bytes = io::copy(log, &mut draft)?;
        // A follower takes the new older part as the sign of a rotation: it has to be there
        // before the log is short.
        fs::rename(&draft_path, &old)?;
        for _ in 0..COPIES {
            if log.metadata()?.len() <= bytes {
                break;
            }
            bytes += io::copy(log, &mut draft)?;
        }
        Ok(())
    };
    copied().inspect_err(|_| {
        fs::remove_file(&draft_path).ok();
    })
}

#[cfg(test)]
mod tests {
    use super::super::{Follower, tail};
    use super::*;
    use std::io::Write;

    /// A log in a directory of its own, written to as a process does.
    struct Log {
        dir: PathBuf,
        path: PathBuf,
        out: File,
    }

    impl Log {
        fn new(name: &str) -> Self {
            let dir = std::env::temp_dir().join(format!("robocell-{name}-{}", std::process::id()));
            fs::create_dir_all(&dir).unwrap();
            let path = dir.join("task.log");
            let out = OpenOptions::new().append(true).create(true).open(&path);
            Self {
                dir,
                out: out.unwrap(),
                path,
            }
        }

        /// The lines `from..to`, ten bytes each.
        fn write(&mut self, from: usize, to: usize) {
            (from..to).for_each(|n| writeln!(self.out, "{n:9}").unwrap());
        }
    }

    impl Drop for Log {
        fn drop(&mut self) {
            fs::remove_dir_all(&self.dir).unwrap();
        }
    }

    fn numbers(text: &str) -> Vec<usize> {
        text.lines().map(|l| l.trim().parse().unwrap()).collect()
    }

    #[test]
    fn a_log_keeps_its_newest_lines_in_two_parts_and_its_writer_writes_on() {
        let mut log = Log::new("log-rotation");
        for turn in 0..5 {
            log.write(20 * turn, 20 * (turn + 1));
            assert!(rotate(&log.path, 150).unwrap());
            assert!(!rotate(&log.path, 150).unwrap());
        }
        log.write(100, 110);
        assert!(!rotate(&log.path, 150).unwrap());
        assert_eq!(
            numbers(&tail(&log.path, 1000)),
            (80..110).collect::<Vec<_>>()
        );
        assert_eq!(
            numbers(&tail(&log.path, 150)),
            (95..110).collect::<Vec<_>>()
        );
        assert_eq!(
            numbers(&tail(&log.path, 50)),
            (105..110).collect::<Vec<_>>()
        );
        assert_eq!(fs::read_dir(&log.dir).unwrap().count(), 2);
    }

    #[test]
    fn a_reader_that_follows_sees_each_line_once_over_a_rotation() {
        let mut log = Log::new("log-follower");
        log.write(0, 20);
        rotate(&log.path, 150).unwrap();
        log.write(20, 25);
        let mut follower = Follower::open(&log.path).unwrap();
        let mut seen = Vec::new();
        follower.read(&mut seen).unwrap();
        log.write(25, 40);
        rotate(&log.path, 150).unwrap();
        log.write(40, 41);
        follower.read(&mut seen).unwrap();
        // As long as before when the reader looks again.
        rotate(&log.path, 5).unwrap();
        log.write(41, 60);
        follower.read(&mut seen).unwrap();
        follower.read(&mut seen).unwrap();
        let seen = String::from_utf8(seen).unwrap();
        assert_eq!(numbers(&seen), (0..60).collect::<Vec<_>>());
    }

    #[test]
    fn a_reader_is_told_that_lines_are_missing() {
        let mut log = Log::new("log-missing");
        log.write(0, 20);
        let mut follower = Follower::open(&log.path).unwrap();
        let mut seen = Vec::new();
        follower.read(&mut seen).unwrap();
        rotate(&log.path, 50).unwrap();
        log.write(20, 26);
        rotate(&log.path, 50).unwrap();
        log.write(26, 27);
        follower.read(&mut seen).unwrap();
        let seen = String::from_utf8(seen).unwrap();
        assert!(seen.contains("19\n(lines are missing here"), "{seen}");
        assert!(seen.ends_with("26\n"), "{seen}");
    }

    #[test]
    fn a_log_that_cannot_be_kept_is_bounded_all_the_same() {
        let mut log = Log::new("log-full");
        // In the place of the older part, and not removable as a file.
        fs::create_dir_all(older(&log.path)).unwrap();
        log.write(0, 20);
        rotate(&log.path, 150).unwrap_err();
        assert_eq!(log.path.metadata().unwrap().len(), 200);
        log.write(20, 40);
        rotate(&log.path, 150).unwrap_err();
        assert_eq!(log.path.metadata().unwrap().len(), 0);
    }
}
