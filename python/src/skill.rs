//! The skills as Python objects.

use ipc_types::GripperGoal;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};

use crate::arm::Arm;
use crate::inner::lock_open;
use crate::work::{Goal, Status, What, Work, gripper_of};

/// A skill under way.
#[pyclass(module = "robocell._core")]
pub(crate) struct Skill(Work);

impl Skill {
    fn new(what: What) -> Self {
        Self(Work::new(what))
    }
}

/// An argument that is a skill.
impl FromPyObject<'_, '_> for Work {
    type Error = PyErr;

    fn extract(skill: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        // A copy: the object in Python may be given to another arm meanwhile.
        Ok(skill.cast::<Skill>()?.try_borrow()?.0.clone())
    }
}

#[pymethods]
impl Skill {
    /// The TCP at a pose, tool straight down unless an orientation is given; at an
    /// object's grip; above a slot of a place; or straight up.
    #[staticmethod]
    #[pyo3(signature = (goal, *, precise=false, gripper=None, holding=None, timeout_s=10.0))]
    fn move_to(
        goal: &Bound<'_, PyTuple>,
        precise: bool,
        gripper: Option<&str>,
        holding: Option<String>,
        timeout_s: f64,
    ) -> PyResult<Self> {
        let kind: String = goal.get_item(0)?.extract()?;
        let goal = match kind.as_str() {
            "pose" => {
                let (_, position, orientation, yaw) = goal.extract::<(String, _, _, _)>()?;
                Goal::Pose(position, orientation, yaw)
            }
            "object" => {
                let (_, object, above_m) = goal.extract::<(String, _, _)>()?;
                Goal::Object(object, above_m)
            }
            "place" => {
                let (_, object, place, above_m) = goal.extract::<(String, _, _, _)>()?;
                Goal::Place(object, place, above_m)
            }
            "up" => Goal::Up(goal.extract::<(String, _)>()?.1),
            _ => return Err(PyValueError::new_err(format!("unknown goal '{kind}'"))),
        };
        Ok(Self::new(What::Move {
            goal,
            precise,
            gripper: gripper.map(gripper_of).transpose()?.map(GripperGoal::code),
            holding,
            timeout_s: finite("timeout_s", timeout_s)?,
        }))
    }

    #[staticmethod]
    fn pick(object: String, clearance_m: f64, max_attempts: u32) -> PyResult<Self> {
        Ok(Self::new(What::Pick {
            object,
            clearance_m: finite("clearance_m", clearance_m)?,
            max_attempts,
        }))
    }

    #[staticmethod]
    fn place(
        object: String,
        place: String,
        clearance_m: f64,
        tolerance_m: f64,
        max_attempts: u32,
    ) -> PyResult<Self> {
        Ok(Self::new(What::Place {
            object,
            place,
            clearance_m: finite("clearance_m", clearance_m)?,
            tolerance_m: finite("tolerance_m", tolerance_m)?,
            max_attempts,
        }))
    }

    #[staticmethod]
    fn home() -> Self {
        Self::new(What::Home)
    }

    #[staticmethod]
    fn open() -> Self {
        Self::new(What::Open)
    }

    #[staticmethod]
    fn close(object: Option<String>) -> Self {
        Self::new(What::Close(object))
    }

    #[staticmethod]
    fn wait(seconds: f64) -> PyResult<Self> {
        Ok(Self::new(What::Wait(finite("seconds", seconds)?)))
    }

    #[staticmethod]
    fn conveyor(run: bool) -> Self {
        Self::new(What::Conveyor(run))
    }

    #[staticmethod]
    fn add_bin() -> Self {
        Self::new(What::AddBin)
    }

    #[staticmethod]
    fn drop_parts() -> Self {
        Self::new(What::DropParts)
    }

    #[staticmethod]
    fn follow_operator() -> Self {
        Self::new(What::FollowOperator)
    }

    /// One decision of work with an arm.
    fn step(&mut self, arm: &Bound<'_, PyAny>) -> PyResult<Status> {
        // The class of the Python package keeps the native one.
        let arm = match arm.cast::<Arm>() {
            Ok(arm) => arm.clone(),
            Err(_) => arm.getattr("_core")?.cast_into::<Arm>()?,
        };
        let arm = arm.get();
        let mut inner = lock_open(&arm.shared)?;
        self.0.step(&mut inner.decision, arm.index)
    }

    /// Forgets its progress: the next step starts the skill again.
    fn reset(&mut self) {
        self.0.restart();
    }

    fn __repr__(&self) -> String {
        self.0.what.shown()
    }

    /// For pickle and copy.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let bytes = bincode::serialize(&slf.borrow().0).map_err(unreadable)?;
        let restore = slf.get_type().getattr("_restore")?;
        let arguments = PyTuple::new(py, [PyBytes::new(py, &bytes)])?;
        PyTuple::new(py, [restore, arguments.into_any()])
    }

    #[staticmethod]
    fn _restore(bytes: &[u8]) -> PyResult<Self> {
        bincode::deserialize(bytes).map(Self).map_err(unreadable)
    }
}

fn unreadable(error: bincode::Error) -> PyErr {
    PyValueError::new_err(format!("a skill cannot be restored: {error}"))
}

fn finite(what: &str, value: f64) -> PyResult<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(PyValueError::new_err(format!(
        "{what} is {value}; a finite number is needed"
    )))
}
