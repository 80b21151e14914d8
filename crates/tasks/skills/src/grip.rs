//! Opening and closing the gripper. A grip is friction or suction in physics:
//! whether something is held is seen, not assumed.

use behavior::Status;
use ipc_types::GripperGoal;
use robocell_task::PolicyTime;

use crate::progress::{Progress, Step, Switched};
use crate::setup::Tool;
use crate::skill::Skill;
use crate::world::World;

/// Fingers are given this long at least to close (s).
const CLOSE_S: f64 = 0.5;
/// Suction has attached at the latest after this, and the tool has come to rest before it (s).
const ATTACH_S: f64 = 2.0;
/// An object on the cup is given this long at least (s).
const ATTACHED_S: f64 = 0.05;
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

/// Closes the gripper, or switches suction on as soon as the tool is at rest, off first where it is
/// on. It fails when the object, or with `None` anything, is not in the gripper then, and logs why.
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
        let status = close(&mut progress.step, self.object, world);
        if status == Status::Failure {
            let setup = world.setup;
            let what = self.object.map_or("nothing", |of| setup.object_name(of));
            let missed = match self.object {
                Some(_) => "was not caught",
                None => "was caught",
            };
            let why = world.why_not_caught(&progress.step, missed);
            let arm = world.arm_name();
            world.out.log(format_args!("[retry] {arm}: {what} {why}"));
        }
        status
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
    if world.tool() == Tool::Suction {
        return attach(step, object, world);
    }
    let lasted = world.begin(step);
    world.stay(GripperGoal::Close);
    let past = |seconds: f64| lasted >= PolicyTime::from_seconds(seconds);
    match (
        is_caught(object, world) && past(CLOSE_S),
        past(CLOSE_TIMEOUT_S),
    ) {
        (true, _) => Status::Success,
        (false, true) => Status::Failure,
        (false, false) => Status::Running,
    }
}

fn is_caught(object: Option<usize>, world: &World<'_>) -> bool {
    let held = world.held();
    held.is_some() && (object.is_none() || held == object)
}

/// Switches suction on, and waits until something is attached. A cup searches once when suction is
/// switched on, so one that is on already is switched off first.
fn attach(step: &mut Step, object: Option<usize>, world: &mut World<'_>) -> Status {
    let lasted = world.begin(step);
    let Some(gripper) = world.observation.arm(world.arm).map(|arm| arm.gripper) else {
        return Status::Failure;
    };
    let past = |since: PolicyTime| since >= PolicyTime::from_seconds(ATTACH_S);
    let (since, missed) = match step.switched {
        Some(on) => (
            world.now().since(on.at),
            gripper.breaks != on.breaks || gripper.refusals != on.refusals,
        ),
        None => (lasted, false),
    };
    if world.held().is_some() {
        world.stay(GripperGoal::Close);
        return match (is_caught(object, world), past(since)) {
            (true, _) if lasted >= PolicyTime::from_seconds(ATTACHED_S) => Status::Success,
            (false, true) => Status::Failure,
            _ => Status::Running,
        };
    }
    if step.switched.is_none() && switches_on(step, world) {
        step.switched = Some(Switched {
            at: world.now(),
            breaks: gripper.breaks,
            refusals: gripper.refusals,
        });
    } else if step.switched.is_some() {
        world.stay(GripperGoal::Close);
    }
    if missed || past(since) {
        Status::Failure
    } else {
        Status::Running
    }
}

/// Switches suction on as soon as it is off and the tool at rest; whether it does so in this
/// decision. A tool that moves while the cup locks breaks the grip.
pub(crate) fn switches_on(step: &mut Step, world: &mut World<'_>) -> bool {
    let arm = world.observation.arm(world.arm);
    let is_off = arm.is_some_and(|arm| arm.gripper.suction == 0);
    // The time at rest counts also while suction is still on.
    let is_ready = world.rests(step) && is_off;
    world.stay(if is_ready {
        GripperGoal::Close
    } else {
        GripperGoal::Open
    });
    is_ready
}
