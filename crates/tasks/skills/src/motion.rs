//! Motions of the arm.

use behavior::Status;
use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_task::job::Placement;
use robocell_task::operator::{operator_target, requested_gripper};
use robocell_task::{ArmIntent, GoalKind, PolicyTime};

use crate::geometry;
use crate::pose::KeptPose;
use crate::progress::{Progress, Step};
use crate::skill::Skill;
use crate::way::Way;
use crate::world::{Drive, World};

/// Joints nearer than this to their positions have arrived (rad or m).
const JOINT_TOLERANCE: f64 = 0.03;
/// Largest duration of a motion of all joints (s).
const HOME_TIMEOUT_S: f64 = 10.0;

/// The goal of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// The TCP at this pose, world frame.
    Pose(Pose),
    /// The TCP at the grip of an object from above, or above that; it follows the object.
    Object {
        /// The object.
        object: usize,
        /// Height above the grip (m).
        above_m: f64,
    },
    /// The TCP with the object in the gripper in the next free slot of a place, or above that.
    Place {
        /// The object.
        object: usize,
        /// The place.
        place: usize,
        /// Height above (m).
        above_m: f64,
    },
    /// Straight up from the start of the motion.
    Up {
        /// How far (m).
        by_m: f64,
    },
}

/// Brings the TCP to a target. It succeeds at once if the arm is at rest there. It fails if the
/// target is out of reach or not reached in time, if an object that shall be in the gripper is
/// lost, or if an object that shall keep its place moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveTo {
    /// Where to.
    pub target: Target,
    /// Whether the motion is exact and in a straight line.
    pub precise: bool,
    /// Goal of the gripper during the motion.
    pub gripper: GripperGoal,
    /// Object that has to stay in the gripper.
    pub holding: Option<usize>,
    /// Largest motion of the target's object in the plane (m).
    pub move_tolerance_m: f64,
    /// Time after which it fails.
    pub timeout: PolicyTime,
    /// Posture, corridor and obstacles.
    pub way: Way,
}

impl MoveTo {
    /// A motion to `target`, not very exact, within 10 s.
    pub fn new(target: Target) -> Self {
        Self {
            target,
            precise: false,
            gripper: GripperGoal::Keep,
            holding: None,
            move_tolerance_m: 0.05,
            timeout: PolicyTime::from_ticks(10_000),
            way: Way::default(),
        }
    }

    /// A motion to the grip of an object and `above_m` above it (m), with the gripper open.
    pub fn object(object: usize, above_m: f64) -> Self {
        Self {
            precise: above_m <= 0.0,
            gripper: GripperGoal::Open,
            ..Self::new(Target::Object { object, above_m })
        }
    }

    /// A motion with the object in the gripper to the next free slot of a place, and `above_m`
    /// above it (m).
    pub fn place(object: usize, place: usize, above_m: f64) -> Self {
        Self {
            precise: above_m <= 0.0,
            ..Self::new(Target::Place {
                object,
                place,
                above_m,
            })
            .holding(object)
        }
    }

    /// A motion straight up by `by_m` (m).
    pub fn up(by_m: f64) -> Self {
        Self {
            precise: true,
            ..Self::new(Target::Up { by_m })
        }
    }

    /// Adds an object that has to stay in the gripper.
    #[must_use]
    pub fn holding(mut self, object: usize) -> Self {
        self.holding = Some(object);
        self.gripper = GripperGoal::Close;
        self
    }

    /// The pose of the TCP in this decision; `None` if the target is unknown or out of reach.
    /// The part that does not follow the object is kept in `progress`.
    fn pose(&self, progress: &mut Progress, world: &World<'_>) -> Option<Pose> {
        let pose = self.wanted(progress, world)?;
        world.reaches(pose.position.into()).then_some(pose)
    }

    fn wanted(&self, progress: &mut Progress, world: &World<'_>) -> Option<Pose> {
        match self.target {
            Target::Pose(pose) => Some(pose),
            Target::Object { object, above_m } => {
                let seen = world.placement(object)?;
                // The turn is chosen at the start and kept near it: the nearest quarter to the
                // turning tool would turn the wrist with the object.
                let reference = progress.anchor.map_or(world.tool_yaw(), |a| a.yaw);
                let at = Placement {
                    yaw: geometry::nearest_quarter(seen.yaw, reference),
                    ..seen
                };
                progress.anchor.get_or_insert(at);
                Some(world.grip_pose(object, at, above_m))
            }
            Target::Place {
                object,
                place,
                above_m,
            } => {
                // Chosen once: the next free slot may change while the object is on its way.
                let tcp = if let Some(tcp) = progress.tool {
                    tcp
                } else {
                    let tcp = world.destination(object, place).ok()?;
                    *progress.tool.insert(KeptPose::from(&tcp.tcp))
                };
                let [x, y, z] = tcp.position;
                Some(Pose {
                    position: [x, y, z + above_m],
                    ..tcp.into()
                })
            }
            Target::Up { by_m } => {
                let at = match progress.anchor {
                    Some(at) => at,
                    None => *progress.anchor.insert(Placement {
                        position: world.tcp()?.position,
                        yaw: world.tool_yaw(),
                    }),
                };
                let [x, y, z] = at.position;
                Some(Pose {
                    position: [x, y, z + by_m],
                    orientation_wxyz: world.tool().down(at.yaw),
                })
            }
        }
    }

    /// Whether the target's object has moved from its position at the start.
    fn has_moved(&self, progress: &Progress, world: &World<'_>) -> bool {
        let (Target::Object { object, .. }, Some(anchor)) = (self.target, progress.anchor) else {
            return false;
        };
        let seen = world.position(object);
        seen.is_none_or(|seen| {
            geometry::plane_distance(seen, anchor.position.into()) > self.move_tolerance_m
        })
    }
}

impl Skill for MoveTo {
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        // Before anything else: without the object the motion would continue with empty
        // fingers.
        if let Some(object) = self.holding
            && world.is_lost(object, &mut progress.missed)
        {
            return Status::Failure;
        }
        let Some(target) = self.pose(progress, world) else {
            return Status::Failure;
        };
        // A failure, not a correction: the node above decides whether to pick up again.
        if self.has_moved(progress, world) {
            world.job.counters.resyncs += 1;
            return Status::Failure;
        }
        let drive = if self.precise {
            Drive::precise(target, self.gripper)
        } else {
            Drive::travel(target, self.gripper)
        };
        let drive = Drive {
            way: self.way,
            ..drive
        };
        let object = match self.target {
            Target::Object { object, .. } | Target::Place { object, .. } => Some(object),
            Target::Pose(_) | Target::Up { .. } => self.holding,
        };
        // Only in the first decision: an arm that passes its target while it moves is not at
        // rest there.
        let begins = progress.stage == 0 && !progress.step.has_begun();
        if begins && world.is_there(&drive) {
            return Status::Success;
        }
        // Travel starts with a rise if the tool is beside an object; a precise motion is meant
        // to be near one.
        let leaves = progress.stage == 0 && !self.precise;
        if leaves && !is_clear(&mut progress.step, object, world) {
            return Status::Running;
        }
        if leaves {
            progress.next();
        }
        let there = world.drive(&mut progress.step, &drive.near(object));
        if there {
            return Status::Success;
        }
        if world.now().since(progress.step.began) < self.timeout {
            return Status::Running;
        }
        if let Some(refused) = world.refuse_if_arm_blocks(&target) {
            return refused;
        }
        let arm = world.arm_name();
        let why = world.why_not_reached("does not reach its target");
        world.out.log(format_args!("[retry] {arm} {why}"));
        Status::Failure
    }
}

/// Height by which a tool rises that leaves an object (m).
const CLEAR_M: f64 = 0.1;
/// Largest duration of that (s).
const CLEAR_TIMEOUT_S: f64 = 3.0;

/// Whether the tool is clear of objects other than `object` and the held one. If it is not, as
/// after an interrupted place, it rises: another motion would drag the objects along. `step` is
/// used for the rise until the tool is clear.
pub(crate) fn is_clear(step: &mut Step, object: Option<usize>, world: &mut World<'_>) -> bool {
    let beside = world.beside_tool(object);
    if !step.has_begun() && beside.is_none() {
        return true;
    }
    let lasted = world.begin(step);
    let [x, y, z] = step.from;
    let target = Pose {
        position: [x, y, z + CLEAR_M],
        orientation_wxyz: world.tool().down(world.tool_yaw()),
    };
    // Empty fingers that had begun to open continue to do so.
    let gripper = match world.held() {
        Some(_) => GripperGoal::Keep,
        None => GripperGoal::Open,
    };
    let drive = Drive::straight(target, gripper);
    let risen = world.drive(step, &drive.near(beside));
    // After the time limit the motion starts all the same: an arm that cannot rise must not
    // wait for ever.
    risen || lasted >= PolicyTime::from_seconds(CLEAR_TIMEOUT_S)
}

/// Brings the joints to their positions at the start of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Home;

impl Skill for Home {
    fn step(&self, progress: &mut Progress, world: &mut World<'_>) -> Status {
        if progress.stage == 0 {
            if !is_clear(&mut progress.step, None, world) {
                return Status::Running;
            }
            progress.next();
        }
        let lasted = world.begin(&mut progress.step);
        let (Some(arm), Some(seen)) = (world.arm_setup(), world.observation.arm(world.arm)) else {
            return Status::Failure;
        };
        let count = seen.joint_count as usize;
        let joints = seen.joint_positions.iter().zip(arm.home).take(count);
        let near = joints
            .map(|(is, wanted)| (is - wanted).abs())
            .all(|off| off < JOINT_TOLERANCE);
        // Followed, too: joints near their goal may belong to an older goal that passes there.
        let followed = world.is_followed(progress.step.key);
        world.act(ArmIntent {
            kind: GoalKind::Joints,
            key: progress.step.key,
            posture: Some(arm.home),
            target: world.tcp().unwrap_or(Pose::IDENTITY),
            ..ArmIntent::default()
        });
        let settle = PolicyTime::from_ticks(100);
        if world.settles(&mut progress.step, near && followed, settle) {
            Status::Success
        } else if lasted >= PolicyTime::from_seconds(HOME_TIMEOUT_S) {
            Status::Failure
        } else {
            Status::Running
        }
    }
}

/// Follows the operator's target and gripper requests for this arm; never ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FollowOperator;

impl Skill for FollowOperator {
    fn step(&self, _progress: &mut Progress, world: &mut World<'_>) -> Status {
        let panel = world.observation.panel();
        let mine = panel.target_arm as usize == world.arm;
        let gripper = if mine && panel.gripper_seq > 0 {
            requested_gripper(panel)
        } else {
            GripperGoal::Keep
        };
        if mine && panel.target_seq > 0 {
            world.act(ArmIntent {
                gripper,
                ..operator_target(panel)
            });
        } else {
            world.stay(gripper);
        }
        Status::Running
    }
}

/// Height of `to` above a point (m); 0 if it is below.
pub(crate) fn rise(from: Vector3<f64>, to: f64) -> f64 {
    (to - from.z).max(0.0)
}
