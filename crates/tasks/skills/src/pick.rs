//! Picking an object up.

use behavior::Status;
use grasp::Exclusion;
use ipc_types::GripperGoal;
use nalgebra::{Isometry3, Translation3, Vector3};
use robocell_task::job::Placement;
use robocell_task::{PolicyTime, TraceEvent};

use crate::ability::{self, Need};
use crate::choice::{Choice, frame};
use crate::geometry;
use crate::grip;
use crate::motion;
use crate::place::Bring;
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
    /// The gripper closed, or suction was switched on, and the object was not in it, again and
    /// again.
    pub const CANNOT_BE_GRIPPED: &str = "object_cannot_be_gripped";
    /// The arm did not arrive at the object, again and again.
    pub const NOT_REACHED: &str = "object_not_reached";
    /// The arm did not arrive above with the object, again and again.
    pub const CANNOT_BE_LIFTED: &str = "object_cannot_be_lifted";
    /// The object left the gripper in the lift, or its grip broke on the way to its place, again and
    /// again.
    pub const LOST: &str = crate::place::reason::LOST;
    /// The weight of the object exceeds the limit of the cup.
    pub const TOO_HEAVY: &str = "object_too_heavy";
    /// All of them.
    pub const ALL: &[&str] = &[
        OUT_OF_REACH,
        CANNOT_BE_GRIPPED,
        NOT_REACHED,
        CANNOT_BE_LIFTED,
        LOST,
        TOO_HEAVY,
    ];
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
            Drive::precise(wire(&tcp), GripperGoal::Open)
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
            return self.failed(reason::NOT_REACHED, &why, world);
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

    /// Brings another object in the gripper back.
    fn put_back(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let Some(other) = progress.put_back.map(usize::from) else {
            return Status::Failure;
        };
        let bring = Bring::back(other, self.clearance_m, self.max_attempts);
        if bring.step(progress, world) != Status::Running {
            progress.reset();
        }
        if world.job.failure.is_some() {
            return Status::Failure;
        }
        Status::Running
    }

    /// Leaves other objects first.
    fn clear(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let told = world.out.previous(world.arm).map(|told| told.gripper);
        if world.held().is_some() && told == Some(GripperGoal::Open) {
            // Not let go of yet: a person pushed it against an opening finger.
            return match grip::open(&mut progress.step, world) {
                Status::Failure => Status::Failure,
                Status::Running | Status::Success => Status::Running,
            };
        }
        if let Some(held) = world.held() {
            let (setup, wanted) = (world.setup, self.object);
            let (name, wanted) = (setup.object_name(held), setup.object_name(wanted));
            let line = format_args!(
                "[recover] {name} is in the gripper, not {wanted}: it is brought back"
            );
            world.job.counters.recoveries += 1;
            world.out.event(TraceEvent::Recover, line);
            progress.reset();
            progress.put_back = u16::try_from(held).ok();
            return self.put_back(progress, world);
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
        let drive = Drive::straight(target, GripperGoal::Close);
        if world.drive(&mut progress.step, &drive.near(Some(self.object))) {
            if let Some(attempts) = world.attempts_mut(self.object) {
                attempts.pick = 0;
            }
            return Status::Success;
        }
        if is_late(progress, world) {
            let why = world.why_not_reached("cannot be lifted");
            return self.failed(reason::CANNOT_BE_LIFTED, &why, world);
        }
        Status::Running
    }

    /// The object left the gripper. One that is too heavy for the cup is refused: each attempt
    /// would end like this one.
    fn lost(&self, world: &mut World<'_>) -> Status {
        let Some(broken) = world.broken_grip(self.object) else {
            return self.failed(reason::LOST, "was lost", world);
        };
        if broken.is_too_heavy {
            let name = world.setup.object_name(self.object);
            return world.refuse(reason::TOO_HEAVY, format_args!("{name} is {}", broken.why));
        }
        self.failed(reason::LOST, &format!("was lost: {}", broken.why), world)
    }

    /// The gripper closed and does not have the object.
    fn missed(&self, progress: &Progress, world: &mut World<'_>) -> Status {
        let is_broken = world.has_broken(&progress.step);
        match world.broken_grip(self.object).filter(|_| is_broken) {
            Some(broken) if broken.is_too_heavy => self.lost(world),
            _ => {
                let why = world.why_not_caught(&progress.step, "was not caught");
                self.failed(reason::CANNOT_BE_GRIPPED, &why, world)
            }
        }
    }

    fn failed(&self, reason: &str, why: &str, world: &mut World<'_>) -> Status {
        world.note_retry(self.object, why);
        world.count_failed_pick(self.object, self.max_attempts, reason, why);
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
        if progress.put_back.is_some() {
            return self.put_back(progress, world);
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
                Status::Failure => self.missed(progress, world),
            },
            _ => self.lift(progress, world),
        }
    }
}
