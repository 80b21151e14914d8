//! A cell in this process, which Python steps.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use camera::Picture;
use cell_model::Cell;
use cell_model::cells::replace::of_arguments;
use cell_model::cells::script;
use cell_model::cells::setting::Setting;
use cell_run::report;
use cell_run::spec::RunSpec;
use cell_sim::{OneProcess, SimError, eval};
use ipc_types::{Decision, Wire};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use robocell_skills::Setup;
use robocell_task::{AnyPolicy, Policies};
use robocell_task_program::inspect;
use serde_json::Value;

use crate::about;
use crate::inner::{Inner, Shared, lock};
use crate::moment::Moment;
use crate::outside::{self, Outside};
use crate::picture;
use crate::policy::{Reports, places};
use crate::program;

type Fault = Arc<Mutex<Option<PyErr>>>;

/// A cell in this process.
#[pyclass(frozen, module = "robocell._core")]
pub(crate) struct Sim {
    run: Mutex<Run>,
    /// The state that Python sees, and its commands for the arms.
    shared: Shared,
    moment: Py<Moment>,
    /// The newest decision, byte by byte.
    decision: Py<PyArray1<u8>>,
    /// The exception that a policy in Python raised.
    fault: Fault,
}

/// The cell, and the inputs that it was made from.
struct Run {
    sim: OneProcess,
    spec: RunSpec,
    cell: Cell,
    policies: Policies,
    began: Instant,
    /// Lines of the task that were not taken, with their ticks.
    log: Vec<(u64, String)>,
}

impl Run {
    fn new(spec: RunSpec, policies: Policies) -> Result<Self, SimError> {
        let cell = spec.load_cell_from(&cell_files::data())?;
        let sim = OneProcess::new(&policies, &spec, cell.clone())?;
        Ok(Self {
            sim,
            spec,
            cell,
            policies,
            began: Instant::now(),
            log: Vec::new(),
        })
    }

    /// Keeps the lines and warnings of the cell since the last call.
    fn take_news(&mut self) {
        let lines = self.sim.take_trace();
        let tick = self.sim.state().header.tick;
        let warnings = self.sim.take_warnings();
        let warnings = warnings.into_iter();
        self.log.extend(lines);
        // Warnings have no tick of their own.
        self.log
            .extend(warnings.map(|text| (tick, format!("[warning] {text}"))));
    }

    /// Advances at most `ticks`; how many it were. A cell that has ended does not
    /// advance.
    fn step(&mut self, ticks: u64, fault: &Fault) -> Result<u64, SimError> {
        for done in 0..ticks {
            // Not a tick further after an exception: Python sees the state in which it was raised.
            if !self.sim.tick()? || peek(fault).is_some() {
                return Ok(done);
            }
        }
        Ok(ticks)
    }
}

fn peek(fault: &Fault) -> MutexGuard<'_, Option<PyErr>> {
    fault.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Sim {
    /// The cell, for a call that does not hold the interpreter.
    fn lock(&self) -> MutexGuard<'_, Run> {
        self.run.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Pictures of cameras in the present state.
    pub(crate) fn pictures(&self, cameras: &[String]) -> Result<Vec<Picture>, String> {
        let run = self.lock();
        camera::observe(&run.cell, run.sim.state(), cameras).map_err(|error| error.to_string())
    }

    /// Advances; then Python sees the new state. The interpreter is not held.
    pub(crate) fn advance(&self, ticks: u64) -> PyResult<u64> {
        let mut run = self.lock();
        let done = run.step(ticks, &self.fault).map_err(refused);
        // After an error as well: Python sees the state in which the cell stopped.
        lock(&self.shared).decision.show(run.sim.state());
        run.take_news();
        if let Some(raised) = peek(&self.fault).take() {
            return Err(raised);
        }
        done
    }

    /// Shows Python the newest messages.
    pub(crate) fn show(&self, py: Python<'_>) -> PyResult<()> {
        self.moment.get().show_state(py)?;
        // A thread that steps the cell may wait for the interpreter.
        let decision = py.detach(|| Box::new(*self.lock().sim.decision()));
        let mut shown = self.decision.bind(py).try_readwrite()?;
        shown.as_slice_mut()?.copy_from_slice(decision.as_bytes());
        Ok(())
    }
}

#[pymethods]
impl Sim {
    /// Loads `name`, of the folder `data` or a built-in one. `policy` names a policy;
    /// with `maker` it is one in Python; without both the arms are commanded from outside.
    #[new]
    #[pyo3(signature = (name, seed=0, policy=None, maker=None, data=None, bins=None, script=None,
                        time_limit_s=None, set=Vec::new(), replace=Vec::new()))]
    #[allow(clippy::too_many_arguments, reason = "they are named in Python")]
    fn new(
        py: Python<'_>,
        name: &str,
        seed: u64,
        policy: Option<String>,
        maker: Option<Py<PyAny>>,
        data: Option<PathBuf>,
        bins: Option<u32>,
        script: Option<&str>,
        time_limit_s: Option<f64>,
        set: Vec<String>,
        replace: Vec<String>,
    ) -> PyResult<Self> {
        let mut spec = eval::template(name, "");
        spec.seed = seed;
        spec.data_dir = data;
        spec.bins = bins;
        spec.time_limit_s = time_limit_s;
        let set: Result<Vec<Setting>, String> = set.iter().map(|one| one.parse()).collect();
        spec.set = set.map_err(PyValueError::new_err)?;
        spec.replace = of_arguments(&replace).map_err(refused)?;
        let cell = spec.load_cell_from(&cell_files::data()).map_err(refused)?;
        if let Some(script) = script {
            spec.script = script::parse_for(script, "script", &cell).map_err(refused)?;
        }
        let settings: Value = cell.task.read().map_err(refused)?;
        let setup = Setup::new(
            &cell,
            places(&settings).iter().map(|(name, table)| (name, table)),
        );
        let told = about::cell(&cell, &setup, &settings);
        let is_outside = policy.is_none() && maker.is_none();
        let shared: Shared = Arc::new(Mutex::new(if is_outside {
            Inner::told_outside(setup)
        } else {
            Inner::new(setup)
        }));
        let fault = Fault::default();
        let policies = match maker {
            Some(maker) => in_python(maker, &fault, &mut spec),
            None if is_outside => from_outside(&shared, &mut spec),
            None => built_in(policy.as_deref().unwrap_or_default(), &cell, &mut spec),
        };
        // A program that commands the arms itself decides when the run ends.
        if !is_outside {
            spec.time_limit_s = Some(time_limit_s.unwrap_or(cell.time_limit_s));
        }
        let run = py.detach(|| Run::new(spec, policies)).map_err(refused)?;
        lock(&shared).decision.show(run.sim.state());
        let moment = Moment::new(py, Arc::clone(&shared), told);
        let sim = Self {
            run: Mutex::new(run),
            shared,
            moment: Py::new(py, moment)?,
            decision: PyArray1::zeros(py, size_of::<Decision>(), false).unbind(),
            fault,
        };
        sim.show(py)?;
        Ok(sim)
    }

    /// The state of the cell, with its arms.
    #[getter]
    fn moment(&self, py: Python<'_>) -> Py<Moment> {
        self.moment.clone_ref(py)
    }

    /// The newest decision, as bytes; see `wire_schema`.
    #[getter]
    fn decision(&self, py: Python<'_>) -> Py<PyArray1<u8>> {
        self.decision.clone_ref(py)
    }

    /// Advances at most that many ticks of 1 ms; how many it were. Other threads of
    /// Python run meanwhile.
    #[pyo3(signature = (ticks=1))]
    fn step(&self, py: Python<'_>, ticks: u64) -> PyResult<u64> {
        let done = py.detach(|| self.advance(ticks));
        self.show(py)?;
        done
    }

    /// Back to the start, of another seed if one is given.
    #[pyo3(signature = (seed=None))]
    fn reset(&self, py: Python<'_>, seed: Option<u64>) -> PyResult<()> {
        py.detach(|| {
            let mut run = self.lock();
            let mut spec = run.spec.clone();
            spec.seed = seed.unwrap_or(spec.seed);
            {
                let mut inner = lock(&self.shared);
                let setup = inner.decision.setup.clone();
                // Replaced in place: the moment and the arms in Python share this value.
                *inner = if inner.kept().is_empty() {
                    Inner::new(setup)
                } else {
                    Inner::told_outside(setup)
                };
            }
            *run = Run::new(spec, run.policies.clone()).map_err(refused)?;
            lock(&self.shared).decision.show(run.sim.state());
            Ok::<(), PyErr>(())
        })?;
        self.show(py)
    }

    /// All of the cell as bytes.
    fn snapshot(&self, py: Python<'_>) -> PyResult<Py<PyBytes>> {
        let bytes = py.detach(|| self.lock().sim.snapshot()).map_err(refused)?;
        Ok(PyBytes::new(py, &bytes).unbind())
    }

    /// Goes back to a snapshot of the same cell, seed and policy.
    fn restore(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        py.detach(|| {
            let mut run = self.lock();
            // The policy is restored before physics, which may refuse the snapshot.
            let before = outside::Memory::of(&lock(&self.shared));
            let restored = run.sim.restore(bytes).map_err(refused);
            let mut inner = lock(&self.shared);
            if restored.is_err() {
                before.put(&mut inner);
            }
            inner.decision.show(run.sim.state());
            restored
        })?;
        self.show(py)
    }

    /// A picture, height x width x RGB: from a point towards another (m, world frame),
    /// by default those of the cell file.
    #[pyo3(signature = (width, height, eye_m=None, target_m=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: u32,
        height: u32,
        eye_m: Option<[f64; 3]>,
        target_m: Option<[f64; 3]>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let picture = py.detach(|| {
            let run = self.lock();
            picture::from_point(
                &run.cell,
                run.sim.state(),
                (width, height),
                (eye_m, target_m),
            )
        });
        picture::colour(py, &picture.map_err(PyValueError::new_err)?)
    }

    /// What cameras of the cell file see: colour, depth (m) and mask of each.
    fn observe<'py>(
        &self,
        py: Python<'py>,
        cameras: Vec<String>,
    ) -> PyResult<Vec<picture::Seen<'py>>> {
        let pictures = py.detach(|| self.pictures(&cameras));
        let pictures = pictures.map_err(PyValueError::new_err)?;
        pictures
            .iter()
            .map(|picture| picture::arrays(py, picture))
            .collect()
    }

    /// Names of the cameras of the cell file.
    #[getter]
    fn cameras(&self) -> Vec<String> {
        let run = self.lock();
        run.cell
            .cameras
            .iter()
            .map(|camera| camera.name.clone())
            .collect()
    }

    /// Names of the numbers of a mask, from 1 on.
    #[getter]
    fn instances(&self) -> Vec<String> {
        camera::instances(&self.lock().cell)
    }

    /// Lines of the task since the last call, with their ticks.
    fn take_log(&self, py: Python<'_>) -> Vec<(u64, String)> {
        py.detach(|| std::mem::take(&mut self.lock().log))
    }

    /// Warnings about the files of the cell, and the script.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> Vec<String> {
        py.detach(|| {
            let run = self.lock();
            let drawing = inspect::draw(run.sim.task().graphs(), "text", usize::MAX);
            let mut all = report::of_cell(&run.cell);
            all.extend(report::of_script(&run.spec.script, &drawing, &run.cell));
            all
        })
    }

    /// What `robocell run --json` prints at the end of a run, of the run so far.
    fn summary(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| {
            let run = self.lock();
            let wall_time_s = run.began.elapsed().as_secs_f64();
            let summary = run.sim.summary(&run.spec, wall_time_s);
            serde_json::to_string(&summary).map_err(refused)
        })
    }
}

/// The policies of the demos, and the one that is named; the default one for "".
fn built_in(policy: &str, cell: &Cell, spec: &mut RunSpec) -> Policies {
    let policies = demos::policies();
    let policy = match policy {
        "" => policies.default_policy(cell).to_owned(),
        named => named.to_owned(),
    };
    spec.policy = policy;
    policies
}

fn in_python(maker: Py<PyAny>, fault: &Fault, spec: &mut RunSpec) -> Policies {
    "python".clone_into(&mut spec.policy);
    let fault = Arc::clone(fault);
    let reports = Reports {
        on_fault: Arc::new(move |error, _| {
            // The first is the cause.
            let _kept = peek(&fault).get_or_insert(error);
        }),
        // `Cell.log` has it.
        on_warning: Arc::new(|_| {}),
    };
    program::policies(vec![(spec.policy.clone(), maker)], &reports)
}

fn from_outside(shared: &Shared, spec: &mut RunSpec) -> Policies {
    outside::NAME.clone_into(&mut spec.policy);
    let shared = Arc::clone(shared);
    Policies::new().policy_for_every_kind(outside::NAME, move |_| {
        let policy: Box<dyn AnyPolicy> = Box::new(Outside::new(&shared));
        Ok(policy)
    })
}

fn refused(problem: impl std::error::Error) -> PyErr {
    PyValueError::new_err(problem.to_string())
}
