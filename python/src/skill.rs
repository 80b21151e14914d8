//! The skills, with names in place of indices and their memory in them.

use behavior::Status as Ended;
use ipc_types::GripperGoal;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use robocell_skills::{
    AddBin, Close, Conveyor, DropParts, FollowOperator, Home, MoveTo, Open, Pick, Place, Progress,
    Skill as _, Target, Wait, World,
};
use robocell_task::PolicyTime;
use serde::{Deserialize, Serialize};

use crate::arm::{Arm, gripper_of, pose_of};
use crate::inner::{Inner, lock_open};

mod names;

/// How a step of a skill ended.
#[pyclass(eq, eq_int, hash, frozen, from_py_object, module = "robocell._core")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[allow(clippy::upper_case_acronyms, reason = "a constant in Python")]
pub(crate) enum Status {
    /// Not finished.
    RUNNING,
    /// Finished as intended.
    SUCCESS,
    /// Finished otherwise.
    FAILURE,
}

impl From<Ended> for Status {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Running => Self::RUNNING,
            Ended::Success => Self::SUCCESS,
            Ended::Failure => Self::FAILURE,
        }
    }
}

/// Where a motion ends.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Goal {
    Pose([f64; 3], Option<[f64; 4]>, f64),
    Object(String, f64),
    Place(String, String, f64),
    Up(f64),
}

/// What a skill does.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum What {
    Move {
        goal: Goal,
        precise: bool,
        gripper: Option<u32>,
        holding: Option<String>,
        timeout_s: f64,
    },
    Home,
    Pick {
        object: String,
        clearance_m: f64,
        max_attempts: u32,
    },
    Place {
        object: String,
        place: String,
        clearance_m: f64,
        tolerance_m: f64,
        max_attempts: u32,
    },
    Open,
    Close(Option<String>),
    Wait(f64),
    Conveyor(bool),
    AddBin,
    DropParts,
    FollowOperator,
}

impl What {
    /// As it is written in Python.
    fn shown(&self) -> String {
        match self {
            Self::Move { goal, .. } => match goal {
                Goal::Pose([x, y, z], ..) => format!("move_to(({x:.3}, {y:.3}, {z:.3}))"),
                Goal::Object(object, above) => format!("move_to_object('{object}', {above})"),
                Goal::Place(object, place, above) => {
                    format!("move_to_place('{object}', '{place}', {above})")
                }
                Goal::Up(by) => format!("move_up({by})"),
            },
            Self::Home => "home()".to_owned(),
            Self::Pick { object, .. } => format!("pick('{object}')"),
            Self::Place { object, place, .. } => format!("place('{object}', '{place}')"),
            Self::Open => "open()".to_owned(),
            Self::Close(None) => "close()".to_owned(),
            Self::Close(Some(object)) => format!("close('{object}')"),
            Self::Wait(seconds) => format!("wait({seconds})"),
            Self::Conveyor(run) => {
                format!("conveyor({})", if *run { "True" } else { "False" })
            }
            Self::AddBin => "add_bin()".to_owned(),
            Self::DropParts => "drop_parts()".to_owned(),
            Self::FollowOperator => "follow_operator()".to_owned(),
        }
    }
}

/// A skill under way: what it does, and what it remembers.
#[pyclass(module = "robocell._core")]
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Skill {
    what: What,
    progress: Progress,
}

impl Skill {
    fn new(what: What) -> Self {
        Self {
            what,
            progress: Progress::default(),
        }
    }

    /// Forgets its progress.
    pub(crate) fn restart(&mut self) {
        self.progress.reset();
    }

    /// One decision of work with an arm.
    pub(crate) fn work(&mut self, inner: &mut Inner, arm: usize) -> PyResult<Status> {
        let Self { what, progress } = self;
        let ended = match what {
            What::Move { .. } => {
                let motion = motion(what, inner, arm)?;
                inner.world(arm, |world| motion.step(progress, world))
            }
            What::Pick {
                object,
                clearance_m,
                max_attempts,
            } => {
                let pick = Pick {
                    clearance_m: *clearance_m,
                    max_attempts: *max_attempts,
                    ..Pick::new(inner.object(object)?)
                };
                inner.world(arm, |world| pick.step(progress, world))
            }
            What::Place {
                object,
                place,
                clearance_m,
                tolerance_m,
                max_attempts,
            } => {
                let place = Place {
                    clearance_m: *clearance_m,
                    tolerance_m: *tolerance_m,
                    max_attempts: *max_attempts,
                    ..Place::new(inner.object(object)?, inner.place(place)?)
                };
                inner.world(arm, |world| place.step(progress, world))
            }
            What::Close(object) => {
                let object = object
                    .as_deref()
                    .map(|name| inner.object(name))
                    .transpose()?;
                let close = Close { object };
                inner.world(arm, |world| close.step(progress, world))
            }
            _ => inner.world(arm, |world| plain(what, progress, world)),
        };
        Ok(ended.into())
    }
}

/// The motion of a [`What::Move`].
fn motion(what: &What, inner: &mut Inner, arm: usize) -> PyResult<MoveTo> {
    let What::Move {
        goal,
        precise,
        gripper,
        holding,
        timeout_s,
    } = what
    else {
        return Err(PyValueError::new_err("not a motion"));
    };
    let mut motion = match goal {
        Goal::Pose(position, orientation, yaw) => {
            let down = inner.world(arm, |world| world.tool().down(*yaw));
            let pose = pose_of(*position, orientation.unwrap_or(down))?;
            MoveTo::new(Target::Pose(pose))
        }
        Goal::Object(object, above_m) => MoveTo::object(inner.object(object)?, *above_m),
        Goal::Place(object, place, above_m) => {
            MoveTo::place(inner.object(object)?, inner.place(place)?, *above_m)
        }
        Goal::Up(by_m) => MoveTo::up(*by_m),
    };
    if let Some(object) = holding {
        motion = motion.holding(inner.object(object)?);
    }
    if let Some(gripper) = gripper.and_then(GripperGoal::from_code) {
        motion.gripper = gripper;
    }
    motion.precise |= *precise;
    motion.timeout = PolicyTime::from_seconds(*timeout_s);
    Ok(motion)
}

/// A step of a skill without names.
fn plain(what: &What, progress: &mut Progress, world: &mut World<'_>) -> Ended {
    match what {
        What::Home => Home.step(progress, world),
        What::Open => Open.step(progress, world),
        What::Wait(seconds) => {
            let time = PolicyTime::from_seconds(*seconds);
            Wait { time }.step(progress, world)
        }
        What::Conveyor(run) => Conveyor { run: *run }.step(progress, world),
        What::AddBin => AddBin.step(progress, world),
        What::DropParts => DropParts.step(progress, world),
        What::FollowOperator => FollowOperator.step(progress, world),
        What::Move { .. } | What::Pick { .. } | What::Place { .. } | What::Close(_) => {
            Ended::Failure
        }
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
        self.work(&mut inner, arm.index)
    }

    /// Forgets its progress: the next step begins the skill.
    fn reset(&mut self) {
        self.restart();
    }

    fn __repr__(&self) -> String {
        self.what.shown()
    }

    /// For pickle and copy.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let bytes = bincode::serialize(&*slf.borrow()).map_err(unreadable)?;
        let restore = slf.get_type().getattr("_restore")?;
        let arguments = PyTuple::new(py, [PyBytes::new(py, &bytes)])?;
        PyTuple::new(py, [restore, arguments.into_any()])
    }

    #[staticmethod]
    fn _restore(bytes: &[u8]) -> PyResult<Self> {
        bincode::deserialize(bytes).map_err(unreadable)
    }
}

#[allow(clippy::needless_pass_by_value, reason = "for map_err")]
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
