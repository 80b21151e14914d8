//! Starts, signals and reaps the processes of a cell.
//!
//! A child asks the kernel to end it when the thread that started it dies, so
//! everything here is called from the launcher's main thread only.

use std::fs::{File, OpenOptions};
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::Duration;

use cell_rt::process::{SIGCONT, SIGKILL, SIGTERM, kill, start_time};
use cell_run::children::ChildId;
use cell_run::python;
use cell_run::spec::RunSpec;
use ipc_types::topic::Process;

use crate::process_log;
use crate::programs::Programs;
use crate::rundir::RunDir;
use crate::supervision::Exit;

/// `command` with nothing of our environment but what a process may use.
pub(crate) fn clean(command: &mut Command) {
    command.env_clear();
    let keep = |key: &str| key == "PATH" || key == "RUST_BACKTRACE" || key.starts_with("ROBOCELL_");
    for (key, value) in std::env::vars_os() {
        if key.to_str().is_some_and(keep) {
            command.env(key, value);
        }
    }
    if let Some(cache) = cache_dir() {
        command.env(ENV_CACHE_DIR, cache);
    }
}

/// Names the directory of fetched files.
pub const ENV_CACHE_DIR: &str = "ROBOCELL_CACHE_DIR";

/// Where `assets fetch` keeps its files. That program derives the directory from the
/// environment, which the processes do not get, so it is passed to them.
pub fn cache_dir() -> Option<PathBuf> {
    cell_rt::user_dir(
        |name| std::env::var_os(name),
        ENV_CACHE_DIR,
        "XDG_CACHE_HOME",
        ".cache",
    )
}

/// How long a killed process may take to end.
const END_LIMIT: Duration = Duration::from_secs(2);
/// Time between two looks whether it has.
const END_PAUSE: Duration = Duration::from_millis(1);

/// The run file as a process opens it: its standard input, so that the path has no effect.
const SPEC: &str = "/proc/self/fd/0";

#[derive(Debug)]
struct Running {
    process: Process,
    generation: u32,
    id: Option<ChildId>,
    child: Child,
}

/// The processes of one cell.
#[derive(Debug)]
pub(crate) struct Children {
    dir: RunDir,
    /// Of the run directory: files in it are opened by it, so that they are those of the
    /// directory that was checked, whatever its path leads to later.
    handle: File,
    programs: Programs,
    running: Vec<Running>,
}

impl Children {
    pub(crate) fn new(dir: RunDir, programs: Programs) -> std::io::Result<Self> {
        let mut options = OpenOptions::new();
        let options = options.read(true);
        let options = options.custom_flags(libc::O_DIRECTORY | libc::O_NOFOLLOW);
        Ok(Self {
            handle: options.open(dir.path())?,
            dir,
            programs,
            running: Vec::new(),
        })
    }

    /// The run file, opened.
    fn spec(&self) -> std::io::Result<File> {
        let handle = self.handle.as_raw_fd();
        let path = format!("/proc/self/fd/{handle}/{}", RunSpec::FILE);
        let mut options = OpenOptions::new();
        let options = options.read(true).custom_flags(libc::O_NOFOLLOW);
        options.open(path)
    }

    /// Starts `process` as its start number `generation`.
    pub(crate) fn spawn(&mut self, process: Process, generation: u32) -> Result<(), String> {
        let path = self.programs.path(process);
        let path = path.map_err(|failure| failure.to_string())?;
        let log =
            append(&self.dir.log(&process.name())).map_err(|error| format!("its log: {error}"))?;
        let log_too = log
            .try_clone()
            .map_err(|error| format!("its log: {error}"))?;
        let mut command = python::command(&path);
        let spec = self
            .spec()
            .map_err(|error| format!("its run file: {error}"))?;
        command.args(["--spec", SPEC]);
        command.args(["--generation", &generation.to_string()]);
        if let Process::Controller(arm) = process {
            command.args(["--arm", &arm.to_string()]);
        }
        // A program of the user gets all of the user's environment.
        if self.programs.own(process).is_none() {
            clean(&mut command);
        }
        // Its own process group: Ctrl-C in a terminal is for the launcher.
        command
            .current_dir("/")
            .stdin(spec)
            .stdout(log)
            .stderr(log_too)
            .process_group(0);
        let child = command
            .spawn()
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let pid = child.id();
        let id = start_time(pid).map(|started| ChildId { pid, started });
        self.running.push(Running {
            process,
            generation,
            id,
            child,
        });
        self.write_down();
        Ok(())
    }

    /// Process id of `process`, while it runs.
    pub(crate) fn pid(&self, process: Process) -> Option<u32> {
        self.running
            .iter()
            .rev()
            .find(|r| r.process == process)
            .map(|r| r.child.id())
    }

    /// Asks `process` to end.
    pub(crate) fn terminate(&self, process: Process) {
        self.signal(process, SIGTERM);
        // A stopped one has to run to hear it.
        self.signal(process, SIGCONT);
    }

    /// Ends `process`.
    pub(crate) fn kill(&self, process: Process) {
        self.signal(process, SIGKILL);
    }

    /// Sends `signal`. The pid is ours until the child is reaped, so no one
    /// else is hit.
    pub(crate) fn signal(&self, process: Process, signal: i32) {
        if let Some(pid) = self.pid(process) {
            // It may have ended on its own a moment ago.
            kill(pid, signal).ok();
        }
    }

    /// Those that ended since the last call.
    pub(crate) fn reap(&mut self) -> Vec<(Process, u32, Exit)> {
        let mut ended = Vec::new();
        self.running
            .retain_mut(|running| match running.child.try_wait() {
                Ok(None) => true,
                Ok(Some(status)) => {
                    let exit = status
                        .signal()
                        .map_or_else(|| Exit::Code(status.code().unwrap_or(-1)), Exit::Signal);
                    ended.push((running.process, running.generation, exit));
                    false
                }
                Err(_) => {
                    ended.push((running.process, running.generation, Exit::Code(-1)));
                    false
                }
            });
        if !ended.is_empty() {
            self.write_down();
        }
        ended
    }

    /// For the next start, should the launcher not live to clean up itself.
    fn write_down(&self) {
        let ids: Vec<ChildId> = self.running.iter().filter_map(|r| r.id).collect();
        if let Ok(text) = serde_json::to_string(&ids) {
            // A full run directory must not end a run, so an error is ignored.
            std::fs::write(self.dir.children(), text).ok();
        }
    }
}

impl Drop for Children {
    fn drop(&mut self) {
        for running in &mut self.running {
            running.child.kill().ok();
        }
        // The kernel may keep one for as long as a device does not answer.
        for _ in 0..END_LIMIT.as_millis() / END_PAUSE.as_millis() {
            self.running
                .retain_mut(|running| matches!(running.child.try_wait(), Ok(None)));
            if self.running.is_empty() {
                return;
            }
            std::thread::sleep(END_PAUSE);
        }
    }
}

fn append(path: &Path) -> std::io::Result<File> {
    OpenOptions::new()
        .append(true)
        .create(true)
        .mode(0o600)
        .open(path)
}

/// The last `count` lines of a log; of a program that panicked, the message without the
/// backtrace.
pub(crate) fn last_words(path: &Path, count: usize) -> Vec<String> {
    // A backtrace follows the message of a panic, which is then far above the last lines.
    words_of(last_lines(path, 20 * count), count)
}

fn words_of(mut lines: Vec<String>, count: usize) -> Vec<String> {
    if let Some(panic) = lines
        .iter()
        // Newer standard libraries write the id of the thread, in parentheses, after its name.
        .rposition(|line| line.contains("' panicked at ") || line.contains(") panicked at "))
    {
        let after = lines.iter().skip(panic);
        let end = after.clone().position(|line| line == "stack backtrace:");
        let until = panic + end.unwrap_or_else(|| after.count());
        lines.truncate(until);
        lines.drain(..panic);
        lines.truncate(count);
    }
    lines.drain(..lines.len().saturating_sub(count));
    lines
}

/// The last `count` lines of a log.
fn last_lines(path: &Path, count: usize) -> Vec<String> {
    let text = process_log::tail(path, 16 << 10);
    let lines: Vec<_> = text.lines().map(str::to_owned).collect();
    lines[lines.len().saturating_sub(count)..].to_vec()
}

#[cfg(test)]
mod tests {
    #[test]
    fn of_a_panic_the_message_counts_and_not_the_backtrace() {
        let words = |text: &str| super::words_of(text.lines().map(str::to_owned).collect(), 3);
        let panic = "began\nthread 'main' (7) panicked at src/main.rs:3:1:\nno cube\n\
                     stack backtrace:\n 0: a\n 1: b\n 2: c";
        assert_eq!(words(panic)[1..], ["no cube"]);
        assert_eq!(words("a\nb\nc\nd"), ["b", "c", "d"]);
    }
}
