//! The cell in one decision, in memory that Python may hold on to.

use std::sync::Arc;

use behavior::{NodeStatus, suggest};
use ipc_types::trace::TraceEvent;
use ipc_types::{Wire, WorldState};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robocell_skills::settings::{Pattern, PlaceTable};
use robocell_task::Outcome;

use crate::arm::Arm;
use crate::inner::{Shared, lock, lock_open};

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
        // Copied into one array for the whole run: views in Python see every state without a new
        // object.
        let mut shown = self.state.bind(py).try_readwrite()?;
        shown
            .as_slice_mut()?
            .copy_from_slice(inner.decision.state.as_bytes());
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
        lock(&self.shared).decision.time.seconds()
    }

    /// Whether decisions were missed before this one.
    #[getter]
    fn resumed(&self) -> bool {
        lock(&self.shared).decision.resumed
    }

    /// The start event was given, for jobs that wait for one.
    #[getter]
    fn started(&self) -> bool {
        lock(&self.shared).decision.job.started
    }

    /// The arm of that index.
    fn arm(&self, index: usize) -> PyResult<Arm> {
        let count = lock(&self.shared).decision.setup.arms.len();
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
        let setup = &mut lock(&self.shared).decision.setup;
        // A name is looked up from the start of the list, so an older place of this name would win.
        setup.places.retain(|place| place.name != name);
        setup.add_place(name, &table);
        Ok(())
    }

    /// Objects in slots of a place, in the order of the cell file.
    fn placed(&self, place: &str, tolerance_m: f64) -> PyResult<Vec<String>> {
        let mut inner = lock(&self.shared);
        let place = inner.decision.place(place)?;
        let objects = inner.decision.setup.objects.len();
        let placed: Vec<usize> = inner.decision.world(0, |world| {
            let placed = |object: &usize| world.slot_of(*object, place, tolerance_m).is_some();
            (0..objects).filter(placed).collect()
        });
        let names = placed
            .into_iter()
            .map(|o| inner.decision.setup.object_name(o).to_owned());
        Ok(names.collect())
    }

    /// Reports the state of the job: whether it is done, and which objects are in
    /// place; all in slots of places without a list.
    #[pyo3(signature = (done, placed=None))]
    fn report(&self, done: bool, placed: Option<Vec<String>>) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        let Some(placed) = placed else {
            inner.decision.world(0, |world| world.report(done));
            return Ok(());
        };
        let indices: PyResult<Vec<usize>> =
            placed.iter().map(|n| inner.decision.object(n)).collect();
        let indices = indices?.into_iter().filter_map(|i| u32::try_from(i).ok());
        let inner = &mut *inner;
        inner.decision.job.placed.clear();
        // An object that is named twice is placed once, so that all fit.
        for index in indices {
            if !inner.decision.job.placed.contains(&index) {
                inner.decision.job.placed.push(index);
            }
        }
        inner.decision.job.done = done;
        inner.decision.out.outcome = if done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        Ok(())
    }

    /// Gives the job up. `reason` is a stable name; `why` is for the log.
    fn fail(&self, reason: &str, why: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        inner
            .decision
            .world(0, |world| world.fail(reason, format_args!("{why}")));
        Ok(())
    }

    /// Adds a log line.
    fn log(&self, line: &str) -> PyResult<()> {
        lock_open(&self.shared)?
            .decision
            .out
            .log(format_args!("{line}"));
        Ok(())
    }

    /// Adds a log line about the end of a phase or a transition.
    fn transition(&self, line: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        inner.decision.out.transition(format_args!("{line}"));
        Ok(())
    }

    /// Counts `drop`, `resync`, `abort` or `recovery`, with a line in the log.
    fn count(&self, what: &str, line: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        let inner = &mut *inner;
        let counters = &mut inner.decision.job.counters;
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
        inner.decision.out.event(event, format_args!("{line}"));
        Ok(())
    }

    /// Adds that a node of a picture changed its status.
    fn status(&self, graph: usize, node: usize, change: (u8, u8), why: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        let (from, to) = (status_of(change.0), status_of(change.1));
        inner.decision.out.status((graph, node), from, to, why);
        Ok(())
    }

    /// Adds the answer of a guard.
    fn guard(&self, graph: usize, node: usize, name: &str, holds: bool) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        inner.decision.out.guard((graph, node), name, holds);
        Ok(())
    }

    /// Adds the value of a key of a blackboard.
    fn key(&self, graph: usize, scope: &str, key: &str, value: &str) -> PyResult<()> {
        let mut inner = lock_open(&self.shared)?;
        inner.decision.out.key(graph, scope, key, &value);
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
