//! A policy written in Python, in the form a task keeps.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use behavior::NodeStatus;
use behavior::graph::{Graph, GraphKind};
use cell_model::Cell;
use cell_model::cells::replace::Replace;
use ipc_types::Text;
use ipc_types::trace::TraceEvent;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use robocell_skills::settings::check_places;
use robocell_skills::{ArmMemory, PlaceTable, Setup};
use robocell_task::{AnyPolicy, Job, Observation, Output, SetupError, checkpoint};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::about;
use crate::inner::{Inner, Shared, lock};
use crate::moment::{Moment, status_of};

/// Reason of a job whose policy raised an exception.
const RAISED: &str = "policy_raised";

/// Gets an exception of a policy, and a sentence with its file and line.
pub(crate) type OnFault = Arc<dyn Fn(PyErr, &str) + Send + Sync>;
/// Gets a warning, which is a line in the log of the task as well.
pub(crate) type OnWarning = Arc<dyn Fn(&str) + Send + Sync>;

/// Where the problems of a policy are reported.
#[derive(Clone)]
pub(crate) struct Reports {
    pub(crate) on_fault: OnFault,
    pub(crate) on_warning: OnWarning,
}

/// Kind of a line from Python that is a warning; any other line is about the task itself.
const WARNING: &str = "warning";

/// The memory of a policy between two decisions.
#[derive(Serialize, Deserialize)]
struct Memory {
    #[serde(with = "serde_bytes")]
    object: Vec<u8>,
    arms: Vec<ArmMemory>,
    resumed: bool,
}

/// A policy in Python. `runner` is a `robocell.task._runner.Runner`, which knows the
/// kinds of policies there are.
pub(crate) struct PyPolicy {
    runner: Py<PyAny>,
    moment: Py<Moment>,
    shared: Shared,
    reports: Reports,
    phase: Text<32>,
    /// Whether the last restore took anything back.
    has_resumed: bool,
}

impl PyPolicy {
    /// Of `make`, a `Maker` of the Python package, for a cell.
    ///
    /// # Errors
    /// The exception of its constructor, with file and line.
    pub(crate) fn new(
        make: &Py<PyAny>,
        cell: &Cell,
        reports: &Reports,
    ) -> Result<Self, SetupError> {
        let refused = |problem: String| SetupError::in_file(problem);
        let settings: Value = cell.task.read().map_err(|e| refused(e.to_string()))?;
        let named: BTreeMap<String, PlaceTable> = places(&settings).into_iter().collect();
        check_places(&named, cell, &cell.task.checker()).map_err(|e| refused(e.to_string()))?;
        let setup = Setup::new(cell, &named);
        let told = about::cell(cell, &setup, &settings);
        let shared: Shared = Arc::new(Mutex::new(Inner::new(setup)));
        Python::attach(|py| {
            let failed = |error: PyErr| refused(explain(py, &error));
            let moment = Moment::new(py, Arc::clone(&shared), told);
            let moment = Py::new(py, moment).map_err(failed)?;
            let runner = make.call1(py, (moment.clone_ref(py),)).map_err(failed)?;
            Ok(Self {
                runner,
                moment,
                shared,
                reports: reports.clone(),
                phase: Text::EMPTY,
                has_resumed: true,
            })
        })
    }

    /// Calls a method of the policy inside of a decision.
    fn call(&mut self, method: &str, seen: &Observation<'_>, job: &mut Job, out: &mut Output) {
        // Locked twice, not over the call: Python locks it for every command.
        lock(&self.shared).decision.begin(seen, job, out);
        let answer = Python::attach(|py| {
            let called = self.moment.get().show_state(py);
            let said = called.and_then(|()| self.runner.call_method0(py, method));
            let said = said.and_then(|said| said.extract::<(String, Vec<(String, String)>)>(py));
            said.map_err(|error| (explain(py, &error), error))
        });
        lock(&self.shared)
            .decision
            .end(answer.is_ok() && method == "decide", job, out);
        match answer {
            Ok((phase, lines)) => {
                self.phase = Text::new(&phase);
                for (kind, line) in lines {
                    self.tell(&kind, &line, out);
                }
            }
            Err((problem, error)) => {
                out.event(TraceEvent::Fault, format_args!("[fault] {problem}"));
                job.fail(RAISED);
                (self.reports.on_fault)(error, &problem);
            }
        }
    }

    /// Adds a line about the policy's memory: a loss, or the changes of an edited file.
    fn tell(&self, kind: &str, line: &str, out: &mut Output) {
        if kind == WARNING {
            out.log(format_args!("[warning] {line}"));
            (self.reports.on_warning)(line);
        } else {
            out.lifecycle(TraceEvent::None, format_args!("[task] {line}"));
        }
    }

    /// Calls a method that decides nothing; the default after an exception, which is
    /// reported.
    fn ask<T: Default>(&self, ask: impl FnOnce(Python<'_>, &Py<PyAny>) -> PyResult<T>) -> T {
        Python::attach(|py| match ask(py, &self.runner) {
            Ok(answer) => answer,
            Err(error) => {
                let problem = explain(py, &error);
                (self.reports.on_fault)(error, &problem);
                T::default()
            }
        })
    }
}

/// The places that `[task]` names, in the form of the file tasks.
pub(crate) fn places(settings: &Value) -> Vec<(String, PlaceTable)> {
    let tables = settings.get("place").and_then(Value::as_object);
    let tables = tables.into_iter().flatten();
    tables
        .filter_map(|(name, table)| {
            let table = serde_json::from_value(table.clone()).ok()?;
            Some((name.clone(), table))
        })
        .collect()
}

/// An exception in one line: file, line and message.
pub(crate) fn explain(py: Python<'_>, error: &PyErr) -> String {
    // Up to Python 3.11 only this conversion gives the exception its traceback.
    let raised = error.clone_ref(py).into_value(py);
    let explained = py
        .import("robocell.task._explain")
        .and_then(|module| module.call_method1("explain", (raised,)))
        .and_then(|text| text.extract::<String>());
    explained.unwrap_or_else(|_| error.to_string())
}

/// The picture that Python draws of a policy.
#[derive(Deserialize)]
struct Picture {
    kind: GraphKind,
    nodes: Vec<behavior::graph::GraphNode>,
    edges: Vec<behavior::graph::GraphEdge>,
    #[serde(default)]
    name: Option<String>,
}

impl AnyPolicy for PyPolicy {
    fn replace(&mut self, rules: &[Replace]) -> Result<(), String> {
        let rules = serde_json::to_string(rules).map_err(|error| error.to_string())?;
        Python::attach(|py| {
            let replaced = self.runner.call_method1(py, "replace", (rules,));
            replaced
                .map(|_| ())
                .map_err(|error| error.value(py).to_string())
        })
    }

    fn reset(&mut self) {
        self.phase = Text::EMPTY;
        // Unlocked before the call: Python locks it for every look at the cell.
        {
            let mut inner = lock(&self.shared);
            inner.decision.memories.fill(ArmMemory::default());
            inner.decision.resumed = false;
        }
        self.has_resumed = true;
        self.ask(|py, runner| runner.call_method0(py, "reset").map(|_| ()));
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        self.call("decide", observation, job, out);
        if out.phase == Text::EMPTY {
            out.phase = self.phase;
        }
    }

    fn phase(&self) -> Text<32> {
        self.phase
    }

    fn describe(&self, name: &str) -> Vec<Graph> {
        let text: String = self.ask(|py, runner| {
            let text = runner.call_method1(py, "graphs", (name,))?;
            text.extract(py)
        });
        // Empty after an exception, which `ask` has reported: the policy then has no picture.
        let pictures: Vec<Picture> = serde_json::from_str(&text).unwrap_or_default();
        let graphs = pictures.into_iter().map(|picture| Graph {
            kind: picture.kind,
            name: picture.name.unwrap_or_else(|| name.to_owned()),
            nodes: picture.nodes,
            edges: picture.edges,
        });
        graphs.collect()
    }

    fn statuses(&self, graph: usize, out: &mut Vec<NodeStatus>) {
        let numbers: Vec<u8> = self.ask(|py, runner| {
            let numbers = runner.call_method1(py, "statuses", (graph,))?;
            let numbers = numbers.bind(py).cast::<PyBytes>()?;
            Ok(numbers.as_bytes().to_vec())
        });
        out.extend(numbers.into_iter().map(status_of));
    }

    fn has_resumed(&self) -> bool {
        self.has_resumed
    }

    fn save(&self) -> Vec<u8> {
        let object: PyResult<Vec<u8>> = Python::attach(|py| {
            let bytes = self.runner.call_method0(py, "save")?;
            Ok(bytes.bind(py).cast::<PyBytes>()?.as_bytes().to_vec())
        });
        // A process that ended here would end after each restart, too: it continues, and
        // only a restart starts the policy again.
        let object = object.unwrap_or_else(|error| {
            let problem = Python::attach(|py| explain(py, &error));
            (self.reports.on_warning)(&format!("the memory is not kept: {problem}"));
            Vec::new()
        });
        let inner = lock(&self.shared);
        checkpoint::to_bytes(&Memory {
            object,
            arms: inner.decision.memories.clone(),
            resumed: inner.decision.resumed,
        })
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.reset();
        let memory: Memory = checkpoint::from_bytes(bytes)?;
        {
            let mut inner = lock(&self.shared);
            if memory.arms.len() == inner.decision.memories.len() {
                inner.decision.memories = memory.arms;
            }
            inner.decision.resumed = memory.resumed;
        }
        // `save` raised an exception: the policy starts without its memory.
        if memory.object.is_empty() {
            self.has_resumed = false;
            return Ok(());
        }
        let restored: PyResult<(String, bool)> = Python::attach(|py| {
            let state = PyBytes::new(py, &memory.object);
            self.runner
                .call_method1(py, "restore", (state,))?
                .extract(py)
        });
        match restored {
            Ok((phase, has_resumed)) => {
                self.phase = Text::new(&phase);
                self.has_resumed = has_resumed;
                Ok(())
            }
            Err(error) => {
                let problem = Python::attach(|py| explain(py, &error));
                // Python may have restored a part before it raised the exception.
                self.reset();
                Err(serde::de::Error::custom(problem))
            }
        }
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        lock(&self.shared).decision.resumed = true;
        self.call("reconcile", observation, job, out);
    }
}
