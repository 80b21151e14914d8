//! Opening and closing the gripper. A grip is friction or suction in physics:
//! whether something is held is seen, not assumed.

use behavior::Status;
use ipc_types::GripperGoal;
use robocell_task::PolicyTime;

use crate::progress::{Progress, Step};
use crate::setup::Tool;
use crate::skill::Skill;
use crate::world::World;

/// Fingers are given this long at least to close (s).
const CLOSE_S: f64 = 0.5;
/// Suction has attached at the latest after this (s).
const ATTACH_S: f64 = 2.0;
/// A grip is given up after this (s).
const CLOSE_TIMEOUT_S: f64 = 3.0;
/// A gripper is given this long at least to open (s).
const OPEN_S: f64 = 0.25;
/// A gripper that is not open after this is blocked (s).
const OPEN_TIMEOUT_S: f64 = 5.0;

/// Stable name of the failure of a gripper that does not open.
pub const GRIPPER_BLOCKED: &str = "gripper_blocked";

/// Opens the gripper, or switches suction off; succeeds at once where it is open
/// already. The arm stays where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Open;

/// Closes the gripper, or switches suction on. It fails when the object, or with
/// `None` anything, is not in the gripper then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Close {
    /// The object.
    pub object: Option<usize>,
}

impl Skill for Open {
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        open(&mut progress.step, world)
    }
}

impl Skill for Close {
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        close(&mut progress.step, self.object, world)
    }
}

pub(crate) fn open(step: &mut Step, world: &mut World<'_>) -> Status {
    if !step.has_begun() && world.is_open() {
        world.stay(GripperGoal::Open);
        return Status::Success;
    }
    let lasted = world.begin(step);
    world.stay(GripperGoal::Open);
    if world.is_open() && lasted >= PolicyTime::from_seconds(OPEN_S) {
        return Status::Success;
    }
    if lasted >= PolicyTime::from_seconds(OPEN_TIMEOUT_S) {
        world.fail(GRIPPER_BLOCKED, format_args!("the gripper does not open"));
        return Status::Failure;
    }
    Status::Running
}

pub(crate) fn close(step: &mut Step, object: Option<usize>, world: &mut World<'_>) -> Status {
    let lasted = world.begin(step);
    world.stay(GripperGoal::Close);
    let held = world.held();
    let caught = held.is_some() && (object.is_none() || held == object);
    let (least, most) = match world.tool() {
        Tool::Suction => (0.05, ATTACH_S),
        Tool::Fingers { .. } | Tool::None => (CLOSE_S, CLOSE_TIMEOUT_S),
    };
    let past = |seconds: f64| lasted >= PolicyTime::from_seconds(seconds);
    match (caught && past(least), past(most)) {
        (true, _) => Status::Success,
        (false, true) => Status::Failure,
        (false, false) => Status::Running,
    }
}
