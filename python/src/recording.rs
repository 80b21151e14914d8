//! Recordings as arrays.

use std::path::PathBuf;

use cell_record::{Channel, Entry, RecordError, Recording};
use ipc_types::trace::{TraceEvent, TraceKind};
use ipc_types::{ArmState, ArmStatus, Decision, ObjectState, TraceLine, Wire, WorldPiece};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

/// The messages that were read, as bytes of structs one after the other.
#[derive(Default)]
struct Read {
    ticks: Vec<u64>,
    /// When each of these states was sent (monotonic, ns).
    published_ns: Vec<u64>,
    arms: Vec<u8>,
    objects: Vec<u8>,
    decisions: Vec<u8>,
    statuses: Vec<Vec<u8>>,
    /// Tick, name of the event, text.
    log: Vec<(u64, Option<&'static str>, String)>,
    /// Pieces of a recording that cannot be read.
    problems: Vec<String>,
    arm_count: usize,
    object_count: usize,
    /// The newest known state of each object.
    known: Vec<ObjectState>,
    /// A state with all objects was read; those before it are left out.
    has_all: bool,
}

/// The newest history of a recording, a file or the directory of a flight recorder: its
/// description as JSON, and its arrays by name. Of states and statuses it has those of each
/// `every`th tick.
///
/// # Errors
/// For a path that is not a recording.
#[pyfunction]
#[pyo3(signature = (path, every=10))]
pub(crate) fn read_recording(
    py: Python<'_>,
    path: PathBuf,
    every: u64,
) -> PyResult<(String, Bound<'_, PyDict>)> {
    if every == 0 {
        return Err(PyValueError::new_err("every is 0; 1 and more are allowed"));
    }
    let (about, read) = py
        .detach(|| {
            // Other threads of Python can run while a long recording is read.
            let recording = Recording::open(&path)?;
            let read = Read::of(&recording, every);
            Ok::<_, RecordError>((about(&recording, &read), read))
        })
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let arrays = PyDict::new(py);
    arrays.set_item("ticks", PyArray1::from_vec(py, read.ticks))?;
    arrays.set_item("published_ns", PyArray1::from_vec(py, read.published_ns))?;
    arrays.set_item("arms", PyArray1::from_vec(py, read.arms))?;
    arrays.set_item("objects", PyArray1::from_vec(py, read.objects))?;
    arrays.set_item("decisions", PyArray1::from_vec(py, read.decisions))?;
    let statuses = read.statuses.into_iter();
    let statuses: Vec<_> = statuses
        .map(|bytes| PyArray1::from_vec(py, bytes))
        .collect();
    arrays.set_item("statuses", statuses)?;
    arrays.set_item("log", read.log)?;
    Ok((about, arrays))
}

fn about(recording: &Recording, read: &Read) -> String {
    let (run, scene) = (recording.run(), recording.scene());
    let names = |list: &Value| -> Vec<Value> {
        let list = list.as_array().into_iter().flatten();
        list.map(|one| one["name"].clone()).collect()
    };
    let arms = scene["arms"].as_array().into_iter().flatten();
    let arms: Vec<Value> = arms
        .map(|arm| {
            let count = arm["arm_joints"].as_u64().unwrap_or_default();
            let mut joints = names(&arm["joints"]);
            joints.truncate(usize::try_from(count).unwrap_or_default());
            json!({ "name": arm["name"], "joint_names": joints })
        })
        .collect();
    json!({
        "demo": run.demo,
        "policy": run.policy,
        "seed": run.seed,
        "arms": arms,
        "objects": names(&scene["objects"]),
        "arm_count": read.arm_count,
        "object_count": read.object_count,
        "cut": recording.cut(),
        "problems": read.problems,
    })
    .to_string()
}

impl Read {
    fn of(recording: &Recording, every: u64) -> Self {
        let mut read = Self::default();
        let (from, to) = recording.span_s();
        for entry in recording.history(from, to) {
            let taken = entry.and_then(|entry| read.take(&entry, every));
            // A damaged piece ends nothing: those after it can still be read.
            if let Err(problem) = taken {
                read.problems.push(problem.to_string());
            }
        }
        read
    }

    fn take(&mut self, entry: &Entry, every: u64) -> Result<(), RecordError> {
        let is_due = entry.tick.is_multiple_of(every);
        match entry.channel {
            Channel::World => self.world(&entry.read()?, every),
            Channel::Decision => {
                let decision: Decision = entry.read()?;
                self.decisions.extend(decision.as_bytes());
            }
            Channel::Status(arm) if is_due => {
                let status: ArmStatus = entry.read()?;
                let arm = usize::from(arm);
                if self.statuses.len() <= arm {
                    self.statuses.resize(arm + 1, Vec::new());
                }
                if let Some(bytes) = self.statuses.get_mut(arm) {
                    bytes.extend(status.as_bytes());
                }
            }
            Channel::Log => self.line(&entry.read()?, entry.tick),
            _ => {}
        }
        Ok(())
    }

    fn world(&mut self, piece: &WorldPiece, every: u64) {
        if piece.all_objects == 1 && piece.piece == 0 && !self.has_all {
            self.has_all = true;
            self.arm_count = (piece.arm_count as usize).min(piece.arms.len());
            self.object_count = (piece.object_count as usize).min(ipc_types::MAX_OBJECTS);
            self.known = vec![ObjectState::zeroed(); self.object_count];
        }
        if !self.has_all {
            return;
        }
        for object in piece.objects() {
            if let Some(known) = self.known.get_mut(object.index as usize) {
                *known = object.state;
            }
        }
        let tick = piece.state.tick;
        let is_last = piece.piece + 1 >= piece.pieces;
        // A state that was recorded twice is one.
        let is_new = self.ticks.last().is_none_or(|last| tick > *last);
        if !(is_last && is_new && tick.is_multiple_of(every)) {
            return;
        }
        self.ticks.push(tick);
        self.published_ns.push(piece.state.publish_ns);
        let arms: &[ArmState] = piece.arms.get(..self.arm_count).unwrap_or_default();
        for arm in arms {
            self.arms.extend(arm.as_bytes());
        }
        let known = self.known.iter();
        known.for_each(|object| self.objects.extend(object.as_bytes()));
    }

    fn line(&mut self, line: &TraceLine, tick: u64) {
        let is_for_people = TraceKind::from_code(line.kind).is_some_and(TraceKind::is_for_people);
        if is_for_people {
            let event = TraceEvent::from_code(line.event).and_then(TraceEvent::name);
            self.log.push((tick, event, line.text.as_str().to_owned()));
        }
    }
}
