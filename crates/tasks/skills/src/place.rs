//! Setting the object in the gripper down.

use behavior::Status;
use ipc_types::{GripperGoal, Pose};
use robocell_task::PolicyTime;
use robocell_task::job::{Attempts, Placement};

use crate::condition::PLACE_TOLERANCE_M;
use crate::grip;
use crate::motion::{destination, rise};
use crate::progress::Progress;
use crate::skill::Skill;
use crate::world::{Drive, World};

const RISE: u8 = 0;
const CARRY: u8 = 1;
const LOWER: u8 = 2;
const OPEN: u8 = 3;

/// A motion takes no longer (s).
const MOTION_TIMEOUT_S: f64 = 8.0;
/// A slot that another object is in the way of is waited for this long (s).
const BLOCKED_PATIENCE_S: f64 = 10.0;
/// A tool this near to its travel height does not rise first (m).
const RISEN_M: f64 = 0.03;

/// Stable names of what goes wrong for good.
pub mod reason {
    /// The object did not stay where it was set down, again and again.
    pub const CANNOT_BE_PLACED: &str = "object_cannot_be_placed";
    /// The place is too far from the arm.
    pub const OUT_OF_REACH: &str = "place_out_of_reach";
    /// An object is in the way of the next slot and stays there.
    pub const BLOCKED: &str = "place_is_blocked";
    /// Every slot of the place is taken.
    pub const PLACE_IS_FULL: &str = "place_is_full";
}

/// Brings the object in the gripper to the next free slot of a place: up, across,
/// down, open, up. It fails when the object is lost on the way or does not stay
/// in its slot; after too many failures in a row the job fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The object.
    pub object: usize,
    /// The place.
    pub place: usize,
    /// Height above the slot at which the object travels (m).
    pub clearance_m: f64,
    /// An object nearer to its slot is in it (m).
    pub tolerance_m: f64,
    /// Failures in a row after which the job fails.
    pub max_attempts: u32,
}

impl Place {
    /// With 0.1 m of clearance and five attempts.
    pub fn new(object: usize, place: usize) -> Self {
        Self {
            object,
            place,
            clearance_m: 0.1,
            tolerance_m: PLACE_TOLERANCE_M,
            max_attempts: 5,
        }
    }

    /// With the object in the gripper.
    fn carry(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if progress.stage == RISE && !progress.step.has_begun() {
            if world.held() != Some(self.object) {
                return self.failed("is not in the gripper; it has to be picked first", world);
            }
            if let Some(refused) = self.refuse(world) {
                return refused;
            }
        }
        if world.is_lost(self.object, &mut progress.missed) {
            return Status::Failure;
        }
        // As the object is in the gripper now, not as it was at first.
        if progress.anchor.is_none() || !progress.step.has_begun() && progress.stage == CARRY {
            progress.anchor = destination(self.object, self.place, world);
        }
        let Some(goal) = progress.anchor else {
            return self.no_slot(world);
        };
        let [x, y, z] = goal.position;
        let drive = match progress.stage {
            RISE => {
                let tcp = world.tcp_position();
                let to = z + self.clearance_m;
                if !progress.step.has_begun() && rise(tcp, to) < RISEN_M {
                    progress.go_to(CARRY);
                    return self.carry(progress, world);
                }
                world.begin(&mut progress.step);
                let [x, y, from] = progress.step.from;
                let target = Placement {
                    position: [x, y, to.max(from)],
                    yaw: world.tool_yaw(),
                };
                Drive {
                    tolerance_m: 0.02,
                    ..Drive::precise(pose(target, world), GripperGoal::Close)
                }
            }
            CARRY => {
                let above = Placement {
                    position: [x, y, z + self.clearance_m],
                    ..goal
                };
                Drive::travel(pose(above, world), GripperGoal::Close)
            }
            _ => Drive::precise(pose(goal, world), GripperGoal::Close),
        };
        if world.drive(&mut progress.step, &drive.near(Some(self.object))) {
            progress.next();
        } else if is_late(progress, world) {
            return self.failed("cannot be brought to its place", world);
        }
        Status::Running
    }

    fn retract(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let Some(goal) = progress.anchor else {
            return Status::Failure;
        };
        let [x, y, z] = goal.position;
        let above = Placement {
            position: [x, y, z + self.clearance_m],
            ..goal
        };
        let drive = Drive {
            tolerance_m: 0.02,
            ..Drive::precise(pose(above, world), GripperGoal::Open)
        };
        let there = world.drive(&mut progress.step, &drive.near(Some(self.object)));
        if !there && !is_late(progress, world) {
            return Status::Running;
        }
        if world
            .slot_of(self.object, self.place, self.tolerance_m)
            .is_none()
        {
            return self.failed("is not in its place", world);
        }
        if let Some(attempts) = world.job.attempts_mut(self.object) {
            *attempts = Attempts::default();
        }
        let setup = world.setup;
        let name = setup.object_name(self.object);
        world.out.log(format_args!("[placed] {name}"));
        Status::Success
    }

    /// Where the object cannot go now.
    fn refuse(&self, world: &mut World<'_>) -> Option<Status> {
        let setup = world.setup;
        let slot = world.free_slot(self.object, self.place, self.tolerance_m);
        let Some(goal) = slot.and_then(|slot| setup.goal(self.object, self.place, slot)) else {
            return Some(self.no_slot(world));
        };
        let place = setup
            .places
            .get(self.place)
            .map_or("?", |p| p.name.as_str());
        if !world.reaches(goal.position.into()) {
            world.fail(
                reason::OUT_OF_REACH,
                format_args!("place '{place}' is out of reach"),
            );
            return Some(Status::Failure);
        }
        let Some(other) = world.blocks(goal, self.object) else {
            world.job.unreachable_since = None;
            return None;
        };
        let (now, name) = (world.now(), setup.object_name(other));
        let since = *world.job.unreachable_since.get_or_insert(now);
        if since == now {
            world.out.log(format_args!(
                "[wait] {name} is in the way at place '{place}'"
            ));
        }
        if now.since(since) < PolicyTime::from_seconds(BLOCKED_PATIENCE_S) {
            return Some(Status::Running);
        }
        world.fail(
            reason::BLOCKED,
            format_args!("{name} stays in the way at place '{place}'"),
        );
        Some(Status::Failure)
    }

    fn no_slot(&self, world: &mut World<'_>) -> Status {
        let setup = world.setup;
        let name = setup
            .places
            .get(self.place)
            .map_or("?", |p| p.name.as_str());
        world.fail(
            reason::PLACE_IS_FULL,
            format_args!("place '{name}' has no free slot"),
        );
        Status::Failure
    }

    fn failed(&self, why: &str, world: &mut World<'_>) -> Status {
        world.note_retry(self.object, why);
        world.count_failed_place(self.object, self.max_attempts, reason::CANNOT_BE_PLACED);
        Status::Failure
    }
}

fn is_late(progress: &Progress, world: &World<'_>) -> bool {
    world.now().since(progress.step.began) >= PolicyTime::from_seconds(MOTION_TIMEOUT_S)
}

impl Skill for Place {
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if world.resumed && world.held() == Some(self.object) {
            progress.reset();
        }
        match progress.stage {
            RISE..=LOWER => self.carry(progress, world),
            OPEN => match grip::open(&mut progress.step, world) {
                Status::Success => {
                    progress.next();
                    Status::Running
                }
                other => other,
            },
            _ => self.retract(progress, world),
        }
    }
}

fn pose(at: Placement, world: &World<'_>) -> Pose {
    Pose {
        position: at.position,
        orientation_wxyz: world.tool().down(at.yaw),
    }
}
