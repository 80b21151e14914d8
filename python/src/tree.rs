//! A tree from a file whose leaves are in Python: the tree itself is the one of `behavior`.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use behavior::board::{Board, Fault};
use behavior::descriptor::{self, Source};
use behavior::status::{ResetReason, Status as Answer};
use behavior::tree::{BindError, Cx, DeclaredLeaf, Halt, Host, Leaf, Library, Tree, any};
use behavior::value::Numbers;
use behavior::{NodeStatus, Str, Value, suggest};
use cell_model::cells::replace::Replace;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use robocell_task::replaced::replace_leaves;

use crate::work::Status;

/// Calls Python for its leaves.
struct Python3;

impl Host for Python3 {
    type World<'w> = Caller<'w>;
}

/// What a tick lends to the leaves.
struct Caller<'w> {
    call: &'w Py<PyAny>,
    /// The first exception of this tick.
    error: Option<PyErr>,
}

/// A leaf of a Python class or function; its memory is in Python.
struct PyLeaf(DeclaredLeaf);

impl PyLeaf {
    /// Calls `leaf(node, what, ports)`, which answers a status and the ports to write.
    fn call(&self, what: &str, cx: &mut Cx<'_, '_, Python3>) -> PyResult<Answer> {
        Python::attach(|py| {
            let ports = PyDict::new(py);
            for port in &self.0.ports {
                if let Some(value) = port.get(cx) {
                    ports.set_item(&port.name, to_python(py, value)?)?;
                }
            }
            let said = cx.world.call.call1(py, (&self.0.node, what, ports))?;
            let (status, writes) = said.extract::<(Status, Bound<'_, PyDict>)>(py)?;
            for (name, value) in writes {
                self.write(&name.extract::<String>()?, &value, cx)?;
            }
            Ok(match status {
                Status::RUNNING => Answer::Running,
                Status::SUCCESS => Answer::Success,
                Status::FAILURE => Answer::Failure,
            })
        })
    }

    fn write(
        &self,
        name: &str,
        value: &Bound<'_, PyAny>,
        cx: &mut Cx<'_, '_, Python3>,
    ) -> PyResult<()> {
        let node = &self.0.node;
        let Some(port) = self.0.ports.iter().find(|port| port.name == name) else {
            let known: Vec<&str> = self.0.ports.iter().map(|p| p.name.as_str()).collect();
            let advice = suggest::advice(name, &known);
            let problem = format!("'{node}' has no bound port '{name}'; {advice}");
            return Err(PyValueError::new_err(problem));
        };
        let whole = integer(value);
        let value = from_python(name, value)?;
        // A whole number of Python fits a key of numbers, and one of integers.
        let set = port.set(cx, value).or_else(|fault| match (fault, whole) {
            (Fault::NotFinite(_), Some(whole)) => port.set(cx, Value::Integer(whole)),
            _ => Err(fault),
        });
        set.map_err(|fault| {
            let why = match fault {
                Fault::Access => "it is not bound to a key that it writes",
                _ => "its key is of another type",
            };
            PyTypeError::new_err(format!(
                "'{node}' cannot write {value} to port '{name}': {why}"
            ))
        })
    }
}

impl Leaf<Python3> for PyLeaf {
    type State = ();

    fn start(&self, (): &mut (), cx: &mut Cx<'_, '_, Python3>) -> Result<(), Fault> {
        self.say("start", cx).map(|_| ())
    }

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Python3>) -> Result<Answer, Fault> {
        self.say("tick", cx)
    }

    fn halt(&self, (): &mut (), cx: &mut Cx<'_, '_, Python3>, _: ResetReason) -> Halt {
        // The caller has kept an exception, which ends the decision.
        let _answer = self.say("halt", cx);
        Halt::Done
    }
}

impl PyLeaf {
    fn say(&self, what: &str, cx: &mut Cx<'_, '_, Python3>) -> Result<Answer, Fault> {
        if cx.world.error.is_some() {
            return Err(Fault::Node("a leaf before it raised an exception"));
        }
        self.call(what, cx).map_err(|error| {
            cx.world.error = Some(error);
            Fault::Node("it raised an exception")
        })
    }
}

fn to_python(py: Python<'_>, value: Value) -> PyResult<Bound<'_, PyAny>> {
    Ok(match value {
        Value::Bool(value) => value.into_pyobject(py)?.to_owned().into_any(),
        Value::Integer(value) => value.into_pyobject(py)?.into_any(),
        Value::Number(value) => value.into_pyobject(py)?.into_any(),
        Value::Text(value) => value.as_str().into_pyobject(py)?.into_any(),
        Value::Numbers(value) => value.as_slice().into_pyobject(py)?.into_any(),
        set @ Value::Set(_) => set.to_string().into_pyobject(py)?.into_any(),
    })
}

/// A whole number; `True` and `False` are none.
fn integer(value: &Bound<'_, PyAny>) -> Option<i64> {
    let is_flag = value.extract::<bool>().is_ok();
    value.extract().ok().filter(|_| !is_flag)
}

fn from_python(port: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    // Before numbers: `True` is a number of Python as well.
    if let Ok(value) = value.extract::<bool>() {
        return Ok(Value::Bool(value));
    }
    if let Ok(value) = value.extract::<f64>() {
        return Ok(Value::Number(value));
    }
    if let Ok(text) = value.extract::<String>() {
        return Str::new(&text).map(Value::Text).ok_or_else(|| {
            PyValueError::new_err(format!(
                "port '{port}' is given {} bytes of text, at most 62 fit",
                text.len()
            ))
        });
    }
    let numbers = value.extract::<Vec<f64>>().ok();
    let numbers = numbers.and_then(|numbers| Numbers::new(&numbers));
    numbers.map(Value::Numbers).ok_or_else(|| {
        PyTypeError::new_err(format!(
            "port '{port}' is given {value}; True, False, a number, a text or a few numbers are \
             needed"
        ))
    })
}

/// A tree from a file.
#[pyclass(module = "robocell._core")]
pub(crate) struct FileTree {
    /// Python shares its objects between threads.
    tree: Mutex<Tree<Python3>>,
    shared: Board,
}

impl FileTree {
    fn tree(&mut self) -> &mut Tree<Python3> {
        self.tree.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl FileTree {
    /// The tree of `text`; `include` reads a file by its name, or raises. Types of
    /// leaves are known by name.
    #[new]
    fn new(
        file: &str,
        text: &str,
        known: Vec<String>,
        include: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let read = |name: &str| -> Result<String, String> {
            let text = include.call1((name,)).and_then(|text| text.extract());
            text.map_err(|error: PyErr| error.value(include.py()).to_string())
        };
        let source = Source {
            file,
            text,
            include: &read,
        };
        let library = Library::default().with_declared(move |leaf| {
            if known.contains(&leaf.type_name) {
                return Ok(any(PyLeaf(leaf)));
            }
            let names: Vec<&str> = known.iter().map(String::as_str).collect();
            let advice = suggest::advice(&leaf.type_name, &names);
            Err(BindError::Host(format!(
                "the policy's 'leaves' have no '{}'; {advice}",
                leaf.type_name
            )))
        });
        let mut shared = Board::new();
        let tree = descriptor::load(&source, &library, &BTreeMap::new(), &mut shared)
            .map_err(|errors| PyValueError::new_err(errors.to_string()))?;
        let tree = Mutex::new(tree);
        Ok(Self { tree, shared })
    }

    /// Replaces leaves, by rules as JSON.
    fn replace(&mut self, rules: &str) -> PyResult<()> {
        let refused = |problem: String| PyValueError::new_err(problem);
        let rules: Vec<Replace> =
            serde_json::from_str(rules).map_err(|error| refused(error.to_string()))?;
        replace_leaves([self.tree()], &rules).map_err(refused)
    }

    /// Ids and types of its nodes, as JSON.
    fn graph(&mut self) -> PyResult<String> {
        serde_json::to_string(&self.tree().graph())
            .map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Ticks it at `milliseconds`; `leaf` is called for the leaves.
    fn tick(&mut self, milliseconds: u64, leaf: Py<PyAny>) -> PyResult<Status> {
        let mut caller = Caller {
            call: &leaf,
            error: None,
        };
        let now = Duration::from_millis(milliseconds);
        let tree = self.tree.get_mut().unwrap_or_else(PoisonError::into_inner);
        let answer = tree.tick(now, &mut self.shared, &mut caller);
        match caller.error {
            Some(error) => Err(error),
            None => Ok(answer.into()),
        }
    }

    /// The status of each node.
    fn statuses<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let mut statuses = Vec::new();
        self.tree().statuses(&mut statuses);
        let numbers = statuses.into_iter().map(|status| match status {
            NodeStatus::Running => 1,
            NodeStatus::Success => 2,
            NodeStatus::Failure => 3,
            _ => 0,
        });
        PyBytes::new(py, &numbers.collect::<Vec<u8>>())
    }

    /// Index of the node that gave the answer.
    fn tip(&mut self) -> Option<usize> {
        self.tree().tip()
    }

    /// Keys that have a value, with their text.
    fn values(&mut self) -> Vec<(String, String)> {
        let board = self.tree().local();
        let keys = board.keys().enumerate();
        let valued = keys
            .filter_map(|(index, key)| Some((key.name.clone(), board.value(index)?.to_string())));
        valued.collect()
    }

    /// The state of the engine and the blackboard.
    fn save<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let mut record = Vec::new();
        self.tree().save(&mut record);
        PyBytes::new(py, &record)
    }

    /// Takes back what `save` gave; how many nodes and keys are not in the file any more.
    fn restore(&mut self, record: &[u8]) -> PyResult<usize> {
        self.tree()
            .restore(record)
            .map(|carried| carried.lost)
            .map_err(|error| PyValueError::new_err(error.to_string()))
    }
}
