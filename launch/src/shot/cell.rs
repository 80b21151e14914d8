//! The cell a picture is taken of: the one that runs, or one started for it.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use ipc_types::world::FLAG_PAUSED;

use crate::cli::ShownArgs;
use crate::client::Session;
use crate::client::picture::Picture;
use crate::failure::{Code, Context, Failure};
use crate::flight;
use crate::page::{self, Entry};
use crate::rundir::RunDir;

/// Starting a cell, or computing some minutes of it, takes a while.
const PATIENCE: Duration = Duration::from_secs(180);

/// What a picture is taken of.
pub(crate) struct Subject<'a> {
    /// The demo that is started for it, if any.
    pub(crate) args: &'a ShownArgs,
    /// Simulated time the demo is run to (s).
    pub(crate) time: Option<f64>,
    /// Name of the running cell.
    pub(crate) cell: &'a str,
}

/// See the module. A cell that was started for the picture ends with it.
pub(crate) struct Shown {
    entry: Entry,
    _own: Option<Own>,
}

struct Own {
    launcher: Child,
    name: String,
}

impl Shown {
    /// The cell of `subject`.
    pub(crate) fn of(subject: &Subject<'_>) -> Result<Self, Failure> {
        let Some(demo) = &subject.args.demo else {
            if subject.args.data.data.is_some() || subject.args.data.task.is_some() {
                let message = "--data and --task need --demo: a running cell has its own";
                return Err(Failure::usage(message));
            }
            return Ok(Self {
                entry: entry(&Session::of(subject.cell)?)?,
                _own: None,
            });
        };
        let mut own = Own::start(subject, demo)?;
        let session = own.wait("its start", |session| {
            Picture::open(session).is_ok_and(|mut picture| {
                picture.fill();
                picture.state().is_some() && picture.decision().is_some()
            })
        })?;
        let ticks = Duration::from_secs_f64(subject.time.unwrap_or(0.0)).as_millis();
        let ticks = u64::try_from(ticks).unwrap_or(u64::MAX);
        if ticks > 0 {
            own.run_to(ticks)?;
        }
        Ok(Self {
            entry: entry(&session)?,
            _own: Some(own),
        })
    }

    /// Its page.
    pub(crate) fn entry(&self) -> &Entry {
        &self.entry
    }
}

fn entry(session: &Session) -> Result<Entry, Failure> {
    let page = session.spec.page.as_ref().and_then(page::entry);
    page.ok_or_else(|| {
        Failure::configuration(
            "this cell was started with --headless and has no page to take a picture of",
        )
    })
}

impl Own {
    fn start(subject: &Subject<'_>, demo: &str) -> Result<Self, Failure> {
        let name = format!("shot-{}", std::process::id());
        let args = subject.args;
        let seed = args.seed.to_string();
        let program = std::env::current_exe().map_err(Failure::configuration)?;
        let mut command = Command::new(program);
        command
            .args(["run", demo, "--cell", &name, "--paused", "--speed", "max"])
            .args(["--seed", &seed])
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        if let Some(policy) = &args.policy {
            command.args(["--policy", policy]);
        }
        if let Some(data) = &args.data.data {
            command.arg("--data").arg(data);
        }
        if let Some(task) = &args.data.task {
            command.args(["--task", task]);
        }
        let launcher = command.spawn().cannot("start the cell")?;
        Ok(Self { launcher, name })
    }

    fn wait(
        &mut self,
        what: &str,
        mut there: impl FnMut(&Session) -> bool,
    ) -> Result<Session, Failure> {
        let since = Instant::now();
        while since.elapsed() < PATIENCE {
            if let Ok(session) = Session::of(&self.name)
                && there(&session)
            {
                return Ok(session);
            }
            self.still_runs(what)?;
            std::thread::sleep(Duration::from_millis(50));
        }
        Err(Failure {
            code: Code::GaveUp,
            message: format!("the cell for the picture does not get to {what}"),
        })
    }

    /// A cell that ended has said why, and will not come.
    fn still_runs(&mut self, what: &str) -> Result<(), Failure> {
        super::not_stopped()?;
        let ended = self
            .launcher
            .try_wait()
            .cannot("look at the cell for the picture")?;
        let Some(status) = ended else { return Ok(()) };
        let code = if status.code() == Some(Code::Usage as i32) {
            Code::Usage
        } else {
            Code::Configuration
        };
        Err(Failure {
            code,
            message: format!("no picture: its cell ended before {what}, see above"),
        })
    }

    /// Waits for a command about the cell to end, or ends it with us.
    fn wait_for(&mut self, mut child: Child) -> Result<(), Failure> {
        let ended = loop {
            if let Err(stopped) = self.still_runs("the time asked for") {
                break Err(stopped);
            }
            match child.try_wait().cannot("talk to the cell") {
                Ok(Some(_)) => return Ok(()),
                Ok(None) => std::thread::sleep(Duration::from_millis(20)),
                Err(failure) => break Err(failure),
            }
        };
        child.kill().ok();
        child.wait().ok();
        ended
    }

    /// Lets the task work for so many ticks, then stops time.
    fn run_to(&mut self, ticks: u64) -> Result<(), Failure> {
        let count = ticks.to_string();
        for words in [&["task", "start"][..], &["step", &count]] {
            let program = std::env::current_exe().map_err(Failure::configuration)?;
            let mut command = Command::new(program);
            command.args(words).args(["--cell", &self.name]);
            let child = command.stdout(Stdio::null()).spawn();
            self.wait_for(child.cannot("talk to the cell")?)?;
        }
        let session = self.wait("its start", |_| true)?;
        let mut picture = Picture::open(&session)?;
        self.wait("the time asked for", |_| {
            picture.fill();
            let is_there = |state: &ipc_types::WorldState| {
                state.header.tick >= ticks && state.has(FLAG_PAUSED)
            };
            picture.state().is_some_and(is_there)
        })?;
        Ok(())
    }
}

impl Drop for Own {
    fn drop(&mut self) {
        cell_rt::process::kill(self.launcher.id(), cell_rt::process::SIGTERM).ok();
        self.launcher.wait().ok();
        // No one returns to a cell of this name; its recorder's files are large.
        let dir = RunDir::of(&self.name);
        let kept = [
            flight::ring(&self.name, &dir).flight_dir,
            flight::incidents(&self.name, &dir),
            dir.path().to_owned(),
        ];
        for path in kept {
            std::fs::remove_dir_all(path).ok();
        }
    }
}
