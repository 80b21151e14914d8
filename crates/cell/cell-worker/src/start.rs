//! The start of a process: everything that can fail is done before it joins the bus.
//!
//! A process killed or failing while it joins leaves files that only the wipe after the run
//! removes, so arguments, files and the model are read first. The exit code tells the launcher
//! whether another start can help: 3 ends the cell, 1 is followed by a restart.

use std::process::ExitCode;

use cell_bus::{Bus, BusError, RunSite};
use cell_model::{Cell, ModelError};
use cell_rt::{priority, process, signal};
use cell_run::spec::{RunSpec, RunSpecError};
use cell_run::worker_args::{WorkerArgs, WorkerArgsError};
use ipc_types::topic::Process;

use crate::orphan;

/// Configuration that cannot be used.
// The same for every start, so the launcher must not restart in a loop.
const EXIT_CONFIGURATION: u8 = 3;
/// Anything else.
const EXIT_FAILED: u8 = 1;

/// Reasons why a process cannot start.
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
    /// Number of this start of the process, from 1 up.
    pub generation: u32,
    /// Which arm, for a controller.
    pub arm: u8,
    /// Process id of the launcher; `None` in a model of a process.
    launcher: Option<u32>,
}

impl Start {
    /// Reads arguments, run file and cell, and ties this process to the
    /// launcher: it ends when the launcher ends.
    pub fn from_arguments(words: &[String]) -> Result<Self, SetupError> {
        // Before any file is created: files of a run are for its user only.
        process::private_umask();
        // Before the request below: a SIGTERM sent by the kernel must already be caught.
        signal::install_stop_handler()?;
        let parent = process::parent_pid();
        // A launcher that died before this line would leave a process without a supervisor.
        if !process::die_with_parent(process::SIGTERM, parent)? {
            return Err(SetupError::Orphan);
        }
        // Only now, as all of these may take long or fail: from here
        // on the process ends with its launcher.
        let args = WorkerArgs::parse(words.iter().cloned())?;
        let spec = RunSpec::load(&args.spec)?;
        let cell = spec.load_cell()?;
        Ok(Self {
            spec,
            cell,
            generation: args.generation,
            arm: args.arm,
            launcher: Some(parent),
        })
    }

    /// The start of a modelled process in this one, which has no arguments and no launcher.
    pub fn modelled(spec: RunSpec, cell: Cell, generation: u32, arm: u8) -> Self {
        Self {
            spec,
            cell,
            generation,
            arm,
            launcher: None,
        }
    }

    /// Whether this process is only modelled: files and figures of a process are not its own.
    pub(crate) fn is_modelled(&self) -> bool {
        self.launcher.is_none()
    }

    /// Requests real-time scheduling where the run wants it, and logs what was refused. True if
    /// SCHED_FIFO was granted.
    pub fn real_time(&self, fifo_priority: i32, core: usize) -> bool {
        // In lockstep a FIFO thread that waits for others would keep them from its core.
        if !self.spec.real_time || self.spec.speed.is_lockstep() {
            return false;
        }
        if self.is_modelled() {
            return true;
        }
        // On a single core pinning gains nothing and keeps the kernel from balancing.
        let core = (priority::core_count() > 1).then_some(core % priority::core_count());
        let granted = priority::request(fifo_priority, core);
        for line in &granted.refused {
            crate::warn(format_args!("no {line}"));
        }
        granted.fifo
    }

    /// Requests real-time scheduling alone, without a core or locked memory. True if it was
    /// granted; logs the reason if not.
    pub fn real_time_priority(&self, fifo_priority: i32) -> bool {
        if !self.spec.real_time || self.spec.speed.is_lockstep() {
            return false;
        }
        if self.is_modelled() {
            return true;
        }
        let granted = priority::set_fifo(fifo_priority);
        if let Err(error) = &granted {
            crate::warn(format_args!(
                "no SCHED_FIFO {fifo_priority}: {error}; `robocell doctor` says more"
            ));
        }
        granted.is_ok()
    }

    /// Reserves all shared memory that the ports of this process may use, so that it continues
    /// when /dev/shm is full. To be called after all ports are open.
    pub fn populate(&self) {
        // All mappings of the run, also those that ports opened on behalf of other processes.
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

/// Errors of a process that has read its files.
pub trait RunError: std::fmt::Display {
    /// Whether every other start would end with the same error. The launcher does not restart
    /// it then.
    fn is_lasting(&self) -> bool;
}

impl RunError for BusError {
    fn is_lasting(&self) -> bool {
        // Another build stays another build; every other error of the bus may pass.
        matches!(self, Self::Version { .. })
    }
}

/// `main` of a process: runs it and turns its error into one line and an exit code. Errors in
/// arguments or files are permanent; later ones may pass, and the launcher restarts the
/// process.
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
            // The launcher died: no process is left that would end one of the cell that hangs.
            if Some(process::parent_pid()) != start.launcher {
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
