//! A running cell, joined like the monitor does: as a reader, and as one who asks.

use std::time::Duration;

use cell_bus::{Bus, BusError, Latest, OperatorClient, RunSite, Subscriber};
use cell_model::runs::spec::{RunSpec, RunSpecError};
use cell_model::{Cell, ModelError};
use ipc_types::operator::ReplyCode;
use ipc_types::topic::TopicId;
use ipc_types::{Decision, OperatorRequest, TraceLine, WorldState};
use launch::rundir::RunDir;
use thiserror::Error;

/// How long physics may take to answer.
const PATIENCE: Duration = Duration::from_millis(500);

/// Why a cell cannot be joined.
#[derive(Debug, Error)]
pub enum JoinError {
    /// Nothing of this name runs.
    #[error("cell `{0}` is not running; start it with `robocell run DEMO --cell {0}`")]
    NotRunning(String),
    /// What the launcher says of the run.
    #[error(transparent)]
    Spec(#[from] RunSpecError),
    /// Its files.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Its bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// A run of a cell.
pub struct Joined {
    /// What it was started with.
    pub spec: RunSpec,
    /// The cell.
    pub cell: Cell,
    dir: RunDir,
    launcher: u32,
    world: Latest<WorldState>,
    decision: Latest<Decision>,
    trace: Subscriber<TraceLine>,
    operator: OperatorClient,
    // Last: its ports are dropped before it.
    _bus: Bus,
}

impl Joined {
    /// Joins the running cell of this name.
    ///
    /// # Errors
    /// [`JoinError`] where it does not run or its files cannot be read.
    pub fn of(name: &str) -> Result<Self, JoinError> {
        let dir = RunDir::of(name);
        let holder = dir.holder();
        let holder = holder.ok_or_else(|| JoinError::NotRunning(name.to_owned()))?;
        let spec = RunSpec::load(&dir.spec())?;
        let cell = spec.load_cell()?;
        let site = RunSite {
            root: spec.root.clone(),
            prefix: spec.prefix.clone(),
        };
        let bus = Bus::join(&site, spec.run, 1, "bridge")?;
        Ok(Self {
            world: bus.latest(TopicId::WorldState)?,
            decision: bus.latest(TopicId::Decision)?,
            trace: bus.subscriber(TopicId::Trace)?,
            operator: bus.operator_client()?,
            spec,
            cell,
            dir,
            launcher: holder.pid,
            _bus: bus,
        })
    }

    /// Whether its launcher is gone, or has started another run.
    pub fn is_over(&self) -> bool {
        let same = self
            .dir
            .holder()
            .is_some_and(|holder| holder.pid == self.launcher);
        let run = RunSpec::load(&self.dir.spec()).map(|spec| spec.run);
        !same || run.is_ok_and(|run| run != self.spec.run)
    }

    /// Looks for newer messages; lines of the task are handed to `line`.
    pub fn refresh(&mut self, line: impl FnMut(&TraceLine)) {
        self.world.refresh();
        self.decision.refresh();
        self.trace.take_all(line);
    }

    /// The newest state, once there is one.
    pub fn world(&self) -> Option<&WorldState> {
        self.world.get()
    }

    /// The newest decision of the task, once there is one.
    pub fn decision(&self) -> Option<&Decision> {
        self.decision.get()
    }

    /// Asks physics; the simulated time at which it takes effect (s).
    ///
    /// # Errors
    /// Why it is refused.
    pub fn ask(&mut self, request: OperatorRequest) -> Result<f64, String> {
        let reply = self.operator.request(request, PATIENCE);
        let reply = reply.map_err(|error| error.to_string())?;
        match ReplyCode::from_code(reply.code) {
            Some(ReplyCode::Accepted) => Ok(reply.header.sim_time_ns as f64 * 1.0e-9),
            _ => Err(reply.message.as_str().to_owned()),
        }
    }
}
