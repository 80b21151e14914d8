//! The start of a process: all that can fail comes before the bus is touched.

use std::process::ExitCode;

use cell_bus::{Bus, BusError, RunSite};
use cell_model::runs::spec::{RunSpec, RunSpecError};
use cell_model::runs::worker_args::{WorkerArgs, WorkerArgsError};
use cell_model::{Cell, ModelError};
use cell_rt::{priority, process, signal};
use ipc_types::topic::Process;

use crate::orphan;

/// Configuration that cannot be used.
const EXIT_CONFIGURATION: u8 = 3;
/// Anything else.
const EXIT_FAILED: u8 = 1;

/// Why a process cannot start.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// The arguments.
    #[error(transparent)]
    Args(#[from] WorkerArgsError),
    /// The run file.
    #[error(transparent)]
    Spec(#[from] RunSpecError),
    /// The cell.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The operating system.
    #[error("start-up: {0}")]
    System(#[from] std::io::Error),
    /// The launcher is gone already.
    #[error("the launcher ended while this process was starting")]
    Orphan,
}

/// A process that knows its run and has not joined it yet.
pub struct Start {
    /// The run.
    pub spec: RunSpec,
    /// The cell, set up for the run's seed.
    pub cell: Cell,
    /// Which start of this process it is.
    pub generation: u32,
    /// Which arm, for a controller.
    pub arm: u8,
    /// Process id of the launcher.
    launcher: u32,
}

impl Start {
    /// Reads arguments, run file and cell, and ties this process to the
    /// launcher: it ends when the launcher ends.
    pub fn from_arguments(words: &[String]) -> Result<Self, SetupError> {
        process::private_umask();
        signal::install_stop_handler()?;
        let parent = process::parent_pid();
        if !process::die_with_parent(process::SIGTERM, parent)? {
            return Err(SetupError::Orphan);
        }
        let args = WorkerArgs::parse(words.iter().cloned())?;
        let spec = RunSpec::load(&args.spec)?;
        let cell = spec.load_cell()?;
        Ok(Self {
            spec,
            cell,
            generation: args.generation,
            arm: args.arm,
            launcher: parent,
        })
    }

    /// Asks for real-time scheduling where the run wants it; says in the log
    /// what was refused. Whether SCHED_FIFO was granted.
    pub fn real_time(&self, fifo_priority: i32, core: usize) -> bool {
        if !self.spec.real_time || self.spec.speed.is_lockstep() {
            return false;
        }
        let core = (priority::core_count() > 1).then_some(core % priority::core_count());
        let granted = priority::request(fifo_priority, core);
        for line in &granted.refused {
            crate::warn(format_args!("no {line}"));
        }
        granted.fifo
    }

    /// Asks for real-time scheduling alone: no core and no memory of its own. Whether
    /// it was granted; says in the log if not.
    pub fn real_time_priority(&self, fifo_priority: i32) -> bool {
        if !self.spec.real_time || self.spec.speed.is_lockstep() {
            return false;
        }
        let granted = priority::set_fifo(fifo_priority);
        if let Err(error) = &granted {
            crate::warn(format_args!(
                "no SCHED_FIFO {fifo_priority}: {error}; `robocell doctor` says more"
            ));
        }
        granted.is_ok()
    }

    /// Gives this process all the shared memory its ports may use, so that it works on
    /// while there is no room. After all of them are made.
    pub fn populate(&self) {
        let prefix = format!("/dev/shm/{}", self.spec.prefix);
        match cell_rt::memory::populate(&prefix) {
            Ok(0) => {}
            Ok(bytes) => crate::warn(format_args!(
                "{bytes} bytes of shared memory are not there yet: without room in /dev/shm a \
                 write to them ends this process"
            )),
            Err(error) => crate::warn(format_args!("/proc/self/maps: {error}")),
        }
    }

    /// Joins the run as `process`.
    pub fn join(&self, process: Process) -> Result<Bus, BusError> {
        let site = RunSite {
            root: self.spec.root.clone(),
            prefix: self.spec.prefix.clone(),
        };
        Bus::join(&site, self.spec.run, self.generation, &process.name())
    }
}

/// Why a process that has read its files cannot run.
pub trait RunError: std::fmt::Display {
    /// Whether every other start would end in the same way. The launcher does not
    /// try again then.
    fn is_lasting(&self) -> bool;
}

impl RunError for BusError {
    fn is_lasting(&self) -> bool {
        matches!(self, Self::Version { .. })
    }
}

/// `main` of a process: runs it and turns its error into one line and a code.
/// What is wrong with arguments or files stays wrong; what fails afterwards may
/// pass, and the launcher tries again.
pub fn main<E: RunError>(name: &str, run: impl FnOnce(&Start) -> Result<(), E>) -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    main_of(name, &words, run)
}

/// As [`main`], with these words in place of the arguments of this process.
pub fn main_of<E: RunError>(
    name: &str,
    words: &[String],
    run: impl FnOnce(&Start) -> Result<(), E>,
) -> ExitCode {
    let fail = |error: &dyn std::fmt::Display, code: u8| {
        crate::warn::line(format_args!("{name}: {error}"));
        ExitCode::from(code)
    };
    match Start::from_arguments(words) {
        Err(error) => fail(&error, EXIT_CONFIGURATION),
        Ok(start) => {
            let code = match run(&start) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) if error.is_lasting() => fail(&error, EXIT_CONFIGURATION),
                Err(error) => fail(&error, EXIT_FAILED),
            };
            if process::parent_pid() != start.launcher {
                orphan::end_the_others(&start.spec.run_dir);
            }
            code
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_version_is_not_tried_again_and_a_full_port_is() {
        let version = BusError::Version {
            service: "task/decision".to_owned(),
            theirs: "Decision#1".to_owned(),
            ours: "Decision#2".to_owned(),
        };
        let port = BusError::Port {
            service: "task/decision".to_owned(),
            reason: "ExceedsMaxSupportedPublishers".to_owned(),
        };
        assert!(version.is_lasting() && !port.is_lasting());
    }
}
