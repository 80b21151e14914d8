//! A cell started from the built programs, in a run directory of its own.

use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use cell_bus::{Bus, RunSite};
use cell_rt::process::{SIGTERM, kill};
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{Said, finish, robocell, wait_for};

/// A short directory in memory: names of sockets in it are limited to 108
/// bytes.
///
/// # Panics
/// Where it cannot be made.
pub fn base() -> TempDir {
    tempfile::Builder::new()
        .prefix("rt")
        .tempdir_in("/dev/shm")
        .expect("a directory in memory")
}

/// An orderly stop takes at most a second for each process.
const PATIENCE: Duration = Duration::from_secs(15);

/// A launcher that runs; dropping it ends it, and its processes with it.
#[derive(Debug)]
pub struct TestCell {
    base: TempDir,
    child: Option<Child>,
}

impl TestCell {
    /// `robocell run ARGUMENTS` in its own run directory.
    pub fn start(arguments: &[&str]) -> Self {
        Self::start_in(base(), arguments)
    }

    /// As [`TestCell::start`], in a directory an earlier one may have used.
    ///
    /// # Panics
    /// Where the program cannot be started.
    pub fn start_in(base: TempDir, arguments: &[&str]) -> Self {
        Self::start_with(base, arguments, |_| {})
    }

    /// As [`TestCell::start_in`], after `prepare` has changed the command.
    ///
    /// # Panics
    /// Where the program cannot be started.
    pub fn start_with(
        base: TempDir,
        arguments: &[&str],
        prepare: impl FnOnce(&mut std::process::Command),
    ) -> Self {
        let all: Vec<&str> = ["run"].iter().chain(arguments).copied().collect();
        Self::launch(base, &all, prepare)
    }

    /// `robocell ARGUMENTS` that stays: `run ...`, or `replay ...`.
    ///
    /// # Panics
    /// Where the program cannot be started.
    pub fn launch(
        base: TempDir,
        arguments: &[&str],
        prepare: impl FnOnce(&mut std::process::Command),
    ) -> Self {
        let out = std::fs::File::create(base.path().join("stdout")).expect("a file for stdout");
        let err = std::fs::File::create(base.path().join("stderr")).expect("a file for stderr");
        let mut command = robocell(base.path(), arguments);
        prepare(&mut command);
        let child = command
            .stdout(Stdio::from(out))
            .stderr(Stdio::from(err))
            .spawn()
            .expect("robocell starts");
        Self {
            base,
            child: Some(child),
        }
    }

    /// Where the run directories lie.
    pub fn base(&self) -> &Path {
        self.base.path()
    }

    /// The run directory.
    pub fn run_dir(&self) -> PathBuf {
        self.base.path().join("cell")
    }

    /// The link to its page, as soon as it is said.
    pub fn link(&self) -> String {
        wait_for("the link", || {
            let said = std::fs::read_to_string(self.base.path().join("stdout")).ok()?;
            let link = said.lines().find(|line| line.starts_with("http://"));
            link.map(str::to_owned)
        })
    }

    /// Process id of the launcher.
    ///
    /// # Panics
    /// After its end.
    pub fn launcher(&self) -> u32 {
        self.child.as_ref().expect("the launcher runs").id()
    }

    /// Another `robocell` command about this cell.
    pub fn ask(&self, arguments: &[&str]) -> Said {
        finish(robocell(self.base.path(), arguments))
    }

    /// What `status --json` says, if the cell answers.
    pub fn status(&self) -> Option<Value> {
        let said = self.ask(&["status", "--json"]);
        (said.code == 0).then(|| said.json())
    }

    /// Waits until `status --json` fulfils `condition`.
    pub fn wait_status(&self, what: &str, condition: impl Fn(&Value) -> bool) -> Value {
        wait_for(what, || self.status().filter(|status| condition(status)))
    }

    /// Waits until every process shows itself.
    pub fn wait_up(&self) -> Value {
        self.wait_status("all processes", |status| {
            let processes = status["processes"].as_array();
            processes.is_some_and(|all| all.iter().all(|process| process["pid"].is_u64()))
        })
    }

    /// Joins its bus as one more reader.
    ///
    /// # Panics
    /// Where the cell has no run file or no bus.
    pub fn join(&self) -> Bus {
        self.join_as(1)
    }

    /// Joins its bus as start number `generation` of whatever it publishes.
    ///
    /// # Panics
    /// As [`Self::join`].
    pub fn join_as(&self, generation: u32) -> Bus {
        let text = std::fs::read_to_string(self.run_dir().join("run.json")).expect("a run file");
        let spec: Value = serde_json::from_str(&text).expect("JSON");
        let word = |key: &str| spec[key].as_str().expect("a text").to_owned();
        let site = RunSite {
            root: word("root").into(),
            prefix: word("prefix"),
        };
        Bus::join(
            &site,
            spec["run"].as_u64().expect("a number"),
            generation,
            "test",
        )
        .expect("a bus")
    }

    /// Whether the launcher has not ended.
    pub fn is_running(&mut self) -> bool {
        let child = self.child.as_mut();
        child.is_some_and(|child| matches!(child.try_wait(), Ok(None)))
    }

    /// Waits for the launcher to end by itself.
    ///
    /// # Panics
    /// Where it does not.
    pub fn wait_end(&mut self) -> Said {
        let mut child = self.child.take().expect("the launcher runs");
        let status = wait_for("the end of the run", || {
            child.try_wait().expect("its state is known")
        });
        let read =
            |name: &str| std::fs::read_to_string(self.base.path().join(name)).unwrap_or_default();
        Said {
            code: status.code().unwrap_or(-1),
            stdout: read("stdout"),
            stderr: read("stderr"),
        }
    }

    /// Ends the launcher without a word, as a crash would; gives the directory
    /// back for the next start.
    ///
    /// # Panics
    /// Where the launcher cannot be killed.
    pub fn crash(mut self) -> TempDir {
        let mut child = self.child.take().expect("the launcher runs");
        child.kill().expect("it can be killed");
        child.wait().expect("it ends");
        std::mem::replace(&mut self.base, base())
    }
}

impl Drop for TestCell {
    /// Ends the cell in order, so that nothing stays in shared memory; one that
    /// does not listen is killed.
    fn drop(&mut self) {
        let Some(mut child) = self.child.take() else {
            return;
        };
        kill(child.id(), SIGTERM).ok();
        let asked = Instant::now();
        while matches!(child.try_wait(), Ok(None)) {
            if asked.elapsed() > PATIENCE {
                child.kill().ok();
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// The process `name` in a status, if it shows itself.
pub fn process<'a>(status: &'a Value, name: &str) -> Option<&'a Value> {
    status["processes"]
        .as_array()?
        .iter()
        .find(|process| process["name"] == name && process["pid"].is_u64())
}

/// The pid of `name` in a status.
///
/// # Panics
/// Where it does not show itself.
pub fn pid(status: &Value, name: &str) -> u32 {
    let pid = process(status, name).and_then(|process| process["pid"].as_u64());
    u32::try_from(pid.unwrap_or_else(|| panic!("{name} is silent: {status}"))).expect("a pid")
}

/// The start count of `name` in a status; 0 where it is silent.
pub fn generation(status: &Value, name: &str) -> u64 {
    process(status, name)
        .and_then(|process| process["generation"].as_u64())
        .unwrap_or(0)
}
