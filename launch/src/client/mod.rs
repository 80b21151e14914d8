//! Commands that talk to a running cell.

mod approach;
mod behaviour;
mod breakpoints;
mod columns;
mod doctor;
mod follow;
mod grasp;
mod hand;
mod import;
mod incident;
mod joints;
mod list;
mod load;
mod logs;
mod measure;
mod operate;
pub(crate) mod picture;
mod process_table;
mod restart;
mod scene;
mod status;
mod top;
mod watched;

pub(crate) use behaviour::{behaviour, schema, tree};
pub(crate) use breakpoints::breakpoint;
pub(crate) use doctor::{DoctorReport, doctor};
pub(crate) use grasp::grasp;
pub(crate) use hand::{gripper, target};
pub(crate) use incident::{IncidentList, incident};
pub(crate) use joints::joints;
pub(crate) use list::{List, list};
pub(crate) use load::load;
pub(crate) use logs::{LogLine, logs};
pub(crate) use operate::{add_bin, down, drag, drop_parts, plain, speed, step, task};
pub(crate) use restart::restart;
pub(crate) use status::{Status, status};
pub(crate) use top::{Snapshot, top};

use cell_bus::{Bus, RunSite};
use cell_model::Cell;
use cell_model::runs::spec::RunSpec;
use supervisor::failure::{Context, Failure};
use supervisor::lock::Holder;
use supervisor::run::room::Room;
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
