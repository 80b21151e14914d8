//! The cell in one decision, in memory that Python may hold on to.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use behavior::{NodeStatus, suggest};
use ipc_types::trace::TraceEvent;
use ipc_types::{MAX_ARMS, Wire, WorldState};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use robocell_skills::settings::{Pattern, PlaceTable};
use robocell_skills::{ArmMemory, Setup, Told, World};
use robocell_task::observation::ControllerEcho;
use robocell_task::{Job, Observation, Outcome, Output, PolicyTime};
use serde::{Deserialize, Serialize};

use crate::arm::Arm;
use crate::command::Command;
use crate::skill::Status;

/// Statuses on their way from Python, by their number.
const STATUSES: [NodeStatus; 4] = [
    NodeStatus::Invalid,
    NodeStatus::Running,
    NodeStatus::Success,
    NodeStatus::Failure,
];

/// The status of a number from Python; any other number is no status.
pub(crate) fn status_of(number: u8) -> NodeStatus {
    let known = STATUSES.get(usize::from(number));
    known.copied().unwrap_or(NodeStatus::Invalid)
}

/// What the equipment was asked for outside of decisions.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Asked {
    conveyor: Option<bool>,
    bins: u32,
    parts: u32,
}

/// What a policy sees and says in one decision.
pub(crate) struct Inner {
    pub(crate) setup: Setup,
    state: Box<WorldState>,
    echoes: [Option<ControllerEcho>; MAX_ARMS],
    time: PolicyTime,
    pub(crate) job: Job,
    pub(crate) out: Output,
    /// By arm; empty for one arm, which the job remembers.
    pub(crate) memories: Vec<ArmMemory>,
    told: [Told; MAX_ARMS],
    /// Timers of skills start again: decisions were missed.
    pub(crate) resumed: bool,
    /// A decision is under way.
    open: bool,
    /// By arm, what it was told outside of decisions; empty where a policy decides.
    kept: Vec<Option<Command>>,
    /// What the equipment is asked for by the next decision.
    pub(crate) asked: Asked,
}

impl Inner {
    /// Before the first decision.
    pub(crate) fn new(setup: Setup) -> Self {
        let arms = setup.arms.len();
        Self {
            setup,
            state: Box::new(WorldState::zeroed()),
            echoes: [None; MAX_ARMS],
            time: PolicyTime::default(),
            job: Job::default(),
            out: Output::default(),
            memories: vec![ArmMemory::default(); if arms > 1 { arms } else { 0 }],
            told: [Told::default(); MAX_ARMS],
            resumed: false,
            open: false,
            kept: Vec::new(),
            asked: Asked::default(),
        }
    }

    /// As [`Inner::new`], for a cell whose arms are told outside of decisions.
    pub(crate) fn told_outside(setup: Setup) -> Self {
        let kept = vec![None; setup.arms.len()];
        Self {
            kept,
            ..Self::new(setup)
        }
    }

    /// Shows a state between two decisions.
    pub(crate) fn show(&mut self, state: &WorldState) {
        *self.state = *state;
    }

    /// Gives an arm a command: in this decision, or from the next one on.
    pub(crate) fn tell(&mut self, arm: usize, mut command: Command) -> PyResult<()> {
        if self.open {
            return command.give(self, arm);
        }
        match self.kept.get_mut(arm) {
            Some(kept) => {
                *kept = Some(command);
                Ok(())
            }
            None => Err(outside()),
        }
    }

    /// Gives every arm, and the equipment, what they were told outside of decisions.
    pub(crate) fn give_kept(&mut self) -> PyResult<()> {
        self.give_asked();
        let mut kept = std::mem::take(&mut self.kept);
        let told = kept.iter_mut().enumerate();
        let given = told
            .filter_map(|(arm, command)| Some((arm, command.as_mut()?)))
            .try_for_each(|(arm, command)| command.give(self, arm));
        self.kept = kept;
        given
    }

    fn give_asked(&mut self) {
        let asked = std::mem::take(&mut self.asked);
        let io = &mut self.job.io;
        io.conveyor_running = asked.conveyor.unwrap_or(io.conveyor_running);
        io.add_bin = io.add_bin.wrapping_add(asked.bins);
        io.drop_parts = io.drop_parts.wrapping_add(asked.parts);
    }

    /// Asks the equipment: in this decision, or in the next one.
    fn ask(&mut self, ask: impl FnOnce(&mut Asked)) -> PyResult<()> {
        if !self.open && self.kept.is_empty() {
            return Err(outside());
        }
        ask(&mut self.asked);
        if self.open {
            self.give_asked();
        }
        Ok(())
    }

    /// What the arms were told outside of decisions.
    pub(crate) fn kept(&self) -> &[Option<Command>] {
        &self.kept
    }

    /// Takes back what [`Inner::kept`] gave.
    pub(crate) fn keep(&mut self, kept: Vec<Option<Command>>) {
        if kept.len() == self.kept.len() {
            self.kept = kept;
        }
    }

    /// How the skill that an arm was told ended.
    pub(crate) fn skill_status(&self, arm: usize) -> Option<Status> {
        match self.kept.get(arm)?.as_ref()? {
            Command::Skill(_, ended) => Some(ended.unwrap_or(Status::RUNNING)),
            _ => None,
        }
    }

    /// Controlled joints of an arm.
    pub(crate) fn joint_count(&self, arm: usize) -> usize {
        let arm = self.state.arms().get(arm);
        arm.map_or(0, |arm| arm.joint_count as usize)
    }

    /// Takes what a decision begins with.
    pub(crate) fn begin(&mut self, seen: &Observation<'_>, job: &mut Job, out: &mut Output) {
        *self.state = *seen.state();
        for (arm, echo) in self.echoes.iter_mut().enumerate() {
            *echo = seen.echo(arm);
        }
        self.time = seen.time();
        self.told = [Told::default(); MAX_ARMS];
        self.open = true;
        std::mem::swap(&mut self.job, job);
        std::mem::swap(&mut self.out, out);
    }

    /// Gives back what [`Inner::begin`] took. With `finish`, arms without a command
    /// stay where they are, and drops are counted.
    pub(crate) fn end(&mut self, finish: bool, job: &mut Job, out: &mut Output) {
        if finish {
            (0..self.setup.arms.len()).for_each(|arm| self.world(arm, |world| world.finish()));
            self.resumed = false;
        }
        self.open = false;
        std::mem::swap(&mut self.job, job);
        std::mem::swap(&mut self.out, out);
    }

    /// The view of one arm, as skills use it.
    pub(crate) fn world<R>(&mut self, arm: usize, work: impl FnOnce(&mut World<'_>) -> R) -> R {
        let observation = Observation::with_echoes(&self.state, self.echoes, self.time);
        let mut world = World::new(&self.setup, &observation, &mut self.job, &mut self.out, arm);
        world.resumed = self.resumed;
        world.memory = self.memories.get_mut(arm);
        world.told = self.told.get(arm).copied().unwrap_or_default();
        let result = work(&mut world);
        let told = world.told;
        if let Some(slot) = self.told.get_mut(arm) {
            *slot = told;
        }
        result
    }

    /// Index of an object.
    pub(crate) fn object(&self, name: &str) -> PyResult<usize> {
        let names = || self.setup.objects.iter().map(|o| o.name.as_str()).collect();
        found("object", name, self.setup.object(name), names)
    }

    /// Bit of an obstacle.
    pub(crate) fn obstacle(&self, name: &str) -> PyResult<u64> {
        let names = &self.setup.obstacles;
        let index = names.iter().position(|known| known == name);
        let known = || names.iter().map(String::as_str).collect();
        found("obstacle", name, index.filter(|index| *index < 64), known).map(|index| 1 << index)
    }

    /// Index of a place.
    pub(crate) fn place(&self, name: &str) -> PyResult<usize> {
        let names = || self.setup.places.iter().map(|p| p.name.as_str()).collect();
        found("place", name, self.setup.place(name), names)
    }
}

fn found<'a>(
    what: &str,
    name: &str,
    index: Option<usize>,
    names: impl FnOnce() -> Vec<&'a str>,
) -> PyResult<usize> {
    index.ok_or_else(|| {
        let advice = suggest::advice(name, &names());
        PyValueError::new_err(format!("there is no {what} '{name}'; {advice}"))
    })
}

/// What Python and the policy share.
pub(crate) type Shared = Arc<Mutex<Inner>>;

/// Locks it. A decision that failed leaves nothing half done that matters.
pub(crate) fn lock(shared: &Shared) -> MutexGuard<'_, Inner> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Locks it for a command.
///
/// # Errors
/// Outside of a decision.
pub(crate) fn lock_open(shared: &Shared) -> PyResult<MutexGuard<'_, Inner>> {
    let inner = lock(shared);
    if inner.open {
        return Ok(inner);
    }
    Err(outside())
}

fn outside() -> PyErr {
    PyRuntimeError::new_err("a cell takes commands only while decide() or reconcile() runs")
}

/// The cell in one decision.
#[pyclass(frozen, module = "robocell._core")]
pub(crate) struct Moment {
    pub(crate) shared: Shared,
    about: String,
    /// The state of the newest decision, byte by byte.
    state: Py<PyArray1<u8>>,
}

impl Moment {
    pub(crate) fn new(py: Python<'_>, shared: Shared, about: String) -> Self {
        let bytes = size_of::<WorldState>();
        Self {
            shared,
            about,
            state: PyArray1::zeros(py, bytes, false).unbind(),
        }
    }

    /// Shows Python the state of this decision.
    pub(crate) fn show_state(&self, py: Python<'_>) -> PyResult<()> {
        let inner = lock(&self.shared);
        let mut shown = self.state.bind(py).try_readwrite()?;
        shown
            .as_slice_mut()?
            .copy_from_slice(inner.state.as_bytes());
        Ok(())
    }
}

#[pymethods]
impl Moment {
    /// Names and numbers of the cell, as JSON.
    #[getter]
    fn about(&self) -> &str {
        &self.about
    }

    /// The state of the newest decision, as bytes; see `wire_schema`.
    #[getter]
    fn state(&self, py: Python<'_>) -> Py<PyArray1<u8>> {
        self.state.clone_ref(py)
    }

    /// Policy time (s).
    #[getter]
    fn time_s(&self) -> f64 {
        lock(&self.shared).time.seconds()
    }

    /// Whether decisions were missed before this one.
    #[getter]
    fn resumed(&self) -> bool {
        lock(&self.shared).resumed
    }

    /// The start event was given, for jobs that wait for one.
    #[getter]
    fn started(&self) -> bool {
        lock(&self.shared).job.started
    }

    /// The arm of that index.
    fn arm(&self, index: usize) -> PyResult<Arm> {
        let count = lock(&self.shared).setup.arms.len();
        if index >= count {
            let problem = format!("arm {index} does not exist; the cell has {count}");
            return Err(PyValueError::new_err(problem));
        }
        Ok(Arm::new(Arc::clone(&self.shared), index))
    }

    /// Adds a place for `Place`: `layers` on top of each other, each
    /// `layer_height_m` above the one below.
    #[pyo3(signature = (name, position_m, yaw_rad=0.0, layers=1, layer_height_m=0.0))]
    fn add_place(
        &self,
        name: &str,
        position_m: [f64; 3],
        yaw_rad: f64,
        layers: u32,
        layer_height_m: f64,
    ) -> PyResult<()> {
        let numbers = position_m.into_iter().chain([yaw_rad, layer_height_m]);
        if !numbers.into_iter().all(f64::is_finite) || !(1..=64).contains(&layers) {
            let problem = format!("place '{name}': numbers have to be finite, layers 1 to 64");
            return Err(PyValueError::new_err(problem));
        }
        let pattern = (layers > 1).then_some(Pattern::Stack {
            layers,
            layer_height_m,
        });
        let table = PlaceTable {
            position_m,
            yaw_rad,
            pattern,
        };
        let setup = &mut lock(&self.shared).setup;
        setup.places.retain(|place| place.name != name);
        setup.add_place(name, &table);
        Ok(())
    }

    /// Objects in slots of a place, in the order of the cell file.
    fn placed(&self, place: &str, tolerance_m: f64) -> PyResult<Vec<String>> {
        let mut inner = lock(&self.shared);
        let place = inner.place(place)?;
        let objects = inner.setup.objects.len();
        let placed: Vec<usize> = inner.world(0, |world| {
            let placed = |object: &usize| world.slot_of(*object, place, tolerance_m).is_some();
            (0..objects).filter(placed).collect()
        });
        let names = placed
            .into_iter()
            .map(|o| inner.setup.object_name(o).to_owned());
        Ok(names.collect())
    }

    /// Reports the state of the job: whether it is done, and which objects are in
    /// place; all in slots of places without a list.
    #[pyo3(signature = (done, placed=None))]
    fn report(&self, done: bool, placed: Option<Vec<String>>) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        let Some(placed) = placed else {
            inner.world(0, |world| world.report(done));
            return Ok(());
        };
        let indices: PyResult<Vec<usize>> = placed.iter().map(|n| inner.object(n)).collect();
        let indices = indices?.into_iter().filter_map(|i| u32::try_from(i).ok());
        let inner = &mut *inner;
        inner.job.placed.clear();
        let most = ipc_types::decision::MAX_PLACED;
        inner.job.placed.extend(indices.take(most));
        inner.job.done = done;
        inner.out.outcome = if done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        Ok(())
    }

    /// Gives the job up. `reason` is a stable name; `why` is for the log.
    fn fail(&self, reason: &str, why: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        inner.world(0, |world| world.fail(reason, format_args!("{why}")));
        Ok(())
    }

    /// Adds a log line.
    fn log(&self, line: &str) -> PyResult<()> {
        lock_open(&self.shared)?.out.log(format_args!("{line}"));
        Ok(())
    }

    /// Adds a log line about the end of a phase or a transition.
    fn transition(&self, line: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        inner.out.transition(format_args!("{line}"));
        Ok(())
    }

    /// Counts `drop`, `resync`, `abort` or `recovery`, with a line in the log.
    fn count(&self, what: &str, line: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        let inner = &mut *inner;
        let counters = &mut inner.job.counters;
        let (counter, event) = match what {
            "drop" => (&mut counters.drops, TraceEvent::Drop),
            "resync" => (&mut counters.resyncs, TraceEvent::Resync),
            "abort" => (&mut counters.aborts, TraceEvent::Abort),
            "recovery" => (&mut counters.recoveries, TraceEvent::Recover),
            _ => {
                let known = ["drop", "resync", "abort", "recovery"];
                let advice = suggest::advice(what, &known);
                return Err(PyValueError::new_err(format!(
                    "'{what}' is not counted; {advice}"
                )));
            }
        };
        *counter = counter.saturating_add(1);
        inner.out.event(event, format_args!("{line}"));
        Ok(())
    }

    /// Adds that a node of a picture changed its status.
    fn status(&self, graph: usize, node: usize, change: (u8, u8), why: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        let (from, to) = (status_of(change.0), status_of(change.1));
        inner.out.status((graph, node), from, to, why);
        Ok(())
    }

    /// Adds the answer of a guard.
    fn guard(&self, graph: usize, node: usize, name: &str, holds: bool) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        inner.out.guard((graph, node), name, holds);
        Ok(())
    }

    /// Adds the value of a key of a blackboard.
    fn key(&self, graph: usize, scope: &str, key: &str, value: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        inner.out.key(graph, scope, key, &value);
        Ok(())
    }

    /// Runs or stops the belt.
    fn conveyor(&self, run: bool) -> PyResult<()> {
        lock(&self.shared).ask(|asked| asked.conveyor = Some(run))
    }

    /// Asks for another bin.
    fn add_bin(&self) -> PyResult<()> {
        lock(&self.shared).ask(|asked| asked.bins += 1)
    }

    /// Asks the dispenser for parts.
    fn drop_parts(&self) -> PyResult<()> {
        lock(&self.shared).ask(|asked| asked.parts += 1)
    }
}
