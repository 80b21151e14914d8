//! Picking an object up from above.

use behavior::Status;
use ipc_types::GripperGoal;
use nalgebra::Vector3;
use robocell_task::PolicyTime;
use robocell_task::job::Placement;

use crate::ability::{self, Need};
use crate::fingers::Ways;
use crate::geometry;
use crate::grip;
use crate::motion;
use crate::progress::Progress;
use crate::skill::Skill;
use crate::world::{Drive, World};

const CLEAR: u8 = 0;
const ABOVE: u8 = 1;
const DOWN: u8 = 2;
const CLOSE: u8 = 3;
const LIFT: u8 = 4;

/// An object that moved further in the plane while it is approached is
/// approached again (m).
const MOVE_TOLERANCE_M: f64 = 0.03;
/// A motion takes no longer (s).
const MOTION_TIMEOUT_S: f64 = 6.0;

/// Stable names of what goes wrong for good.
pub mod reason {
    /// The object stayed too far from the arm.
    pub const OUT_OF_REACH: &str = "object_out_of_reach";
    /// The gripper holds another object, which has to be placed first.
    pub const HOLDS_ANOTHER: &str = "gripper_holds_another_object";
    /// The object was lost again and again.
    pub const CANNOT_BE_GRIPPED: &str = "object_cannot_be_gripped";
}

/// Picks an object up: above it, down, close, lift. A tool that is at another
/// object opens and rises first. It succeeds at once with an object that is in the
/// gripper already, starts again when the object moves before it is gripped, and
/// fails when the object is not caught or is lost, or another one is held.
/// After too many failures in a row the job fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The object.
    pub object: usize,
    /// Height above the object at which the tool travels, and to which it is
    /// lifted (m).
    pub clearance_m: f64,
    /// Failures in a row after which the job fails.
    pub max_attempts: u32,
}

impl Pick {
    /// With 0.1 m of clearance and five attempts.
    pub fn new(object: usize) -> Self {
        Self {
            object,
            clearance_m: 0.1,
            max_attempts: 5,
        }
    }

    fn approach(&self, seen: Placement, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let centre = Vector3::from(seen.position);
        if !world.reaches(centre) {
            progress.reset();
            return world.wait_for_reach(self.object, reason::OUT_OF_REACH);
        }
        let failures = world.job.attempts(self.object).pick;
        let anchor = *progress.anchor.get_or_insert_with(|| Placement {
            // Every other attempt takes the other way.
            yaw: Ways::around(self.object, seen, 0.0, world).choose(failures % 2 == 1),
            ..seen
        });
        if geometry::plane_distance(centre, anchor.position.into()) > MOVE_TOLERANCE_M {
            world.note_resync(self.object);
            progress.reset();
            return Status::Running;
        }
        let at = Placement {
            yaw: geometry::nearest_quarter(seen.yaw, anchor.yaw),
            ..seen
        };
        let above = progress.stage == ABOVE;
        let height = if above { self.clearance_m } else { 0.0 };
        let target = world.grip_pose(self.object, at, height);
        let drive = if above {
            Drive::travel(target, GripperGoal::Open)
        } else {
            Drive::grasp(target, GripperGoal::Open)
        };
        let there = world.drive(&mut progress.step, &drive.near(Some(self.object)));
        if there && world.is_open() {
            progress.anchor = Some(at);
            progress.next();
        } else if is_late(progress, world) {
            return self.failed("is not reached", world);
        }
        Status::Running
    }

    /// The job cannot be done by this arm.
    fn refuse(&self, world: &mut World<'_>) -> Option<Status> {
        let arm = world.arm_setup()?;
        let lack = ability::lacks(arm, Need::Grip(world.object_setup(self.object)))?;
        let (arm, object) = (world.arm_name(), world.setup.object_name(self.object));
        world.fail(
            lack.reason(),
            format_args!("{arm} cannot grip {object}: it {lack}"),
        );
        Some(Status::Failure)
    }

    /// Leaves other objects first.
    fn clear(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if let Some(held) = world.held() {
            let setup = world.setup;
            let name = setup.object_name(held);
            world.fail(
                reason::HOLDS_ANOTHER,
                format_args!("{name} is in the gripper and has to be placed first"),
            );
            return Status::Failure;
        }
        if let Some(refused) = self.refuse(world) {
            return refused;
        }
        if motion::is_clear(&mut progress.step, Some(self.object), world) {
            progress.next();
        }
        Status::Running
    }

    fn lift(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if world.is_lost(self.object, &mut progress.missed) {
            return self.failed("was lost", world);
        }
        let Some(anchor) = progress.anchor else {
            return Status::Failure;
        };
        let target = world.grip_pose(self.object, anchor, self.clearance_m);
        let drive = Drive {
            tolerance_m: 0.02,
            ..Drive::precise(target, GripperGoal::Close)
        };
        if world.drive(&mut progress.step, &drive.near(Some(self.object))) {
            if let Some(attempts) = world.job.attempts_mut(self.object) {
                attempts.pick = 0;
            }
            return Status::Success;
        }
        if is_late(progress, world) {
            return self.failed("cannot be lifted", world);
        }
        Status::Running
    }

    fn failed(&self, why: &str, world: &mut World<'_>) -> Status {
        world.note_retry(self.object, why);
        world.count_failed_pick(self.object, self.max_attempts, reason::CANNOT_BE_GRIPPED);
        Status::Failure
    }
}

fn is_late(progress: &Progress, world: &World<'_>) -> bool {
    world.now().since(progress.step.began) >= PolicyTime::from_seconds(MOTION_TIMEOUT_S)
}

impl Skill for Pick {
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let Some(seen) = world.placement(self.object) else {
            return Status::Failure;
        };
        let held = world.held() == Some(self.object);
        if held && progress.stage < CLOSE {
            return Status::Success;
        }
        if world.resumed && !held {
            progress.reset();
        }
        if world.reaches(seen.position.into()) {
            world.job.unreachable_since = None;
        }
        match progress.stage {
            CLEAR => self.clear(progress, world),
            ABOVE | DOWN => self.approach(seen, progress, world),
            CLOSE => match grip::close(&mut progress.step, Some(self.object), world) {
                Status::Running => Status::Running,
                Status::Success => {
                    progress.go_to(LIFT);
                    Status::Running
                }
                Status::Failure => self.failed("was not caught", world),
            },
            _ => self.lift(progress, world),
        }
    }
}
