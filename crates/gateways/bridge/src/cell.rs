//! A running cell, joined like the monitor does: as a reader, and as an operator.

use std::time::Duration;

use cell_bus::{Bus, BusError, Latest, OperatorClient, RunSite, Subscriber};
use cell_run::spec::{RunSpec, RunSpecError};
use cell_model::{Cell, ModelError};
use ipc_types::operator::ReplyCode;
use ipc_types::topic::TopicId;
use ipc_types::{Decision, OperatorRequest, TraceLine, WorldState};
use supervisor::failure::Failure;
use supervisor::rundir::RunDir;
use thiserror::Error;

/// Time limit for an answer of physics.
// Bounds the wait of a client during a restart of physics; commands are handled one by one.
const PATIENCE: Duration = Duration::from_millis(500);

/// Reasons why a cell cannot be joined.
#[derive(Debug, Error)]
pub enum JoinError {
    /// No cell of this name is running.
    #[error("cell `{0}` is not running; start it with `robocell run DEMO --cell {0}`")]
    NotRunning(String),
    /// Its run directory.
    #[error(transparent)]
    RunDir(#[from] Failure),
    /// The run file.
    #[error(transparent)]
    Spec(#[from] RunSpecError),
    /// Its files.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Its bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// A joined run of a cell.
pub struct Joined {
    /// Its run file.
    pub spec: RunSpec,
    /// The cell.
    pub cell: Cell,
    dir: RunDir,
    launcher: u32,
    world: Latest<WorldState>,
    decision: Latest<Decision>,
    trace: Subscriber<TraceLine>,
    operator: OperatorClient,
    // Last: ports are dropped before their bus.
    _bus: Bus,
}

impl Joined {
    /// Joins the running cell of this name.
    ///
    /// # Errors
    /// [`JoinError`] if it is not running or its files cannot be read.
    pub fn of(name: &str) -> Result<Self, JoinError> {
        let dir = RunDir::of(name)?;
        // The lock's holder is the launcher; without one, files are leftovers.
        let holder = dir.holder();
        let holder = holder.ok_or_else(|| JoinError::NotRunning(name.to_owned()))?;
        let spec = RunSpec::load(&dir.spec())?;
        let cell = spec.load_cell()?;
        let site = RunSite {
            root: spec.root.clone(),
            prefix: spec.prefix.clone(),
        };
        // Generation 1: the bridge publishes nothing that a successor would have to replace.
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

    /// Whether its launcher has ended, or started another run.
    pub fn is_over(&self) -> bool {
        let same = self
            .dir
            .holder()
            .is_some_and(|holder| holder.pid == self.launcher);
        // A run file that is just being replaced cannot be read; then the next look decides.
        let run = RunSpec::load(&self.dir.spec()).map(|spec| spec.run);
        !same || run.is_ok_and(|run| run != self.spec.run)
    }

    /// Reads newer messages; lines of the task are passed to `line`.
    pub fn refresh(&mut self, line: impl FnMut(&TraceLine)) {
        self.world.refresh();
        self.decision.refresh();
        self.trace.take_all(line);
    }

    /// The newest state; `None` before the first.
    pub fn world(&self) -> Option<&WorldState> {
        self.world.get()
    }

    /// The newest decision of the task; `None` before the first.
    pub fn decision(&self) -> Option<&Decision> {
        self.decision.get()
    }

    /// Sends a request to physics; returns the simulated time at which it takes effect (s).
    ///
    /// # Errors
    /// The reason of a refusal.
    pub fn ask(&mut self, request: OperatorRequest) -> Result<f64, String> {
        let reply = self.operator.request(request, PATIENCE);
        let reply = reply.map_err(|error| error.to_string())?;
        match ReplyCode::from_code(reply.code) {
            Some(ReplyCode::Accepted) => Ok(reply.header.sim_time_ns as f64 * 1.0e-9),
            _ => Err(reply.message.as_str().to_owned()),
        }
    }
}
