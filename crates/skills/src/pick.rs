//! Picking an object up from above.

use behavior::Status;
use ipc_types::GripperGoal;
use nalgebra::{Vector2, Vector3};
use robocell_task::job::Placement;
use robocell_task::{PolicyTime, TraceEvent};

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
/// An object out of reach is waited for this long; the operator may bring it
/// back (s).
const REACH_PATIENCE_S: f64 = 10.0;

/// Half of the open width, a finger's thickness and half of a turned cube: an
/// object with its centre nearer than this along the fingers' axis is in their
/// way (m).
const FINGER_REACH_M: f64 = 0.09;
/// Half a finger's breadth and half of a turned cube (m).
const FINGER_BREADTH_M: f64 = 0.045;

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
            return self.wait_for_reach(progress, world);
        }
        let failures = world.job.attempts(self.object).pick;
        let anchor = *progress.anchor.get_or_insert_with(|| Placement {
            yaw: choose_yaw(self.object, seen, failures, world),
            ..seen
        });
        if geometry::plane_distance(centre, anchor.position.into()) > MOVE_TOLERANCE_M {
            return self.again(progress, world);
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

    /// The object moved before it was gripped.
    fn again(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let setup = world.setup;
        let name = setup.object_name(self.object);
        world.job.counters.resyncs += 1;
        world
            .out
            .event(TraceEvent::Resync, format_args!("[resync] {name} moved"));
        progress.reset();
        Status::Running
    }

    fn wait_for_reach(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let now = world.now();
        let since = *world.job.unreachable_since.get_or_insert(now);
        let setup = world.setup;
        let name = setup.object_name(self.object);
        if since == now {
            world.out.log(format_args!("[wait] {name} is out of reach"));
        }
        progress.reset();
        if now.since(since) < PolicyTime::from_seconds(REACH_PATIENCE_S) {
            return Status::Running;
        }
        world.fail(
            reason::OUT_OF_REACH,
            format_args!("{name} stayed out of reach"),
        );
        Status::Failure
    }

    fn failed(&self, why: &str, world: &mut World<'_>) -> Status {
        world.note_retry(self.object, why);
        let Some(attempts) = world.job.attempts_mut(self.object) else {
            return Status::Failure;
        };
        attempts.pick += 1;
        if attempts.pick >= self.max_attempts {
            let setup = world.setup;
            let name = setup.object_name(self.object);
            world.fail(
                reason::CANNOT_BE_GRIPPED,
                format_args!("{name} cannot be gripped"),
            );
        }
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

/// Turn of the tool for a new pick-up (rad): the object's own, unless a
/// neighbour is in the way of the fingers and not of fingers turned by a
/// quarter; every other attempt takes the other way.
fn choose_yaw(object: usize, seen: Placement, failures: u32, world: &World<'_>) -> f64 {
    let along = geometry::nearest_quarter(seen.yaw, 0.0);
    let across = if along > 0.0 {
        along - std::f64::consts::FRAC_PI_2
    } else {
        along + std::f64::consts::FRAC_PI_2
    };
    let (a, b) = (
        crowding(object, seen, along, world),
        crowding(object, seen, across, world),
    );
    if b < a || (a == b && failures % 2 == 1) {
        across
    } else {
        along
    }
}

/// Objects in the way of fingers that close along the tool's y axis.
fn crowding(object: usize, seen: Placement, yaw: f64, world: &World<'_>) -> usize {
    let across = Vector2::new(libm::cos(yaw), libm::sin(yaw));
    let along = Vector2::new(-across.y, across.x);
    let half = world
        .object_setup(object)
        .map_or(0.0, |setup| setup.half_height_m);
    let in_the_way = |other: &usize| {
        let Some(position) = world.position(*other) else {
            return false;
        };
        let off = position - Vector3::from(seen.position);
        *other != object
            && off.z > -1.4 * half
            && off.xy().dot(&along).abs() < FINGER_REACH_M
            && off.xy().dot(&across).abs() < FINGER_BREADTH_M
    };
    (0..world.setup.objects.len()).filter(in_the_way).count()
}
