//! The skills with names in place of indices: what each does, and a decision of it.

use behavior::Status as Ended;
use ipc_types::{GripperGoal, Pose};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robocell_skills::{
    AddBin, Close, Conveyor, DropParts, FollowOperator, Home, MoveTo, Open, Pick, Place, Progress,
    Skill as _, Target, Wait, World,
};
use robocell_task::PolicyTime;
use serde::{Deserialize, Serialize};

use crate::decision::Decision;

/// How a step of a skill ended.
#[pyclass(eq, eq_int, hash, frozen, from_py_object, module = "robocell._core")]
#[allow(
    clippy::unsafe_derive_deserialize,
    reason = "its unsafe methods are those of pyo3, which need nothing of the value"
)]
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
pub(crate) enum Goal {
    Pose([f64; 3], Option<[f64; 4]>, f64),
    Object(String, f64),
    Place(String, String, f64),
    Up(f64),
}

/// What a skill does.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum What {
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
    pub(crate) fn shown(&self) -> String {
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

/// A skill in progress, with its memory.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Work {
    pub(crate) what: What,
    progress: Progress,
}

impl Work {
    pub(crate) fn new(what: What) -> Self {
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
    pub(crate) fn step(&mut self, decision: &mut Decision, arm: usize) -> PyResult<Status> {
        let Self { what, progress } = self;
        let ended = match what {
            What::Move { .. } => {
                let motion = motion(what, decision, arm)?;
                decision.world(arm, |world| motion.step(progress, world))
            }
            What::Pick {
                object,
                clearance_m,
                max_attempts,
            } => {
                let pick = Pick {
                    clearance_m: *clearance_m,
                    max_attempts: *max_attempts,
                    ..Pick::new(decision.object(object)?)
                };
                decision.world(arm, |world| pick.step(progress, world))
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
                    ..Place::new(decision.object(object)?, decision.place(place)?)
                };
                decision.world(arm, |world| place.step(progress, world))
            }
            What::Close(object) => {
                let object = object
                    .as_deref()
                    .map(|name| decision.object(name))
                    .transpose()?;
                let close = Close { object };
                decision.world(arm, |world| close.step(progress, world))
            }
            _ => decision.world(arm, |world| plain(what, progress, world)),
        };
        Ok(ended.into())
    }

    /// Looks up the objects and places that it names.
    ///
    /// # Errors
    /// The name that the cell does not know, with the nearest that it knows.
    pub(crate) fn check_names(&self, decision: &Decision) -> PyResult<()> {
        let (objects, place) = match &self.what {
            What::Move { goal, holding, .. } => {
                let (object, place) = match goal {
                    Goal::Object(object, _) => (Some(object), None),
                    Goal::Place(object, place, _) => (Some(object), Some(place)),
                    Goal::Pose(..) | Goal::Up(_) => (None, None),
                };
                ([object, holding.as_ref()], place)
            }
            What::Pick { object, .. } => ([Some(object), None], None),
            What::Place { object, place, .. } => ([Some(object), None], Some(place)),
            What::Close(object) => ([object.as_ref(), None], None),
            _ => ([None, None], None),
        };
        for object in objects.into_iter().flatten() {
            decision.object(object)?;
        }
        place.map_or(Ok(()), |place| decision.place(place).map(|_| ()))
    }
}

/// The motion of a [`What::Move`].
fn motion(what: &What, decision: &mut Decision, arm: usize) -> PyResult<MoveTo> {
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
            // Only here, not in `move_to`: it depends on the tool of the arm with the skill.
            let down = decision.world(arm, |world| world.tool().down(*yaw));
            let pose = pose_of(*position, orientation.unwrap_or(down))?;
            MoveTo::new(Target::Pose(pose))
        }
        Goal::Object(object, above_m) => MoveTo::object(decision.object(object)?, *above_m),
        Goal::Place(object, place, above_m) => {
            MoveTo::place(decision.object(object)?, decision.place(place)?, *above_m)
        }
        Goal::Up(by_m) => MoveTo::up(*by_m),
    };
    if let Some(object) = holding {
        motion = motion.holding(decision.object(object)?);
    }
    if let Some(gripper) = gripper.and_then(GripperGoal::from_code) {
        motion.gripper = gripper;
    }
    // A motion straight up, and one down onto an object or into a place, is precise by itself.
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
        // `Work::step` has handled the skills with names.
        What::Move { .. } | What::Pick { .. } | What::Place { .. } | What::Close(_) => {
            Ended::Failure
        }
    }
}

/// A gripper command by its name.
pub(crate) fn gripper_of(word: &str) -> PyResult<GripperGoal> {
    match word {
        "keep" => Ok(GripperGoal::Keep),
        "open" => Ok(GripperGoal::Open),
        "close" => Ok(GripperGoal::Close),
        _ => Err(PyValueError::new_err(format!(
            "gripper '{word}' is unknown; 'open', 'close' and 'keep' are allowed"
        ))),
    }
}

/// A pose with a unit quaternion.
pub(crate) fn pose_of(position: [f64; 3], orientation_wxyz: [f64; 4]) -> PyResult<Pose> {
    let norm = orientation_wxyz.iter().map(|x| x * x).sum::<f64>().sqrt();
    let good = position.iter().all(|x| x.is_finite()) && norm.is_finite() && norm > 1e-6;
    if !good {
        return Err(PyValueError::new_err(format!(
            "no pose: position {position:?} m, orientation {orientation_wxyz:?} (w x y z); finite \
             numbers are needed, and an orientation that is not zero"
        )));
    }
    Ok(Pose {
        position,
        // Numbers that a person typed have a length of 1 only up to their digits.
        orientation_wxyz: orientation_wxyz.map(|x| x / norm),
    })
}
