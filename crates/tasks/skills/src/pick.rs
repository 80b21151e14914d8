//! Picking an object up.

use behavior::Status;
use grasp::Exclusion;
use ipc_types::GripperGoal;
use nalgebra::{Isometry3, Translation3, Vector3};
use robocell_task::PolicyTime;
use robocell_task::job::Placement;

use crate::ability::{self, Need};
use crate::choice::{Choice, frame};
use crate::geometry;
use crate::grip;
use crate::motion;
use crate::pose::{KeptPose, wire};
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
/// A grasp along another direction is another one (rad).
const TIPPED_RAD: f64 = 0.05;
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

/// Picks an object up: before it, to it, close, lift. The grasp is the best of all
/// candidates that nothing excludes; after a failure the next one is taken. A tool that is at
/// another object opens and rises first. It succeeds at once with an object that is in the
/// gripper already, starts again when the object moves before it is gripped, and
/// fails when the object is not caught or is lost, or another one is held.
/// After too many failures in a row the job fails. An object without a grasp is refused with
/// the reason before the arm moves to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The object.
    pub object: usize,
    /// Distance before the grasp to which the tool travels, and height to which the object is
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
            return self.out_of_reach(progress, world);
        }
        let (Some(anchor), Some(grasp)) = (progress.anchor, progress.tool) else {
            return self.choose(seen, progress, world);
        };
        if geometry::plane_distance(centre, anchor.position.into()) > MOVE_TOLERANCE_M {
            world.note_resync(self.object);
            progress.reset();
            return Status::Running;
        }
        let at = Placement {
            yaw: geometry::nearest_quarter(seen.yaw, anchor.yaw),
            ..seen
        };
        let tcp = frame(&at) * grasp.isometry();
        let above = progress.stage == ABOVE;
        let drive = if above {
            let back = world.tool().axis() * -self.clearance_m;
            let retreated = tcp * Translation3::from(back);
            Drive::travel(wire(&retreated), GripperGoal::Open)
        } else {
            Drive::grasp(wire(&tcp), GripperGoal::Open)
        };
        world.opening_to(progress.open_width_m);
        let there = world.drive(&mut progress.step, &drive.near(Some(self.object)));
        if there && world.is_opened_to(progress.open_width_m) {
            if above && self.is_outdated(&tcp, world) {
                progress.go_to(ABOVE);
                return self.choose(seen, progress, world);
            }
            progress.anchor = Some(at);
            progress.next();
        } else if is_late(progress, world) {
            if let Some(refused) = world.refuse_if_arm_blocks(&wire(&tcp)) {
                return refused;
            }
            let why = world.why_not_reached("is not reached");
            return self.failed(&why, world);
        }
        Status::Running
    }

    /// Whether the object would be gripped from another side now: it has fallen or tipped over since
    /// the grasp was chosen.
    fn is_outdated(&self, tcp: &Isometry3<f64>, world: &World<'_>) -> bool {
        let axis = world.tool().axis();
        let failures = world.attempts(self.object).pick;
        match world.choose_grasp(self.object, failures) {
            Choice::Grasp(now) => (tcp * axis).dot(&(now.tcp * axis)) < libm::cos(TIPPED_RAD),
            Choice::None(_) | Choice::Unknown => true,
        }
    }

    /// Chooses a grasp, or says why there is none.
    fn choose(&self, seen: Placement, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let failures = world.attempts(self.object).pick;
        let why = match world.choose_grasp(self.object, failures) {
            Choice::Grasp(chosen) => {
                progress.waits = None;
                if let Some(remark) = chosen.remark {
                    let name = world.setup.object_name(self.object);
                    world.out.log(format_args!("[grasp] {name}: {remark}"));
                }
                progress.anchor = Some(seen);
                progress.tool = Some(KeptPose::from(&(frame(&seen).inverse() * chosen.tcp)));
                progress.open_width_m = chosen.opening_m;
                return self.approach(seen, progress, world);
            }
            Choice::Unknown => return Status::Failure,
            Choice::None(why) => why,
        };
        if why == Exclusion::OutOfReach {
            return self.out_of_reach(progress, world);
        }
        world.wait_or_refuse(self.object, &why, &mut progress.waits)
    }

    /// An object that is where the run began never was in reach; one that left it may come back.
    fn out_of_reach(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if world.is_where_it_began(self.object) {
            let why = Exclusion::OutOfReach;
            return world.wait_or_refuse(self.object, &why, &mut progress.waits);
        }
        world.wait_for_reach(self.object, reason::OUT_OF_REACH)
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
            return self.lost(world);
        }
        let Some((anchor, grasp)) = progress.anchor.zip(progress.tool) else {
            return Status::Failure;
        };
        let centre = Vector3::from(anchor.position);
        let bottom = centre.z - world.half_height(self.object);
        let passing = world.passing_height(self.object, centre, centre) - bottom;
        let up = Translation3::new(0.0, 0.0, self.clearance_m.max(passing));
        let target = wire(&(up * frame(&anchor) * grasp.isometry()));
        let drive = Drive {
            tolerance_m: 0.02,
            ..Drive::precise(target, GripperGoal::Close)
        };
        if world.drive(&mut progress.step, &drive.near(Some(self.object))) {
            if let Some(attempts) = world.attempts_mut(self.object) {
                attempts.pick = 0;
            }
            return Status::Success;
        }
        if is_late(progress, world) {
            let why = world.why_not_reached("cannot be lifted");
            return self.failed(&why, world);
        }
        Status::Running
    }

    /// The object left the gripper. One that is too heavy for the cup is refused: each attempt
    /// would end like this one.
    fn lost(&self, world: &mut World<'_>) -> Status {
        let Some(broken) = world.broken_grip(self.object) else {
            return self.failed("was lost", world);
        };
        if broken.is_too_heavy {
            let name = world.setup.object_name(self.object);
            return world.refuse(
                reason::CANNOT_BE_GRIPPED,
                format_args!("{name} is {}", broken.why),
            );
        }
        self.failed(&format!("was lost: {}", broken.why), world)
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
            world.note_in_reach();
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
                Status::Failure => {
                    let why = world.why_not_attached("was not caught");
                    self.failed(&why, world)
                }
            },
            _ => self.lift(progress, world),
        }
    }
}
