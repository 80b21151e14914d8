//! Keeps the logs of a run bounded, on a thread of its own: a file system may wait for a
//! disk.

use std::fs::{self, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use cell_rt::hole;
use cell_rt::priority::{set_fifo, set_other};

use super::{FULL, LIMIT};
use crate::say;

/// Time between two looks. A program that does nothing but print writes 1 MB in it.
const LOOK: Duration = Duration::from_millis(5);
/// Below every process of a cell, so that none is delayed, and above other programs: on a
/// busy machine a thread without it came 100 ms late, and a log had 9 MB by then.
const PRIORITY: i32 = 1;
/// Storage is given back in whole blocks: no file system has larger ones in common use.
const BLOCK: u64 = 64 << 10;

/// Bounds every `*.log` of a directory until it is dropped.
#[derive(Debug)]
pub(crate) struct LogBounds {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl LogBounds {
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

impl Drop for LogBounds {
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

/// Bounds a log that is full, and reports the first time.
fn look(path: &Path, reported: &mut Vec<PathBuf>) {
    let done = bound(path, FULL);
    if matches!(done, Ok(false)) || reported.iter().any(|known| known == path) {
        return;
    }
    reported.push(path.to_owned());
    let name = path.file_stem().unwrap_or_default().display();
    match done {
        Ok(_) => say::warn(format_args!(
            "the log of {name} is long: its newest lines are kept, at most {} MB",
            LIMIT / 1_000_000
        )),
        Err(error) => say::warn(format_args!(
            "the log of {name} is long, and its file system cannot give back its older half \
             ({error}): it is emptied whenever it has {} MB",
            FULL / 1_000_000
        )),
    }
}

/// Gives back the older half of the log at `path` where it occupies more than `full`
/// bytes; whether it did.
///
/// # Errors
/// Of the file system. The log is empty then.
fn bound(path: &Path, full: u64) -> io::Result<bool> {
    let mut options = OpenOptions::new();
    let options = options.read(true).write(true);
    let log = options.custom_flags(libc::O_NOFOLLOW).open(path)?;
    let length = log.metadata()?.len();
    if length - hole::first_data(&log)?.min(length) <= full {
        return Ok(false);
    }
    let end = length - full / 2;
    let released = hole::release(&log, end - end % BLOCK);
    if released.is_err() {
        log.set_len(0)?;
    }
    released.map(|()| true)
}

#[cfg(test)]
mod tests {
    use super::super::{Follower, tail};
    use super::*;
    use std::fs::File;
    use std::io::Write;
    use std::os::unix::fs::MetadataExt;

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

    fn occupied(log: &Log) -> u64 {
        log.path.metadata().unwrap().blocks() * 512
    }

    #[test]
    fn a_log_keeps_its_newest_lines_and_its_writer_writes_on() {
        let mut log = Log::new("log-bound");
        for turn in 0..5 {
            log.write(40_000 * turn, 40_000 * (turn + 1));
            assert!(bound(&log.path, 300_000).unwrap());
            assert!(!bound(&log.path, 300_000).unwrap());
            assert!(occupied(&log) <= 300_000, "{}", occupied(&log));
        }
        log.write(200_000, 200_010);
        let newest = |count: usize| (200_010 - count..200_010).collect::<Vec<_>>();
        assert_eq!(numbers(&tail(&log.path, 150_000)), newest(15_000));
        assert_eq!(numbers(&tail(&log.path, 50)), newest(5));
        let whole = tail(&log.path, 1 << 30);
        assert!(whole.len() > 150_000 && whole.len() < 300_000);
        assert!(!whole.contains('\0'));
        assert_eq!(fs::read_dir(&log.dir).unwrap().count(), 1);
    }

    #[test]
    fn a_reader_that_follows_sees_each_line_once() {
        let mut log = Log::new("log-follower");
        log.write(0, 40_000);
        bound(&log.path, 300_000).unwrap();
        let mut follower = Follower::open(&log.path).unwrap();
        let mut seen = Vec::new();
        for from in [40_000, 50_000, 60_000, 70_000] {
            log.write(from, from + 10_000);
            follower.read(&mut seen).unwrap();
            bound(&log.path, 150_000).unwrap();
            follower.read(&mut seen).unwrap();
        }
        let seen = numbers(&String::from_utf8(seen).unwrap());
        assert_eq!(seen, (seen[0]..80_000).collect::<Vec<_>>());
        assert!(seen[0] < 30_000, "{}", seen[0]);
    }

    #[test]
    fn a_reader_is_told_that_lines_are_missing() {
        let mut log = Log::new("log-missing");
        log.write(0, 20);
        let mut follower = Follower::open(&log.path).unwrap();
        let mut seen = Vec::new();
        follower.read(&mut seen).unwrap();
        log.write(20, 40_000);
        bound(&log.path, 200_000).unwrap();
        follower.read(&mut seen).unwrap();
        let seen = String::from_utf8(seen).unwrap();
        assert!(seen.contains("19\n\n(lines are missing here"), "{seen}");
        assert!(seen.ends_with("39999\n"));
    }
}
