//! One run of the `robocell` program to its end.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Everything that waits gives up after this: a hang is a failed test, not a
/// stuck one. No bound on speed.
pub const WATCHDOG: Duration = Duration::from_secs(240);

/// The program `name`, built from the sources as they are now, in the target
/// folder of this test.
///
/// # Panics
/// Where it cannot be built.
pub fn built(name: &str) -> PathBuf {
    static PROGRAMS: OnceLock<PathBuf> = OnceLock::new();
    let path = PROGRAMS.get_or_init(build_programs).join(name);
    assert!(path.exists(), "{} is no program of ours", path.display());
    path
}

/// The example program `name`.
pub fn example(name: &str) -> PathBuf {
    built("examples").join(name)
}

/// `cargo test -p robocell-tests` builds the tests alone: their programs may be
/// missing or stale. Where cargo has built them already, it compares some dates.
/// With `ROBOCELL_TESTS_BUILD=no` they are taken as they are: `.ci/run` has built them, and its
/// lints hold cargo's lock.
fn build_programs() -> PathBuf {
    let own = std::env::current_exe().expect("a test knows its own path");
    // TARGET/PROFILE/deps/TEST
    let folder = own.ancestors().nth(2).expect("a test lies in deps");
    if std::env::var("ROBOCELL_TESTS_BUILD").is_ok_and(|build| build == "no") {
        return folder.to_owned();
    }
    let profile = folder.file_name().and_then(OsStr::to_str);
    let profile = profile.expect("a profile has a name");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let target = folder.parent().expect("a profile lies in a target folder");
    let status = Command::new(cargo)
        .args(["build", "--quiet", "--workspace", "--bins"])
        .args([
            "--example",
            "circle",
            "--example",
            "misbehaving",
            "--example",
            "sway",
        ])
        .args([
            "--profile",
            if profile == "debug" { "dev" } else { profile },
        ])
        .args(["--manifest-path", manifest, "--target-dir"])
        .arg(target)
        .status()
        .expect("cargo starts");
    assert!(status.success(), "the programs cannot be built, see above");
    folder.to_owned()
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
pub fn finish(command: Command) -> Said {
    finish_within(command, WATCHDOG)
}

/// As [`finish`], for what may take as long as `patience`.
///
/// # Panics
/// Where it cannot be started or does not end within `patience`.
pub fn finish_within(mut command: Command, patience: Duration) -> Said {
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let pid = child.id();
    let started = Instant::now();
    let reader = std::thread::spawn(move || child.wait_with_output());
    while !reader.is_finished() {
        if started.elapsed() > patience {
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
        assert!(started.elapsed() < WATCHDOG, "timed out waiting for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
