//! One run of the `robocell` program to its end.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Everything that waits gives up after this: a hang is a failed test, not a
/// stuck one. No bound on speed.
pub const WATCHDOG: Duration = Duration::from_secs(240);

/// The built program `name`, in the target folder of this test.
///
/// # Panics
/// Where it was not built.
pub fn built(name: &str) -> PathBuf {
    let own = std::env::current_exe().expect("a test knows its own path");
    // target/PROFILE/deps/TEST
    let folder = own
        .parent()
        .and_then(Path::parent)
        .expect("a test lies in deps");
    let path = folder.join(name);
    assert!(
        path.is_file(),
        "{} is missing: cargo build --workspace --bins",
        path.display()
    );
    path
}

/// What a program that ended has said.
#[derive(Clone, Debug)]
pub struct Said {
    /// Exit code; -1 when a signal ended it.
    pub code: i32,
    /// Everything on stdout.
    pub stdout: String,
    /// Everything on stderr.
    pub stderr: String,
}

impl Said {
    /// The JSON object on the last line of stdout.
    ///
    /// # Panics
    /// Where there is none.
    pub fn json(&self) -> serde_json::Value {
        let line = self.stdout.lines().last().unwrap_or_default();
        serde_json::from_str(line)
            .unwrap_or_else(|error| panic!("no JSON at the end: {error}: {self:?}"))
    }
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

/// `robocell` with the run directories of its cells in `base`.
pub fn robocell(base: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(built("robocell"));
    command
        .args(arguments)
        .env("ROBOCELL_RUN_DIR", base)
        .stdin(Stdio::null());
    command
}

/// Runs `command` to its end.
///
/// # Panics
/// Where it cannot be started or does not end within [`WATCHDOG`].
pub fn finish(mut command: Command) -> Said {
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let pid = child.id();
    let started = Instant::now();
    let reader = std::thread::spawn(move || child.wait_with_output());
    while !reader.is_finished() {
        if started.elapsed() > WATCHDOG {
            cell_rt::process::kill(pid, cell_rt::process::SIGKILL).ok();
            panic!("{command:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    reader
        .join()
        .expect("the reader ends")
        .expect("the output can be read")
        .into()
}

/// Waits until `condition` gives a value.
///
/// # Panics
/// Where it does not within [`WATCHDOG`]; `what` is for the message.
pub fn wait_for<T>(what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(value) = condition() {
            return value;
        }
        assert!(started.elapsed() < WATCHDOG, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
