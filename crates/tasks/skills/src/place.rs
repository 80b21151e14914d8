//! Setting the object in the gripper down.

use behavior::Status;
use grasp::Exclusion;
use ipc_types::{GripperGoal, Pose};
use nalgebra::{Isometry3, Translation3};
use robocell_task::PolicyTime;
use robocell_task::job::{Attempts, Placement};

use crate::condition::PLACE_TOLERANCE_M;
use crate::grip;
use crate::motion::rise;
use crate::pose::{KeptPose, wire};
use crate::progress::Progress;
use crate::set_down::Destination;
use crate::setup::Tool;
use crate::skill::Skill;
use crate::world::{Drive, World};

const RISE: u8 = 0;
const CARRY: u8 = 1;
const LOWER: u8 = 2;
const OPEN: u8 = 3;

/// A motion takes no longer (s).
const MOTION_TIMEOUT_S: f64 = 8.0;
/// The object is lowered when the tool is this near to its pose above the place (m, rad).
const ABOVE_PLACE: (f64, f64) = (0.005, 0.05);
/// A tool this near to its travel height does not rise first (m).
const RISEN_M: f64 = 0.03;

/// Stable names of what goes wrong for good.
pub mod reason {
    /// The object did not stay where it was set down, again and again.
    pub const CANNOT_BE_PLACED: &str = "object_cannot_be_placed";
    /// The place is too far from the arm.
    pub const OUT_OF_REACH: &str = "place_out_of_reach";
    /// Every slot of the place is taken.
    pub const PLACE_IS_FULL: &str = "place_is_full";
    /// The object to be set down is not in the gripper.
    pub const NOT_IN_GRIPPER: &str = "object_not_in_gripper";
    /// The arm did not arrive above or at the place, again and again.
    pub const NOT_REACHED: &str = "place_not_reached";
    /// The object in the gripper is not the one to be picked, and cannot be brought back.
    pub const HOLDS_ANOTHER: &str = "gripper_holds_another_object";
    /// The object left the gripper in the lift, or its grip broke on the way to its place, again and
    /// again. In the list of [`crate::pick::reason`].
    pub const LOST: &str = "object_lost";
    /// All of them.
    pub const ALL: &[&str] = &[
        CANNOT_BE_PLACED,
        OUT_OF_REACH,
        PLACE_IS_FULL,
        NOT_IN_GRIPPER,
        NOT_REACHED,
        HOLDS_ANOTHER,
    ];
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

    fn bring(self) -> Bring {
        Bring {
            object: self.object,
            to: To::Place(self.place),
            clearance_m: self.clearance_m,
            tolerance_m: self.tolerance_m,
            max_attempts: self.max_attempts,
        }
    }
}

/// Where an object is brought.
#[derive(Clone, Copy)]
enum To {
    /// The next free slot of a place.
    Place(usize),
    /// Where it was at the start of the run, or near to it.
    Back,
}

/// Sets the object in the gripper down.
pub(crate) struct Bring {
    object: usize,
    to: To,
    clearance_m: f64,
    tolerance_m: f64,
    max_attempts: u32,
}

impl Bring {
    /// To where the object was at the start of the run.
    pub(crate) fn back(object: usize, clearance_m: f64, max_attempts: u32) -> Self {
        Self {
            object,
            to: To::Back,
            clearance_m,
            tolerance_m: PLACE_TOLERANCE_M,
            max_attempts,
        }
    }

    /// One decision.
    pub(crate) fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if world.resumed && world.held() == Some(self.object) {
            *progress = Progress {
                put_back: progress.put_back,
                ..Progress::default()
            };
        }
        match progress.stage {
            RISE..=LOWER => self.carry(progress, world),
            _ => self.release(progress, world),
        }
    }

    fn destination(&self, world: &World<'_>) -> Result<Destination, Option<Exclusion>> {
        match self.to {
            To::Place(place) => world.destination(self.object, place),
            To::Back => world.way_back(self.object),
        }
    }

    /// With the object in the gripper.
    fn carry(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if progress.stage == RISE && !progress.step.has_begun() {
            if world.held() != Some(self.object) {
                let why = "is not in the gripper; it has to be picked first";
                return self.failed(reason::NOT_IN_GRIPPER, why, world);
            }
            if let Some(refused) = self.refuse(progress, world) {
                return refused;
            }
        }
        if world.is_lost(self.object, &mut progress.missed) {
            // A grip that breaks again and again is a failure; what a person takes is not.
            return match world.broken_grip(self.object) {
                Some(broken) => {
                    let why = format!("was lost: {}", broken.why);
                    self.failed(reason::LOST, &why, world)
                }
                None => Status::Failure,
            };
        }
        if let Some(status) = self.aim(progress, world) {
            return status;
        }
        let Some((goal, travel)) = progress.tool.map(Pose::from).zip(progress.anchor) else {
            return Status::Failure;
        };
        let to = travel.position[2];
        if progress.stage == RISE
            && !progress.step.has_begun()
            && rise(world.tcp_position(), to) < RISEN_M
        {
            progress.go_to(CARRY);
            return self.carry(progress, world);
        }
        let drive = match progress.stage {
            RISE => rise_to(to, progress, world),
            CARRY => above(&goal, &travel),
            // A cup lets go near the goal, as soon as the object touches: an arm that comes to rest
            // there presses it on, and the grip of a load near its limit breaks.
            _ => Drive {
                at_rest: world.tool() != Tool::Suction,
                ..Drive::precise(goal, GripperGoal::Close)
            },
        };
        if world.drive(&mut progress.step, &drive.near(Some(self.object))) {
            progress.next();
        } else if is_late(progress, world) {
            let why = world.why_not_reached("cannot be brought to its place");
            return self.failed(reason::NOT_REACHED, &why, world);
        }
        Status::Running
    }

    /// Decides where the tool sets the object down: as it is in the gripper now, not as it was at
    /// first.
    fn aim(&self, progress: &mut Progress, world: &mut World<'_>) -> Option<Status> {
        let begins_to_carry = !progress.step.has_begun() && progress.stage == CARRY;
        if progress.tool.is_some() && !begins_to_carry {
            return None;
        }
        match self.destination(world) {
            Ok(Destination { tcp, opening_m }) => {
                progress.tool = Some(KeptPose::from(&tcp));
                progress.open_width_m = opening_m;
                progress.anchor = Some(self.travel(&tcp, world));
                None
            }
            Err(why) => Some(self.no_destination(why.as_ref(), progress, world)),
        }
    }

    /// The TCP above `goal` from which the object is lowered: so high that it passes above all on
    /// its way.
    fn travel(&self, goal: &Isometry3<f64>, world: &World<'_>) -> Placement {
        let tcp = world.tcp_position();
        let centre = world.position(self.object).unwrap_or(tcp);
        let goal = goal.translation.vector;
        let end = goal + (centre - tcp);
        let below = centre.z - world.half_height(self.object) - tcp.z;
        let passing = world.passing_height(self.object, centre, end) - below;
        let [x, y, z] = goal.into();
        Placement {
            position: [x, y, passing.max(z + self.clearance_m)],
            yaw: 0.0,
        }
    }

    fn retract(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        let Some(goal) = progress.tool else {
            return Status::Failure;
        };
        let back = Translation3::from(world.tool().axis() * -self.clearance_m);
        let drive = Drive::straight(wire(&(goal.isometry() * back)), GripperGoal::Open);
        let there = world.drive(&mut progress.step, &drive.near(Some(self.object)));
        if !there && !is_late(progress, world) {
            return Status::Running;
        }
        let To::Place(place) = self.to else {
            return Status::Success;
        };
        if world
            .slot_of(self.object, place, self.tolerance_m)
            .is_none()
        {
            return self.failed(reason::CANNOT_BE_PLACED, "is not in its place", world);
        }
        if let Some(attempts) = world.attempts_mut(self.object) {
            *attempts = Attempts::default();
        }
        let setup = world.setup;
        let name = setup.object_name(self.object);
        world.out.log(format_args!("[placed] {name}"));
        Status::Success
    }

    /// Where the object cannot go now.
    fn refuse(&self, progress: &mut Progress, world: &mut World<'_>) -> Option<Status> {
        match self.destination(world) {
            Ok(_) => None,
            Err(why) => Some(self.no_destination(why.as_ref(), progress, world)),
        }
    }

    fn no_destination(
        &self,
        why: Option<&Exclusion>,
        progress: &mut Progress,
        world: &mut World<'_>,
    ) -> Status {
        match why {
            None => self.no_slot(world),
            Some(Exclusion::OutOfReach) => {
                let (place, arm) = (self.name(world), world.arm_name());
                world.refuse(
                    reason::OUT_OF_REACH,
                    format_args!("place '{place}' is out of reach of {arm}"),
                )
            }
            Some(why) => world.wait_or_refuse(self.object, why, &mut progress.waits),
        }
    }

    fn name<'w>(&self, world: &World<'w>) -> &'w str {
        let To::Place(place) = self.to else {
            return "where it was at the start";
        };
        let place = world.setup.places.get(place);
        place.map_or("?", |place| place.name.as_str())
    }

    fn no_slot(&self, world: &mut World<'_>) -> Status {
        let name = self.name(world);
        if matches!(self.to, To::Back) {
            let object = world.setup.object_name(self.object);
            let why = format_args!("{object} is in the gripper and cannot be brought back");
            world.fail(reason::HOLDS_ANOTHER, why);
            return Status::Failure;
        }
        world.fail(
            reason::PLACE_IS_FULL,
            format_args!("place '{name}' has no free slot"),
        );
        Status::Failure
    }

    fn failed(&self, reason: &str, why: &str, world: &mut World<'_>) -> Status {
        world.note_retry(self.object, why);
        world.count_failed_place(self.object, self.max_attempts, reason, why);
        Status::Failure
    }

    /// Opens, and moves back.
    fn release(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        world.opening_to(progress.open_width_m);
        match progress.stage {
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

fn is_late(progress: &Progress, world: &World<'_>) -> bool {
    world.now().since(progress.step.began) >= PolicyTime::from_seconds(MOTION_TIMEOUT_S)
}

/// Straight up to a height (m), with the tool turned as it was commanded last.
fn rise_to(height: f64, progress: &mut Progress, world: &mut World<'_>) -> Drive {
    world.begin(&mut progress.step);
    let [x, y, from] = progress.step.from;
    let told = world.out.previous(world.arm).map(|told| told.target);
    let turned = told.or(world.tcp()).unwrap_or(Pose::IDENTITY);
    let target = Pose {
        position: [x, y, height.max(from)],
        ..turned
    };
    Drive::straight(target, GripperGoal::Close)
}

/// Across to the point from which the object is lowered straight down, between neighbours.
fn above(goal: &Pose, travel: &Placement) -> Drive {
    let above = Pose {
        position: travel.position,
        ..*goal
    };
    Drive {
        tolerance_m: ABOVE_PLACE.0,
        angle_rad: ABOVE_PLACE.1,
        ..Drive::travel(above, GripperGoal::Close)
    }
}

impl Skill for Place {
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        self.bring().step(progress, world)
    }
}
