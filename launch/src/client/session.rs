//! A running cell, seen by a command.

use cell_bus::{Bus, RunSite};
use cell_model::Cell;
use cell_run::spec::RunSpec;
use supervisor::failure::{Context, Failure};
use supervisor::lock::Holder;
use supervisor::run::files::room::Room;
use supervisor::rundir::RunDir;

use crate::run::plan;

/// A running cell, seen from outside.
pub(crate) struct Session {
    pub(crate) dir: RunDir,
    pub(crate) spec: RunSpec,
    pub(crate) holder: Holder,
}

impl Session {
    /// The running cell of this name.
    pub(crate) fn of(cell: &str) -> Result<Self, Failure> {
        let dir = RunDir::of(cell)?;
        let holder = dir.running(cell)?;
        // A cell that starts at this moment has no run file yet.
        let spec = RunSpec::load(&dir.spec()).map_err(Failure::configuration)?;
        Ok(Self { dir, spec, holder })
    }

    /// The cell it was started with.
    pub(crate) fn load_cell(&self) -> Result<Cell, Failure> {
        let spec = &self.spec;
        let data = spec.data_dir.as_deref();
        plan::cell::load(data, &spec.demo, spec.seed, spec.robot.as_ref(), &spec.set)
    }

    /// Joins its bus as a reader and asker.
    pub(crate) fn join(&self) -> Result<Bus, Failure> {
        // Without room the bus fails by an error that does not name it, or by SIGBUS.
        if let Some(lack) = Room::of_command(self.dir.path()).lack() {
            return Err(Failure::configuration(format!(
                "cannot join cell `{}`: {lack}; delete files there",
                self.spec.cell
            )));
        }
        let site = RunSite {
            root: self.spec.root.clone(),
            prefix: self.spec.prefix.clone(),
        };
        Bus::join(&site, self.spec.run, 1, "client")
            .cannot(format!("join cell `{}`", self.spec.cell))
    }
}
